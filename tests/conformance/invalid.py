"""Packs that a reader must refuse, with the code: each rule of docs/pack-format.md broken alone, then two at once."""

from collections.abc import Iterator

from facezip.pack.write import write_pack
from tests.conformance.broken_heads import broken_geometry, broken_heads, edited_head, mesh_in, with_mesh
from tests.conformance.broken_manifests import broken_fields, broken_files, broken_manifests, two_faults
from tests.conformance.broken_textures import (
    broken_images,
    broken_masks,
    broken_normals,
    broken_tiles,
    with_activations,
    with_normals,
)
from tests.conformance.editing import BAD, HEAD, SMALL, Change, edited
from tests.conformance.signing import with_content
from tests.conformance.valid import masked, model


def invalid() -> Iterator[tuple[str, str, Change]]:
    """Name, code and writer of each."""
    for name, (code, damage) in {**broken_manifests(), **broken_files()}.items():
        yield name, code, lambda pack, damage=damage: (write_pack(model(**SMALL), pack, name="vector"), damage(pack))
    for name, edit in broken_fields().items():
        yield name, BAD, lambda pack, edit=edit: (write_pack(model(**SMALL), pack, name="vector"), edited(pack, edit))
    for name, edit in broken_geometry().items():
        yield name, BAD, lambda pack, edit=edit: (with_mesh(pack), edited(pack, edit))
    for name, files in {"under-another-name": ["mesh.glb"], "of-version-2": ["neutral.obj", "deltas.f32"]}.items():
        yield f"geometry-{name}", BAD, lambda pack, files=files: (with_mesh(pack), mesh_in(pack, files))
    for name, change in broken_normals().items():
        yield name, BAD, lambda pack, edit=change: (with_normals(pack), edited(pack, edit))
    for name, change in broken_images().items():
        yield name, BAD, lambda pack, change=change: (write_pack(model(**SMALL), pack, name="vector"), change(pack))
    yield (
        "head-of-gltf-1",
        BAD,
        lambda pack: (
            with_mesh(pack),
            with_content(pack, HEAD, b"glTF\1" + (pack / HEAD).read_bytes()[5:]),
        ),
    )
    for name, edit in broken_heads().items():
        yield name, BAD, lambda pack, edit=edit: (with_mesh(pack), edited_head(pack, edit))
    for name, (made, edit) in broken_tiles().items():
        yield name, BAD, lambda pack, made=made, edit=edit: (write_pack(made, pack, name="vector"), edit(pack))
    for name, edit in broken_masks().items():
        yield name, BAD, lambda pack, edit=edit: (write_pack(masked(slots=1), pack, name="vector"), edited(pack, edit))
    for name, content in {"not-finite": b"\0\x7c", "not-clamped-as-stated": b"\0\0"}.items():
        yield f"activations-{name}", BAD, lambda pack, content=content: with_activations(pack, content)
    for name, (code, change) in two_faults().items():
        yield name, code, lambda pack, change=change: (write_pack(model(**SMALL), pack, name="vector"), change(pack))
