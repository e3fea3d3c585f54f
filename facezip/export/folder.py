"""A folder that holds an export: written whole or not at all, with one document that names everything in it."""

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from facezip.character.units import size_words
from facezip.errors import ErrorCode, FaceZipError
from facezip.export.formats import Format
from facezip.export.record import FILE_NAME, with_record
from facezip.export.source import APART, TOGETHER, Source, Tile, read_source
from facezip.export.textures import write_maps
from facezip.files.writing import whole_folder
from facezip.pack.footprint import SLOTS_PER_LAYER

FORMAT = "facezip-export/1"


@dataclass(frozen=True)
class Target:
    """An engine, as far as exports differ.

    Attributes
    ----------
    name : as the command line calls it.
    formats : how it takes textures, by the words of ``--textures``.
    write_tile : adds the material of a tile to a folder that holds its textures.
    write_head : adds what all tiles share to the folder of them all, which is that of the tile where there is one.
    upside_down : whether it keeps the last row of a texture first.
    maps : how maps may lie in textures; the first where nothing is said.
    expands : whether it has no pre-pass that combines masks, and takes weight maps that are made of them.
    reads : the unit in which it takes numbers of meshes whose unit is not known (:mod:`facezip.character.units`).
    """

    name: str
    formats: dict[str, Format]
    write_tile: Callable[[Tile, Path], None]
    write_head: Callable[[Source, Path, Format], None]
    upside_down: bool = False
    maps: tuple[str, ...] = (TOGETHER, APART)
    expands: bool = False
    reads: str = "m"

    def __call__(
        self,
        pack: Path,
        output: Path,
        *,
        textures: str = "png",
        maps: str | None = None,
        region: Mapping[str, Path] | None = None,
        overwrite: bool = False,
    ) -> dict[str, Any]:
        """Export a pack into the folder ``output``; of several tiles, each into a folder of its number in there.

        ``textures`` is one of ``formats``; ``maps``, one of those of the target, and ``region`` are as of
        :func:`facezip.export.source.read_source`.

        Returns
        -------
        The content of ``facezip.json``, with ``output`` and the ``bytes`` of all files.

        Raises
        ------
        FaceZipError
            What :func:`facezip.export.source.read_source` and :mod:`facezip.files.writing` raise; ``BAD_VALUE``
            where the engine takes no such textures.
        """
        form = self._format(textures)
        source = read_source(pack, self._layout(maps), form.normals_alone, region, self.expands)
        form.check(source)
        with whole_folder(output, overwrite, is_export) as folder:
            tiles = {str(tile.layout.number): self._tile(source, tile, folder, form) for tile in source.tiles}
            self.write_head(source, folder, form)
            return put_document(self._whole(source, tiles, folder), folder, output)

    def _tile(self, source: Source, tile: Tile, place: Path, form: Format) -> dict[str, Any]:
        folder = source.folder_of(tile, place)
        folder.mkdir(exist_ok=True)
        document = {"format": FORMAT, "target": self.name, **describe(tile)}
        document |= write_maps(tile, folder, form, self.upside_down) | tile.regions.write(folder)
        if tile.masks:
            document |= tile.masks.write(folder)
        self.write_tile(tile, folder)
        return document

    def _whole(self, source: Source, tiles: dict[str, dict[str, Any]], folder: Path) -> dict[str, Any]:
        """The document of a tile; of several one that has theirs, which are written beside their textures."""
        said = size_words(source.geometry, self.reads) if source.geometry else None
        notes = {"notes": [said] if said else []}
        if len(tiles) == 1:
            return next(iter(tiles.values())) | notes
        for number, document in tiles.items():
            _write(document, folder / number)
        return {"format": FORMAT, "target": self.name, "name": source.name, "tiles": tiles, **notes}

    def _format(self, textures: str) -> Format:
        if textures not in self.formats:
            known = " or ".join(self.formats)
            raise FaceZipError(ErrorCode.BAD_VALUE, f"--textures {textures}: {self.name} takes {known}")
        return self.formats[textures]

    def _layout(self, maps: str | None) -> str:
        if maps is not None and maps not in self.maps:
            raise FaceZipError(ErrorCode.BAD_VALUE, f"--maps {maps}: {self.name} takes {' or '.join(self.maps)}")
        return maps or self.maps[0]


def describe(tile: Tile) -> dict[str, Any]:
    """What an engine has to know of a tile, by names: morph target, and place among any weight maps, of each."""
    columns, first = tile.layout.weight_columns, tile.sheets[0]
    return {
        "name": tile.name,
        "tile": tile.layout.number,
        "resolution": list(first.size),
        "channels": first.channels,
        "layers": -(-len(tile.layout.weight_span) // SLOTS_PER_LAYER),
        "weight_size": list(tile.layout.weight_size),
        "uniform_weights": [list(row) for row in tile.uniform_weights],
        "gains": {
            "maps": [kind.name for kind in tile.maps],
            "expressions": list(tile.expressions),
            "regions": list(tile.regions.names),
        },
        "order": list(tile.expressions),
        "expressions": {
            name: {"morph_target": n} | ({} if tile.masks else {"weight_tile": [n % columns, n // columns]})
            for n, name in enumerate(tile.expressions)
        },
    }


def put_document(document: Mapping[str, Any], folder: Path, output: Path) -> dict[str, Any]:
    """Write the document of a finished folder, with its record: what an export that becomes ``output`` answers."""
    whole = with_record(document, folder)
    _write(whole, folder)
    size = sum(file.stat().st_size for file in folder.rglob("*") if file.is_file())
    return {**whole, "output": str(output), "bytes": size}


def is_export(folder: Path) -> bool:
    """Whether an export was written here: only such a folder may be overwritten by one."""
    try:
        return json.loads((folder / FILE_NAME).read_bytes())["format"] == FORMAT
    except (OSError, ValueError, KeyError, TypeError):
        return False


def _write(document: dict[str, Any], folder: Path) -> None:
    text = json.dumps(document, indent=1, allow_nan=False)
    (folder / FILE_NAME).write_text(text + "\n", encoding="utf-8")
