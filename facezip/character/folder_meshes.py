"""The meshes of a folder: read, of the face alone, where its textures are, and in the neutral's order."""

from facezip.character.correspondence import in_order_of
from facezip.character.layout import Layout
from facezip.character.meshes import check_digits
from facezip.character.notes import Note
from facezip.character.obj_parts import Faces, Mesh
from facezip.character.scans import NEUTRAL
from facezip.character.uvs import check_on_tiles, in_unit_square
from facezip.errors import FaceZipError
from facezip.files.obj import may_be_cut

# Of a texel: exporters round UVs, each in its own way.
UV_TOLERANCE = 1 / 16


class FolderMeshes:
    """One reading of them, the neutral first; the others may be read side by side.

    Parameters
    ----------
    layout : the folder.
    texel : the side of a texel in UV.

    Attributes
    ----------
    notes : what is left out or moved, in any order.
    """

    def __init__(self, layout: Layout, texel: float) -> None:
        self._layout, self._texel, self._tolerance = layout, texel, UV_TOLERANCE * texel
        self.notes: list[Note] = []
        self._faces = Faces(layout, self.notes)
        self._neutral: Mesh | None = None

    def read(self, name: str) -> Mesh:
        """The face of a mesh as its file has it, vertices ``(V, 3)`` and topology.

        Raises
        ------
        FaceZipError
            What :class:`facezip.character.obj_parts.Faces` raises.
        """
        return self._faces.neutral() if name == NEUTRAL else self._faces.expression(name, self._tolerance)

    def in_order(self, name: str, mesh: Mesh) -> Mesh:
        """A mesh that was read, with UVs where textures are, and vertices in the order of the neutral's.

        Raises
        ------
        FaceZipError
            ``UNREADABLE_MESH``: it lies too far away, or its UVs lie where there is no texture;
            ``TOPOLOGY_MISMATCH``: it is another mesh than the neutral.
        """
        path, (vertices, topology) = self._layout.meshes[name], mesh
        check_digits(path, vertices, topology)
        if not self._layout.numbered:
            topology, notes = in_unit_square(path, topology, self._texel)
            self.notes += (self._layout.note(path, note.words, note.asks) for note in notes)
        elif name == NEUTRAL:
            self._note_empty(check_on_tiles(path, topology, self._layout.tiles, self._texel))
        if name == NEUTRAL:
            self._neutral = vertices, topology
        elif self._neutral is not None:
            try:
                vertices = in_order_of(path, *self._neutral, vertices, topology, self._tolerance)
            except FaceZipError as error:
                if may_be_cut(path):
                    words = f"{error}; its last line does not end, so the file may be cut off"
                    raise FaceZipError(error.code, words) from None
                raise
        return vertices, topology

    def _note_empty(self, tiles: tuple[int, ...]) -> None:
        for tile in tiles:
            words = f"no triangle lies on tile {tile}; its textures take room in the pack all the same"
            self.notes.append(self._layout.note(self._layout.maps[0].files[NEUTRAL, tile], words))
