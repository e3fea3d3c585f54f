"""``facezip decompress``: textures out of a pack, of expressions or of a blend."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import click

from facezip.character.folder import file_name, write_map
from facezip.character.maps import Map
from facezip.character.scans import unknown
from facezip.commands import options
from facezip.documents.document import Document
from facezip.errors import ErrorCode, FaceZipError
from facezip.files.writing import whole_folder
from facezip.machine.memory import beside, limited
from facezip.machine.progress import track
from facezip.names import one_form
from facezip.pack.model import CompressedTextures
from facezip.pack.read import read_pack

BLEND_FILE = "blend"


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
@click.option("--expression", "names", multiple=True, metavar="NAME", help="Only this expression; may be repeated.")
@click.option("--blend", metavar="NAME=0.5,NAME=1", help=f"One blend of expressions, as {BLEND_FILE}.png.")
@options.memory
@options.overwrite
@options.as_json
def command(
    pack: Path,
    output: Path,
    names: tuple[str, ...],
    blend: str | None,
    memory: int | None,
    overwrite: bool,
    as_json: bool,
) -> None:
    """Write the textures of PACK as PNG at full size: every expression, those named, or one blend (equation 8).

    Of a pack with several maps or tiles, all of them: NAME.png, NAME.normal.png, NAME.1002.png … ; floats that were
    kept beyond 0..1 as OpenEXR.
    """
    with limited(memory, beside(output)):
        textures = _decompress(pack, output, names, blend, overwrite)
    document = DecompressDocument(output=str(output), textures=textures)
    options.answer(document, as_json, lambda: [f"{output}: {len(textures)} texture(s)"])


def _decompress(pack: Path, output: Path, names: tuple[str, ...], blend: str | None, overwrite: bool) -> list[str]:
    """Write the textures; the names of their files."""
    model = read_pack(pack)
    blends = _blends(model, names, blend)
    for name in (name for weights in blends.values() for name in weights):
        if one_form(name) not in model.expressions:
            raise unknown("expression", name, model.expressions, str(pack))
    known = {stem for name in (*model.expressions, BLEND_FILE) for stem in _stems(model, name).values()}
    textures = []

    def ours(folder: Path) -> bool:
        return all(file.stem in known and file.suffix in (".png", ".exr") for file in folder.iterdir())

    with whole_folder(output, overwrite, ours) as folder:
        for name in track(blends, "Decompressing", len(blends)):
            for (kind, tile), stem in _stems(model, name).items():
                key = kind.name, tile
                texels = model.texels(blends[name], key)
                textures.append(write_map(folder / stem, texels, kind, model.parts[key].bits).name)
    return textures


def _stems(model: CompressedTextures, name: str) -> dict[tuple[Map, int], str]:
    """What each map on each tile is called, without its suffix."""
    tiles = model.tiles
    return {(kind, tile): file_name(name, kind, tile, tiles) for kind in model.maps for tile in tiles}


def _blends(model: CompressedTextures, names: tuple[str, ...], blend: str | None) -> dict[str, dict[str, float]]:
    if blend is not None:
        return {BLEND_FILE: parse_blend(blend)}
    return {name: {name: 1.0} for name in map(one_form, names or model.expressions)}


def parse_blend(text: str) -> dict[str, float]:
    """``"smile=0.5,blink=1"`` as a dictionary; ``BAD_VALUE`` for anything else."""
    try:
        pairs = [item.rsplit("=", 1) for item in text.split(",")]
        return {name.strip(): float(weight) for name, weight in pairs}
    except ValueError:
        raise FaceZipError(ErrorCode.BAD_VALUE, f"--blend '{text}': write it as NAME=0.5,NAME=1") from None
