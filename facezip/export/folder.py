"""A folder that holds an export: written whole or not at all, with one document that names everything in it."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from facezip.character.units import size_words
from facezip.documents.document import Document, from_json, to_json
from facezip.errors import ErrorCode, FaceZipError
from facezip.export.documents.textures import ExpressionPlace, Gains
from facezip.export.documents.tiles import ExportDocument, TileExport, TilesDocument
from facezip.export.formats import Format
from facezip.export.record import FILE_NAME, E, with_record
from facezip.export.source import APART, TOGETHER, Source, Tile, read_source
from facezip.export.textures import WrittenMaps, write_maps
from facezip.files.writing import whole_folder
from facezip.pack.footprint import SLOTS_PER_LAYER

FORMAT = TileExport.format


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
    ) -> ExportDocument | TilesDocument:
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
            notes = size_words(source.geometry, self.reads)
            if len(tiles) == 1:
                return put_document(ExportDocument(**vars(next(iter(tiles.values()))), notes=notes), folder, output)
            # Of several each stands beside its textures as well.
            for number, document in tiles.items():
                _write(document, folder / number)
            whole = TilesDocument(target=self.name, name=source.name, tiles=tiles, notes=notes)
            return put_document(whole, folder, output)

    def _tile(self, source: Source, tile: Tile, place: Path, form: Format) -> TileExport:
        folder = source.folder_of(tile, place)
        folder.mkdir(exist_ok=True)
        document = describe(tile, self.name, write_maps(tile, folder, form, self.upside_down), folder)
        self.write_tile(tile, folder)
        return document

    def _format(self, textures: str) -> Format:
        if textures not in self.formats:
            known = " or ".join(self.formats)
            raise FaceZipError(ErrorCode.BAD_VALUE, f"--textures {textures}: {self.name} takes {known}")
        return self.formats[textures]

    def _layout(self, maps: str | None) -> str:
        if maps is not None and maps not in self.maps:
            raise FaceZipError(ErrorCode.BAD_VALUE, f"--maps {maps}: {self.name} takes {' or '.join(self.maps)}")
        return maps or self.maps[0]


def describe(tile: Tile, target: str, written: WrittenMaps, folder: Path) -> TileExport:
    """What an engine has to know of a tile, whose regions and masks are written beside its maps."""
    columns, first = tile.layout.weight_columns, tile.sheets[0]
    return TileExport(
        target=target,
        name=tile.name,
        tile=tile.layout.number,
        resolution=first.size,
        channels=first.channels,
        layers=-(-len(tile.layout.weight_span) // SLOTS_PER_LAYER),
        weight_size=tile.layout.weight_size,
        uniform_weights=tile.uniform_weights,
        gains=Gains(maps=[kind.name for kind in tile.maps], expressions=tile.expressions, regions=tile.regions.names),
        order=tile.expressions,
        expressions={
            name: ExpressionPlace(morph_target=n, weight_tile=None if tile.masks else (n % columns, n // columns))
            for n, name in enumerate(tile.expressions)
        },
        textures=written.textures,
        maps=written.maps,
        codec=written.codec,
        mips=written.mips,
        regions=tile.regions.write(folder),
        masks=tile.masks.write(folder) if tile.masks else None,
    )


def put_document(document: E, folder: Path, output: Path) -> E:
    """Write the document of a finished folder, with its record: what an export that becomes ``output`` answers."""
    whole = with_record(document, folder)
    _write(whole, folder)
    size = sum(file.stat().st_size for file in folder.rglob("*") if file.is_file())
    return replace(whole, output=str(output), bytes=size)


def is_export(folder: Path) -> bool:
    """Whether an export was written here: only such a folder may be overwritten by one."""
    try:
        return from_json((folder / FILE_NAME).read_bytes(), Document).format == FORMAT
    except (OSError, ValueError, RecursionError):
        return False


def _write(document: Document, folder: Path) -> None:
    (folder / FILE_NAME).write_text(f"{to_json(document)}\n", encoding="utf-8")
