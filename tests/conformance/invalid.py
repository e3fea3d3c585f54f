"""Packs that a reader must refuse, with the code: each rule of docs/pack-format.md broken alone, then two at once."""

import json
import os
import struct
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from facezip.character.maps import KNOWN, Map
from facezip.files.glb import Glb
from facezip.files.images import read_texture_exactly
from facezip.pack.manifest import FILE_NAME
from facezip.pack.model import CompressedTextures
from facezip.pack.write import write_pack
from tests.conformance.signing import manifest_of, png, signed, with_content
from tests.conformance.valid import masked, model, sheet
from tests.trust.claims import sign

Change = Callable[[Path], Any]
Edit = Callable[[dict[str, Any]], Any]
BAD, DAMAGED, OTHER = "bad-pack", "damaged-pack", "other-format"
NEUTRAL, DIFFERENCE, WEIGHTS, HEAD = (
    "albedo.1001.neutral.png", "albedo.1001.difference_0.png", "weights.1001.png", "head.glb"
)  # fmt: skip
SMALL = {"size": (4, 4), "slots": 1, "weights": (2, 2)}


def invalid() -> Iterator[tuple[str, str, Change]]:
    """Name, code and writer of each."""
    for name, (code, damage) in {**_manifests(), **_files()}.items():
        yield name, code, lambda pack, damage=damage: (write_pack(model(**SMALL), pack, name="vector"), damage(pack))
    for name, edit in _fields().items():
        yield name, BAD, lambda pack, edit=edit: (write_pack(model(**SMALL), pack, name="vector"), _edited(pack, edit))
    for name, edit in _geometry().items():
        yield name, BAD, lambda pack, edit=edit: (_with_mesh(pack), _edited(pack, edit))
    for name, files in {"under-another-name": ["mesh.glb"], "of-version-2": ["neutral.obj", "deltas.f32"]}.items():
        yield f"geometry-{name}", BAD, lambda pack, files=files: (_with_mesh(pack), _mesh_in(pack, files))
    for name, change in _normals().items():
        yield name, BAD, lambda pack, edit=change: (_with_normals(pack), _edited(pack, edit))
    for name, change in _images().items():
        yield name, BAD, lambda pack, change=change: (write_pack(model(**SMALL), pack, name="vector"), change(pack))
    yield (
        "head-of-gltf-1",
        BAD,
        lambda pack: (
            _with_mesh(pack),
            with_content(pack, HEAD, b"glTF\1" + (pack / HEAD).read_bytes()[5:]),
        ),
    )
    for name, edit in _heads().items():
        yield name, BAD, lambda pack, edit=edit: (_with_mesh(pack), _head(pack, edit))
    for name, (made, edit) in _several().items():
        yield name, BAD, lambda pack, made=made, edit=edit: (write_pack(made, pack, name="vector"), edit(pack))
    for name, edit in _masks().items():
        yield name, BAD, lambda pack, edit=edit: (write_pack(masked(slots=1), pack, name="vector"), _edited(pack, edit))
    for name, content in {"not-finite": b"\0\x7c", "not-clamped-as-stated": b"\0\0"}.items():
        yield f"activations-{name}", BAD, lambda pack, content=content: _activations(pack, content)
    for name, (code, change) in _orders().items():
        yield name, code, lambda pack, change=change: (write_pack(model(**SMALL), pack, name="vector"), change(pack))


