"""Geometry that a reader must refuse, in packs that are well signed."""

import struct
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

from facezip.files.glb import Glb
from facezip.pack.write import write_pack
from tests.conformance.editing import HEAD, SMALL, Edit, edited
from tests.conformance.signing import with_content
from tests.conformance.valid import model, sheet


def broken_geometry() -> dict[str, Edit]:
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


def broken_heads() -> dict[str, Callable[[Glb], Any]]:
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


def _accessor(glb: Glb, name: str) -> dict[str, Any]:
    """Of an attribute or of the triangles."""
    primitive = glb.document["meshes"][0]["primitives"][0]
    return glb.document["accessors"][{**primitive, **primitive["attributes"]}[name]]


def _overwritten(glb: Glb, name: str, at: int, content: bytes) -> Glb:
    """With other bytes at a place of an attribute or of the triangles."""
    view = _accessor(glb, name)["bufferView"]
    start = glb.document["bufferViews"][view].get("byteOffset", 0) + at
    return replace(glb, binary=glb.binary[:start] + content + glb.binary[start + len(content) :])


def with_mesh(pack: Path) -> None:
    write_pack(model(**SMALL, meshes=sheet(seam=True)), pack, name="vector")


def mesh_in(pack: Path, names: list[str]) -> None:
    """The same mesh in files of other names, all of them stated."""
    content = (pack / HEAD).read_bytes()
    (pack / HEAD).unlink()
    edited(pack, lambda d: (d["geometry"].update(files=names), d["files"].pop(HEAD)))
    for name in names:
        with_content(pack, name, content)


def edited_head(pack: Path, edit: Callable[[Glb], Any]) -> None:
    glb = Glb.read(pack / HEAD)
    changed = edit(glb)
    with_content(pack, HEAD, (changed if isinstance(changed, Glb) else glb).to_bytes())
