"""An export as an engine reads it: numbers from facezip.json alone, blocks by others' decoders."""

import json
from dataclasses import replace

import numpy as np
import OpenImageIO as oiio

from facezip.character.neutrals import unpacked_neutral
from facezip.files.images import read_texture_exactly, to_float
from facezip.pack.model import Part

# DXGI_FORMAT of a DDS file to the channels of its blocks, where those are not in one; where its blocks begin.
CHANNELS = {80: 1, 83: 2}
HEADER = 148


def texels_of(file, cut=False):
    """The finest level of a texture, ``(H, W, C)`` in [0, 1], as a sampler sees it.

    ``cut`` says that the sampler cuts what BC4 and BC5 interpolate down to 8 bits, as those of software do.
    """
    if file.suffix == ".png":
        return to_float(read_texture_exactly(file))
    content = np.frombuffer(file.read_bytes(), np.uint8)
    height, width, dxgi = (int.from_bytes(content[at : at + 4].tobytes(), "little") for at in (12, 16, 128))
    if dxgi not in CHANNELS:
        return to_float(oiio.ImageBuf(str(file)).get_pixels(oiio.UINT8))
    channels = CHANNELS[dxgi]
    blocks = content[HEADER:][: height * width * channels // 2].reshape(-1, channels, 8)
    return np.stack([interpolated(blocks[:, k], (height, width), cut) for k in range(channels)], axis=2)


def interpolated(blocks, size, cut=False):
    """Texels ``(H, W)`` in [0, 1] of blocks of BC4, 8 bytes each, as the format defines them."""
    width = size[1]
    texels = np.empty(size, np.float32)
    for number, block in enumerate(blocks):
        first, second = int(block[0]), int(block[1])
        steps = 7 if first > second else 5
        palette = [first, second, *((first * (steps - k) + second * k) / steps for k in range(1, steps)), 0, 255][:8]
        bits = int.from_bytes(block[2:].tobytes(), "little")
        top, left = number // (width // 4) * 4, number % (width // 4) * 4
        codes = np.array([bits >> 3 * k & 7 for k in range(16)])
        values = np.array(palette)[codes].reshape(4, 4)
        texels[top : top + 4, left : left + 4] = (np.floor(values) if cut else values) / 255
    return texels


def as_exported(model, folder, cut=False):
    """The textures of a pack of one tile as its export holds them; ``cut`` as of :func:`texels_of`."""
    facts = json.loads((folder / "facezip.json").read_text())
    textures, parts, (tile,) = facts["textures"], {}, model.tiles
    for kind in model.maps:
        place = facts["maps"][kind.name]
        channels = place["channels"]

        def texels(name, channels=channels):
            return np.ascontiguousarray(texels_of(folder / textures[name]["file"], cut)[..., channels])

        neutral = np.asarray(unpacked_neutral(texels(place["neutral"]), kind), np.float32)
        values = [
            (texels(name) - textures[name]["zero"]) * np.array(textures[name]["scale"])[channels]
            for name in place["differences"]
        ]
        parts[kind.name, tile] = Part(neutral, np.stack(values).astype(np.float32) / np.float32(kind.unit))
    return replace(model, parts=parts)
