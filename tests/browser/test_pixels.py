"""The viewer's pixels and vertices are those of the model: at most one step of 255 anywhere, for every map and tile."""

from pathlib import Path

import numpy as np
import pytest

from facezip.character.maps import Map
from facezip.pack.read import read_pack
from facezip.pack.write import write_pack
from tests.browser.conftest import viewing
from tests.facezip.conftest import random_model
from tests.facezip.viewer.models import DEPTH, random_maps, random_scans

GOLDEN = Path(__file__).parents[1] / "data"
BLENDS = ({}, {"expr_1": 1.0}, {"expr_0": 0.35, "expr_2": 0.8})
CASES = {
    "weights wider than high": {"maps": ("albedo",), "size": (96, 128), "weights": (12, 16), "expressions": 5},
    "six differences on two tiles": {"slots": 6, "tiles": (1001, 1002)},
    "uniform weights": {"maps": ("albedo", "normal"), "size": (64, 48), "weights": (1, 1)},
    "neutrals of 16 bits": {"bits": 16},
    "nine masks, six differences on two tiles": {"masks": 9, "slots": 6, "tiles": (1001, 1002)},
    "every map on three tiles": {
        "maps": ("albedo", "normal", "roughness", "specular", "cavity"), "tiles": (1001, 1003, 1012),
    },
    "grey, a range, two and three channels": {
        "maps": ("albedo", DEPTH, Map("flow", "data"), Map("tint", "srgb"), Map("detail", "normal", -1.0, 1.0)),
        "channels": {"albedo": 1, "flow": 2},
    },
}  # fmt: skip


def written(model, folder):
    write_pack(model, folder / "random.facezip")
    return folder / "random.facezip"


def as_shown(model, kind, tile, blend):
    """The map of a blend on a tile in 255, ``(H, W, 3)``: what has one channel is grey, a second one is green."""
    values = 255 * (model.blend(blend, map=kind.name, tile=tile) - kind.low) / (kind.high - kind.low)
    if values.shape[2] == 1:
        return np.repeat(values, 3, axis=2)
    return np.pad(values, [(0, 0), (0, 0), (0, 3 - values.shape[2])])


def lay_flat(viewer, model):
    if model.meshes:
        viewer.choose("Surface", "Layout")
    viewer.switch("Texel = pixel", True)


def assert_layouts(viewer, model, blends, most=1):
    """Every map on every tile, within ``most`` of 255 of the model's."""
    lay_flat(viewer, model)
    for kind in model.maps:
        if len(model.maps) > 1:
            viewer.choose("Map", kind.name)
        for blend in blends:
            viewer.slide(blend)
            for t, tile in enumerate(model.tiles):
                error = np.abs(viewer.layout(t) - as_shown(model, kind, tile, blend))
                assert error.max() <= most, (kind.name, tile, blend)


@pytest.mark.parametrize("case", CASES)
def test_the_layout_shows_the_blend(context, tmp_path, case):
    pack = written(random_maps(**{"size": (32, 48), **CASES[case]}), tmp_path)
    with viewing(context, pack) as viewer:
        assert_layouts(viewer, read_pack(pack), BLENDS)


def test_a_pack_without_meshes_shows_the_blend(context, tmp_path):
    pack = written(random_model(size=(32, 32), weights=(4, 4)), tmp_path)
    with viewing(context, pack) as viewer:
        assert_layouts(viewer, read_pack(pack), BLENDS)


@pytest.mark.parametrize("version", [1, 2])
def test_packs_of_old_versions_show_the_blend(context, version):
    pack = GOLDEN / f"pack-{version}" / "golden.facezip"
    with viewing(context, pack) as viewer:
        assert_layouts(viewer, read_pack(pack), ({"smile": 0.6, "frown": 0.5},))


