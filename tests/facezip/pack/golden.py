"""A golden pack of a format version: ``python -m tests.facezip.pack.golden tests/data/pack-N``.

Made once per version and never again: it stands for all packs that people have. Tiny, from the embedded character: its
textures at 64 x 64 and the triangles around the tip of its nose.
"""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

from facezip import Topology
from facezip.character.folder import file_name, write_map
from facezip.character.meshes import Meshes
from facezip.files.images import write_texture
from facezip.fit.methods import compress
from facezip.pack.model import CompressedTextures
from facezip.pack.read import read_pack
from facezip.pack.write import write_pack
from scenes.character import make_character
from scenes.surface import make_surface


def golden_model() -> CompressedTextures:
    model = compress(make_character(64, 5, nuisances=0), weight_scale=8)
    return replace(model, meshes=_patch(model.meshes, 120))


def _patch(meshes: Meshes, triangles: int) -> Meshes:
    """The triangles whose corners lie farthest to the front."""
    topology = meshes.topology
    front = meshes.neutral[topology.faces, 2].mean(axis=1)
    chosen = np.sort(np.argsort(-front, kind="stable")[:triangles])
    vertices, faces = np.unique(topology.faces[chosen], return_inverse=True)
    coordinates, face_uv = np.unique(topology.face_uv[chosen], return_inverse=True)
    corners, uv_corners = (indices.reshape(-1, 3).astype(np.int32) for indices in (faces, face_uv))
    patch = Topology(corners, topology.uv[coordinates], uv_corners)
    return Meshes(patch, meshes.neutral[vertices], meshes.deltas[:, vertices])


def golden_surface() -> CompressedTextures:
    """Albedo, normals and roughness of the same, on two tiles."""
    model = compress(make_surface(64, 5, nuisances=0, tiles=(2, 1)), weight_scale=8)
    return replace(model, meshes=_patch(model.meshes, 120))


def write_layered(folder: Path) -> None:
    path = folder / "golden.facezip"
    write_pack(golden_surface(), path, name="golden", made_with={"method": "refined", "seed": 0})
    model = read_pack(path)
    for name in model.expressions:
        for kind in model.maps:
            for tile in model.tiles:
                texture = model.parts[kind.name, tile].reconstruct(name)
                write_map(folder / file_name(name, kind, tile, model.tiles), texture, kind, 8)


if __name__ == "__main__":
    folder = Path(sys.argv[1])
    if folder.name == "pack-2":
        write_layered(folder)
        sys.exit()
    write_pack(golden_model(), folder / "golden.facezip", name="golden", made_with={"method": "refined", "seed": 0})
    for name in (model := read_pack(folder / "golden.facezip")).expressions:
        write_texture(folder / f"{name}.png", model.reconstruct(name))
