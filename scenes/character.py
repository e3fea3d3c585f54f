"""The embedded character: a folder's worth of scans of a person who never was, and the truth behind them."""

from collections.abc import Iterator
from copy import deepcopy
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from facezip.character.maps import ALBEDO, KNOWN
from facezip.character.meshes import Meshes
from facezip.character.scans import Character, Stack
from facezip.character.tiles import FIRST_TILE
from facezip.errors import ErrorCode, FaceZipError
from facezip.files.images import Texels
from facezip.machine.progress import track
from scenes.face.capture import MAPS, Nuisances, captured, captured_maps
from scenes.face.expressions import expression_weights
from scenes.face.head import Head, build_head
from scenes.face.identity import shaped
from scenes.face.shapes import ARKIT_SHAPES, shape_deltas
from scenes.face.skin.albedo import neutral_albedo
from scenes.face.skin.creases import Creases
from scenes.face.skin.ground import Ground
from scenes.face.skin.hairs import grown
from scenes.face.skin.relief import Relief, relief
from scenes.face.skin.sampling import TexelGrid, closed
from scenes.face.skin.strain import Strain, strain
from scenes.face.skin.wrinkles import rested, wrinkled
from scenes.face.traits import Traits, traits
from scenes.tiles import in_tiles


@dataclass(frozen=True, eq=False)
class Person:
    """The truth: geometry and texture for any weights of the 52 shapes.

    Attributes
    ----------
    head : the neutral head.
    deltas : ``(52, V, 3)`` float32, cm.
    traits : sex, age and colours.
    texels : where texels lie on the head before it was bent into the person's.
    creases : the lines in which the face folds.
    hair : ``(R, R)`` float32 in [0, 1], how much of a texel it covers.
    albedo : ``(R, R, 3)`` float32, encoded sRGB, of the neutral.
    """

    head: Head
    deltas: NDArray[np.float32]
    traits: Traits
    texels: TexelGrid
    creases: Creases
    hair: NDArray[np.float32]
    albedo: NDArray[np.float32]

    @staticmethod
    def make(resolution: int, seed: int = 0) -> "Person":
        """The person with this seed, with textures of ``resolution`` x ``resolution``."""
        sculpt, who = build_head(), traits(seed)
        # Zones of the skin are places of the sculpt; a person's skin is bent with it.
        texels = TexelGrid.of(sculpt, resolution)
        creases, hair = Creases.of(sculpt, texels, who), grown(sculpt, texels, who)
        albedo = neutral_albedo(sculpt.rows, texels, who, hair)
        rested(albedo, texels, creases)
        head, deltas = shaped(sculpt, shape_deltas(sculpt), who)
        return Person(head, deltas, who, texels, creases, hair, albedo)

    @property
    def seed(self) -> int:
        """Which person."""
        return self.traits.seed

    def vertices(self, weights: dict[str, float]) -> NDArray[np.float32]:
        """``(V, 3)`` of a blend of shapes, equation (7)."""
        moved = self.head.vertices.copy()
        for name, weight in weights.items():
            moved += np.float32(weight) * self.deltas[ARKIT_SHAPES.index(name)]
        return moved

    def texture(self, weights: dict[str, float]) -> NDArray[np.float32]:
        """``(R, R, 3)`` float32 in [0, 1], encoded sRGB, of a blend of shapes: what its strain does to the skin."""
        return self.posed(weights).texture

    def relief(self, weights: dict[str, float]) -> Relief:
        """The other maps, which go with :meth:`texture`."""
        return self.posed(weights).relief

    def posed(self, weights: dict[str, float]) -> "Posed":
        """A blend of shapes, for whoever asks for several of its maps."""
        return Posed(self, weights)

    @cached_property
    def ground(self) -> Ground:
        """The relief that expressions fold."""
        return Ground.of(self.head.rows, self.texels, self.seed, self.hair)


@dataclass(frozen=True, eq=False)
class Posed:
    """A person with an expression."""

    person: Person
    weights: dict[str, float]

    @cached_property
    def strain(self) -> Strain:
        """Of the skin; the same for all maps."""
        return strain(self.person.head, self.person.vertices(self.weights))

    @property
    def texture(self) -> NDArray[np.float32]:
        """See :meth:`Person.texture`."""
        person = self.person
        return wrinkled(person.albedo, person.texels, person.creases, self.strain) if self.weights else person.albedo

    @property
    def relief(self) -> Relief:
        """See :meth:`Person.relief`."""
        return relief(self.person.ground, self.person.texels, self.person.creases, self.strain)


