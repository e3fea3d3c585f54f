"""Rules 1 to 4 broken: manifests that are no JSON as they should be, fields, and files that are not as stated."""

import json
from pathlib import Path

from facezip.files.packs import MANIFEST
from tests.conformance.editing import (
    BAD,
    DAMAGED,
    DIFFERENCE,
    NEUTRAL,
    OTHER,
    WEIGHTS,
    Change,
    Edit,
    edited,
    edited_bytes,
    edited_text,
    linked,
    renamed,
)
from tests.conformance.signing import manifest_of, signed, with_content
from tests.trust.claims import sign


def broken_manifests() -> dict[str, tuple[str, Change]]:
    """Rule 1, and what is wrong with a manifest as JSON."""
    return {
        "manifest-missing": (BAD, lambda pack: (pack / MANIFEST).unlink()),
        "manifest-linked": (BAD, lambda pack: linked(pack, MANIFEST)),
        "manifest-empty": (DAMAGED, lambda pack: (pack / MANIFEST).write_bytes(b"")),
        "manifest-cut-short": (DAMAGED, lambda pack: edited_bytes(pack, MANIFEST, lambda content: content[:-100])),
        "manifest-with-a-tail": (DAMAGED, _with_tail),
        "manifest-of-a-flipped-bit": (
            DAMAGED,
            lambda pack: edited_bytes(pack, MANIFEST, lambda content: content.replace(b"smile", b"smime")),
        ),
        "manifest-without-checksum": (DAMAGED, _unsigned),
        "manifest-not-json": (BAD, lambda pack: edited_text(pack, lambda text: text + b"{}")),
        "manifest-not-utf-8": (BAD, lambda pack: edited_text(pack, lambda text: text.replace(b"smile", b"sm\xffle"))),
        "manifest-with-a-key-twice": (
            BAD,
            lambda pack: edited_text(pack, lambda text: text.replace(b'"method"', b'"name": "x", "method"')),
        ),
        "manifest-with-nan": (BAD, lambda pack: sign(pack, {"made_with": {"x": float("nan")}})),
        "manifest-with-infinity": (
            BAD,
            lambda pack: edited_text(pack, lambda text: text.replace(b'"made_with": {', b'"made_with": {"x": 1e999')),
        ),
        "format-4": (OTHER, lambda pack: sign(pack, {"format": "facezip-pack/4"})),
        "format-of-others": (DAMAGED, lambda pack: sign(pack, {"format": "zip"})),
        "format-a-number": (DAMAGED, lambda pack: sign(pack, {"format": 3})),
        "format-not-second": (DAMAGED, lambda pack: edited(pack, lambda d: d.update(format=d.pop("format")))),
        "manifest-of-one-line": (
            DAMAGED,
            lambda pack: signed(pack, json.dumps(manifest_of(pack) | {"sha256": "0" * 64}).encode()),
        ),
        "manifest-with-half-a-character": (
            BAD,
            lambda pack: edited(pack, lambda d: d.update(made_with={"x": "\udc00"})),
        ),
        "format-missing": (DAMAGED, lambda pack: edited(pack, lambda d: d.pop("format"))),
    }


def broken_files() -> dict[str, tuple[str, Change]]:
    """Rules 3 and 4."""
    changes: dict[str, Change] = {
        "file-missing": lambda pack: (pack / WEIGHTS).unlink(),
        "file-added": lambda pack: (pack / "notes.txt").write_bytes(b"x"),
        "hidden-file-added": lambda pack: (pack / ".hidden").write_bytes(b"x"),
        "folder-added": lambda pack: ((pack / "more").mkdir(), (pack / "more" / "x.txt").write_bytes(b"x")),
        "file-a-folder": lambda pack: (
            (pack / WEIGHTS).unlink(), (pack / WEIGHTS).mkdir(), (pack / WEIGHTS / "x").write_bytes(b"x")
        ),
        "file-a-link": lambda pack: linked(pack, WEIGHTS),
        "file-longer": lambda pack: edited_bytes(pack, NEUTRAL, lambda content: content + b"\0"),
        "file-shorter": lambda pack: edited_bytes(pack, NEUTRAL, lambda content: content[:-1]),
        "file-of-a-flipped-bit": lambda pack: edited_bytes(
            pack, NEUTRAL, lambda content: content[:-20] + bytes([content[-20] ^ 1]) + content[-19:]
        ),
        "file-that-is-a-path": lambda pack: edited(pack, lambda d: renamed(d, "../vector.facezip/" + NEUTRAL)),
        "file-under-another-name": lambda pack: (pack / WEIGHTS).rename(pack / "weights.1002.png"),
    }  # fmt: skip
    return {name: (DAMAGED, change) for name, change in changes.items()}


