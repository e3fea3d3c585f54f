"""The maps of a glTF's face, read for the neutral and every expression: base colours, roughness, and normals."""

from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from facezip.character.folder import described
from facezip.character.gltf_images import Images
from facezip.character.gltf_material import Material
from facezip.character.gltf_texels import NOTHING, bumped_rows, roughness_rows, tinted
from facezip.character.gltf_textures import Look
from facezip.character.maps import ALBEDO, Key
from facezip.character.masks import read_face, seen, sized_for
from facezip.character.notes import Note
from facezip.character.scans import NEUTRAL, Stack
from facezip.character.sizes import SPARE
from facezip.character.tiles import FIRST_TILE
from facezip.errors import ErrorCode, FaceZipError
from facezip.files.bands import Bands, filled
from facezip.files.colours import colour_bands
from facezip.files.images import Texels
from facezip.files.obj import Topology
from facezip.files.reading import check_expansion
from facezip.files.statements import stated
from facezip.machine import memory
from facezip.machine.progress import track

# An image or file, and the material that says how it is meant.
Source = tuple[int | Path, Material | None]


class Maps:
    """One reading of the textures of a face.

    Parameters
    ----------
    path, images : the file.
    looks : of the neutral, first, and of every expression.
    mask : the look of the mask, where there is one.
    topology : the mesh that they lie on.
    held : bytes that are held besides.
    """

    def __init__(
        self,
        path: Path,
        images: Images,
        looks: Mapping[str, Look],
        mask: Look | None,
        topology: Topology,
        held: int,
    ) -> None:
        self._path, self._images, self._looks, self._mask_look = path, images, looks, mask
        self._topology, self._held = topology, held
        self._mask: NDArray[np.float32] | None = None
        self.notes: list[Note] = []

    def read(self, wanted: tuple[str, ...] | None) -> dict[Key, Stack]:
        """The stacks of all maps, or of the wanted ones, that the neutral and every expression have."""
        kinds = [kind for kind in (ALBEDO, "normal", "roughness") if wanted is None or kind in wanted or kind == ALBEDO]
        sources = {kind: self._sources(kind) for kind in kinds}
        return {(kind, FIRST_TILE): self._stack(kind, those) for kind, those in sources.items() if those is not None}

    def _sources(self, kind: str) -> dict[str, Source] | None:
        """What holds a map under each name; None if not all have it, and a note if some do."""
        if kind == ALBEDO:
            # What the face is multiplied by holds for textures that are no material's, too.
            own = self._looks[NEUTRAL].material
            return {name: (look.source, look.material or own) for name, look in self._looks.items()}
        found: dict[str, Source] = {}
        missing: dict[str, str] = {}
        for name, look in self._looks.items():
            use = None if look.material is None else look.material.textures.get(kind)
            if use is None or look.colours is None:
                missing[name] = "has none"
            elif not use.placement.is_as(look.colours.placement):
                missing[name] = "has it on other UVs than its colours"
            else:
                found[name] = use.image, look.material
        if not missing:
            return found
        if found or {*missing.values()} != {"has none"}:
            name, reason = next(iter(missing.items()))
            self.notes.append(Note(self._path.name, f"textures of {kind} are left out: '{name}' {reason}"))
        return None

    def _stack(self, kind: str, sources: dict[str, Source]) -> Stack:
        rows = self._rows_of(kind, sources)

        def read(name: str, into: Texels | None = None) -> Texels:
            with self._images.file(sources[name][0]) as file:
                self._note(kind, sources[name][0], file)
                return filled(rows(name, file), into)

        neutral = read(NEUTRAL)
        names = [name for name in sources if name != NEUTRAL]
        unfolded = len(sources) * neutral.nbytes
        beside = {source: self._images.stored_bytes(source) for source, _ in sources.values()}
        check_expansion(self._path, unfolded, self._path.stat().st_size + sum(beside.values()), SPARE)
        memory.check(unfolded // len(neutral), self._held)
        textures: Texels = memory.empty((len(names), *neutral.shape), neutral.dtype)
        for n, name in enumerate(track(names, f"Reading the {kind}", len(names))):
            texture = read(name, textures[n])
            if texture.shape != neutral.shape or texture.dtype != neutral.dtype:
                raise FaceZipError(
                    ErrorCode.SIZE_MISMATCH,
                    f"{self._path}: the {kind} texture of '{name}' is {described(texture)}, the neutral is "
                    f"{described(neutral)}; export both alike",
                )
        return Stack(neutral, textures, self._mask_of(kind, neutral.shape[:2]))

    def _rows_of(self, kind: str, sources: dict[str, Source]) -> Callable[[str, Path], Bands]:
        if kind == ALBEDO:
            tints = {name: NOTHING if material is None else material.tint for name, (_, material) in sources.items()}
            coloured = any(len({*tint}) > 1 for tint in tints.values())
            if any(tint != NOTHING for tint in tints.values()):
                self.notes.append(Note(self._path.name, "colours are multiplied by the base colour factor"))
            return lambda name, file: tinted(_colours(file, sources[name][0]), tints[name], coloured)
        factors = {name: material for name, (_, material) in sources.items() if material is not None}
        if kind == "roughness":
            return lambda name, file: roughness_rows(file, factors[name].roughness)
        on_face: dict[tuple[int, int], NDArray[np.bool_]] = {}

        def normals(name: str, file: Path) -> Bands:
            size = stated(file).size
            if size not in on_face:
                on_face[size] = self._seen(size)
            return bumped_rows(file, factors[name].bump, on_face[size])

        return normals

    def _seen(self, size: tuple[int, int]) -> NDArray[np.bool_]:
        mask = None if self._mask_look is None else self._read_mask(self._mask_look.source)
        return seen(self._topology, size, mask)

    def _mask_of(self, kind: str, size: tuple[int, int]) -> NDArray[np.float32] | None:
        if self._mask_look is None:
            return None
        source = self._mask_look.source
        what = str(source) if isinstance(source, Path) else f"{self._path}: {self._images.shown(source)}"
        mask, words = sized_for(kind, size, self._read_mask(source), what)
        self.notes += [Note(self._images.shown(source), words)] if words else []
        return mask

    def _read_mask(self, source: int | Path) -> NDArray[np.float32]:
        if self._mask is None:
            with self._images.file(source) as file:
                self._mask, done = read_face(file)
            self.notes += [Note(self._images.shown(source), words) for words in done]
        return self._mask

    def _note(self, kind: str, source: int | Path, file: Path) -> None:
        is_stated = isinstance(source, Path) and kind == ALBEDO
        shown = self._images.shown(source)
        self.notes += [Note(shown, words) for words in stated(file).applied(as_colours=is_stated)]


def _colours(file: Path, source: int | Path) -> Bands:
    """glTF states what its images' numbers are (2.0, section 3.8.3): they do not; those beside it do."""
    return colour_bands(file, ignores_space=isinstance(source, int) and file.suffix.lower() != ".exr")