def make_character(
    resolution: int = 512,
    expressions: int = 20,
    seed: int = 0,
    nuisances: float = 1.0,
    maps: tuple[str, ...] = (),
    tiles: tuple[int, int] = (1, 1),
) -> Character:
    """Scans of the embedded character: 8-bit textures, meshes, and the mask of the face region.

    Parameters
    ----------
    resolution : side of the square textures, 64 to 8192 texels.
    expressions : how many; the first twenty have names, further ones are seeded compounds.
    seed : which person, and which noise.
    nuisances : strength of misregistration, sensor noise and exposure drift; 0 for none, 1 for a good capture.
    maps : names out of :data:`scenes.face.capture.MAPS`, besides the albedo and misregistered as it is; none depends
        on which others there are.
    tiles : columns and rows of UDIM tiles that its chart is spread over, at most 10 columns; both divide
        ``resolution``.

    Raises
    ------
    FaceZipError
        ``BAD_VALUE`` for a size or number outside its range, or a map that the character does not have.
    """
    _check(resolution, expressions, maps, tiles)
    person, named = Person.make(resolution, seed), expression_weights(expressions, seed)
    names = (ALBEDO, *(name for name in MAPS if name in maps))
    scans = _scans(person, named, nuisances, names)
    neutral = next(scans)
    textures = {name: np.empty((len(named), *texels.shape), texels.dtype) for name, texels in neutral.items()}
    for n, scan in enumerate(track(scans, "Making the character", len(named))):
        for name, texels in scan.items():
            textures[name][n] = texels
    vertices = np.stack([person.vertices(weights) for weights in named.values()])
    meshes = Meshes(person.head.topology, person.head.vertices, vertices, centimetres=True)
    mask = face_mask(person.head, resolution)
    stacks = {(name, FIRST_TILE): Stack(neutral[name], textures[name], mask) for name in names}
    whole = Character("character", tuple(named), meshes, tuple(KNOWN[name] for name in names), stacks)
    return in_tiles(whole, *tiles)


def _check(resolution: int, expressions: int, maps: tuple[str, ...], tiles: tuple[int, int]) -> None:
    if not (64 <= resolution <= 8192 and expressions >= 2):
        reason = f"{resolution} texels and {expressions} expressions; make 64 to 8192 texels and at least 2"
        raise FaceZipError(ErrorCode.BAD_VALUE, f"the embedded character cannot have {reason}")
    for name in maps:
        if name not in MAPS:
            reason = f"has no map '{name}'; it has {', '.join((ALBEDO, *MAPS))}"
            raise FaceZipError(ErrorCode.BAD_VALUE, f"the embedded character {reason}")
    columns, rows = tiles
    if not (1 <= columns <= 10 and rows >= 1 and resolution % columns == 0 and resolution % rows == 0):
        reason = (
            f"{columns} columns and {rows} rows of tiles; make 1 to 10 columns, and both divide {resolution} texels"
        )
        raise FaceZipError(ErrorCode.BAD_VALUE, f"the embedded character cannot have {reason}")


def _scans(
    person: Person, named: dict[str, dict[str, float]], nuisances: float, names: tuple[str, ...]
) -> Iterator[dict[str, Texels]]:
    """The maps ``(R, R, C)`` of the neutral and of each expression, in the order of ``names``."""
    strengths = Nuisances().scaled(nuisances)
    for albedo, posed, rng in captures(person, named, nuisances):
        found: dict[str, Texels] = {ALBEDO: albedo}
        if names != (ALBEDO,):
            found |= captured_maps(posed.relief, strengths, rng, registered=not posed.weights)
        yield {name: found[name] for name in names}


def captures(
    person: Person, named: dict[str, dict[str, float]], nuisances: float
) -> Iterator[tuple[NDArray[np.uint8], Posed, np.random.Generator]]:
    """The albedo ``(R, R, 3)`` of the neutral and of each expression as a capture gives it.

    With each come the truth, and a generator that draws the same misregistration again, for further maps of it.
    """
    strengths = Nuisances().scaled(nuisances)
    rng = np.random.default_rng([person.seed, 3])
    for weights in ({}, *named.values()):
        again, posed = deepcopy(rng), person.posed(weights)
        yield _bytes(captured(posed.texture, strengths, rng, registered=not weights)), posed, again


def face_mask(head: Head, resolution: int) -> NDArray[np.float32]:
    """``(R, R)`` of 0 and 1: the face from the hairline to the throat, to the ears and under the angles of the jaw."""
    texels = TexelGrid.of(head, resolution)
    rows, columns = texels.row_of.round().astype(int), texels.column_of.round().astype(int)
    x, y, z = np.moveaxis(closed(head, head.vertices)[rows][:, columns], 2, 0)
    inside = (z > np.where(y < -3.5, -2.6, 0.4)) & (y > -13.8) & (y < 9.5) & (np.abs(x) < 7.4)
    return inside.astype(np.float32)


def _bytes(texture: NDArray[np.float32]) -> NDArray[np.uint8]:
    rounded: NDArray[np.uint8] = np.rint(texture * 255).astype(np.uint8)
    return rounded
