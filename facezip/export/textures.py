"""The textures of an export, what is measured of them, and what its document says of them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from facezip.blocks.codecs import Codec, raw
from facezip.character.maps import MAX_SLOPE
from facezip.export.containers import Pieces
from facezip.export.documents.maps import CodecErrors, ExportedMap, MipErrors
from facezip.export.documents.textures import ExportedTexture
from facezip.export.formats import Format
from facezip.export.joining import CHANNELS
from facezip.export.levels import averaged_levels, fitted_levels
from facezip.export.measured import codec_errors, mip_errors, stated
from facezip.export.mips import Pyramid, targets
from facezip.export.sheets import Sheet
from facezip.export.source import Tile
from facezip.files.images import Texels, write_texture
from facezip.machine import memory
from facezip.pack.footprint import SLOTS_PER_LAYER
from facezip.pack.quantise import ZERO

# What a file of the lower bits is called.
LOW = "_low"
# Bytes that are written at a time.
PIECE = 2**22

# Of a map: of blocks what the codec adds, and its mip-maps.
Measured = tuple[CodecErrors | None, list[MipErrors]]


@dataclass(frozen=True)
class WrittenMaps:
    """The textures and weight maps of a tile.

    Attributes
    ----------
    textures : by name the file, and the numbers that turn its texels t in [0, 1] back into values.
    maps : by name where each is, and what was measured of it.
    codec, mips : of the first map, which is the albedo; with what storing lost of each texture.
    """

    textures: Mapping[str, ExportedTexture]
    maps: Mapping[str, ExportedMap]
    codec: CodecErrors
    mips: Sequence[MipErrors]


def write_maps(tile: Tile, folder: Path, form: Format, upside_down: bool = False) -> WrittenMaps:
    """Write the textures and weight maps of a tile into ``folder``.

    Parameters
    ----------
    tile : of a pack.
    form : of neutrals and differences; weight maps are PNGs always, since they are small and blocks would show.
    upside_down : whether blocks begin with the last row, as in Unity's memory.
    """
    textures: dict[str, ExportedTexture] = {}
    maps: dict[str, ExportedMap] = {}
    loss: dict[str, float] = {}
    with form.codecs() as codecs:
        for sheet in tile.sheets:
            codec = codecs.get(sheet.channels)
            if codec is None:
                measured, lost = _write_images(sheet, folder, form), dict[str, float]()
            else:
                measured, lost = _write_blocks(sheet, folder, form, codec, upside_down)
            suffix = form.suffix_of(codec.name if codec else form.name)
            textures |= _described(sheet, suffix)
            if _is_halved(sheet.neutral, form):
                neutral = sheet.textures[0]
                textures[neutral] = replace(textures[neutral], low=f"{neutral}{LOW}{suffix}")
            maps |= {kind.name: _placed(sheet, kind.name, *measured[kind.name]) for kind, _ in sheet.maps}
            loss |= lost
    first = maps[tile.maps[0].name]
    return WrittenMaps(
        textures | _weights(tile, folder),
        {kind.name: maps[kind.name] for kind in tile.maps},
        replace(first.codec or CodecErrors(name=form.name), maps=loss or None),
        first.mips,
    )


def _write_images(sheet: Sheet, folder: Path, form: Format) -> dict[str, Measured]:
    """What is measured of each map."""
    for name, image in zip(sheet.textures, sheet.images(), strict=True):
        if _is_halved(image, form):
            # The lower byte lies first.
            low, image = np.moveaxis(image.astype("<u2")[..., None].view(np.uint8), -1, 0)
            write_texture(folder / f"{name}{LOW}{form.suffix}", low)
        write_texture(folder / f"{name}{form.suffix}", image)
    part, pyramid = sheet.dequantised(), Pyramid(sheet.fill)
    plain = list(averaged_levels(sheet, part, pyramid, raw(CHANNELS)))
    return {name: (None, rows) for name, rows in mip_errors(sheet, part, pyramid, plain).items()}


def _is_halved(texels: Texels, form: Format) -> bool:
    return form.halves and texels.dtype == np.uint16


def _write_blocks(
    sheet: Sheet, folder: Path, form: Format, codec: Codec, upside_down: bool
) -> tuple[dict[str, Measured], dict[str, float]]:
    """What is measured of each map, and what storing lost of each texture."""
    part, pyramid = sheet.dequantised(), Pyramid(sheet.fill)
    plain = list(averaged_levels(sheet, part, pyramid, raw(CHANNELS)))
    levels = list(fitted_levels(sheet, part, pyramid, plain, targets(sheet, part, pyramid), codec, upside_down))
    for name in sheet.textures:
        stored = [level.stored[name] for level in levels]
        _write(form.pieces(sheet.size, stored, codec.name, name), folder / f"{name}{form.suffix_of(codec.name)}")
    averaged = list(averaged_levels(sheet, part, pyramid, codec))
    seen, afterwards = (codec_errors(sheet, part, pyramid, one[0].part) for one in (levels, averaged))
    mips = mip_errors(sheet, part, pyramid, plain, averaged=averaged, fitted=levels)
    errors = {kind.name: stated(kind, codec.name, seen[kind.name], afterwards[kind.name]) for kind, _ in sheet.maps}
    return {name: (error, mips[name]) for name, error in errors.items()}, levels[0].loss


def _write(pieces: Pieces, file: Path) -> None:
    with open(file, "wb") as content:
        for piece in pieces:
            for start in range(0, len(piece), PIECE):
                content.write(piece[start : start + PIECE])
                memory.ease()


def _placed(sheet: Sheet, name: str, codec: CodecErrors | None, mips: Sequence[MipErrors]) -> ExportedMap:
    """Where a map is, and what was measured of it."""
    kind, at = next((kind, at) for kind, at in sheet.maps if kind.name == name)
    neutral, *differences = sheet.textures
    return ExportedMap(
        encoding=kind.encoding,
        range=(kind.low, kind.high),
        size=sheet.size,
        neutral=neutral,
        differences=differences,
        channels=tuple(range(at.start, at.stop)),
        max_slope=MAX_SLOPE if kind.is_normal else None,
        codec=codec,
        mips=mips,
    )


def _described(sheet: Sheet, suffix: str) -> dict[str, ExportedTexture]:
    neutral, *differences = sheet.textures
    return {neutral: ExportedTexture(file=f"{neutral}{suffix}")} | {
        name: ExportedTexture(file=f"{name}{suffix}", scale=span, zero=ZERO / 255)
        for name, span in zip(differences, sheet.span_of_values, strict=True)
    }


def _weights(tile: Tile, folder: Path) -> dict[str, ExportedTexture]:
    """Writes the pack's weight maps as they are, or those made of masks; uniform ones are constants in the shader."""
    entries = {}
    for layer, image in enumerate(tile.weight_images):
        file = folder / f"weights_{layer}.png"
        if isinstance(image, bytes):
            file.write_bytes(image)
        else:
            write_texture(file, image)
        slots = slice(SLOTS_PER_LAYER * layer, SLOTS_PER_LAYER * (layer + 1))
        entries[f"weights_{layer}"] = ExportedTexture(
            file=file.name,
            columns=tile.layout.weight_columns,
            size=tile.layout.weight_size,
            scale=tile.layout.weight_span[slots],
            offset=tile.layout.weight_offset[slots],
        )
    return entries
