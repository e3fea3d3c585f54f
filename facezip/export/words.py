"""What the templates of shaders and scripts say: their words, by the names that they have there."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass

Numbers = tuple[float, ...]


@dataclass(frozen=True)
class Dialect:
    """A shading language, and how an engine keeps its textures.

    Attributes
    ----------
    name : the suffix of files.
    vector, integers : prefixes of the types of vectors.
    texture : the type of a texture parameter.
    sampler : the type of a parameter that says how textures are sampled; empty where textures know.
    sample : an expression that samples a texture, with ``{texture}`` and ``{uv}``.
    load : an expression that reads a texel, with ``{texture}`` and ``{texel}``.
    beta, region_gains, activations : what the weights β, the gains of regions, and the activations of masks in a blend
        are called; global, or parameters where empty.
    rows_from_below : whether the first row of a texture in memory is the lowest of the image.
    encoded_if : what is defined where a project takes colours as they are encoded; empty where none does.
    """

    name: str
    vector: str
    integers: str
    texture: str
    sampler: str
    sample: str
    load: str
    beta: str = ""
    region_gains: str = ""
    activations: str = ""
    rows_from_below: bool = False
    encoded_if: str = ""


@dataclass(frozen=True)
class SheetWords:
    """What the function of a sheet says.

    Attributes
    ----------
    function : its name.
    names : of its maps.
    textures : neutral and difference textures.
    type : of its value.
    channels : of a texel, as a swizzle.
    gain, bias : per channel, from a neutral's texel to its value; None for the texel itself.
    slopes : which channels are a normal's, as a swizzle; None without.
    scales : of each slot's difference, per channel.
    low, high : the limits of the value, per channel.
    change_gain : text of what its change is multiplied by: the gains of its maps.
    """

    function: str
    names: list[str]
    textures: list[str]
    type: str
    channels: str
    gain: list[float] | None
    bias: list[float]
    slopes: str | None
    scales: list[Numbers]
    low: list[float]
    high: list[float]
    change_gain: str


@dataclass(frozen=True)
class MapWords:
    """What ``facezip_surface`` gives of a map.

    Attributes
    ----------
    name, encoding : of the map.
    type : of what is given.
    sheet : the number of its sheet.
    part : a swizzle of the sheet's value, empty for all of it.
    """

    name: str
    encoding: str
    type: str
    sheet: int
    part: str


@dataclass(frozen=True)
class Words:
    """What is said of a tile in a dialect.

    Attributes
    ----------
    dialect : the shading language.
    beta, region_gains, activations : what the weights β and the like are called there.
    float2, float3, float4, int2 : types.
    load, sample : text that reads a texel, or samples, of a texture and a place.
    vector : text of a vector of numbers.
    identifier : the tile's name, as every language takes it.
    zero : the texel of a difference of zero.
    count : of expressions.
    fours, vectors : how many places of the atlas masks take, and vectors of four activations a blend has; 0 without.
    columns, rows, width, height : of the atlas in weight maps or fours of masks, and of one of these in texels.
    slots, layers, targets : how many difference textures a map has, layers of four slots, targets of three.
    weight_scale, weight_offset : of each layer.
    uniform : of each expression the weights of each layer, where those are uniform; else empty.
    sheets, textures, maps : what there is to sample, and what it gives.
    known : the maps that materials everywhere have a place for.
    regions, region_columns, region_rows : how many regions there are, and how their masks lie.
    camel : ``difference_0`` to ``Difference0``.
    """

    dialect: Dialect
    beta: str
    region_gains: str
    activations: str
    float2: str
    float3: str
    float4: str
    int2: str
    load: Callable[[str, str], str]
    sample: Callable[[str, str], str]
    vector: Callable[[Iterable[float]], str]
    identifier: str
    zero: str
    count: int
    fours: int
    vectors: int
    columns: int
    rows: int
    width: int
    height: int
    slots: int
    layers: range
    targets: range
    weight_scale: list[Numbers]
    weight_offset: list[Numbers]
    uniform: list[list[Numbers]]
    sheets: list[SheetWords]
    textures: list[str]
    maps: list[MapWords]
    known: list[str]
    regions: int
    region_columns: int
    region_rows: int
    camel: Callable[[str], str]
