"""The validation report: self-contained, safe with hostile names, and true to its document."""

import base64
import hashlib
import json
import re
from html.parser import HTMLParser

import numpy as np
import pytest

from facezip.documents.document import plain
from facezip.errors import ErrorCode, FaceZipError
from reports.summary import memory_table
from reports.validation import write_validation_report
from tests.reports.conftest import METRICS, make_document

HOSTILE = "<script>alert(1)</script>\"'><img src=x onerror=alert(2)> ../../etc {{ 7*7 }} & ]]>"


class Page(HTMLParser):
    """Elements, references, words and inline scripts of a page."""

    def __init__(self, text):
        super().__init__()
        self.tags, self.references, self.words, self.scripts, self.handlers = [], [], [], [], []
        self._open = []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))
        self._open.append(tag)
        self.references += [value for name, value in attrs if name in ("src", "href", "srcset", "action", "data")]
        self.handlers += [name for name, _ in attrs if name.startswith("on")]

    def handle_endtag(self, tag):
        while self._open and self._open.pop() != tag:
            pass

    def handle_data(self, data):
        inside = self._open[-1] if self._open else ""
        if inside == "script":
            self.scripts.append(data)
        elif inside != "style" and data.strip():
            self.words.append(" ".join(data.split()))

    def count(self, tag, css=None):
        return sum(
            1 for name, attrs in self.tags if name == tag and (css is None or css in attrs.get("class", "").split())
        )


def page_of(document, folder):
    return Page(write_validation_report(document, folder).read_text(encoding="utf-8"))


def test_a_page_loads_nothing_but_itself(comparison, tmp_path):
    page = page_of(comparison, tmp_path)
    assert page.count("img") >= 12
    outside = [url for url in page.references if not url.startswith(("data:", "#"))]
    assert outside == []


def test_styles_and_script_reach_for_nothing(document, tmp_path):
    text = write_validation_report(document, tmp_path).read_text(encoding="utf-8")
    without_pictures = re.sub(r"data:image/webp;base64,[A-Za-z0-9+/=]+", "", text)
    assert re.findall(r"https?:|@import|url\(|fetch\(|XMLHttpRequest", without_pictures) == []


def test_report_json_is_the_document(comparison, tmp_path):
    write_validation_report(comparison, tmp_path)
    assert json.loads((tmp_path / "report.json").read_text(encoding="utf-8")) == comparison


def test_report_json_is_strict_where_the_document_is_not(document, tmp_path):
    document["packs"][0]["psnr"] = float("inf")
    document["packs"][0]["ssim"] = np.float32(0.5)
    write_validation_report(document, tmp_path)

    def refuse(constant):
        raise AssertionError(constant)

    written = json.loads((tmp_path / "report.json").read_text(encoding="utf-8"), parse_constant=refuse)
    assert written["packs"][0]["psnr"] is None
    assert written["packs"][0]["ssim"] == 0.5


@pytest.mark.parametrize("value", [float("nan"), float("inf"), -float("inf"), np.float32("nan")])
def test_plain_data_has_no_numbers_that_json_lacks(value):
    assert plain({"a": [1, (value,)]}) == {"a": [1, [None]]}


def test_hostile_names_are_text_wherever_they_stand(tmp_path):
    document = make_document(
        tmp_path, packs=(HOSTILE, "b" + HOSTILE), expressions=(HOSTILE, "x" + HOSTILE), name=HOSTILE
    )
    for pack in document["packs"]:
        pack["verdict"] = HOSTILE
    document["command"] = HOSTILE
    document["conditions"][HOSTILE] = HOSTILE
    document["baselines"] = [{"name": "c" + HOSTILE, "texture_rmse": 1.5, "bytes_on_gpu": 7, "fetches": HOSTILE,
                              "texture_rmse_per_expression": {HOSTILE: 1.5}}]  # fmt: skip
    harmless = page_of(make_document(tmp_path / "harmless", packs=("a", "b")), tmp_path / "harmless")
    page = page_of(document, tmp_path)
    assert page.handlers == []
    assert page.count("script") == harmless.count("script")
    assert page.count("img") == harmless.count("img")
    assert HOSTILE in page.words


