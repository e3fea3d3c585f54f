"""``facezip bench clean``: what cleaning does to scans and packs, against the known truth."""

from collections.abc import Mapping
from typing import Any

import click

from facezip.commands import options
from facezip.machine.conditions import conditions

LIBRARIES = ("facezip", "numpy", "numba", "scipy")


@click.command("clean")
@options.resolution
@options.seed
@click.option("--seeds", type=click.IntRange(min=1), default=1, show_default=True, metavar="N", help="Persons.")
@options.as_json
def command(resolution: int, seed: int, seeds: int, as_json: bool) -> None:
    """Clean the embedded head's scans step by step, and compare with the truth behind them.

    Reports the RMSE of 255 (inside the mask) of the neutral, the scans and packs of them, and the power of the
    neutral's detail over the truth's: without cleaning, then with one more step of --clean at a time.
    """
    from reports.cleaning import bench_clean

    people = {str(seed + n): bench_clean(resolution, seed + n) for n in range(seeds)}
    document = {
        "people": people,
        "conditions": {**conditions(LIBRARIES), "character": "embedded", "resolution": [resolution, resolution]},
    }
    options.answer(document, as_json, lambda: _lines(people))


def _lines(people: Mapping[str, Any]) -> list[str]:
    lines = ["RMSE to the truth, of 255      neutral   scans    pack   detail"]
    for name, steps in people.items():
        for step, found in steps.items():
            numbers = "  ".join(f"{found[key]:6.2f}" for key in ("neutral", "scans", "pack", "detail"))
            lines.append(f"  person {name:>3}  {step:<14} {numbers}")
    return lines
