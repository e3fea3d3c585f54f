"""A folder that holds an export: written whole or not at all, with one document that names everything in it."""

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from facezip.errors import ErrorCode, FaceZipError
from facezip.export.maps import Format, write_maps
from facezip.export.source import Source, read_source
from facezip.writing import whole_folder

FILE_NAME = "facezip.json"
FORMAT = "facezip-export/1"


@dataclass(frozen=True)
class Target:
    """An engine, as far as exports differ.

    Attributes
    ----------
    name : as the command line calls it.
    formats : how it takes textures, by the words of ``--textures``.
    write : adds the engine's own files to a folder that holds the textures.
    upside_down : whether it keeps the last row of a texture first.
    """

    name: str
    formats: dict[str, Format]
    write: Callable[[Source, Path, Format], None]
    upside_down: bool = False

    def __call__(self, pack: Path, output: Path, *, textures: str = "png", overwrite: bool = False) -> dict[str, Any]:
        """Export a pack into the folder ``output``.

        Returns
        -------
        The content of ``facezip.json``, with ``output`` and the ``bytes`` of all files.

        Raises
        ------
        FaceZipError
            What :func:`facezip.read_pack` and :func:`facezip.writing.whole_folder` raise; ``BAD_VALUE`` where the
            engine takes no such textures.
        """
        form = self._format(textures)
        source = read_source(pack)
        with whole_folder(output, overwrite, is_export) as folder:
            document = {"format": FORMAT, "target": self.name, **describe(source)}
            document |= write_maps(source, folder, form, self.upside_down)
            self.write(source, folder, form)
            text = json.dumps(document, indent=1, allow_nan=False)
            (folder / FILE_NAME).write_text(text + "\n", encoding="utf-8")
            size = sum(file.stat().st_size for file in folder.rglob("*") if file.is_file())
        return {**document, "output": str(output), "bytes": size}

    def _format(self, textures: str) -> Format:
        if textures not in self.formats:
            known = " or ".join(self.formats)
            raise FaceZipError(ErrorCode.BAD_VALUE, f"--textures {textures}: {self.name} takes {known}")
        return self.formats[textures]


def describe(source: Source) -> dict[str, Any]:
    """What an engine has to know of a pack, by names: morph target, and place among the weight maps, of each."""
    manifest, columns = source.manifest, source.manifest.weight_columns
    return {
        "name": manifest.name,
        "resolution": list(manifest.size),
        "channels": manifest.channels,
        "layers": max(manifest.footprint.layers, -(-len(manifest.difference_scale) // 4)),
        "weight_size": list(manifest.weight_size),
        "order": list(manifest.expressions),
        "expressions": {
            name: {"morph_target": n, "weight_tile": [n % columns, n // columns]}
            for n, name in enumerate(manifest.expressions)
        },
    }


def is_export(folder: Path) -> bool:
    """Whether an export was written here: only such a folder may be overwritten by one."""
    try:
        return json.loads((folder / FILE_NAME).read_bytes())["format"] == FORMAT
    except (OSError, ValueError, KeyError, TypeError):
        return False
