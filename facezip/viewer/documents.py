"""The document that the viewer's page draws; ``web/src/published.ts`` has its types in TypeScript."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from facezip.documents.document import Document
from facezip.pack.facts import PackMap


@dataclass(frozen=True, kw_only=True)
class SceneMap(PackMap):
    """One map, as the page draws it.

    Attributes
    ----------
    image_channels : of its images: 3 for normals; two channels may come as grey with alpha.
    error : to the originals, where those are there: degrees of normals, else parts of 255.
    """

    image_channels: int
    error: float | None


@dataclass(frozen=True, kw_only=True)
class SceneTexture:
    """One map on one tile.

    Attributes
    ----------
    size : rows and columns of neutral and differences.
    neutral_bits : of a channel of the neutral, 8 or 16.
    difference_span : D = (t − zero) · span: of texels, or of slopes for normals.
    """

    size: tuple[int, int]
    neutral_bits: int
    difference_span: Sequence[tuple[float, float, float]]


@dataclass(frozen=True, kw_only=True)
class SceneTile:
    """One UDIM tile.

    Attributes
    ----------
    number : of the tile.
    place : its column and row.
    weight_size : rows and columns of one weight map.
    weight_span, weight_offset : a weight is t · span + offset; one of each a slot.
    textures : one a map.
    """

    number: int
    place: tuple[int, int]
    weight_size: tuple[int, int]
    weight_span: Sequence[float]
    weight_offset: Sequence[float]
    textures: Sequence[SceneTexture]


@dataclass(frozen=True, kw_only=True)
class ScenePose:
    """A named blend.

    Attributes
    ----------
    name : of the pose.
    weights : places of expressions, and their weights.
    """

    name: str
    weights: Sequence[tuple[int, float]]


@dataclass(frozen=True, kw_only=True)
class SceneCosts:
    """Bytes and fetches, as of :class:`facezip.pack.facts.PackFacts`."""

    bytes_on_gpu: int
    bytes_raw: int
    bytes_on_disk: int
    fetches: int


@dataclass(frozen=True, kw_only=True)
class SceneMesh:
    """How many vertices and triangles the head has."""

    vertices: int
    triangles: int


@dataclass(frozen=True, kw_only=True)
class SceneDocument(Document):
    """What the viewer's page draws.

    Attributes
    ----------
    name, method, expressions : of the pack.
    poses : that it offers.
    maps, tiles : albedo first, numbers ascending.
    slots : difference textures of a map.
    difference_zero : the texel that stands for no difference.
    max_slope : slopes of normals are clipped to this, either way.
    uniform : whether every weight map is one texel of floats.
    weight_range : the largest absolute weight.
    fours : images that hold the masks which weight maps are sums of, by four; left out where weight maps are stored.
    costs : at run time.
    mesh : null where the pack has none.
    originals : whether the original textures are there.
    """

    format: Literal["facezip-scene/1"] = "facezip-scene/1"
    name: str
    method: str
    expressions: Sequence[str]
    poses: Sequence[ScenePose]
    maps: Sequence[SceneMap]
    tiles: Sequence[SceneTile]
    slots: int
    difference_zero: float
    max_slope: float
    uniform: bool
    weight_range: float
    fours: int | None = None
    costs: SceneCosts
    mesh: SceneMesh | None
    originals: bool