def _manifests() -> dict[str, tuple[str, Change]]:
    """Rule 1, and what is wrong with a manifest as JSON."""
    return {
        "manifest-missing": (BAD, lambda pack: (pack / FILE_NAME).unlink()),
        "manifest-linked": (BAD, lambda pack: _linked(pack, FILE_NAME)),
        "manifest-empty": (DAMAGED, lambda pack: (pack / FILE_NAME).write_bytes(b"")),
        "manifest-cut-short": (DAMAGED, lambda pack: _bytes(pack, FILE_NAME, lambda content: content[:-100])),
        "manifest-with-a-tail": (DAMAGED, lambda pack: _bytes(pack, FILE_NAME, lambda content: content + b" ")),
        "manifest-of-a-flipped-bit": (
            DAMAGED,
            lambda pack: _bytes(pack, FILE_NAME, lambda content: content.replace(b"smile", b"smime")),
        ),
        "manifest-without-checksum": (DAMAGED, lambda pack: _unsigned(pack)),
        "manifest-not-json": (BAD, lambda pack: _text(pack, lambda text: text + b"{}")),
        "manifest-not-utf-8": (BAD, lambda pack: _text(pack, lambda text: text.replace(b"smile", b"sm\xffle"))),
        "manifest-with-a-key-twice": (
            BAD,
            lambda pack: _text(pack, lambda text: text.replace(b'"method"', b'"name": "x", "method"')),
        ),
        "manifest-with-nan": (BAD, lambda pack: sign(pack, {"made_with": {"x": float("nan")}})),
        "manifest-with-infinity": (
            BAD,
            lambda pack: _text(pack, lambda text: text.replace(b'"made_with": {', b'"made_with": {"x": 1e999')),
        ),
        "format-4": (OTHER, lambda pack: sign(pack, {"format": "facezip-pack/4"})),
        "format-of-others": (DAMAGED, lambda pack: sign(pack, {"format": "zip"})),
        "format-a-number": (DAMAGED, lambda pack: sign(pack, {"format": 3})),
        "format-not-second": (DAMAGED, lambda pack: _edited(pack, lambda d: d.update(format=d.pop("format")))),
        "manifest-of-one-line": (
            DAMAGED,
            lambda pack: signed(pack, json.dumps(manifest_of(pack) | {"sha256": "0" * 64}).encode()),
        ),
        "manifest-with-half-a-character": (
            BAD,
            lambda pack: _edited(pack, lambda d: d.update(made_with={"x": "\udc00"})),
        ),
        "format-missing": (DAMAGED, lambda pack: _edited(pack, lambda d: d.pop("format"))),
    }


def _files() -> dict[str, tuple[str, Change]]:
    """Rules 3 and 4."""
    changes: dict[str, Change] = {
        "file-missing": lambda pack: (pack / WEIGHTS).unlink(),
        "file-added": lambda pack: (pack / "notes.txt").write_bytes(b"x"),
        "hidden-file-added": lambda pack: (pack / ".hidden").write_bytes(b"x"),
        "folder-added": lambda pack: ((pack / "more").mkdir(), (pack / "more" / "x.txt").write_bytes(b"x")),
        "file-a-folder": lambda pack: (
            (pack / WEIGHTS).unlink(), (pack / WEIGHTS).mkdir(), (pack / WEIGHTS / "x").write_bytes(b"x")
        ),
        "file-a-link": lambda pack: _linked(pack, WEIGHTS),
        "file-longer": lambda pack: _bytes(pack, NEUTRAL, lambda content: content + b"\0"),
        "file-shorter": lambda pack: _bytes(pack, NEUTRAL, lambda content: content[:-1]),
        "file-of-a-flipped-bit": lambda pack: _bytes(
            pack, NEUTRAL, lambda content: content[:-20] + bytes([content[-20] ^ 1]) + content[-19:]
        ),
        "file-that-is-a-path": lambda pack: _edited(pack, lambda d: _renamed(d, "../vector.facezip/" + NEUTRAL)),
        "file-under-another-name": lambda pack: (pack / WEIGHTS).rename(pack / "weights.1002.png"),
    }  # fmt: skip
    return {name: (DAMAGED, change) for name, change in changes.items()}


def _fields() -> dict[str, Edit]:
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
        "neutral-in-the-manifest": lambda d: _renamed(d, FILE_NAME),
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


