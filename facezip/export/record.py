"""What the files of an export have to be, for whoever asks later: lengths, checksums, numbers, importers' settings.

It stands in ``facezip.json`` of every export, under ``files``.
"""

import hashlib
import json
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from facezip.files.decoding import decoding
from facezip.files.statements import stated
from facezip.pack.verification import stored

FILE_NAME = "facezip.json"
IMAGES = (".png", ".tif")
# Godot's own settings lie beside each texture, and its editor adds to them.
SETTINGS = ".import"
_SETTING = re.compile(r"^[ \t]*([\w/]+)[ \t]*[=:][ \t]*(.*?)[ \t\r]*$", re.MULTILINE)


def with_record(document: Mapping[str, Any], folder: Path) -> dict[str, Any]:
    """A document of an export with what is said of every file in its folder, and a checksum of all of that."""
    files = dict(_files(folder, dict(_textures(document))))
    whole = {**document, "files": files}
    return {**whole, "sha256": checksum(whole)}


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


def _textures(document: Mapping[str, Any]) -> Iterator[tuple[str, dict[str, bool]]]:
    """The textures' files, relative to the folder, and how each is imported: an atlas, with columns, has no mip-maps.

    Numbers of a fit are no sRGB: an importer that takes them for that, or for transparent, changes them. Whole pictures
    of colours, where a document says so, are.
    """
    for tile, each in document.get("tiles", {"": document}).items():
        beside = [each[name] for name in ("regions", "masks") if name in each]
        for entry in (*each["textures"].values(), *beside):
            for file in (entry[key] for key in ("file", "low") if key in entry):
                settings = {"srgb": entry.get("srgb", False), "mipmaps": entry.get("mipmaps", "columns" not in entry)}
                yield f"{tile}/{file}" if tile else file, settings


def _files(folder: Path, textures: Mapping[str, dict[str, bool]]) -> Iterator[tuple[str, dict[str, Any]]]:
    for path in sorted(folder.rglob("*")):
        name = path.relative_to(folder).as_posix()
        if not path.is_file() or name == FILE_NAME:
            continue
        if path.suffix == SETTINGS:
            yield name, {"settings": settings_in(path.read_text(encoding="utf-8"))}
            continue
        entry: dict[str, Any] = {**vars(stored(path))}
        if name in textures:
            entry |= textures[name]
            if path.suffix in IMAGES:
                entry |= {"size": list(stated(path).size), "numbers": numbers_of(path)}
        yield name, entry
