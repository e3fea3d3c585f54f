"""Figures of docs/engines.md: what blocks cost, of maps that share textures and of maps that have their own.

``python -m tests.facezip.export.figures CHARACTER PACK``: for each way to store a pack its fetches a pixel, the bytes
of its textures with mip-maps, and by map the error that coding adds to the expressions (afterwards, and as written) and
the error to the originals. The first line is the pack itself.
"""

import sys
from dataclasses import replace
from pathlib import Path

from facezip.blocks.codecs import bc4, bc5, bc7, raw
from facezip.character.loading import load_character
from facezip.export.joining import CHANNELS
from facezip.export.levels import averaged_levels, fitted_levels
from facezip.export.measured import codec_errors
from facezip.export.mips import Pyramid, targets
from facezip.export.source import APART, TOGETHER, read_source
from facezip.pack.errors import model_errors
from facezip.pack.model import Part
from facezip.pack.read import read_pack

BC7 = dict.fromkeys((1, 2, 3), bc7())
BC754 = {1: bc4(), 2: bc5(), 3: bc7()}
WAYS = {
    "together": (TOGETHER, BC7), "apart, BC7": (APART, BC7), "apart, BC7, BC5 and BC4": (APART, BC754),
}  # fmt: skip


def main(character, pack):
    scans, model = load_character(character), read_pack(pack)
    print("pack:", words(means(scans, model)))
    for way, (maps, codecs) in WAYS.items():
        parts, size, fetches, added, afterwards = {}, 0, 0, {}, {}
        for tile in read_source(Path(pack), maps).tiles:
            fetches = sum(len(sheet.textures) for sheet in tile.sheets) + len(tile.weight_images)
            for sheet in tile.sheets:
                part, levels, errors = coded(sheet, codecs[sheet.channels])
                size += sum(len(stored) for level in levels for stored in level.stored.values())
                for found, those in zip((added, afterwards), errors, strict=True):
                    found |= {name: error.mean for name, error in those.items()}
                for kind, at in sheet.maps:
                    own = Part(part.neutral[..., at], part.differences[..., at])
                    parts[kind.name, tile.layout.number] = own
        print(f"{way}: {fetches} fetches, {size / 1e6:.2f} MB")
        print("  coded afterwards adds:", words(afterwards))
        print("  as written adds:      ", words(added))
        print("  to the originals:     ", words(means(scans, replace(model, parts=parts))))


def coded(sheet, codec):
    """What a sampler sees of a sheet, its levels, and what coding adds, as written and afterwards."""
    part, pyramid = sheet.dequantised(), Pyramid(sheet.fill)
    plain = list(averaged_levels(sheet, part, pyramid, raw(CHANNELS)))
    levels = list(fitted_levels(sheet, part, pyramid, plain, targets(sheet, part, pyramid), codec))
    averaged = next(averaged_levels(sheet, part, pyramid, codec))
    errors = [codec_errors(sheet, part, pyramid, seen) for seen in (levels[0].part, averaged.part)]
    return levels[0].part, levels, errors


def means(scans, model):
    """The error of each map over expressions: of normals degrees, else parts of 255."""
    return {name: errors.mean for name, errors in model_errors(scans, model).items()}


def words(errors):
    return ", ".join(f"{name} {error:.3f}" for name, error in errors.items())


if __name__ == "__main__":
    main(*sys.argv[1:])
