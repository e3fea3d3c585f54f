"""A face as a rig of layers makes it: three wrinkle layers under twelve masks that overlap, driven from 0 to 1."""

from dataclasses import replace

import numpy as np

from facezip.character.loading import save_character
from facezip.character.maps import KNOWN, normals_of
from facezip.character.scans import Stack
from facezip.files.images import write_texture
from tests.facezip.surfaces import random_surface

SIDE, COUNT, MASKS = 64, 8, 12
# The first mask acts in two layers, as those of a MetaHuman's lips do.
NAMES = ["head_wm13_region0", *(f"head_wm{k % 3 + 1}_region{k}" for k in range(1, MASKS))]
LAYERS = {name: [0, 2] if name == NAMES[0] else [k % 3] for k, name in enumerate(NAMES)}


def spots():
    """``(12, H, W)``, in 0..1."""
    v, u = (np.mgrid[:SIDE, :SIDE] + 0.5) / SIDE
    places = [((k % 4 + 0.5) / 4, (k // 4 + 0.5) / 3) for k in range(MASKS)]
    return np.stack([np.exp(-12 * ((u - x) ** 2 + (v - y) ** 2)) for x, y in places])


def wrinkled(maps=("normal",)):
    """A character whose albedo and normals the layers of such a rig give."""
    rng = np.random.default_rng(0)
    v, u = (np.mgrid[:SIDE, :SIDE] + 0.5) / SIDE
    waves = np.stack([np.sin(9 * (u * np.cos(a) + v * np.sin(a)) + b) for a, b in rng.uniform(0, 6, (6, 2))])
    allowed = np.array([[layer in LAYERS[name] for layer in range(3)] for name in NAMES])
    driven = rng.uniform(0, 1, (COUNT, MASKS, 3)) * (rng.random((COUNT, MASKS, 3)) < 0.25) * allowed
    weights = np.einsum("nki,khw->nhwi", driven, spots())

    def smooth(size, channels):
        return size * np.einsum("bc,bhw->hwc", rng.uniform(-1, 1, (6, channels)), waves)

    def expressions(neutral, size):
        changes = np.stack([smooth(size, neutral.shape[2]) for _ in range(3)])
        return neutral + np.einsum("nhwi,ihwc->nhwc", weights, changes)

    skin, relief = 0.5 + smooth(0.08, 3), smooth(0.1, 2)
    sheet = random_surface(side=SIDE, expressions=COUNT, maps=maps)
    stacks = {
        ("albedo", 1001): Stack(colours(skin), colours(expressions(skin, 0.03))),
        ("normal", 1001): Stack(slopes(relief), slopes(expressions(relief, 0.05))),
    }
    return replace(sheet, stacks={**sheet.stacks, **stacks})


def colours(values):
    return np.rint(255 * np.clip(values, 0, 1)).astype(np.uint8)


def slopes(values):
    return np.rint(65535 * KNOWN["normal"].encode(normals_of(values.astype(np.float32)))).astype(np.uint16)


def write_wrinkled(folder):
    """The character as ``scans``, and ``masks`` as somebody brings them."""
    save_character(wrinkled(), folder / "scans")
    (folder / "masks").mkdir()
    for name, mask in zip(NAMES, spots(), strict=True):
        write_texture(folder / "masks" / f"{name}.png", colours(mask)[..., None])
    lines = ['activations = "0..1"', "[layers]", *(f"{name} = {layers}" for name, layers in LAYERS.items())]
    (folder / "masks" / "masks.toml").write_text("\n".join(lines) + "\n", encoding="utf-8")
