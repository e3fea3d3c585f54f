"""The face among the materials of a mesh: what has the character's textures; eyes and teeth have their own."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from facezip.character.correspondence import UV_TOLERANCE, in_order_of
from facezip.character.layout import Layout
from facezip.character.notes import Note
from facezip.character.parts import is_called, listed, without_inner
from facezip.character.raster import covered
from facezip.character.scans import NEUTRAL
from facezip.character.tiles import shifted
from facezip.errors import ErrorCode, FaceZipError
from facezip.files.mtl import COLOUR
from facezip.files.obj import Topology, only_materials, read_obj
from facezip.names import folded

# Texels a side by which charts are compared, and the share of the smaller one that two have in common if they overlap.
SIDE, OVERLAP = 256, 0.05

Mesh = tuple[NDArray[np.float32], Topology]


@dataclass
class Faces:
    """Reads the meshes of a folder, of the materials that are the face alone.

    Attributes
    ----------
    layout : the folder.
    notes : takes what is left out.
    """

    layout: Layout
    notes: list[Note]
    _whole: Mesh | None = None
    _kept: tuple[str, ...] = ()

    def neutral(self) -> Mesh:
        """The neutral's vertices ``(V, 3)`` and topology, which tells what the face is; first of all meshes.

        Raises
        ------
        FaceZipError
            What :func:`facezip.files.obj.read_obj` raises; ``BAD_CHARACTER`` where it is in doubt.
        """
        path = self.layout.meshes[NEUTRAL]
        vertices, topology = read_obj(path)
        self._kept = self._face(path, topology)
        if len(self._kept) == len(topology.materials):
            return vertices, topology
        self._whole = vertices, topology
        others = [name for name in topology.materials if name not in self._kept]
        words = f"the face is of the material {listed(self._kept)}; left out: {listed(others)}"
        self.notes.append(self.layout.note(path, words))
        return only_materials(vertices, topology, self._kept)

    def expression(self, name: str, tolerance: float = UV_TOLERANCE) -> Mesh:
        """As :meth:`neutral`; a mesh without these materials has to be the neutral's, every part of it."""
        path = self.layout.meshes[name]
        vertices, topology = read_obj(path)
        if self._whole is None:
            return vertices, topology
        if all(material in topology.materials for material in self._kept):
            return only_materials(vertices, topology, self._kept)
        if {*topology.materials} - {"", *self._whole[1].materials}:
            raise FaceZipError(
                ErrorCode.BAD_CHARACTER,
                f"{path}: has the materials {listed(topology.materials)}, and the neutral's face is of "
                f"{listed(self._kept)}; name them alike",
            )
        alike = in_order_of(path, *self._whole, vertices, topology, tolerance)
        return only_materials(alike, self._whole[1], self._kept)

    def _face(self, path: Path, topology: Topology) -> tuple[str, ...]:
        materials = topology.materials
        if self.layout.part is not None:
            return self._wanted(path, materials, self.layout.part)
        if len(materials) == 1:
            return materials
        tied = self._tied(materials)
        if tied:
            return tied
        # Of one image, or of none that is known: then of one texture, if no two of them lie on the same texels of it.
        images = {frozenset(self._images(name)) for name in materials}
        if len(images) == 1 and (all(images) or not _overlapping(topology, self.layout.tiles)):
            return materials
        outer = without_inner([(name,) for name in materials])
        if len(outer) == 1:
            return (materials[outer[0]],)
        raise FaceZipError(
            ErrorCode.BAD_CHARACTER,
            f"{path}: each of its materials {listed(materials)} may be the face; say which in character.toml: "
            f'part = "{materials[(outer or [0])[0]]}"',
        )

    def _wanted(self, path: Path, materials: Sequence[str], part: str) -> tuple[str, ...]:
        found = tuple(name for name in materials if is_called(part, (name,)))
        if not found:
            reason = f"has no material '{part}', as character.toml says; it has {listed(materials)}"
            raise FaceZipError(ErrorCode.BAD_CHARACTER, f"{path}: {reason}")
        return found

    def _tied(self, materials: Sequence[str]) -> tuple[str, ...]:
        """Materials whose image is one of the character's textures; all where they are its tiles."""
        ours = {folded(file.name) for file in self.layout.maps[0].files.values()}
        return tuple(name for name in materials if self._images(name) & ours)

    def _images(self, material: str) -> set[str]:
        stated = [image for image, key in self.layout.materials.get(material, {}).items() if key == COLOUR]
        return {image.replace("<udim>", str(tile)) for tile in self.layout.tiles for image in stated}


def _overlapping(topology: Topology, tiles: Sequence[int]) -> bool:
    """Whether charts of two materials lie over each other, so that they cannot share a texture."""
    return any(_overlap(chart, tile) for tile in tiles for chart in combinations(_by_material(topology), 2))


def _by_material(topology: Topology) -> list[Topology]:
    owner, count = topology.face_material, len(topology.materials)
    every = [topology.faces, topology.face_uv]
    return [Topology(every[0][owner == number], topology.uv, every[1][owner == number]) for number in range(count)]


def _overlap(charts: tuple[Topology, Topology], tile: int) -> bool:
    one, other = (covered(shifted(chart, tile), (SIDE, SIDE)) for chart in charts)
    return bool((one & other).sum() > OVERLAP * min(one.sum(), other.sum()))
