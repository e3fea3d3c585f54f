"""The roofline: what a sweep has to do at least, by counting it, and a table that says how near it comes."""

import pytest

from reports import roofline


@pytest.mark.parametrize("count", [1, 20])
def test_bytes_and_products_are_those_of_every_expression(count):
    slots, channels = roofline.SLOTS, roofline.CHANNELS
    mixed, shared = slots, slots
    pairs = sum(1 for i in range(slots) for j in range(i + 1))
    assert roofline.texel_products(count) == count * (mixed + pairs + 2 * slots * channels + shared)
    assert roofline.texel_bytes(count) == count * channels + channels + 4


def test_the_table_has_a_row_for_each_number_of_expressions(monkeypatch, capsys):
    for name, value in {"SIZE": 64, "EXPRESSIONS": (2, 3), "REPEATS": 1, "_BYTES": 2**20}.items():
        monkeypatch.setattr(roofline, name, value)
    roofline.main()
    rows = [line.split(" | ") for line in capsys.readouterr().out.splitlines() if line.startswith("| ")]
    assert [row[0] for row in rows] == ["| expressions", "| 2", "| 3"]
    assert all(float(row[4]) > float(row[3]) > 0 for row in rows[1:])
