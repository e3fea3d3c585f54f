"""Golden packs of the newest version of the format, without masks and with some.

``python -m tests.facezip.pack.golden tests/data/pack-N [masks]``. Made once and never again: each stands for all packs
that people have. Tiny, from the embedded character: its albedo, normals and roughness between the brows, where its
relief moves most, on two tiles of 64 x 64 texels, and the triangles around the tip of its nose. With masks: five that
overlap, of weights in 0..1.
"""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

from facezip import Topology, compress
from facezip.character.folder import file_name, write_map
from facezip.character.meshes import Meshes
from facezip.character.scans import Character, Stack
from facezip.fit.given import GivenMasks
from facezip.pack.model import CompressedTextures
from facezip.pack.read import read_pack
from facezip.pack.write import write_pack
from scenes.character import make_character
from scenes.face.capture import MAPS
from scenes.tiles import in_tiles


def golden_model(method: str) -> CompressedTextures:
    given = _masks() if method == "masks" else None
    scans = in_tiles(_window(make_character(512, 5, nuisances=0, maps=MAPS[:2])), 2, 1)
    model = compress(scans, method, weight_scale=8, given_masks=given)
    return replace(model, meshes=_patch(model.meshes, 120))


def _masks() -> GivenMasks:
    """Round spots, of which the last one lies on the first tile alone."""
    y, x = (np.mgrid[:32, :64] + 0.5) / 32
    centres = ((0.3, 0.4), (0.7, 0.6), (1.3, 0.4), (1.7, 0.6), (0.5, 0.9))
    spots = [np.exp(-3 * ((x - a) ** 2 + (y - b) ** 2)).astype(np.float32) for a, b in centres]
    tiles = {1001: slice(0, 32), 1002: slice(32, 64)}
    images = {(f"spot_{k}", tile): spot[:, columns] for k, spot in enumerate(spots) for tile, columns in tiles.items()}
    del images["spot_4", 1002]
    return GivenMasks(tuple(f"spot_{k}" for k in range(5)), images, {"spot_0": (0, 1, 2)}, nonnegative=True)


def _window(character: Character) -> Character:
    """The texels between the brows."""
    rows, columns = np.s_[96:160], np.s_[192:320]
    stacks = {
        key: Stack(stack.neutral[rows, columns], stack.textures[:, rows, columns], stack.mask[rows, columns])
        for key, stack in character.stacks.items()
    }
    return replace(character, stacks=stacks)


def _patch(meshes: Meshes, triangles: int) -> Meshes:
    """The triangles whose corners lie farthest to the front."""
    topology = meshes.topology
    front = meshes.neutral[topology.faces, 2].mean(axis=1)
    chosen = np.sort(np.argsort(-front, kind="stable")[:triangles])
    vertices, faces = np.unique(topology.faces[chosen], return_inverse=True)
    coordinates, face_uv = np.unique(topology.face_uv[chosen], return_inverse=True)
    corners, uv_corners = (indices.reshape(-1, 3).astype(np.int32) for indices in (faces, face_uv))
    patch = Topology(corners, topology.uv[coordinates], uv_corners)
    return Meshes(patch, meshes.neutral[vertices], meshes.vertices[:, vertices])


if __name__ == "__main__":
    folder, method = Path(sys.argv[1]), "masks" if "masks" in sys.argv else "refined"
    write_pack(golden_model(method), folder / "golden.facezip", name="golden", made_with={"method": method, "seed": 0})
    model = read_pack(folder / "golden.facezip")
    for name in model.expressions:
        for kind in model.maps:
            for tile in model.tiles:
                texels = model.texels({name: 1.0}, (kind.name, tile))
                write_map(folder / file_name(name, kind, tile, model.tiles), texels, kind, 8)
