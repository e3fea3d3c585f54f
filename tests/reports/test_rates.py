"""Error against bytes: bytes are those of the blocks, curves keep the best, the page is true to its document."""

import json
from dataclasses import replace

import numpy as np
import pytest
from zstandard import ZstdCompressor

from facezip.blocks.codecs import bc4, bc7, raw
from facezip.documents.document import plain
from facezip.errors import ErrorCode, FaceZipError
from facezip.files.images import png
from facezip.fit.choice import whole_error
from facezip.fit.coded import coded_afterwards
from facezip.fit.methods import compress
from facezip.fit.storage import Storage
from facezip.pack.errors import MapErrors, model_errors
from reports.rates import experiment
from reports.rates.comparison import compare, envelope, in_use
from reports.rates.curves import SIZES, curves
from reports.rates.families import FAMILIES, RAW, tried
from reports.rates.findings import find
from reports.rates.points import Pack, Point, Textures
from reports.rates.report import write_rates_report
from tests.documents.checked import check
from tests.facezip.conftest import ALBEDO_KEY, random_character
from tests.facezip.surfaces import random_surface
from tests.reports.test_validation import Page

HOSTILE = "<script>alert(1)</script>\"'><img src=x onerror=alert(2)> {{ 7*7 }} & ]]>"


def point(family, size, error, differences=4, fetches=6):
    errors = {"albedo": MapErrors(rmse=error)}
    sizes = 100 * size, 80 * size, size, size
    return Point(family, "raw", *sizes, fetches, error, 40.0, errors, 1.0, differences, 8, "bc4")


WAYS = [
    Textures("textures_astc", bc7()),
    Pack("refined_astc", "refined", 2, 8, Storage(bc7(), bc4()), in_the_loop=True),
    Pack("refined_raw", "refined", 2, 8, RAW),
]


@pytest.fixture(scope="module")
def document():
    return measured(replace(random_character(side=32), name=HOSTILE))


@pytest.fixture(scope="module")
def tiled():
    """Albedo, normals and roughness on two tiles."""
    return random_surface(side=64, expressions=5, tiles=(2, 1))


@pytest.fixture(scope="module")
def tiled_document(tiled):
    return measured(tiled)


def measured(character):
    """A document of few ways."""
    patch = pytest.MonkeyPatch()
    patch.setattr(experiment, "tried", lambda character, effort: WAYS)
    found = experiment.measure_rates(character, 7, "fast", 0)
    patch.undo()
    return replace(found, command=HOSTILE)


def test_every_texture_raw_costs_its_bytes_and_has_no_error():
    character = random_character(side=32)
    measured = Textures("textures_bc", raw(3)).measure(character)
    assert measured.rmse < 1e-4
    assert measured.bytes_per_texel == 3 * measured.fetches == 3 * (1 + len(character.expressions))


def test_a_coded_pack_costs_its_blocks():
    character = random_character(side=32)
    measured = Pack("refined_bc", "refined", 2, 8, Storage(bc7(), bc4()), in_the_loop=True)
    # Three textures at a byte a texel, and for every expression and slot one block of eight bytes for 4 x 4 weights.
    weights = len(character.expressions) * 2 * 8 / 32**2
    assert measured.measure(character).bytes_per_texel == pytest.approx(3 + weights)


def test_files_weigh_what_zstandard_and_png_leave_of_every_texture():
    character = random_character(side=32)
    images = [character.texels(name, ALBEDO_KEY) for name in ("neutral", *character.expressions)]
    for codec, size in (
        (bc7(), lambda image: len(ZstdCompressor(level=19).compress(bc7().store(image)))),
        (raw(3), lambda image: len(png(image))),
    ):
        assert Textures("textures_bc", codec).measure(character).bytes_on_wire == sum(map(size, images))


