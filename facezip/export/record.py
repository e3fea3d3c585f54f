"""What the files of an export have to be, for whoever asks later: lengths, checksums, numbers, importers' settings.

It stands in ``facezip.json`` of every export, under ``files``.
"""

import hashlib
import json
import re
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

import numpy as np

from facezip.documents.document import plain
from facezip.export.documents.export import Export
from facezip.export.documents.layers import LayersExport
from facezip.export.documents.tiles import ExportDocument, ExportedFile, TileExport, TilesDocument
from facezip.files.decoding import decoding
from facezip.files.statements import stated
from facezip.pack.verification import stored

FILE_NAME = "facezip.json"
IMAGES = (".png", ".tif")
# Godot's own settings lie beside each texture, and its editor adds to them.
SETTINGS = ".import"
# Kinds of documents that have a record.
E = TypeVar("E", ExportDocument, TilesDocument, LayersExport)
_SETTING = re.compile(r"^[ \t]*([\w/]+)[ \t]*[=:][ \t]*(.*?)[ \t\r]*$", re.MULTILINE)


def with_record(document: E, folder: Path) -> E:
    """A document of an export with what is said of every file in its folder, and a checksum of all of that."""
    whole = replace(document, files=dict(_files(folder, dict(_textures(document)))))
    return replace(whole, sha256=checksum(plain(whole)))


def checksum(document: Mapping[str, Any]) -> str:
    """SHA-256 (hexadecimal) of a document without the field ``sha256``, as JSON with sorted keys and no spaces."""
    rest = {key: value for key, value in document.items() if key != "sha256"}
    return hashlib.sha256(json.dumps(rest, sort_keys=True, separators=(",", ":")).encode()).hexdigest()


def numbers_of(image: Path) -> str:
    """SHA-256 (hexadecimal) of an image's size, type and numbers, however they are compressed.

    Raises
    ------
    FaceZipError
        What :func:`facezip.files.decoding.decode` raises.
    """
    with decoding(image) as (facts, bands):
        digest = hashlib.sha256(f"{facts.size} {facts.type} {len(facts.channels)}".encode())
        for _, _, band in bands:
            digest.update(np.ascontiguousarray(band).data)
    return digest.hexdigest()


def settings_in(text: str) -> dict[str, str]:
    """The settings in a file of an importer, ``key=value`` of Godot's and ``key: value`` of Unity's; the first of each.

    Unity repeats some for every platform, after what holds for all.
    """
    return {name: value.strip('"') for name, value in reversed(_SETTING.findall(text))}


class _Import(NamedTuple):
    """How an importer has to take a texture."""

    srgb: bool
    mipmaps: bool


def _textures(document: Export) -> Iterator[tuple[str, _Import]]:
    """The textures' files, relative to the folder, and how each is imported."""
    if isinstance(document, TilesDocument):
        for number, tile in document.tiles.items():
            yield from ((f"{number}/{file}", settings) for file, settings in _of_tile(tile))
    elif isinstance(document, LayersExport):
        for picture in document.textures.values():
            yield picture.file, _Import(picture.srgb, picture.mipmaps is not False)
    else:
        yield from _of_tile(document)


def _of_tile(tile: TileExport) -> Iterator[tuple[str, _Import]]:
    """An atlas, with columns, has no mip-maps.

    Numbers of a fit are no sRGB: an importer that takes them for that, or for transparent, changes them.
    """
    for texture in tile.textures.values():
        for file in filter(None, (texture.file, texture.low)):
            yield file, _Import(srgb=False, mipmaps=texture.columns is None)
    for atlas in (tile.regions, tile.masks):
        if atlas:
            yield atlas.file, _Import(srgb=False, mipmaps=False)


def _files(folder: Path, textures: Mapping[str, _Import]) -> Iterator[tuple[str, ExportedFile]]:
    for path in sorted(folder.rglob("*")):
        name = path.relative_to(folder).as_posix()
        if not path.is_file() or name == FILE_NAME:
            continue
        if path.suffix == SETTINGS:
            yield name, ExportedFile(settings=settings_in(path.read_text(encoding="utf-8")))
            continue
        entry = ExportedFile(**vars(stored(path)))
        if name in textures:
            entry = replace(entry, srgb=textures[name].srgb, mipmaps=textures[name].mipmaps)
            if path.suffix in IMAGES:
                entry = replace(entry, size=stated(path).size, numbers=numbers_of(path))
        yield name, entry
