"""Errors as they happen to textures between a scan and a shader, each as small as it is usually met."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from facezip.character.raster import rasterise
from facezip.character.scans import Character
from facezip.files.srgb import decode_srgb, encode_srgb
from facezip.pack.model import CompressedTextures

Texture = NDArray[np.float32]

# The middle of the right cheek, the side of the key lights, in halves of the head's size from its centre.
CHEEK = (-0.46, -0.01, 0.72)
# Radius of the error there over the head's height; it fades out over half as much again.
CHEEK_RADIUS = 0.07
CHEEK_GAIN = 1.01
SEAM_GAIN = 0.8


def injected_defects(model: CompressedTextures, expression: str, character: Character) -> dict[str, Texture]:
    """The texture ``(H, W, 3)``, encoded, that a model gives for an expression under each defect, by its name."""
    cheek = cheek_weights(character, character.first.resolution[0])
    on_texture: dict[str, Callable[[Texture], Texture]] = {
        "shift by one texel": lambda whole: np.roll(whole, 1, axis=1),
        "cheek 1 % too bright": lambda whole: brightened(whole, cheek),
        "seam one texel wide": seamed,
        "gamma 2.2 for sRGB": lambda whole: encode_srgb(np.power(whole, np.float32(2.2))),
        "flipped v": lambda whole: np.ascontiguousarray(whole[::-1]),
    }
    texture = model.reconstruct(expression)
    spoilt = {name: defect(texture) for name, defect in on_texture.items()}
    return {**spoilt, "swapped weight maps": swapped(model, expression).reconstruct(expression)}


def swapped(model: CompressedTextures, expression: str) -> CompressedTextures:
    """The model with the weight maps of an expression and of the one after it exchanged."""
    here = model.expressions.index(expression)
    order = np.arange(len(model.expressions))
    there = (here + 1) % len(order)
    order[[here, there]] = there, here
    return replace(model, weights={tile: maps[order] for tile, maps in model.weights.items()})


def seamed(texture: Texture) -> Texture:
    """A line one texel wide down the middle of the texture, of :data:`SEAM_GAIN` times the linear albedo."""
    linear = decode_srgb(texture)
    linear[:, texture.shape[1] // 2] *= np.float32(SEAM_GAIN)
    return encode_srgb(linear)


def brightened(texture: Texture, weights: Texture) -> Texture:
    """Linear albedo times :data:`CHEEK_GAIN` where ``(H, W)`` weights are 1, unchanged where they are 0."""
    gain = 1 + np.float32(CHEEK_GAIN - 1) * weights[..., None]
    return encode_srgb(np.minimum(decode_srgb(texture) * gain, 1))


def cheek_weights(character: Character, resolution: int) -> Texture:
    """``(R, R)`` weights in [0, 1] of a round spot on the right cheek, round on the surface."""
    vertices = character.meshes.neutral
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    spot = (low + high) / 2 + np.array(CHEEK, np.float32) * (high - low) / 2
    distance = np.linalg.norm(vertices - spot, axis=1) / ((high - low)[1] * CHEEK_RADIUS)
    raster = rasterise(character.meshes.topology, (resolution, resolution))
    inside = np.clip(3 - 2 * raster.interpolate(distance.astype(np.float32)), 0, 1)
    return np.where(raster.covered, inside, 0).astype(np.float32)
