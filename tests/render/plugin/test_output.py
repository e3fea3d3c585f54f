"""What a run leaves where people look: Markdown, JUnit's XML, a page."""

import re
from dataclasses import replace
from xml.etree import ElementTree

from render.plugin.results import Compared, ImagesDocument, Place, Result, StaleReference, Written
from reports.comment import MOST_ROWS, comment
from reports.regression import write_regression_report
from tests.render.plugin.conftest import BRIGHTER, STEM

WORST = Place(row=1, column=2, side=4, image=0.5, reference=0.25, deviations=9.0)
COMPARED = Compared(probability=1e-9, statistic="largest_4", renders=8, accepted=1, place=WORST)


def failed(name="a", **more):
    told = {"must_differ": False, "outcome": "failed", "level": 0.001, "message": f"{name}: differs"}
    told |= {"reference": "b/a.exr", "comparison": COMPARED}
    return Result(**{**told, "name": name, "test": f"t.py::{name}", **more})


def document(*results, stale=(), idle=0):
    return ImagesDocument(results=results, stale=stale, idle=idle)


MISSING = failed("m", comparison=None, message="m: no reference b/m.exr\n  generate it")


def test_a_run_leaves_markdown_and_properties(generated, pytester):
    generated(BRIGHTER, "--facezip-markdown", "out/comment.md", "--junit-xml", "junit.xml")
    text = (pytester.path / "out" / "comment.md").read_text(encoding="utf-8")
    assert text.startswith("### FaceZip image tests: 1 of 1 differ from their references")
    assert re.search(
        rf"^\| `{STEM}` \| \S+ \| 0\.001 \| row \d+, column \d+, \d+ px: \S+ instead of \S+ \|$", text, re.M
    )
    properties = {
        one.get("name"): one.get("value") for one in ElementTree.parse(pytester.path / "junit.xml").iter("property")
    }
    assert float(properties[f"facezip_p[{STEM}]"]) < 0.001
    assert properties[f"facezip_evidence[{STEM}]"].endswith(STEM)


def test_everything_that_is_wrong_is_told():
    written = Written(change="changed", renders=32, before="0" * 64, after="1" * 64)
    generated = failed("c", outcome="generated", written=written)
    stale = [
        StaleReference(reference="b/gone.exr", test="t.py::gone"), StaleReference(reference="b/shared.exr", test="")
    ]  # fmt: skip
    text = comment(document(failed(), failed("w", outcome="warned"), generated, stale=stale, idle=0))
    for words in ("**Failed**", "**Warned**", "`w`", "000000000000` 0.25", "111111111111` 0.5", "`b/gone.exr`"):
        assert words in text
    assert "2 tests ask for images" in comment(document(idle=2))


def test_a_missing_reference_and_an_image_that_must_differ_are_told():
    agreeing = failed(must_differ=True, comparison=replace(COMPARED, probability=0.5))
    text = comment(document(MISSING, agreeing))
    assert "2 of 2 failed" in text
    assert "no reference b/m.exr" in text
    assert "agrees, though it must differ" in text


def test_names_are_no_markup():
    text = comment(document(failed("a`|<img src=x> @someone\n# b")))
    (row,) = [line for line in text.splitlines() if "@someone" in line]
    assert row.startswith("| `aˋ\\|<img src=x> @someone\\n# b` |")


def test_a_comment_stays_short():
    text = comment(document(*(failed(f"image-{k}") for k in range(400))))
    assert len(text) < 65_000
    assert text.count("| `image-") == MOST_ROWS
    assert f"and {400 - MOST_ROWS} more" in text


def test_the_page_says_the_renders_of_a_new_reference_and_else_those_of_the_image(tmp_path):
    written = Written(change="new", renders=32, after="1" * 64)
    made = failed("c", outcome="generated", comparison=None, message=None, written=written)
    page = write_regression_report(document(MISSING, failed(), made), tmp_path / "index.html").read_text("utf-8")
    rows = re.findall(r"<tr.*?</tr>", page, re.DOTALL)
    shown = [re.findall(r">\s*(\d+|–)\s*<", row)[-1] for row in rows if "t.py::" in row]
    assert shown == ["8", "–", "32"]