def test_a_pack_s_files_are_its_own_whatever_was_measured_before():
    character = random_character(side=32)
    more, fewer = (Pack("refined_raw", "refined", count, 8, RAW) for count in (4, 2))
    alone = fewer.measure(character).bytes_on_wire
    assert more.measure(character).bytes_on_wire > alone == fewer.measure(character).bytes_on_wire


def test_bytes_are_those_of_all_maps_and_tiles(tiled):
    rival = Textures("textures_bc", bc7()).measure(tiled)
    # A byte a texel, whatever the channels: six textures of 64 x 32, and each expression's like the neutral's.
    assert rival.bytes == 6 * 6 * 64 * 32
    assert rival.fetches == 3 * 6
    pack = Pack("refined_raw", "refined", 2, 8, RAW).measure(tiled)
    assert pack.bytes == compress(tiled, differences=2).footprint.bytes_on_gpu
    assert pack.bytes_per_texel == pack.bytes / (6 * 64 * 32)


def test_the_error_is_one_over_all_maps_beside_those_of_each(tiled):
    way = Pack("refined_raw", "refined", 2, 8, RAW)
    model = coded_afterwards(compress(tiled, differences=2), RAW)
    errors, found = model_errors(tiled, model), way.measure(tiled)
    assert found.rmse == pytest.approx(whole_error(errors, {}))
    assert set(found.errors) == {"albedo", "normal", "roughness"}
    assert found.errors["roughness"] == MapErrors(rmse=errors["roughness"].rmse)
    assert found.errors["normal"].angular_error == pytest.approx(errors["normal"].angular_error)


def test_the_rival_codes_normals_as_images(tiled):
    """Uncompressed, 8 bits of n and not of its slopes, which would be off by degrees."""
    found = Textures("textures_bc", raw(3)).measure(tiled).errors
    assert 0 < found["normal"].angular_error < 0.5
    assert found["albedo"].rmse < 1e-4


def test_the_page_shows_the_error_of_each_map(tiled_document, tmp_path):
    page = Page(write_rates_report(tiled_document, tmp_path).read_text(encoding="utf-8"))
    words = " ".join(page.words)
    assert "Normal, mean angle in degrees" in words
    assert "albedo, normal and roughness together" in words
    assert "3 maps on 2 tiles" in words
    point = tiled_document.rounds[0].points[0]
    assert f"{point.errors['roughness'].rmse:.2f}" in page.words


def test_an_albedo_alone_has_one_error(document, tmp_path):
    for one in document.rounds:
        assert all(point.rmse == pytest.approx(point.errors["albedo"].rmse) for point in one.points)
    assert "together" not in write_rates_report(document, tmp_path).read_text(encoding="utf-8")


def test_an_envelope_is_what_nothing_cheaper_beats():
    rng = np.random.default_rng(0)
    points = [plain(point("pca", size, error)) for size, error in rng.random((40, 2))]
    kept = envelope(points)
    assert [one["rmse"] for one in kept] == sorted((one["rmse"] for one in kept), reverse=True)
    for one in points:
        beaten = any(o["bytes_per_texel"] <= one["bytes_per_texel"] and o["rmse"] < one["rmse"] for o in points)
        assert beaten == (one not in kept)


def test_the_comparison_never_costs_more_than_the_rival():
    points = [point("textures_astc", size, 3.0) for size in (1.0, 3.0, 9.0)]
    points += [point("refined_astc", size, error) for size, error in ((2.0, 2.0), (2.5, 2.5), (3.5, 0.5))]
    rows = compare(points)
    assert [(row.rival.bytes_per_texel, row.ours.rmse) for row in rows] == [(3.0, 2.0), (9.0, 0.5)]
    assert in_use(plain(rows)) == plain(rows[:1])


