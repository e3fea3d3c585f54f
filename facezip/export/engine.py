"""What exports to all engines share: files from templates, and the head as a GLB."""

from pathlib import Path

from facezip.export.formats import Format
from facezip.export.gltf import GLB_FILE, write_glb
from facezip.export.shaders import head_words, render
from facezip.export.source import Source
from facezip.export.words import Dialect


def write_text(folder: Path, files: dict[str, str], words: dict[str, object]) -> None:
    """Write each file from its template."""
    for file, template in files.items():
        (folder / file).parent.mkdir(exist_ok=True)
        (folder / file).write_text(render(template, **words), encoding="utf-8")


def write_head(
    source: Source, folder: Path, files: dict[str, str], dialect: Dialect, form: Format, jointed: bool = False
) -> None:
    """Write what tiles share: ``files``, and where the pack has meshes the head, which shows its neutral as PNG.

    ``jointed`` is that of :func:`facezip.export.gltf.write_glb`.
    """
    write_text(folder, files, head_words(source, dialect) | {"suffix": form.suffix_of(form.name)})
    if source.geometry is not None:
        write_glb(source, folder / GLB_FILE, jointed=jointed)