def test_the_policy_allows_the_page_s_own_script_alone(document, tmp_path):
    page = page_of(document, tmp_path)
    policy = next(attrs["content"] for tag, attrs in page.tags if attrs.get("http-equiv") == "Content-Security-Policy")
    digest = base64.b64encode(hashlib.sha256(page.scripts[-1].encode()).digest()).decode()
    assert f"script-src 'sha256-{digest}'" in policy
    assert "default-src 'none'" in policy


def test_data_of_cards_is_json_whatever_the_names(tmp_path):
    document = make_document(tmp_path, packs=(HOSTILE,), expressions=(HOSTILE, "</script>"))
    page = page_of(document, tmp_path)
    cards = [json.loads(text) for text in page.scripts[:-1]]
    assert len(cards) == 2
    assert all(len(card["views"]) == 2 for card in cards)


def shown(document):
    """Every measured number of a document in every form in which a page may print it."""
    values = []

    def walk(item):
        if isinstance(item, dict):
            for part in item.values():
                walk(part)
        elif isinstance(item, list):
            for part in item:
                walk(part)
        elif isinstance(item, int | float):
            values.append(item)

    walk(document)
    values += [pack["bytes_raw"] / entry["bytes_on_gpu"] for pack in document["packs"]
               for entry in (pack, *document.get("baselines", [])) if entry.get("bytes_on_gpu")]  # fmt: skip
    values += [value / 1e6 for value in values]
    return {f"{value:.{digits}f}" for value in values for digits in range(5)} | {"1×", "–"}


def test_every_number_in_a_table_or_tile_is_in_the_document(comparison, tmp_path):
    text = write_validation_report(comparison, tmp_path).read_text(encoding="utf-8")
    cells = re.findall(r'<span class="value">([^<]*)</span>|<td class="number">([^<]+)</td>|<dd><b>([^<]*)</b>', text)
    printed = {"".join(cell).removesuffix("× less").removesuffix("×") for cell in cells} - {""}
    words = {name for name in printed if not re.search(r"\d", name)}
    assert len(printed) > 30
    assert printed - words - shown(comparison) - {"1"} == set()


def test_every_metric_of_every_pack_and_render_is_shown(comparison, tmp_path):
    page = page_of(comparison, tmp_path)
    words = set(page.words)
    for pack in comparison["packs"]:
        assert f"{pack['image_rmse']:.2f}" in words
        assert f"{pack['ssim']:.4f}" in words
        assert pack["verdict"] in words
    cards = [json.loads(text) for text in page.scripts[:-1]]
    numbers = {text for card in cards for view in card["views"] for row in view["numbers"] for text in row}
    for render in comparison["renders"]:
        assert {f"{pack['flip']:.4f}" for pack in render["packs"]} <= numbers


def test_expressions_come_worst_first(document, tmp_path):
    page = page_of(document, tmp_path)
    labels = [attrs["aria-label"] for tag, attrs in page.tags if tag == "input"]
    assert [label.rpartition(" ")[2] for label in labels] == ["frown", "frown", "smile"]


def test_the_pack_with_the_lowest_image_error_leads(tmp_path):
    document = make_document(tmp_path, packs=("bad", "good"))
    document["packs"][0]["image_rmse"], document["packs"][1]["image_rmse"] = 2.75, 0.25
    page = page_of(document, tmp_path)
    label = next(attrs["aria-label"] for tag, attrs in page.tags if "tiles" in attrs.get("class", "").split())
    assert label == "Key figures of good"


def test_packs_of_one_name_can_be_told_apart(tmp_path):
    document = make_document(tmp_path, packs=("a", "b", "c"))
    for pack, method in zip(document["packs"], ("paper", "pca", "pca"), strict=True):
        pack |= {"name": "Ada", "method": method}
    page = page_of(document, tmp_path)
    assert {"Ada (paper)", "Ada (pca) 2", "Ada (pca) 3"} <= set(page.words)
    assert json.loads((tmp_path / "report.json").read_text(encoding="utf-8"))["packs"] == document["packs"]