def test_packs_of_few_fetches_have_a_place_of_their_own():
    points = [point("textures_astc", 3.0, 3.0)]
    points += [point("refined_astc", 2.5, 2.0), point("refined_astc", 2.6, 1.0, differences=6, fetches=9)]
    (row,) = compare(points)
    assert (row.ours.fetches, row.few.fetches, row.few.rmse) == (9, 6, 2.0)
    assert row.few_ratio == pytest.approx(2 / 3)
    (row,) = compare([points[0], points[2]])
    assert row.few is row.few_ratio is None


def test_textures_are_compared_with_packs_of_the_same_devices():
    points = [point("textures_astc", 5.0, 1.0), point("textures_bc", 5.0, 1.0)]
    points += [point("refined_astc", 4.0, 0.5), point("refined_bc", 4.0, 0.7)]
    pairs = {(row.rival.family, row.ours.family) for row in compare(points)}
    assert pairs == {("textures_astc", "refined_astc"), ("textures_bc", "refined_bc")}


def test_what_is_sent_is_a_share_of_gpu_memory_in_words_and_on_an_axis_of_its_own():
    points = [point("textures_astc", 5.0, 1.0), point("refined_astc", 2.0, 0.5)]
    points[1] = replace(points[1], bytes_on_wire=180)
    one = {"expressions": 20, "points": plain(points), "comparison": plain(compare(points))}
    words = " ".join(finding.here for finding in find({"rounds": [one]}))
    assert "0.90 for packs in ASTC, 0.80 for every texture in ASTC." in words
    shown = {against: [mark.title for mark in curves(one, 570.0, against).marks if mark.title] for against in SIZES}
    assert any("2.00 bytes a texel" in title for title in shown["GPU memory"])
    assert any("1.80 bytes a texel" in title for title in shown["files"])


def test_bits_and_decibels_are_the_bytes_and_the_error():
    character = random_character(side=32)
    found = Textures("textures_bc", bc7()).measure(character)
    count = len(character.expressions)
    # A byte a texel of neutral and expressions, which have three channels.
    assert found.bits == pytest.approx(8 * (1 + count) / (3 * count))
    assert found.psnr == pytest.approx(20 * np.log10(255 / found.rmse))


@pytest.mark.parametrize("character", [random_character(side=32), random_surface(side=32, tiles=(2, 1))])
def test_blends_lie_between_the_expressions_and_keep_them(character):
    count = len(character.expressions)
    more = experiment.with_blends(character, count + 4, seed=1)
    for key, stack in character.stacks.items():
        textures = more.stacks[key].textures
        assert np.array_equal(textures[:count], stack.textures)
        assert np.all(textures[count:] <= stack.textures.max(axis=0))
        assert np.all(textures[count:] >= stack.textures.min(axis=0))
        assert len(set(more.expressions)) == len(textures) == len(more.meshes.vertices) == count + 4
    with pytest.raises(FaceZipError) as caught:
        experiment.with_blends(character, count, seed=1)
    assert caught.value.code is ErrorCode.BAD_VALUE


def test_only_ranks_and_scales_that_a_character_allows_are_tried():
    few = random_surface(side=32, expressions=2)
    for way in tried(few, "fast"):
        assert way.family in FAMILIES
        assert isinstance(way, Textures) or way.differences <= 2


def test_the_page_loads_nothing_but_itself_and_names_run_nothing(document, tmp_path):
    page = Page(write_rates_report(document, tmp_path).read_text(encoding="utf-8"))
    assert [url for url in page.references if not url.startswith(("data:", "#"))] == []
    assert page.handlers == []
    assert page.count("img") == 0
    assert page.count("figure", "wide") == page.count("figure", "narrow") == 4


def test_json_beside_the_page_holds_the_document(document, tmp_path):
    write_rates_report(document, tmp_path)
    stored = json.loads((tmp_path / "rates.json").read_text(encoding="utf-8"))
    assert check(stored) == "rates"
    assert stored["rounds"] == plain(document.rounds)
    assert [one["expressions"] for one in stored["rounds"]] == [5, 7]
    assert stored["findings"]
