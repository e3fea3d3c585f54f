"""``facezip decompress``: textures out of a pack, of expressions or of a blend."""

from pathlib import Path

import click

from facezip.commands import options
from facezip.errors import ErrorCode, FaceZipError
from facezip.model import CompressedTextures
from facezip.pack import read_pack
from facezip.progress import track
from facezip.textures import write_texture
from facezip.writing import whole_folder

BLEND_FILE = "blend"


@click.command("decompress")
@click.argument("pack", type=options.FOLDER)
@click.option("-o", "--output", type=options.FOLDER, required=True, metavar="DIR", help="Folder for the textures.")
@click.option("--expression", "names", multiple=True, metavar="NAME", help="Only this expression; may be repeated.")
@click.option("--blend", metavar="NAME=0.5,NAME=1", help=f"One blend of expressions, as {BLEND_FILE}.png.")
@options.overwrite
@options.as_json
def command(
    pack: Path, output: Path, names: tuple[str, ...], blend: str | None, overwrite: bool, as_json: bool
) -> None:
    """Write the textures of PACK as PNG at full size: every expression, those named, or one blend (equation 8)."""
    model = read_pack(pack)
    blends = _blends(model, names, blend)
    known = {f"{name}.png" for name in (*model.expressions, BLEND_FILE)}
    with whole_folder(output, overwrite, lambda folder: {file.name for file in folder.iterdir()} <= known) as folder:
        for name in track(blends, "Decompressing", len(blends)):
            write_texture(folder / f"{name}.png", model.blend(blends[name]))
    document = {"output": str(output), "textures": [f"{name}.png" for name in blends]}
    options.answer(document, as_json, lambda: [f"{output}: {len(blends)} texture(s)"])


def _blends(model: CompressedTextures, names: tuple[str, ...], blend: str | None) -> dict[str, dict[str, float]]:
    if blend is not None:
        return {BLEND_FILE: parse_blend(blend)}
    return {name: {name: 1.0} for name in names or model.expressions}


def parse_blend(text: str) -> dict[str, float]:
    """``"smile=0.5,blink=1"`` as a dictionary; ``BAD_VALUE`` for anything else."""
    try:
        pairs = [item.rsplit("=", 1) for item in text.split(",")]
        return {name.strip(): float(weight) for name, weight in pairs}
    except ValueError:
        raise FaceZipError(ErrorCode.BAD_VALUE, f"--blend '{text}': write it as NAME=0.5,NAME=1") from None
