"""The shader functions of a pack, generated from one template in the words of each shading language."""

import re
from collections.abc import Callable, Iterable
from functools import cache

import jinja2

from facezip.character.maps import MAX_SLOPE, Map
from facezip.character.units import size_words
from facezip.export.sheets import Sheet
from facezip.export.source import Source, Tile
from facezip.export.words import Dialect, MapWords, Numbers, SheetWords, Words
from facezip.pack.footprint import SLOTS_PER_LAYER
from facezip.pack.quantise import ZERO

SLOTS_PER_TARGET = 3


GLSL = Dialect("glsl", "vec", "ivec", "sampler2D", "", "texture({texture}, {uv})", "texelFetch({texture}, {texel}, 0)")
HLSL = Dialect(
    "hlsl",
    "float",
    "int",
    "Texture2D",
    "SamplerState",
    "{texture}.Sample(clamped, {uv})",
    "{texture}.Load(int3({texel}, 0))",
)


def shader(tile: Tile, dialect: Dialect) -> str:
    """Text of the functions ``facezip_weights_K`` (pre-pass) and ``facezip_surface`` (main pass), and theirs."""
    return render("blend.j2", **shader_words(tile, dialect))


def identifier(name: str) -> str:
    """The end of a name as every language takes it, after a letter: letters of the alphabet, digits, underscores."""
    return re.sub(r"[^A-Za-z0-9]+", "_", name).strip("_") or "face"


def shader_words(tile: Tile, dialect: Dialect) -> dict[str, object]:
    """What the templates say of a tile in a dialect: the :class:`facezip.export.words.Words` by name."""
    layout, count = tile.layout, len(tile.expressions)
    slots, fours = len(layout.weight_span), tile.masks.fours if tile.masks else 0
    height, width = layout.weight_size
    words = Words(
        dialect=dialect,
        beta=dialect.beta or "beta",
        region_gains=dialect.region_gains or "region_gains",
        activations=dialect.activations or "activations",
        float2=f"{dialect.vector}2",
        float3=f"{dialect.vector}3",
        float4=f"{dialect.vector}4",
        int2=f"{dialect.integers}2",
        load=_expression(dialect.load),
        sample=_expression(dialect.sample),
        vector=_vector(dialect.vector),
        identifier=identifier(tile.name),
        zero=number(ZERO / 255),
        count=count,
        fours=fours,
        vectors=tile.masks.count if tile.masks else 0,
        columns=layout.weight_columns,
        rows=-(-(fours or count) // layout.weight_columns),
        width=width,
        height=height,
        slots=slots,
        layers=range(-(-slots // SLOTS_PER_LAYER)),
        targets=target_numbers(tile),
        weight_scale=_layered(layout.weight_span),
        weight_offset=_layered(layout.weight_offset),
        uniform=[_layered(row) for row in tile.uniform_weights],
        sheets=[_sheet(sheet, dialect) for sheet in tile.sheets],
        textures=[texture for sheet in tile.sheets for texture in sheet.textures],
        maps=[_map(tile, kind, dialect) for kind in tile.maps],
        known=tile.known,
        regions=len(tile.regions.names),
        region_columns=tile.regions.columns,
        region_rows=tile.regions.rows,
        camel=camel,
    )
    return {**vars(words)}


def head_words(source: Source, dialect: Dialect) -> dict[str, object]:
    """What the templates say of a head: the words of its first tile, as ``tiles`` the numbers of all, and its size."""
    said = size_words(source.geometry, "m") or ["by its size, its numbers are metres"]
    return shader_words(source.tiles[0], dialect) | {
        "tiles": [tile.layout.number for tile in source.tiles],
        "size": " ".join(f"{words[0].upper()}{words[1:]}." for words in said) if source.geometry else "",
    }


def target_numbers(tile: Tile) -> range:
    """The render targets of the pre-pass in engines that keep three numbers of a target's texel only."""
    return range(-(-len(tile.layout.weight_span) // SLOTS_PER_TARGET))


def camel(name: str) -> str:
    """``difference_0`` as ``Difference0``."""
    return name.title().replace("_", "")


def render(template: str, **words: object) -> str:
    """Text of one of the templates of this folder."""
    return _environment().get_template(template).render(words)


def number(value: float) -> str:
    """A literal that every shading language reads as a float."""
    text = f"{value:.9g}"
    return text if "." in text or "e" in text else f"{text}.0"


@cache
def _environment() -> jinja2.Environment:
    return jinja2.Environment(
        loader=jinja2.PackageLoader("facezip.export"),
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        # Shader text, not markup; names of people never get into it.
        autoescape=False,
    )


def _expression(pattern: str) -> Callable[[str, str], str]:
    return lambda texture, place: pattern.format(texture=texture, uv=place, texel=place)


def _vector(prefix: str) -> Callable[[Iterable[float]], str]:
    def vector(values: Iterable[float]) -> str:
        words = [number(value) for value in values]
        return words[0] if len(words) == 1 else f"{prefix}{len(words)}({', '.join(words)})"

    return vector


def _sheet(sheet: Sheet, dialect: Dialect) -> SheetWords:
    kinds = [kind for kind, at in sheet.maps for _ in range(at.start, at.stop)]
    # Colours are three numbers, also where a texture holds one.
    grey = sheet.is_colour and len(kinds) == 1
    times = 3 if grey else 1
    neutral = [(2.0, -1.0) if kind.is_normal else (kind.unit, kind.low) for kind in kinds * times]
    limits = [(-MAX_SLOPE, MAX_SLOPE) if kind.is_normal else (kind.low, kind.high) for kind in kinds * times]
    return SheetWords(
        function=f"facezip_sheet_{sheet.name}" if sheet.name else "facezip_encoded",
        names=[kind.name for kind, _ in sheet.maps],
        textures=sheet.textures,
        type=_type(dialect, len(kinds) * times),
        channels="rrr" if grey else "rgb"[: len(kinds)],
        gain=None if {*neutral} == {(1.0, 0.0)} else [gain for gain, _ in neutral],
        bias=[bias for _, bias in neutral],
        slopes=next(("xyz"[at] for kind, at in sheet.maps if kind.is_normal), None),
        scales=[row * times for row in sheet.span_of_values],
        low=[low for low, _ in limits],
        high=[high for _, high in limits],
        change_gain=_change_gain(sheet, dialect),
    )


def _change_gain(sheet: Sheet, dialect: Dialect) -> str:
    if len(sheet.maps) == 1:
        return f"gain_{sheet.maps[0][0].name}"
    gains = [f"gain_{kind.name}" for kind, at in sheet.maps for _ in range(at.start, at.stop)]
    return f"{dialect.vector}{len(gains)}({', '.join(gains)})"


def _map(tile: Tile, kind: Map, dialect: Dialect) -> MapWords:
    sheet, at = tile.sheet_of(kind.name)
    return MapWords(
        name=kind.name,
        encoding=kind.encoding,
        type=_type(dialect, at.stop - at.start if kind.encoding == "data" else 3),
        sheet=tile.sheets.index(sheet),
        part="" if len(sheet.maps) == 1 else f".{'xyz'[at]}",
    )


def _type(dialect: Dialect, numbers: int) -> str:
    return "float" if numbers == 1 else f"{dialect.vector}{numbers}"


def _layered(values: Numbers) -> list[Numbers]:
    """Values of slots in fours, filled up with zeros."""
    padded = (*values, *[0.0] * (-len(values) % SLOTS_PER_LAYER))
    return [padded[start : start + SLOTS_PER_LAYER] for start in range(0, len(padded), SLOTS_PER_LAYER)]
