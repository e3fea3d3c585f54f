from dataclasses import replace

import numpy as np
import OpenImageIO as oiio

from facezip.character.maps import KNOWN, normals_of
from facezip.character.scans import Character
from facezip.character.tiles import FIRST_TILE
from scenes.surface import in_tiles
from tests.facezip.conftest import random_character


def random_surface(seed=0, side=64, expressions=5, maps=("normal", "roughness"), tiles=(1, 1)):
    """A sheet whose maps change in the same places, each in its own way."""
    albedo = random_character(seed, expressions, side)
    parts = {("albedo", FIRST_TILE): albedo}
    for k, name in enumerate(maps):
        other = random_character(seed, expressions, side)
        if KNOWN[name].is_normal:
            parts[name, FIRST_TILE] = replace(other, neutral=slopes(other.neutral), textures=slopes(other.textures))
        else:
            channel = slice(k % 3, k % 3 + 1)
            parts[name, FIRST_TILE] = replace(
                other, neutral=other.neutral[..., channel].copy(), textures=other.textures[..., channel].copy()
            )
    kinds = tuple(KNOWN[name] for name in ("albedo", *maps))
    return in_tiles(Character(albedo.topology, kinds, parts), *tiles)


def write_floats(path, values, kind="float"):
    spec = oiio.ImageSpec(values.shape[1], values.shape[0], values.shape[2], kind)
    output = oiio.ImageOutput.create(str(path))
    output.open(str(path), spec)
    assert output.write_image(np.ascontiguousarray(values))
    output.close()


def slopes(texels):
    """The first two channels as slopes of a normal map, as an 8-bit file of it is fitted."""
    vectors = normals_of((texels[..., :2] / np.float32(255) - np.float32(0.5)) * np.float32(1.6))
    return np.rint(KNOWN["normal"].fitted(vectors) * 65535).astype(np.uint16)