def test_best_is_marked_only_where_there_is_a_choice(comparison, tmp_path):
    several = page_of(comparison, tmp_path)
    assert several.words.count("best") == len(METRICS) + 1
    alone = make_document(tmp_path / "alone")
    assert page_of(alone, tmp_path / "alone").words.count("best") == 0
    equal = make_document(tmp_path / "equal", packs=("a", "b"))
    equal["packs"][1] = equal["packs"][0] | {"name": "b"}
    assert page_of(equal, tmp_path / "equal").words.count("best") == 0


def test_a_single_pack_offers_no_choice_of_packs(comparison, tmp_path):
    assert page_of(comparison, tmp_path).count("select", "choose-pack") == 2
    alone = make_document(tmp_path / "alone")
    page = page_of(alone, tmp_path / "alone")
    assert page.count("select", "choose-pack") == 0
    assert page.count("select", "choose-view") == 2


def test_rivals_stand_in_chart_and_memory_table_once(comparison, tmp_path):
    page = page_of(comparison, tmp_path)
    assert page.count("rect", "rival-0") == 2 * 2
    rows = [row.name for row in memory_table(comparison).rows]
    assert rows == ["raw textures", "refined", "paper", "tiny", "PCA(4)"]


def test_an_identical_pack_reads_as_exact(tmp_path):
    document = make_document(tmp_path)
    zero = dict.fromkeys(METRICS, 0.0) | {"ssim": 1.0, "psnr": None}
    document["packs"][0] |= zero | {"texture_rmse": 0.0, "level": "identical"}
    document["packs"][0]["worst"] = {}
    for render in document["renders"]:
        render["packs"] = [zero]
    page = page_of(document, tmp_path)
    assert "∞" in page.words
    figures = re.findall(r"<dd><b>([^<]*)</b>", (tmp_path / "index.html").read_text(encoding="utf-8"))
    assert figures[:5] == ["0", "0", "0", "0", "1"]


def test_floors_of_every_metric_are_shown_where_they_were_measured(document, tmp_path):
    assert any("noise floor 0.0777" in word for word in page_of(document, tmp_path).words)


def test_a_document_without_renders_still_makes_a_page(document, tmp_path):
    document["renders"] = []
    page = page_of(document, tmp_path)
    assert page.count("img") == 0
    assert page.count("table", "memory-table") == 1


def test_the_same_document_makes_the_same_bytes(comparison, tmp_path):
    first = write_validation_report(comparison, tmp_path).read_bytes()
    assert write_validation_report(comparison, tmp_path).read_bytes() == first


def test_a_missing_render_is_named_and_nothing_is_written(document, tmp_path):
    (tmp_path / document["renders"][2]["exr"]).unlink()
    with pytest.raises(FaceZipError, match=re.escape(document["renders"][2]["exr"])) as caught:
        write_validation_report(document, tmp_path)
    assert caught.value.code is ErrorCode.MISSING_FILE
    assert [path.name for path in tmp_path.iterdir()] == ["renders"]


def test_a_truncated_render_is_named(document, tmp_path):
    path = tmp_path / document["renders"][0]["exr"]
    path.write_bytes(path.read_bytes()[:400])
    with pytest.raises(FaceZipError, match=re.escape(str(path))) as caught:
        write_validation_report(document, tmp_path)
    assert caught.value.code is ErrorCode.UNREADABLE_IMAGE


def test_renders_of_another_number_of_packs_are_refused(document, tmp_path):
    other = make_document(tmp_path / "other", packs=("a", "b"))
    with pytest.raises(FaceZipError, match="3 parts for an original and 1 packs"):
        write_validation_report(document, tmp_path / "other")
    assert len(other["packs"]) == 2


def test_a_failed_write_leaves_the_old_page(document, tmp_path, monkeypatch):
    (tmp_path / "index.html").write_text("old")

    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("facezip.files.writing.os.replace", full)
    with pytest.raises(FaceZipError) as caught:
        write_validation_report(document, tmp_path)
    assert caught.value.code is ErrorCode.CANNOT_WRITE
    assert (tmp_path / "index.html").read_text() == "old"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["index.html", "renders"]
