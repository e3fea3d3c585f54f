"""An export looked at beside its record: what was changed since it was written, and would break the blend."""

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from facezip.character.diagnosis import Diagnosis, Refusal, Row
from facezip.character.notes import Note
from facezip.errors import ErrorCode, FaceZipError
from facezip.export.record import FILE_NAME, SETTINGS, checksum, numbers_of, settings_in
from facezip.files.reading import reading
from facezip.pack.verification import stored

MAX_BYTES = 2**26
AGAIN = "export it again"
# For people: nothing depends on it.
GUIDE = ".md"
# Unity's, beside every file of a project.
META = ".meta"
TRUE = ("1", "2", "true")


def examine_export(folder: Path) -> Diagnosis:
    """What differs from ``facezip.json`` in the folder of an export.

    A texture that was saved again with the same numbers is well. One with others, or that an importer takes for sRGB,
    needs a decision; a file that is missing is refused.
    """
    with reading(folder):
        document = _document(folder)
        record = document.get("files", {})
        if not _is_record(record):
            words = f"has no record of its files, as those of earlier versions have none, or is damaged; {AGAIN}"
            return Diagnosis("export", str(folder), "cannot be told", notes=(Note(FILE_NAME, words, asks=True),))
        rows, refusals, notes = list[Row](), list[Refusal](), [*_changed_document(document)]
        for name, entry in sorted(record.items()):
            rows.append(_row(name, entry))
            fault = None if (folder / name).is_file() else _missing(folder, record, name)
            if fault is None:
                notes += _notes(folder, name, entry)
            else:
                refusals.append(Refusal.of(fault))
    target, name = (str(document.get(key, "?")) for key in ("target", "name"))
    summary = f"'{name}' for {target}, {len(record)} files"
    return Diagnosis("export", str(folder), summary, tuple(rows), tuple(refusals), tuple(notes))


def _document(folder: Path) -> dict[str, Any]:
    """The content of ``facezip.json``; nothing where it is none."""
    file = folder / FILE_NAME
    try:
        document = json.loads(file.read_bytes()) if file.stat().st_size <= MAX_BYTES else None
    except (ValueError, RecursionError):
        document = None
    return document if isinstance(document, dict) else {}


def _is_record(record: Any) -> bool:
    """Whether it says something of files, all of them within the folder."""
    if not isinstance(record, dict) or not record:
        return False
    inside = all(not Path(name).is_absolute() and ".." not in Path(name).parts for name in record)
    return inside and all(
        isinstance(entry, dict)
        and (isinstance(entry.get("settings"), dict) or {"bytes", "sha256"} <= {*entry})
        and ("srgb" not in entry or type(entry.get("mipmaps")) is bool)
        and all(type(side) is int for side in entry.get("size", [0]))
        for entry in record.values()
    )


def _changed_document(document: Mapping[str, Any]) -> Iterator[Note]:
    if document.get("sha256") != checksum(document):
        yield Note(FILE_NAME, f"was changed after the export: its numbers turn texels into values; {AGAIN}", asks=True)


def _row(name: str, entry: Mapping[str, Any]) -> Row:
    encoding = {False: "as stored, no sRGB", True: "sRGB"}.get(entry.get("srgb", ""), "")
    size = f"{entry['bytes']} bytes" if "bytes" in entry else ""
    what = "settings" if "settings" in entry else "texture" if "srgb" in entry else "file"
    return Row(name, what, "", None, encoding=encoding, size=size)


def _missing(folder: Path, record: Mapping[str, Any], name: str) -> FaceZipError:
    """The error for a file that is not there, with the name that it has now where that is certain."""
    bytes_of = record[name].get("bytes")
    others = (path for path in sorted(folder.rglob("*")) if path.is_file() and bytes_of == path.stat().st_size)
    strange = (path for path in others if path.relative_to(folder).as_posix() not in record)
    now = next((path for path in strange if stored(path).sha256 == record[name]["sha256"]), None)
    if now is not None:
        renamed = now.relative_to(folder).as_posix()
        return FaceZipError(
            ErrorCode.MISSING_FILE,
            f"{folder / name}: is called {renamed} now, and is not found so; call it {name} again",
        )
    return FaceZipError(ErrorCode.MISSING_FILE, f"{folder / name}: is missing; {AGAIN}")


def _notes(folder: Path, name: str, entry: Mapping[str, Any]) -> Iterator[Note]:
    path = folder / name
    if "settings" in entry:
        yield from _of_settings(path, name, entry["settings"])
        return
    if vars(stored(path)) != {key: entry.get(key) for key in ("bytes", "sha256")}:
        yield _changed(path, name, entry)
    if entry.get("srgb") is False:
        meta = path.with_name(path.name + META)
        if meta.is_file():
            yield from _of_unity(meta, f"{name}{META}", entry)
        godot = path.with_name(path.name + SETTINGS)
        if godot.is_file():
            yield from _of_srgb(settings_in(_text(godot)), f"{name}{SETTINGS}")


def _changed(path: Path, name: str, entry: Mapping[str, Any]) -> Note:
    if "numbers" not in entry:
        kind = "texture" if "srgb" in entry else "file"
        asks = path.suffix != GUIDE
        return Note(name, f"is another {kind} than was exported; {AGAIN}, unless it was changed on purpose", asks)
    try:
        same = numbers_of(path) == entry["numbers"]
    except FaceZipError as error:
        return Note(name, f"cannot be read any more ({error}); {AGAIN}", asks=True)
    if same:
        return Note(name, "was saved again, with the same numbers")
    return Note(name, f"was saved again with other numbers, which the blend adds to others; {AGAIN}", asks=True)


def _of_settings(path: Path, name: str, wanted: Mapping[str, str]) -> Iterator[Note]:
    """Godot adds settings of its own; those that were written have to stay."""
    found = settings_in(_text(path))
    for key, value in wanted.items():
        if "/" in key and found.get(key) != value:
            words = f"{key} is {found.get(key, 'not there')}, and was exported as {value}: texels become others"
            yield Note(name, f"{words}; set it back and import the texture again", asks=True)


def _of_srgb(found: Mapping[str, str], name: str) -> Iterator[Note]:
    for key, value in found.items():
        if "srgb" in key.lower() and value.lower() in TRUE:
            words = f"{key} is {value}: texels are taken for sRGB, and are numbers"
            yield Note(name, f"{words}; switch it off and import the texture again", asks=True)


def _of_unity(meta: Path, name: str, entry: Mapping[str, Any]) -> Iterator[Note]:
    """Unity's settings, of what ``Editor/FaceZipImport.cs`` sets."""
    found = settings_in(_text(meta))
    yield from _of_srgb(found, name)
    wanted = {
        "alphaIsTransparency": ("0", "colours where alpha is 0 become others"),
        "nPOTScale": ("0", "the texture is resized"),
        "enableMipMap": (str(int(entry["mipmaps"])), "mip-maps are not as the fit expects"),
    }
    if not entry["mipmaps"]:
        wanted["textureCompression"] = "0", "weights are for the pre-pass to the last bit"
    most = found.get("maxTextureSize", "")
    if most.isdecimal() and "size" in entry and int(most) < max(entry["size"]):
        wanted["maxTextureSize"] = "16384", "the texture is made smaller"
    for key, (value, why) in wanted.items():
        if found.get(key, value) != value:
            words = f"{key} is {found[key]} and has to be {value}: {why}"
            yield Note(name, f"{words}; keep Editor/FaceZipImport.cs in the project and import it again", asks=True)


def _text(path: Path) -> str:
    return path.read_bytes()[:MAX_BYTES].decode("utf-8", "replace")