def _geometry() -> dict[str, Edit]:
    return {
        "geometry-of-another-file": lambda d: d["geometry"].update(files=["neutral.glb"]),
        "geometry-without-triangles": lambda d: d["geometry"].update(triangles=0),
        "geometry-of-too-many-vertices": lambda d: d["geometry"].update(vertices=2**24 + 1),
        "geometry-null-beside-a-mesh": lambda d: d.update(geometry=None),
        "geometry-field-unknown": lambda d: d["geometry"].update(surprise=1),
        "vertices-not-as-stated": lambda d: d["geometry"].update(vertices=6),
        "triangles-not-as-stated": lambda d: d["geometry"].update(triangles=5),
        "expressions-not-as-in-the-mesh": lambda d: d["expressions"].reverse(),
    }


def _several() -> dict[str, tuple[CompressedTextures, Change]]:
    """Packs whose every file is as stated, and readable but for one rule."""
    tint = model(**SMALL, maps=(KNOWN["albedo"], Map("tint", "srgb")))
    tiles = model(**SMALL, tiles=(1001, 1002))
    weights = np.zeros((2, 2, 4), np.uint8)
    return {
        "map-names-twice": (tint, lambda pack: _edited(pack, lambda d: d["maps"][1].update(name="albedo"))),
        "textures-of-more-maps": (tint, lambda pack: _edited(pack, lambda d: d["maps"].pop())),
        "tile-twice": (tiles, lambda pack: _edited(pack, lambda d: d["tiles"][1].update(number=1001))),
        "tiles-that-descend": (tiles, lambda pack: _edited(pack, lambda d: d["tiles"].reverse())),
        "uniform-weights-on-one-tile": (
            tiles, lambda pack: _weights(pack, "weights.1002.png", weights[:1], tile=1, weight_size=[1, 1])
        ),
        "weights-larger-than-textures": (
            model(**SMALL), lambda pack: _weights(pack, WEIGHTS, np.tile(weights, (1, 8, 1)), weight_size=[2, 8])
        ),
        "weight-columns-more-than-expressions": (
            model(**SMALL), lambda pack: _weights(pack, WEIGHTS, np.tile(weights, (1, 3, 1)), weight_columns=3)
        ),
    }  # fmt: skip


def _weights(pack: Path, name: str, samples: np.ndarray, tile: int = 0, **fields: Any) -> None:
    """Other weights, and what the manifest states of them."""
    with_content(pack, name, png(samples))
    _edited(pack, lambda d: d["tiles"][tile].update(fields))


def _masks() -> dict[str, Edit]:
    return {
        "masks-null": lambda d: d.update(masks=None),
        "masks-field-missing": lambda d: d["masks"].pop("clamped"),
        "masks-with-one-name-twice": lambda d: d["masks"].update(names=["a", "A", "c", "d", "e"]),
        "masks-of-an-unsafe-name": lambda d: d["masks"].update(names=["a", "b", "c", "d", "../e"]),
        "masks-more-than-activations": lambda d: d["masks"].update(names=["a", "b", "c", "d", "e", "f"]),
        "masks-of-more-tiles": lambda d: d["masks"].update(files=d["masks"]["files"] * 2),
        "masks-with-another-span": lambda d: d["tiles"][0].update(weight_span=[2.0]),
        "masks-with-an-offset": lambda d: d["tiles"][0].update(weight_offset=[0.5]),
        "masks-in-too-many-columns": lambda d: d["tiles"][0].update(weight_columns=3),
        "masks-clamped-as-a-number": lambda d: d["masks"].update(clamped=0),
    }


