"""What maps do under light: those that say nothing change nothing, and the others do what their names say."""

from dataclasses import replace

import numpy as np
import pytest

from facezip.character.maps import KNOWN, MAX_SLOPE
from facezip.character.meshes import Meshes
from facezip.pack.model import CompressedTextures, Part
from facezip.pack.write import write_pack
from tests.browser.conftest import viewing
from tests.facezip.conftest import grid_topology

# What a skin without maps of them has, in docs/viewer.md.
ROUGHNESS, SPECULAR = 0.48, 0.42


def dome(mirrored=False):
    """A bump that looks at +z, u along x and v along y; or u against x."""
    topology = grid_topology(25)
    x, y = (2 * topology.uv - 1).T
    neutral = np.c_[10 * x, 10 * y, -4 * (x**2 + y**2)].astype(np.float32)
    uv = topology.uv * [-1, 1] + [1, 0] if mirrored else topology.uv
    return Meshes(replace(topology, uv=uv.astype(np.float32)), neutral, np.stack([neutral, neutral]))


SKIN = {"albedo": (0.7, 0.55, 0.45)}


@pytest.fixture
def lit(context, tmp_path):
    """Pixels of meshes under light, of constant maps on every tile: texels, or slopes (x/z, y/z) of normals."""

    def pixels(view="Skin", meshes=None, tiles=(1001,), **maps):
        kinds = tuple(KNOWN[name] for name in maps)
        parts = {}
        for kind, value in zip(kinds, maps.values(), strict=True):
            texel = 0.5 + np.divide(value, 2 * MAX_SLOPE) if kind.is_normal else np.atleast_1d(value)
            neutral = np.broadcast_to(texel, (8, 8, len(texel))).astype(np.float32)
            part = Part(neutral, np.zeros((1, *neutral.shape), np.float32), 16)
            parts |= {(kind.name, tile): part for tile in tiles}
        weights = {tile: np.zeros((2, 2, 2, 1), np.float32) for tile in tiles}
        model = CompressedTextures("refined", ("a", "b"), kinds, parts, weights, meshes or dome())
        pack = tmp_path / f"{len([*tmp_path.iterdir()])}.facezip"
        write_pack(model, pack)
        with viewing(context, pack) as viewer:
            viewer.choose("Show", view)
            return viewer.pixels()[..., :3].astype(float)

    return pixels


def test_maps_that_say_nothing_change_nothing(lit):
    plain = lit(**SKIN, roughness=ROUGHNESS)
    assert plain.max() > 100
    full = lit(**SKIN, normal=(0, 0), roughness=ROUGHNESS, specular=SPECULAR, cavity=1)
    assert np.abs(full - plain).max() <= 1


@pytest.mark.parametrize("mirrored", [False, True])
def test_relief_is_bright_where_it_faces_the_key_light(lit, mirrored):
    def brightness(x, y):
        return lit(**SKIN, meshes=dome(mirrored), normal=(-x if mirrored else x, y)).mean()

    # The key light comes from the left and above: normals have y up, and x along u.
    assert brightness(-0.4, 0) > 1.1 * brightness(0.4, 0)
    assert brightness(0, 0.4) > 1.1 * brightness(0, -0.4)


def test_rough_skin_has_broad_and_faint_highlights(lit):
    glossy, rough = (lit(**SKIN, roughness=roughness) for roughness in (0.3, 0.7))
    assert glossy.max() > rough.max() + 20


def test_specular_adds_light_and_a_cavity_takes_it(lit):
    dull, bright = (lit(**SKIN, roughness=0.4, specular=specular) for specular in (0, 1))
    assert (bright - dull).max() > 20
    deep, half, open_ = (lit(**SKIN, roughness=0.4, cavity=cavity) for cavity in (0, 0.5, 1))
    assert (deep <= half).all()
    assert (half <= open_).all()
    assert (open_ - deep).max() > 20


def test_clay_has_no_colours_but_the_same_relief(lit):
    skin, other = (lit("Clay", albedo=albedo, normal=(0.2, 0.1)) for albedo in (SKIN["albedo"], (0.1, 0.9, 0.3)))
    np.testing.assert_array_equal(skin, other)
    assert np.abs(skin - lit("Clay", **SKIN, normal=(-0.2, 0.1))).max() > 5


def test_relief_is_the_same_however_large_the_chart_is_and_on_how_many_tiles(lit):
    meshes, maps = dome(), {**SKIN, "normal": (0.2, 0.4)}
    wide = replace(meshes, topology=replace(meshes.topology, uv=meshes.topology.uv * np.float32([2, 1])))
    assert np.abs(lit(**maps, meshes=meshes) - lit(**maps, meshes=wide, tiles=(1001, 1002))).max() <= 1
