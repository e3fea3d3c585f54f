"""Figures of docs/engines.md: what a page on the web loads, and what that takes on the GPU.

``python -m tests.facezip.export.wire CHARACTER PACK`` (needs Node.js and ``npm ci --prefix tests/node``): for a pack
and for every texture of the albedo alone, in each format the fetches a pixel, the megabytes of files and of GPU memory,
both without mip-maps, which add a third, and the RMSE to the originals.
"""

import os
import struct
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

from facezip.blocks.basis import uastc
from facezip.blocks.supercompression import supercompress
from facezip.character.loading import load_character
from facezip.export.source import read_source
from facezip.files.images import png, to_float
from facezip.pack.errors import model_errors, texture_errors
from facezip.pack.model import Part
from facezip.pack.read import read_pack
from tests.conftest import NODE
from tests.facezip.export.figures import coded

ETC1S_QUALITIES = 128, 255
# Bytes a texel on the GPU: PNGs are RGBA there, UASTC becomes BC7 or ASTC 4 x 4, ETC1S stays ETC1.
RGBA, BC7, ETC1 = 4.0, 1.0, 0.5


def main(character, pack):
    os.environ["NODE_PATH"] = str(NODE / "node_modules")
    scans, model = load_character(character).only("albedo"), read_pack(pack)
    (key,) = scans.stacks
    images = [scans.texels(name, key) for name in ("neutral", *scans.expressions)]
    (tile,) = read_source(Path(pack)).tiles
    (sheet,) = tile.sheets
    weights = [image if isinstance(image, bytes) else png(image) for image in tile.weight_images]
    maps = sum(image.size for image in model.weights[tile.layout.number])
    line("every texture, PNG", len(images), sum(len(png(image)) for image in images), RGBA * texels(images), 0.0)
    for quality in ETC1S_QUALITIES:
        sizes, seen = zip(*etc1s(images, quality), strict=True)
        line(f"every texture, ETC1S {quality}", len(images), sum(sizes), ETC1 * texels(images), rmse(scans, key, seen))
    with uastc() as codec:
        stored = [codec.store(image) for image in images]
        seen = [codec.load(one, image.shape) for one, image in zip(stored, images, strict=True)]
        size = sum(len(supercompress(one)) for one in stored)
        line("every texture, UASTC", len(images), size, BC7 * texels(images), rmse(scans, key, seen))
        part, levels, _ = coded(sheet, codec)
    own, rest = list(sheet.images()), sum(map(len, weights))
    fetches = len(own) + len(weights)
    error = model_errors(scans, model)["albedo"].rmse
    line("pack, PNG", fetches, rest + sum(len(png(image)) for image in own), RGBA * texels(own) + maps, error)
    shown = replace(model, parts={key: Part(part.neutral, part.differences)})
    size = rest + sum(len(supercompress(blocks)) for blocks in levels[0].stored.values())
    line("pack, UASTC", fetches, size, BC7 * texels(own) + maps, model_errors(scans, shown)["albedo"].rmse)


def texels(images):
    return sum(image.shape[0] * image.shape[1] for image in images)


def rmse(scans, key, seen):
    by_name = dict(zip(("neutral", *scans.expressions), seen, strict=True))
    return texture_errors(scans, lambda name, _: to_float(by_name[name]))["albedo"].rmse


def etc1s(images, quality):
    """Bytes of the file, and what a sampler sees of each image."""
    command = ["node", str(NODE / "etc1s.mjs"), str(quality)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as encoder:
        for image in images:
            height, width = image.shape[:2]
            rgba = np.full((height, width, 4), 255, np.uint8)
            rgba[..., :3] = image
            encoder.stdin.write(struct.pack("<II", width, height) + rgba.tobytes())
            encoder.stdin.flush()
            (size,) = struct.unpack("<I", encoder.stdout.read(4))
            seen = np.frombuffer(encoder.stdout.read(rgba.nbytes), np.uint8).reshape(rgba.shape)
            yield size, seen[..., :3]
        encoder.stdin.close()


def line(name, fetches, files, memory, error):
    print(f"{name:24} {fetches:3} fetches {files / 1e6:7.2f} MB {memory / 1e6:7.2f} MB {error:6.2f}", flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
