from dataclasses import replace

import numpy as np
import OpenImageIO as oiio

from facezip.character.maps import KNOWN, normals_of
from facezip.character.scans import Stack
from facezip.character.tiles import FIRST_TILE
from scenes.tiles import in_tiles
from tests.facezip.conftest import random_character


def random_surface(seed=0, side=64, expressions=5, maps=("normal", "roughness"), tiles=(1, 1)):
    """A sheet whose maps change in the same places, each in its own way."""
    albedo = random_character(seed, expressions, side)
    stacks = dict(albedo.stacks)
    for k, name in enumerate(maps):
        other = random_character(seed, expressions, side).first
        if KNOWN[name].is_normal:
            stacks[name, FIRST_TILE] = Stack(slopes(other.neutral), slopes(other.textures))
        else:
            channel = slice(k % 3, k % 3 + 1)
            stacks[name, FIRST_TILE] = Stack(other.neutral[..., channel].copy(), other.textures[..., channel].copy())
    kinds = tuple(KNOWN[name] for name in ("albedo", *maps))
    return in_tiles(replace(albedo, maps=kinds, stacks=stacks), *tiles)


def write_floats(path, values, kind="float"):
    spec = oiio.ImageSpec(values.shape[1], values.shape[0], values.shape[2], kind)
    output = oiio.ImageOutput.create(str(path))
    output.open(str(path), spec)
    assert output.write_image(np.ascontiguousarray(values))
    output.close()


def slopes(texels):
    """The first two channels as slopes of a normal map, as an 8-bit file of it is fitted."""
    vectors = normals_of((texels[..., :2] / np.float32(255) - np.float32(0.5)) * np.float32(1.6))
    return np.rint(KNOWN["normal"].encode(vectors) * 65535).astype(np.uint16)