def _activations(pack: Path, content: bytes) -> None:
    """Other activations, all the same, of a pack that says that they are not clamped."""
    write_pack(masked(slots=1), pack, name="vector")
    name = manifest_of(pack)["masks"]["activations"]
    with_content(pack, name, content * ((pack / name).stat().st_size // 2))


def _normals() -> dict[str, Edit]:
    return {
        "normals-with-another-range": lambda d: d["maps"][0].update(range=[0.0, 1.0]),
        "normals-of-three-channels": lambda d: (
            d["maps"][0].update(channels=3),
            d["tiles"][0]["textures"][0].update(difference_span=[[1.0] * 3]),
        ),
    }


def _images() -> dict[str, Change]:
    """Rule 5: images with checksums that are right."""

    def replaced(name: str, change: Callable[[np.ndarray], bytes]) -> Change:
        return lambda pack: with_content(pack, name, change(read_texture_exactly(pack / name)))

    def changed(change: Callable[[bytes], bytes]) -> Change:
        return lambda pack: with_content(pack, NEUTRAL, change((pack / NEUTRAL).read_bytes()))

    return {
        "image-of-another-size": replaced(NEUTRAL, lambda samples: png(samples[:3])),
        "image-of-16-bits": replaced(NEUTRAL, lambda samples: png(samples.astype(np.uint16) * 257)),
        "image-of-half-the-columns-in-16-bits": replaced(
            NEUTRAL, lambda samples: png(np.ascontiguousarray(samples[:, :2]).astype(np.uint16) * 257)
        ),
        "image-of-another-signature": changed(lambda content: b"\x88" + content[1:]),
        "image-of-too-few-rows": replaced(NEUTRAL, lambda samples: png(samples, rows=3)),
        "image-of-8-bits": lambda pack: _edited(pack, lambda d: _bits(d, 16)),
        "image-of-grey": replaced(NEUTRAL, lambda samples: png(samples[..., :1])),
        "difference-of-16-bits": replaced(DIFFERENCE, lambda samples: png(samples.astype(np.uint16) * 257)),
        "weights-of-one-channel": replaced(WEIGHTS, lambda samples: png(samples[..., :1])),
        "weights-of-16-bits": replaced(WEIGHTS, lambda samples: png(samples.astype(np.uint16) * 257)),
        "weights-of-another-size": replaced(WEIGHTS, lambda samples: png(np.repeat(samples, 2, 0))),
        "image-that-is-none": changed(lambda content: b"no image"),
        "image-cut-short": changed(lambda content: content[: len(content) // 2]),
        "image-of-a-wrong-checksum": changed(lambda content: content[:-16] + b"\0\0\0\0" + content[-12:]),
        "image-of-an-unknown-filter": replaced(NEUTRAL, lambda samples: png(samples, filters=(5,))),
    }


def _heads() -> dict[str, Callable[[Glb], Any]]:
    """Rule 5: meshes with checksums that are right."""
    primitive = lambda glb: glb.document["meshes"][0]["primitives"][0]  # noqa: E731
    return {
        "head-of-two-meshes": lambda glb: glb.document["meshes"].append(glb.document["meshes"][0]),
        "head-of-other-names": lambda glb: glb.document["meshes"][0]["extras"].update(targetNames=["a", "b"]),
        "head-of-fewer-targets": lambda glb: primitive(glb)["targets"].pop(),
        "head-without-layout": lambda glb: primitive(glb)["attributes"].pop("TEXCOORD_0"),
        "head-without-step": lambda glb: glb.document["nodes"][0].update(scale=[0.0, 0.0, 0.0]),
        "head-of-another-step": lambda glb: glb.document["nodes"][0].update(scale=[3.0, 3.0, 3.0]),
        "head-beyond-its-bytes": lambda glb: glb.document["bufferViews"][-1].update(byteLength=2**20),
        "head-of-4-billion": lambda glb: glb.document["accessors"][0].update(count=2**32 - 1),
        "head-somewhere-else": lambda glb: glb.document["nodes"][0].update(translation=[0.0, 1.0, 0.0]),
        "head-of-lines": lambda glb: primitive(glb).update(mode=1),
        "head-of-another-extension": lambda glb: glb.document.update(extensionsRequired=["KHR_draco_mesh_compression"]),
        "head-of-moving-normals": lambda glb: primitive(glb)["targets"][0].update(NORMAL=0),
        "head-of-nan": lambda glb: _overwritten(glb, "POSITION", 36, struct.pack("<f", float("nan"))),
        "head-of-a-layout-of-nan": lambda glb: _overwritten(glb, "TEXCOORD_0", 0, struct.pack("<f", float("nan"))),
        "head-of-a-layout-of-16-bits": lambda glb: _accessor(glb, "TEXCOORD_0").update(componentType=5123),
        "head-torn-at-its-seam": lambda glb: _overwritten(glb, "POSITION", 0, struct.pack("<f", 1.0)),
        "head-of-a-vertex-that-is-not-there": lambda glb: _overwritten(glb, "indices", 0, b"\xff\x00"),
        "head-without-its-seam": lambda glb: primitive(glb)["attributes"].pop("_SEAM"),
    }


def _orders() -> dict[str, tuple[str, Change]]:
    """Two faults: the earlier rule is what a reader says."""
    return {
        "checksum-before-format": (DAMAGED, lambda pack: (sign(pack, {"format": "zip"}), _tail(pack))),
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
                _bytes(pack, WEIGHTS, lambda content: content[:-1] + b"\0"),
            ),
        ),
    }


def _accessor(glb: Glb, name: str) -> dict[str, Any]:
    """Of an attribute or of the triangles."""
    primitive = glb.document["meshes"][0]["primitives"][0]
    return glb.document["accessors"][{**primitive, **primitive["attributes"]}[name]]


def _overwritten(glb: Glb, name: str, at: int, content: bytes) -> Glb:
    """With other bytes at a place of an attribute or of the triangles."""
    view = _accessor(glb, name)["bufferView"]
    start = glb.document["bufferViews"][view].get("byteOffset", 0) + at
    return replace(glb, binary=glb.binary[:start] + content + glb.binary[start + len(content) :])


def _edited(pack: Path, edit: Edit) -> None:
    document = manifest_of(pack)
    edit(document)
    # Through JSON: what occurs twice becomes two.
    text = json.dumps({**document, "sha256": "0" * 64}, indent=1, ensure_ascii=True)
    signed(pack, text.encode() + b"\n")


def _text(pack: Path, change: Callable[[bytes], bytes]) -> None:
    """Change the manifest as text, and sign it."""
    blank = (pack / FILE_NAME).read_bytes().replace(manifest_of(pack)["sha256"].encode(), b"0" * 64)
    signed(pack, change(blank))


def _bytes(pack: Path, name: str, change: Callable[[bytes], bytes]) -> None:
    (pack / name).write_bytes(change((pack / name).read_bytes()))


def _tail(pack: Path) -> None:
    _bytes(pack, FILE_NAME, lambda content: content + b" ")


def _unsigned(pack: Path) -> None:
    document = manifest_of(pack)
    document.pop("sha256")
    (pack / FILE_NAME).write_text(json.dumps(document, indent=1))


def _linked(pack: Path, name: str) -> None:
    """The same file, beside the pack."""
    (pack / name).rename(pack.parent / "elsewhere")
    os.symlink("../elsewhere", pack / name)


def _renamed(document: dict[str, Any], name: str) -> None:
    document["tiles"][0]["textures"][0]["neutral"] = name
    document["files"][name] = document["files"].pop(NEUTRAL)


def _bits(document: dict[str, Any], bits: int) -> None:
    document["tiles"][0]["textures"][0]["neutral_bits"] = bits


def _with_mesh(pack: Path) -> None:
    write_pack(model(**SMALL, meshes=sheet(seam=True)), pack, name="vector")


def _mesh_in(pack: Path, names: list[str]) -> None:
    """The same mesh in files of other names, all of them stated."""
    content = (pack / HEAD).read_bytes()
    (pack / HEAD).unlink()
    _edited(pack, lambda d: (d["geometry"].update(files=names), d["files"].pop(HEAD)))
    for name in names:
        with_content(pack, name, content)


def _with_normals(pack: Path) -> None:
    write_pack(model(**SMALL, maps=(KNOWN["normal"],)), pack, name="vector")


def _head(pack: Path, edit: Callable[[Glb], Any]) -> None:
    glb = Glb.read(pack / HEAD)
    changed = edit(glb)
    with_content(pack, HEAD, (changed if isinstance(changed, Glb) else glb).to_bytes())
