"""A character looked at without using it: every file, and every reason at once why it cannot be read."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from facezip.character.diagnosis import Diagnosis, Row, distinct
from facezip.character.filenames import within
from facezip.character.folder_meshes import FolderMeshes
from facezip.character.layout import Layout, MapFiles, read_layout
from facezip.character.loading import read_character
from facezip.character.notes import Note
from facezip.character.scans import NEUTRAL, Character, check_names
from facezip.character.settings import read_settings
from facezip.character.sizes import Sizes, add_size, words_for
from facezip.character.sources import gltf_at
from facezip.character.suggestion import suggested
from facezip.character.texels import normal_rows, states_signs, value_rows
from facezip.character.units import WORDS, likely_unit
from facezip.errors import ErrorCode, FaceZipError, Refuse, raised
from facezip.files.facts import Facts
from facezip.files.obj import Topology
from facezip.files.reading import reading
from facezip.files.statements import stated
from facezip.files.values import read_mask
from facezip.machine.progress import track


def examine_character(path: Path) -> Diagnosis:
    """What is read of a character and what of it is unusual; where it cannot be read, all reasons that can be found."""
    search = _Search(path)
    with _collected(search.faults), reading(path):
        gltf = gltf_at(path)
        with _collected(search.faults):
            character = read_character(path)
            rows = _rows(path, character) if gltf is None else _rows_within(gltf, character)
            return Diagnosis("character", str(path), _summary(character), tuple(rows), (), character.notes)
        if gltf is None and path.is_dir():
            search.look()
    notes = tuple(sorted(search.notes, key=lambda note: (note.file, note.words)))
    faults = distinct(search.faults)
    return Diagnosis("character", str(path), "cannot be read", tuple(search.rows), faults, notes, search.character_toml)


def _summary(character: Character) -> str:
    height, width = character.first.resolution
    maps, tiles = ", ".join(kind.name for kind in character.maps), ", ".join(map(str, character.tiles))
    masked = "with a mask" if character.masked else "without a mask: the whole texture is the face"
    return (
        f"{len(character.expressions)} expressions besides the neutral; {maps} of {width}x{height}, {tiles}; {masked}"
    )


def _rows_within(path: Path, character: Character) -> list[Row]:
    """Of a character in one file."""
    found = [
        _mesh_row(path.name, name, character.mesh_vertices(name), character.meshes.topology)
        for name in (NEUTRAL, *character.expressions)
    ]
    for (map, tile), stack in character.stacks.items():
        encoding = f"{stack.neutral.dtype}, {stack.channels} channel(s)"
        found += [
            Row(path.name, map, name, tile, encoding, "as stored", words_for(stack.resolution))
            for name in (NEUTRAL, *character.expressions)
        ]
    return found


def _mesh_row(file: str, name: str, vertices: NDArray[np.float32], topology: Topology) -> Row:
    extent = np.ptp(vertices[topology.faces].reshape(-1, 3), axis=0)
    size = f"{len(vertices)} vertices, {len(topology.faces)} triangles"
    encoding = "obj" if file.lower().endswith(".obj") else "gltf"
    return Row(file, "mesh", name, None, encoding, "taken as y up, looking to +z", size, _unit(extent))


def _unit(extent: NDArray[np.float32]) -> str:
    """The extents of a mesh, and what it is measured in if it is a head."""
    sides = " x ".join(f"{side:.3g}" for side in extent)
    likely = likely_unit(extent)
    return f"{sides}, {f'{WORDS[likely]} by its size' if likely else 'of any unit'}"


def _rows(folder: Path, character: Character) -> list[Row]:
    """Of a character in a folder, by what headers state."""
    layout = read_layout(folder, read_settings(folder))
    topology = character.meshes.topology
    meshes = [
        _mesh_row(within(layout.folder, path), name, character.mesh_vertices(name), topology)
        for name, path in layout.meshes.items()
    ]
    return meshes + _image_rows(layout, _facts(layout))


def _facts(layout: Layout, refuse: Refuse = raised) -> dict[Path, Facts]:
    """What every texture and mask states."""
    facts: dict[Path, Facts] = {}
    for path in (*(path for how in layout.maps for path in how.files.values()), *layout.masks.values()):
        try:
            facts[path] = stated(path)
        except FaceZipError as error:
            refuse(error)
    return facts


def _image_rows(layout: Layout, facts: Mapping[Path, Facts]) -> list[Row]:
    """Of textures and masks; what cannot be read has no row."""
    rows: list[Row] = []
    for how in layout.maps:
        for (name, tile), path in how.files.items():
            # Its colours may be of a space that is not converted.
            with suppress(KeyError, FaceZipError):
                rows.append(_texture_row(layout, how, name, tile, facts[path]))
    for tile, path in layout.masks.items():
        if path in facts:
            rows.append(_mask_row(layout, tile, facts[path]))
    return rows


def _mask_row(layout: Layout, tile: int, facts: Facts) -> Row:
    encoding = f"{_format(facts.path)}, {facts.type}, {', '.join(facts.channels)}"
    file = within(layout.folder, facts.path)
    return Row(file, "mask", "", tile, encoding, _orientation(facts), words_for(facts.size))


def _texture_row(layout: Layout, how: MapFiles, name: str, tile: int, facts: Facts) -> Row:
    space = facts.colour_space.name if how.kind.encoding == "srgb" else "numbers"
    if how.kind.is_normal:
        space = "tangent space, y down" if how.green_down else "tangent space, y up"
    encoding = f"{_format(facts.path)}, {facts.type}, {', '.join(facts.channels)}, {space}"
    file = within(layout.folder, facts.path)
    return Row(file, how.kind.name, name, tile, encoding, _orientation(facts), words_for(facts.size))


def _format(path: Path) -> str:
    return path.suffix.lower().removeprefix(".")


def _orientation(facts: Facts) -> str:
    return "as stored" if facts.orientation == 1 else f"turned upright from {facts.orientation}"


@contextmanager
def _collected(faults: list[FaceZipError]) -> Iterator[None]:
    try:
        yield
    except FaceZipError as error:
        faults.append(error)


@dataclass
class _Search:
    """All reasons why the character of a folder cannot be read."""

    folder: Path
    faults: list[FaceZipError] = field(default_factory=list)
    rows: list[Row] = field(default_factory=list)
    notes: list[Note] = field(default_factory=list)
    character_toml: str = ""

    def look(self) -> None:
        """Add what is found to the faults that are known already, and what can be read all the same."""
        with _collected(self.faults), reading(self.folder):
            layout = self._layout()
            self.notes += layout.notes
            with _collected(self.faults):
                check_names(layout.expressions, self.folder)
            facts = _facts(layout, self.faults.append)
            self._meshes(layout, self._headers(layout, facts))
            self.rows += _image_rows(layout, facts)
            self._texels(layout, facts)

    def _layout(self) -> Layout:
        """Which file is what; where that cannot be told by their names, a ``character.toml`` that would say it."""
        known = len(self.faults)
        try:
            layout = read_layout(self.folder, read_settings(self.folder, self.faults.append), self.faults.append)
        except FaceZipError as error:
            self._suggest(error)
            raise
        for fault in self.faults[known:]:
            self._suggest(fault)
        return layout

    def _suggest(self, error: FaceZipError) -> None:
        if error.code in (ErrorCode.BAD_CHARACTER, ErrorCode.MISSING_FILE) and not self.character_toml:
            with suppress(FaceZipError):
                self.character_toml = suggested(self.folder)

    def _headers(self, layout: Layout, stated: Mapping[Path, Facts]) -> float:
        """What headers say; the side of a texel in UV."""
        sizes = Sizes()
        for how in layout.maps:
            for tile in layout.tiles:
                files = {name: path for (name, of), path in how.files.items() if of == tile and path in stated}
                facts = {name: stated[files[name]] for name in (NEUTRAL, *layout.expressions) if name in files}
                for each in facts.values():
                    with _collected(self.faults):
                        each.applied(how.kind.encoding == "srgb")
                with _collected(self.faults):
                    if len(facts) > 1 and NEUTRAL in facts:
                        sizes.of[how.kind.name, tile] = add_size(sizes, layout, how, tile, facts, self.faults.append)
        self.notes += sizes.notes
        return 1 / max((max(size) for size in sizes.of.values()), default=4096)

    def _meshes(self, layout: Layout, texel: float) -> None:
        meshes = FolderMeshes(layout, texel)
        for name in (NEUTRAL, *layout.expressions):
            with _collected(self.faults):
                mesh = meshes.read(name)
                self.rows.append(_mesh_row(within(self.folder, layout.meshes[name]), name, *mesh))
                meshes.in_order(name, mesh)
        self.notes += meshes.notes

    def _texels(self, layout: Layout, facts: Mapping[Path, Facts]) -> None:
        for path in layout.masks.values():
            with _collected(self.faults):
                read_mask(path)
        files = [(how, key, path) for how in layout.maps for key, path in how.files.items()]
        for how, (_, tile), path in track(files, "Reading every texture", len(files)):
            with _collected(self.faults):
                if path not in facts:
                    continue
                if how.kind.is_normal:
                    signed = states_signs(how.files.get((NEUTRAL, tile), path))
                    rows = normal_rows(path, how, signed, np.zeros(facts[path].size, np.bool_))
                else:
                    rows = value_rows(path, how)
                for _ in rows:
                    pass
