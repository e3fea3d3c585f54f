"""``facezip decompress``: textures out of a pack, of expressions or of a blend."""

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import click
import numpy as np

from facezip.character.folder import file_name, write_map
from facezip.character.maps import Map
from facezip.character.scans import unknown
from facezip.character.tiles import FIRST_TILE
from facezip.commands import options
from facezip.documents.document import Document
from facezip.errors import ErrorCode, FaceZipError
from facezip.files.images import write_texture
from facezip.files.writing import whole_folder
from facezip.fit.painted import as_painted
from facezip.machine.memory import beside, limited
from facezip.machine.progress import track
from facezip.names import one_form
from facezip.pack.model import CompressedTextures
from facezip.pack.read import read_bytes, read_pack

BLEND_FILE = "blend"
_WEIGHTS = re.compile(r".+\.difference_\d\.png", re.DOTALL)


@dataclass(frozen=True, kw_only=True)
class DecompressDocument(Document):
    """What ``facezip decompress`` wrote.

    Attributes
    ----------
    output : the folder.
    textures : names of the files in it.
    """

    format: Literal["facezip-decompress/1"] = "facezip-decompress/1"
    output: str
    textures: Sequence[str]


@click.command("decompress")
@click.argument("pack", type=options.FOLDER)
@click.option("-o", "--output", type=options.FOLDER, required=True, metavar="DIR", help="Folder for the textures.")
@click.option("--expression", "names", multiple=True, metavar="NAME", help="Only this expression. May be repeated.")
@click.option("--blend", metavar="NAME=0.5,NAME=1", help=f"One blend of expressions, as {BLEND_FILE}.png.")
@click.option(
    "--weights",
    is_flag=True,
    help="Weight maps instead: NAME.difference_0.png …, to be painted over and given to 'compress --lock-weights'.",
)
@options.memory
@options.overwrite
@options.as_json
def command(
    pack: Path,
    output: Path,
    names: tuple[str, ...],
    blend: str | None,
    weights: bool,
    memory: int | None,
    overwrite: bool,
    as_json: bool,
) -> None:
    """Write the textures of PACK at full size: of every expression, of some, or of one blend (equation 8).

    All maps and tiles are written: NAME.png, NAME.normal.png, NAME.1002.png …. Floats that were kept outside 0..1
    become OpenEXR.
    """
    if weights and blend is not None:
        raise click.UsageError("--weights are of expressions: leave --blend out")
    with limited(memory, beside(output)):
        textures = (
            _weights(pack, output, names, overwrite) if weights else _decompress(pack, output, names, blend, overwrite)
        )
    document = DecompressDocument(output=str(output), textures=textures)
    options.answer(document, as_json, lambda: [f"{output}: {len(textures)} texture(s)"])


def _decompress(pack: Path, output: Path, names: tuple[str, ...], blend: str | None, overwrite: bool) -> list[str]:
    """Write the textures; the names of their files."""
    model = read_pack(pack)
    blends = _blends(model, names, blend)
    _check_names([name for weights in blends.values() for name in weights], model.expressions, pack)
    known = {stem for name in (*model.expressions, BLEND_FILE) for stem in _stems(model, name).values()}
    textures = []

    def ours(folder: Path) -> bool:
        return folder.is_dir() and all(
            file.stem in known and file.suffix in (".png", ".exr") for file in folder.iterdir()
        )

    with whole_folder(output, overwrite, ours) as folder:
        for name in track(blends, "Decompressing", len(blends)):
            for (kind, tile), stem in _stems(model, name).items():
                key = kind.name, tile
                texels = model.texels(blends[name], key)
                textures.append(write_map(folder / stem, texels, kind, model.parts[key].bits).name)
    return textures


def _weights(pack: Path, output: Path, names: tuple[str, ...], overwrite: bool) -> list[str]:
    """Write weight maps; the names of their files."""
    manifest, stored = read_bytes(pack)
    if manifest.masks or manifest.uniform_weights:
        reason = "its weights are activations of masks" if manifest.masks else "its weights are one number a layer"
        raise FaceZipError(
            ErrorCode.BAD_VALUE, f"{pack}: {reason}; --weights needs a pack of --method refined or paper"
        )
    chosen = tuple(map(one_form, names or stored.expressions))
    _check_names(chosen, stored.expressions, pack)
    tiles, nonnegative = tuple(stored.weights), manifest.made_with.get("nonnegative") is True
    files: list[str] = []

    def ours(folder: Path) -> bool:
        return folder.is_dir() and all(_WEIGHTS.fullmatch(file.name) for file in folder.iterdir())

    with whole_folder(output, overwrite, ours) as folder:
        for tile in tiles:
            weights, number = stored.weight_maps(tile), "" if tiles == (FIRST_TILE,) else f".{tile}"
            for slot, table in enumerate(as_painted(weights, nonnegative)):
                for name in chosen:
                    texels = weights.texels[stored.expressions.index(name), :, :, slot, None]
                    files.append(f"{name}{number}.difference_{slot}.png")
                    write_texture(folder / files[-1], table[texels.astype(np.uint8, copy=False)])
    return files


def _check_names(names: Iterable[str], expressions: tuple[str, ...], pack: Path) -> None:
    for name in names:
        if one_form(name) not in expressions:
            raise unknown("expression", name, expressions, str(pack))


def _stems(model: CompressedTextures, name: str) -> dict[tuple[Map, int], str]:
    """What each map on each tile is called, without its suffix."""
    tiles = model.tiles
    return {(kind, tile): file_name(name, kind, tile, tiles) for kind in model.maps for tile in tiles}


def _blends(model: CompressedTextures, names: tuple[str, ...], blend: str | None) -> dict[str, dict[str, float]]:
    if blend is not None:
        return {BLEND_FILE: parse_blend(blend, model.expressions)}
    return {name: {name: 1.0} for name in map(one_form, names or model.expressions)}


def parse_blend(text: str, expressions: Iterable[str]) -> dict[str, float]:
    """``"smile=0.5,blink=1"`` as a dictionary; ``BAD_VALUE`` for anything else, and for a name that is there twice.

    Names may hold ``,`` and ``=``: where the text goes on with several of ``expressions``, the longest is meant.
    """
    known = "|".join(map(re.escape, sorted(expressions, key=len, reverse=True)))
    item = re.compile(rf"\s*({known}|[^,]*)\s*=([^,=]*),", re.DOTALL)
    rest, weights = f"{one_form(text)},", dict[str, float]()
    try:
        while rest:
            found = item.match(rest)
            name = found[1].strip() if found else ""
            if not found or name in weights:
                raise ValueError
            weights[name], rest = float(found[2]), rest[found.end() :]
    except ValueError:
        reason = "write it as NAME=0.5,NAME=1, each name once"
        raise FaceZipError(ErrorCode.BAD_VALUE, f"--blend '{text}': {reason}") from None
    return weights
