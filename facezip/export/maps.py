"""The textures of an export: as PNG, or as blocks with fitted mip-maps in DDS or KTX2 files."""

import shutil
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from facezip.blocks.basis import uastc
from facezip.blocks.codecs import Codec, bc7, raw
from facezip.errors import ErrorCode, FaceZipError
from facezip.export.containers import BC7_UNORM, BLOCK_SIDE, UASTC, dds, ktx2
from facezip.export.levels import Level, averaged_levels, fitted_levels
from facezip.export.measured import codec_errors, measure_of, mip_errors
from facezip.export.mips import Pyramid, targets
from facezip.export.sheets import CHANNELS, Sheet
from facezip.export.source import Source, Tile
from facezip.files.images import write_texture
from facezip.pack.footprint import SLOTS_PER_LAYER
from facezip.pack.quantise import ZERO

Container = Callable[[tuple[int, int], Sequence[bytes], str], bytes]
Document = dict[str, Any]


@dataclass(frozen=True)
class Format:
    """How textures are stored.

    Attributes
    ----------
    name : of the codec, as documents state it.
    suffix : of the files.
    container : size, levels and name of a texture to the file's content; None for PNG.
    """

    name: str
    suffix: str
    container: Container | None = None

    def check(self, source: Source) -> None:
        """Raise ``BAD_VALUE`` where a pack's textures cannot be stored so."""
        for sheet in (sheet for tile in source.tiles for sheet in tile.sheets):
            if self.container and any(side % BLOCK_SIDE for side in sheet.size):
                height, width = sheet.size
                raise FaceZipError(
                    ErrorCode.BAD_VALUE,
                    f"{source.path}: textures of {width}x{height}; GPUs take blocks of whole {BLOCK_SIDE} texels a "
                    "side: use --textures png",
                )


PNG = Format("png", ".png")
DDS = Format("bc7", ".dds", lambda size, levels, name: dds(size, levels))
KTX2 = Format("bc7", ".ktx2", lambda size, levels, name: ktx2(size, levels, BC7_UNORM))
# glTF knows no BC7; its loaders transcode UASTC. The albedo's neutral is also shown on its own, as colour.
BASIS = Format("uastc", ".ktx2", lambda size, levels, name: ktx2(size, levels, UASTC, name == "neutral"))


def write_maps(tile: Tile, folder: Path, form: Format, upside_down: bool = False) -> Document:
    """Write the textures and weight maps of a tile into ``folder``.

    Parameters
    ----------
    tile : of a pack.
    form : of neutrals and differences; weight maps are PNGs always, since they are small and blocks would show.
    upside_down : whether blocks begin with the last row, as in Unity's memory.

    Returns
    -------
    ``textures``: by name the file, and the numbers that turn its texels t in [0, 1] back into values; ``maps``: by name
    where each is, the ``codec``'s errors and those of ``mips``; ``codec`` and ``mips`` of the first, which is the
    albedo.
    """
    textures: Document = {}
    maps: Document = {}
    loss: dict[str, float] = {}
    with _codec(form) as codec:
        for sheet in tile.sheets:
            pyramid = Pyramid(sheet.covered)
            plain = list(averaged_levels(sheet, pyramid, raw(CHANNELS)))
            if form.container is None or codec is None:
                _write_images(sheet, folder)
                measured = {name: {"mips": rows} for name, rows in mip_errors(sheet, pyramid, plain).items()}
            else:
                levels = list(fitted_levels(sheet, pyramid, plain, targets(sheet, pyramid), codec, upside_down))
                _write_blocks(sheet, levels, folder, form.container, form.suffix)
                measured = _measured(sheet, pyramid, codec, plain, levels)
                loss |= levels[0].loss
            textures |= _described(sheet, form.suffix)
            maps |= {kind.name: _placed(sheet, kind.name) | measured[kind.name] for kind, _ in sheet.maps}
    first = maps[tile.maps[0].name]
    stated: Document = {"name": form.name} | ({"maps": loss} if loss else {})
    return {
        "textures": textures | _weights(tile, folder),
        "maps": {kind.name: maps[kind.name] for kind in tile.maps},
        "codec": stated | first.get("codec", {}),
        "mips": first["mips"],
    }


def _codec(form: Format) -> AbstractContextManager[Codec | None]:
    if form.container is None:
        return nullcontext(None)
    return uastc() if form is BASIS else nullcontext(bc7())


def _write_images(sheet: Sheet, folder: Path) -> None:
    for name, image in zip(sheet.textures, sheet.stored(), strict=True):
        write_texture(folder / f"{name}.png", image)


def _write_blocks(sheet: Sheet, levels: list[Level], folder: Path, container: Container, suffix: str) -> None:
    for name in sheet.textures:
        content = container(sheet.size, [level.stored[name] for level in levels], name)
        (folder / f"{name}{suffix}").write_bytes(content)


def _measured(sheet: Sheet, pyramid: Pyramid, codec: Codec, plain: list[Level], levels: list[Level]) -> Document:
    averaged = list(averaged_levels(sheet, pyramid, codec))
    seen, afterwards = (codec_errors(sheet, pyramid, one[0]) for one in (levels, averaged))
    mips = mip_errors(sheet, pyramid, plain, averaged=averaged, fitted=levels)
    found = {}
    for kind, _ in sheet.maps:
        name, measure = kind.name, measure_of(kind)
        without = {f"{measure}_without_fit": afterwards[name][measure]}
        found[name] = {"codec": seen[name] | without, "mips": mips[name]}
    return found


def _placed(sheet: Sheet, name: str) -> Document:
    """Where a map is."""
    kind, at = next((kind, at) for kind, at in sheet.maps if kind.name == name)
    neutral, *differences = sheet.textures
    return {
        "encoding": kind.encoding,
        "range": [kind.low, kind.high],
        "size": list(sheet.size),
        "neutral": neutral,
        "differences": differences,
        "channels": list(range(at.start, at.stop)),
    }


def _described(sheet: Sheet, suffix: str) -> Document:
    entries: Document = {name: {"file": f"{name}{suffix}"} for name in sheet.textures}
    for entry, scale in zip(list(entries.values())[1:], sheet.scale_of_values, strict=True):
        entry |= {"scale": list(scale), "zero": ZERO / 255}
    return entries


def _weights(tile: Tile, folder: Path) -> Document:
    """Copies the pack's weight maps; uniform weights are constants in the shader."""
    entries: Document = {}
    for layer, file in enumerate(tile.weight_files):
        shutil.copyfile(file, folder / f"weights_{layer}.png")
        slots = slice(SLOTS_PER_LAYER * layer, SLOTS_PER_LAYER * (layer + 1))
        entries[f"weights_{layer}"] = {
            "file": f"weights_{layer}.png",
            "columns": tile.layout.weight_columns,
            "size": list(tile.layout.weight_size),
            "scale": list(tile.layout.weight_scale[slots]),
            "offset": list(tile.layout.weight_offset[slots]),
        }
    return entries
