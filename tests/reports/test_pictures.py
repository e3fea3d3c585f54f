"""Embedded pictures: each shows what its name says, framed alike."""

import base64
import io

import numpy as np
import pytest
from PIL import Image

from render.exr import read_exr, write_exr
from reports.images import BACKDROP, ColourScale, difference, display, to_bytes
from reports.pictures import HERO, OTHER, crops, embed
from tests.reports.conftest import SIZE, make_document

SCALE = ColourScale(16.0)


def pixels_of(uri):
    return np.asarray(Image.open(io.BytesIO(base64.b64decode(uri.partition(",")[2]))).convert("RGB"))


@pytest.fixture
def embedded(tmp_path):
    """The last render of a document of two packs without loss: its parts, its pictures and their crop."""
    document = make_document(tmp_path, packs=("a", "b"))
    render = document["renders"][-1]
    pictures = embed([(render, HERO)], tmp_path, 2, SCALE)[0]
    crop = crops([render], tmp_path)[render["view"]]
    return [crop.of(part) for part in read_exr(tmp_path / render["exr"]).values()], pictures, crop


def test_original_and_packs_are_the_parts_in_their_order(embedded):
    parts, pictures, crop = embedded
    for part, uri in zip(parts, (pictures.original, *pictures.compressed), strict=True):
        np.testing.assert_array_equal(pixels_of(uri), to_bytes(display(part)))
    assert pictures.size == crop.size


def test_differences_are_those_of_the_floats_and_only_on_the_head(embedded):
    parts, pictures, _ = embedded
    empty = parts[0][..., 3] == 0
    assert empty.any()
    for part, uri in zip(parts[1:], pictures.differences, strict=True):
        colours = pixels_of(uri)
        expected = SCALE.colours(difference(display(parts[0]), display(part)))
        np.testing.assert_array_equal(colours[~empty], expected[~empty])
        assert (colours[empty] == BACKDROP).all()


def test_a_render_against_itself_is_the_lowest_colour_everywhere(tmp_path):
    document = make_document(tmp_path, packs=())
    render = document["renders"][0]
    parts = read_exr(tmp_path / render["exr"])
    write_exr(tmp_path / render["exr"], {**parts, "1 same": parts["original"]}, {})
    pictures = embed([(render, HERO)], tmp_path, 1, SCALE)[0]
    seen = {tuple(colour) for colour in pixels_of(pictures.differences[0]).reshape(-1, 3).tolist()}
    assert seen == {BACKDROP, tuple(SCALE.table[0].tolist())}


def test_a_view_has_one_frame_for_all_expressions(tmp_path):
    document = make_document(tmp_path, views=("front", "side"))
    frames = crops(document["renders"], tmp_path)
    sizes = {pictures.size for pictures in embed([(r, OTHER) for r in document["renders"]], tmp_path, 1, SCALE)}
    assert sizes == {frame.size for frame in frames.values()}
    assert all(side < SIZE for size in sizes for side in size)
