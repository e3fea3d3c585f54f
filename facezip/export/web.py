"""The viewer as one HTML file that opens from disk and asks for nothing."""

from pathlib import Path

from facezip.character.scans import Character
from facezip.export.documents.export import WebDocument
from facezip.files.writing import check_target, write_whole
from facezip.viewer.page import single_page
from facezip.viewer.scene import read_scene

FILE_NAME = "index.html"
_BEGINNING = b"<!doctype html>\n<!-- FaceZip viewer -->"


def export_web(pack: Path, output: Path, *, character: Character | None = None, overwrite: bool = False) -> WebDocument:
    """Write the viewer of a pack as ``output``, a file where it ends in ``.html``, else a folder for ``index.html``.

    Parameters
    ----------
    character : its original textures come along, to compare with: about their PNGs' bytes, and a third.

    Raises
    ------
    FaceZipError
        What :func:`facezip.viewer.scene.read_scene` and :mod:`facezip.files.writing` raise.
    """
    file = output if output.suffix.lower() == ".html" else output / FILE_NAME
    check_target(file, overwrite, _is_ours)
    content = single_page(read_scene(pack, character))
    write_whole(file, content)
    return WebDocument(output=str(file), bytes=len(content), originals=character is not None)


def page_at(path: Path) -> Path | None:
    """The page of an export, given itself or by its folder; None where there is none."""
    file = path / FILE_NAME if path.is_dir() else path
    return file if file.suffix.lower() == ".html" and _is_ours(file) else None


def _is_ours(file: Path) -> bool:
    if not file.is_file():
        return False
    with open(file, "rb") as content:
        return content.read(len(_BEGINNING)) == _BEGINNING