def test_every_slider_moves_the_vertices(context, tmp_path):
    pack = written(random_model(meshes=True), tmp_path)
    model = read_pack(pack)
    weights = dict(zip(model.expressions, (0.25, 1.0, 0.6), strict=True))
    with viewing(context, pack) as viewer:
        for blend in ({}, *({name: 0.7} for name in weights), weights):
            viewer.slide(blend)
            viewer.pixels()
            shown = np.reshape(viewer.page.evaluate("Array.from(facezip.stage.head.face.vertices)"), (-1, 3))
            betas = np.array([blend.get(name, 0) for name in model.expressions])
            expected = model.meshes.neutral + np.tensordot(betas, model.meshes.deltas, 1)
            np.testing.assert_allclose(shown, expected, atol=1e-5)


BLEND = {"expr_1": 0.5, "expr_2": 0.25}


def original(scans, name, tile):
    """What the scans blend to, unit vectors of normals: (1 - Σβ) I_0 + Σ β I_n, of normals over slopes."""
    stack, kind = scans.stacks[name, tile], scans.kind(name)
    betas = np.array([BLEND.get(expression, 0) for expression in scans.expressions])
    texels = stack.scale * (stack.neutral + np.tensordot(betas, stack.textures.astype(float) - stack.neutral, 1))
    return kind.decode(np.clip(texels, 0, 1).astype(np.float32))


def in_255(values):
    values = 127.5 * (values + 1) if values.shape[2] == 3 and values.min() < 0 else 255 * values
    return np.repeat(values, 3, axis=2) if values.shape[2] == 1 else values


def test_the_wipe_has_the_originals_on_its_left(context, tmp_path):
    pack = written(random_maps(size=(64, 64), weights=(8, 8), tiles=(1001,)), tmp_path)
    model = read_pack(pack)
    scans = random_scans(model)
    with viewing(context, pack, scans) as viewer:
        lay_flat(viewer, model)
        viewer.slide(BLEND)
        for kind in model.maps:
            viewer.choose("Map", kind.name)
            viewer.choose("Side", "Wipe")
            half = viewer.layout()
            viewer.choose("Side", "Original")
            whole = viewer.layout()
            theirs, ours = in_255(original(scans, kind.name, 1001)), as_shown(model, kind, 1001, BLEND)
            assert np.abs(whole - theirs).max() <= 2
            assert np.abs(half[:, :30] - theirs[:, :30]).max() <= 2
            assert np.abs(half[:, 34:] - ours[:, 34:]).max() <= 1


def heat(share):
    """The scale under the view of errors, ``(..., 3)`` of 255, at shares of its range."""
    stops = [(0.02, 0.02, 0.06), (0.32, 0.1, 0.47), (0.78, 0.23, 0.38), (0.99, 0.62, 0.25), (1.0, 0.98, 0.8)]
    places = np.linspace(0, 1, len(stops))
    return 255 * np.stack([np.interp(share, places, [stop[c] for stop in stops]) for c in range(3)], axis=-1)


def test_errors_are_parts_of_255_and_of_normals_angles(context, tmp_path):
    pack = written(random_maps(size=(64, 64), weights=(8, 8), tiles=(1002,)), tmp_path)
    model = read_pack(pack)
    scans = random_scans(model)
    with viewing(context, pack, scans) as viewer:
        lay_flat(viewer, model)
        viewer.slide(BLEND)
        viewer.choose("Show", "Error")
        for kind in model.maps:
            viewer.choose("Map", kind.name)
            ours, theirs = model.blend(BLEND, map=kind.name), original(scans, kind.name, 1002)
            if kind.is_normal:
                share = np.degrees(np.arccos(np.clip((ours * theirs).sum(axis=2), -1, 1))) / 8
            else:
                share = 255 * np.abs(ours - theirs).max(axis=2) / 16
            # A step of an original of 8 bits is 1/16 of the range, of normals less.
            assert np.abs(viewer.layout() - heat(share)).mean() <= 4
            assert np.corrcoef(viewer.layout().sum(axis=2).ravel(), heat(share).sum(axis=2).ravel())[0, 1] > 0.99
