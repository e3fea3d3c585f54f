"""An export looked at beside its record: what was changed since it was written, and would break the blend."""

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

from facezip.character.diagnosis import Diagnosis, Refusal, Row
from facezip.character.notes import Note
from facezip.documents.document import from_plain
from facezip.errors import ErrorCode, FaceZipError
from facezip.export.documents.tiles import ExportedFile
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


Record = Mapping[str, ExportedFile]


@dataclass(frozen=True)
class Recorded:
    """As much of an export's document as is looked at.

    Attributes
    ----------
    target, name : what takes it, and what the pack is called.
    files : what each has to be; none where there is no record that can be understood.
    changed : whether it was changed after the export.
    """

    target: str = "?"
    name: str = "?"
    files: Record = field(default_factory=dict)
    changed: bool = False


def examine_export(folder: Path) -> Diagnosis:
    """What differs from ``facezip.json`` in the folder of an export.

    A texture that was saved again with the same numbers is well. One with others, or that an importer takes for sRGB,
    needs a decision; a file that is missing is refused.
    """
    with reading(folder):
        document = _document(folder / FILE_NAME)
        record = document.files
        if not record:
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
    summary = f"'{document.name}' for {document.target}, {len(record)} files"
    return Diagnosis("export", str(folder), summary, tuple(rows), tuple(refusals), tuple(notes))


def _document(file: Path) -> Recorded:
    """What ``facezip.json`` says; nothing where it says nothing that can be understood."""
    try:
        content = json.loads(file.read_bytes()) if file.stat().st_size <= MAX_BYTES else {}
        document = from_plain(content, Recorded)
    except (ValueError, RecursionError):
        return Recorded()
    if not all(map(_is_sound, document.files.items())):
        return Recorded()
    return replace(document, changed=content.get("sha256") != checksum(content))


def _is_sound(named: tuple[str, ExportedFile]) -> bool:
    """Whether it says something of a file within the folder."""
    path, file = Path(named[0]), named[1]
    known = file.settings is not None or None not in (file.bytes, file.sha256)
    inside = not path.is_absolute() and ".." not in path.parts
    return known and inside and (file.srgb is None or file.mipmaps is not None)


def _changed_document(document: Recorded) -> Iterator[Note]:
    if document.changed:
        yield Note(FILE_NAME, f"was changed after the export: its numbers turn texels into values; {AGAIN}", asks=True)


def _row(name: str, entry: ExportedFile) -> Row:
    encoding = "" if entry.srgb is None else "sRGB" if entry.srgb else "as stored, no sRGB"
    size = "" if entry.bytes is None else f"{entry.bytes} bytes"
    what = "file" if entry.srgb is None else "texture"
    what = what if entry.settings is None else "settings"
    return Row(name, what, "", None, encoding=encoding, size=size)


def _missing(folder: Path, record: Record, name: str) -> FaceZipError:
    """The error for a file that is not there, with the name that it has now where that is certain."""
    wanted = record[name]
    others = (path for path in sorted(folder.rglob("*")) if path.is_file() and wanted.bytes == path.stat().st_size)
    strange = (path for path in others if path.relative_to(folder).as_posix() not in record)
    now = next((path for path in strange if stored(path).sha256 == wanted.sha256), None)
    if now is not None:
        renamed = now.relative_to(folder).as_posix()
        return FaceZipError(
            ErrorCode.MISSING_FILE,
            f"{folder / name}: is called {renamed} now, and is not found so; call it {name} again",
        )
    return FaceZipError(ErrorCode.MISSING_FILE, f"{folder / name}: is missing; {AGAIN}")


def _notes(folder: Path, name: str, entry: ExportedFile) -> Iterator[Note]:
    path = folder / name
    if entry.settings is not None:
        yield from _of_settings(path, name, entry.settings)
        return
    found = stored(path)
    if (found.bytes, found.sha256) != (entry.bytes, entry.sha256):
        yield _changed(path, name, entry)
    if entry.srgb is False:
        meta = path.with_name(path.name + META)
        if meta.is_file():
            yield from _of_unity(meta, f"{name}{META}", entry)
        godot = path.with_name(path.name + SETTINGS)
        if godot.is_file():
            yield from _of_srgb(settings_in(_text(godot)), f"{name}{SETTINGS}")


def _changed(path: Path, name: str, entry: ExportedFile) -> Note:
    if entry.numbers is None:
        kind = "file" if entry.srgb is None else "texture"
        asks = path.suffix != GUIDE
        return Note(name, f"is another {kind} than was exported; {AGAIN}, unless it was changed on purpose", asks)
    try:
        same = numbers_of(path) == entry.numbers
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


def _of_unity(meta: Path, name: str, entry: ExportedFile) -> Iterator[Note]:
    """Unity's settings, of what ``Editor/FaceZipImport.cs`` sets."""
    found = settings_in(_text(meta))
    yield from _of_srgb(found, name)
    wanted = {
        "alphaIsTransparency": ("0", "colours where alpha is 0 become others"),
        "nPOTScale": ("0", "the texture is resized"),
        "enableMipMap": (str(int(bool(entry.mipmaps))), "mip-maps are not as the fit expects"),
    }
    if not entry.mipmaps:
        wanted["textureCompression"] = "0", "weights are for the pre-pass to the last bit"
    most = found.get("maxTextureSize", "")
    if most.isdecimal() and entry.size and int(most) < max(entry.size):
        wanted["maxTextureSize"] = "16384", "the texture is made smaller"
    for key, (value, why) in wanted.items():
        if found.get(key, value) != value:
            words = f"{key} is {found[key]} and has to be {value}: {why}"
            yield Note(name, f"{words}; keep Editor/FaceZipImport.cs in the project and import it again", asks=True)


def _text(path: Path) -> str:
    return path.read_bytes()[:MAX_BYTES].decode("utf-8", "replace")
