"""Figures of docs/engines.md and docs/maps.md.

``python -m tests.facezip.export.figures CHARACTER PACK EXPORT``: the errors of a DDS export of one tile against the
originals. Everything is read as an engine would: blocks by OpenImageIO's decoder, numbers from facezip.json alone.

``python -m tests.facezip.export.figures PACK``: what BC7 adds to maps that share textures, and to each in its own.
"""

import json
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import OpenImageIO as oiio

from facezip.blocks.codecs import bc7, raw
from facezip.character.loading import load_character
from facezip.character.neutrals import unpacked_neutral
from facezip.export.levels import averaged_levels, fitted_levels
from facezip.export.measured import codec_errors, measure_of
from facezip.export.mips import Pyramid, targets
from facezip.export.sheets import in_sheets
from facezip.export.source import read_source
from facezip.pack.errors import model_errors
from facezip.pack.read import read_pack


def exported(surface, folder):
    """The surface that an export holds."""
    facts = json.loads((folder / "facezip.json").read_text())
    textures, parts, (tile,) = facts["textures"], {}, surface.tiles
    for kind in surface.maps:
        place = facts["maps"][kind.name]

        def texels(name, channels=place["channels"]):
            image = oiio.ImageBuf(str(folder / textures[name]["file"])).get_pixels(oiio.UINT8)
            return np.ascontiguousarray(image[..., channels])

        neutral = unpacked_neutral(texels(place["neutral"]), kind)
        neutral = neutral if neutral.dtype == np.float32 else neutral / np.float32(255)
        values = [
            (texels(name) / 255 - textures[name]["zero"]) * np.array(textures[name]["scale"])[place["channels"]]
            for name in place["differences"]
        ]
        part = surface.parts[kind.name, tile]
        differences = np.stack(values).astype(np.float32) / np.float32(kind.unit)
        parts[kind.name, tile] = replace(part, neutral=neutral, differences=differences)
    return replace(surface, parts=parts)


def to_originals(character, pack, folder):
    scans, surface = load_character(character), read_pack(pack)
    for name, shown in (("pack", surface), ("export", exported(surface, Path(folder)))):
        errors = model_errors(scans, shown)
        means = [f"{kind.name} {errors[kind.name][measure_of(kind)]:.3f}" for kind in scans.maps]
        print(f"{name:8s} to the originals: {', '.join(means)}")


def of_sheets(pack):
    for tile in read_source(Path(pack)).tiles:
        apart = [alone(sheet, kind, at) for sheet in tile.sheets for kind, at in sheet.maps]
        for name, sheets in (("together", in_sheets(apart)), ("apart", apart)):
            for sheet in sheets:
                pyramid = Pyramid(sheet.covered)
                plain = list(averaged_levels(sheet, pyramid, raw(3)))
                level = next(fitted_levels(sheet, pyramid, plain, targets(sheet, pyramid), bc7()))
                for kind, error in codec_errors(sheet, pyramid, level).items():
                    print(f"{name:8s} {kind:10s} BC7 adds {next(iter(error.values())):.3f}")


def alone(sheet, kind, at):
    """A map of a sheet as a sheet of its own."""
    model = replace(
        sheet.model, neutral=sheet.model.neutral[..., at].copy(), differences=sheet.model.differences[..., at].copy()
    )
    maps = ((kind, slice(0, at.stop - at.start)),)
    return replace(sheet, maps=maps, model=model, difference_scale=sheet.difference_scale[:, at])


if __name__ == "__main__":
    (to_originals if len(sys.argv) > 2 else of_sheets)(*sys.argv[1:])