def broken_fields() -> dict[str, Edit]:
    """Rule 2: fields that are missing, unknown or out of their range, in manifests that are well signed."""
    names = {
        "none": [], "twice": ["a", "a"], "alike-but-for-case": ["Smile", "smILE"], "alike-in-unicode": ["é", "e\u0301"],
        "alike-but-for-sharp-s": ["straße", "STRASSE"], "with-a-slash": ["a", "a/b"], "with-a-backslash": ["a", "a\\b"],
        "with-a-colon": ["a", "a:b"], "parent-folder": ["a", ".."], "hidden": ["a", ".a"],
        "dot-at-the-end": ["a", "b."], "space-at-the-start": ["a", " b"],
        "space-at-the-end": ["a", "b "], "neutral": ["a", "Neutral"], "mask": ["a", "mask"], "device": ["a", "NUL"],
        "device-with-a-suffix": ["a", "com1.b"], "with-a-newline": ["a", "b\nc"], "right-to-left": ["a", "b\u202ec"],
        "of-no-letter": ["a", ""], "of-129-letters": ["a", "b" * 129], "of-201-bytes": ["a", "é" * 100 + "e"],
        "a-number": ["a", 1], "half-a-character": ["a", "\ud800"],
    }  # fmt: skip
    edits: dict[str, Edit] = {
        f"expressions-{what}": lambda d, names=names: d.update(expressions=names) for what, names in names.items()
    }
    tile = lambda **fields: lambda d: d["tiles"][0].update(fields)  # noqa: E731
    first = lambda **fields: lambda d: d["maps"][0].update(fields)  # noqa: E731
    texture = lambda **fields: lambda d: d["tiles"][0]["textures"][0].update(fields)  # noqa: E731
    return edits | {
        "field-missing": lambda d: d.pop("method"),
        "field-unknown": lambda d: d.update(surprise=1),
        "field-of-a-map-missing": lambda d: d["maps"][0].pop("channels"),
        "field-of-a-tile-unknown": tile(surprise=1),
        "field-of-a-texture-missing": lambda d: d["tiles"][0]["textures"][0].pop("size"),
        "field-of-a-file-unknown": lambda d: d["files"][NEUTRAL].update(surprise=1),
        "name-too-long": lambda d: d.update(name="x" * 129),
        "name-not-printable": lambda d: d.update(name="a\u0007"),
        "method-empty": lambda d: d.update(method=""),
        "maps-none": lambda d: (d.update(maps=[]), d["tiles"][0].update(textures=[])),
        "map-name-of-capitals": first(name="Albedo"),
        "map-name-of-33": first(name="a" * 33),
        "map-name-weights": first(name="weights"),
        "encoding-unknown": first(encoding="linear"),
        "range-empty": first(range=[1.0, 1.0]),
        "range-too-wide": first(range=[0.0, 1e7]),
        "range-of-one": first(range=[0.0]),
        "channels-5": first(channels=5),
        "channels-true": first(channels=True),
        "tiles-none": lambda d: d.update(tiles=[]),
        "tile-1000": tile(number=1000),
        "tile-2000": tile(number=2000),
        "tile-of-a-fraction": tile(number=1001.5),
        "weight-size-zero": tile(weight_size=[0, 2]),
        "weight-columns-zero": tile(weight_columns=0),
        "weight-span-negative": tile(weight_span=[-1.0]),
        "weight-span-of-more-slots": tile(weight_span=[1.0, 1.0]),
        "weight-offset-of-more-slots": tile(weight_offset=[0.0, 0.0]),
        "weight-offset-too-large": tile(weight_offset=[1e10]),
        "weights-without-images": lambda d: (d["tiles"][0].update(weights=[]), d["files"].pop(WEIGHTS)),
        "weights-of-two-images": tile(weights=[WEIGHTS, WEIGHTS]),
        "textures-of-fewer-maps": tile(textures=[]),
        "size-zero": texture(size=[0, 4]),
        "size-too-large": texture(size=[16385, 4]),
        "neutral-bits-12": texture(neutral_bits=12),
        "differences-of-fewer-slots": texture(differences=[]),
        "difference-span-of-fewer-channels": texture(difference_span=[[1.0, 1.0]]),
        "difference-span-negative": texture(difference_span=[[1.0, -1.0, 1.0]]),
        "neutral-and-difference-in-one-file": texture(neutral=DIFFERENCE),
        "neutral-not-stated": texture(neutral="other.png"),
        "neutral-in-the-manifest": lambda d: renamed(d, MANIFEST),
        "uniform-weights-beside-images": lambda d: d.update(uniform_weights=[[1.0], [1.0]]),
        "uniform-weights-missing": tile(weight_size=[1, 1], weights=[]),
        "geometry-a-list": lambda d: d.update(geometry=[]),
        "made-with-a-list": lambda d: d.update(made_with=[]),
        "file-of-no-bytes": lambda d: d["files"][NEUTRAL].update(bytes=0),
        "checksum-in-capitals": lambda d: d["files"][NEUTRAL].update(sha256=d["files"][NEUTRAL]["sha256"].upper()),
        "file-that-nothing-names": lambda d: d["files"].update({"notes.txt": d["files"][NEUTRAL]}),
        "file-not-stated": lambda d: d["files"].pop(NEUTRAL),
        "texture-of-a-gigabyte": texture(size=[16384, 16384]),
    }


def two_faults() -> dict[str, tuple[str, Change]]:
    """Two faults: the earlier rule is what a reader says."""
    return {
        "checksum-before-format": (DAMAGED, lambda pack: (sign(pack, {"format": "zip"}), _with_tail(pack))),
        "format-before-fields": (OTHER, lambda pack: sign(pack, {"format": "facezip-pack/4", "maps": []})),
        "fields-before-files": (BAD, lambda pack: (sign(pack, {"method": ""}), (pack / WEIGHTS).unlink())),
        "files-before-images": (
            DAMAGED,
            lambda pack: (with_content(pack, NEUTRAL, b"no image"), (pack / "notes.txt").write_bytes(b"x")),
        ),
        "checksums-before-images": (
            DAMAGED,
            lambda pack: (
                with_content(pack, NEUTRAL, b"no image"),
                edited_bytes(pack, WEIGHTS, lambda content: content[:-1] + b"\0"),
            ),
        ),
    }


def _with_tail(pack: Path) -> None:
    edited_bytes(pack, MANIFEST, lambda content: content + b" ")


def _unsigned(pack: Path) -> None:
    document = manifest_of(pack)
    document.pop("sha256")
    (pack / MANIFEST).write_text(json.dumps(document, indent=1))
