"""The shader functions of a pack, generated from one template in the words of each shading language."""

import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cache

import jinja2

from facezip.footprint import SLOTS_PER_LAYER
from facezip.manifest import Manifest
from facezip.quantise import ZERO

SLOTS_PER_TARGET = 3


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
    beta : what the weights β are called; global, or a parameter where empty.
    rows_from_below : whether the first row of a texture in memory is the lowest of the image.
    """

    name: str
    vector: str
    integers: str
    texture: str
    sampler: str
    sample: str
    load: str
    beta: str = ""
    rows_from_below: bool = False


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


def shader(manifest: Manifest, dialect: Dialect) -> str:
    """Text of the functions ``facezip_weights_K`` (pre-pass) and ``facezip_encoded``, ``facezip_color`` (main pass)."""
    return render("blend.j2", **shader_words(manifest, dialect))


def identifier(name: str) -> str:
    """A name that every language takes for one: letters of the alphabet, digits and underscores."""
    return re.sub(r"[^A-Za-z0-9]+", "_", name).strip("_") or "face"


def shader_words(manifest: Manifest, dialect: Dialect) -> dict[str, object]:
    """What the templates say of a pack in a dialect."""
    slots = len(manifest.difference_scale)
    height, width = manifest.weight_size
    columns, count = manifest.weight_columns, len(manifest.expressions)
    return {
        "dialect": dialect,
        "beta": dialect.beta or "beta",
        "float2": f"{dialect.vector}2",
        "float3": f"{dialect.vector}3",
        "float4": f"{dialect.vector}4",
        "int2": f"{dialect.integers}2",
        "load": _expression(dialect.load),
        "sample": _expression(dialect.sample),
        "vector": _vector(dialect.vector),
        "identifier": identifier(str(manifest.name)),
        "size": manifest.size,
        "zero": number(ZERO / 255),
        "count": count,
        "columns": columns,
        "rows": -(-count // columns),
        "width": width,
        "height": height,
        "slots": slots,
        "layers": range(-(-slots // SLOTS_PER_LAYER)),
        "targets": target_numbers(manifest),
        "scales": [_three(row) for row in manifest.difference_scale],
        "weight_scale": _layered(manifest.weight_scale),
        "weight_offset": _layered(manifest.weight_offset),
        "uniform": [_layered(row) for row in manifest.uniform_weights],
        "grey": manifest.channels == 1,
    }


def target_numbers(manifest: Manifest) -> range:
    """The render targets of the pre-pass in engines that keep three numbers of a target's texel only."""
    return range(-(-len(manifest.difference_scale) // SLOTS_PER_TARGET))


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
        return f"{prefix}{len(words)}({', '.join(words)})"

    return vector


def _three(row: tuple[float, ...]) -> tuple[float, ...]:
    return row * 3 if len(row) == 1 else row


def _layered(values: tuple[float, ...]) -> list[tuple[float, ...]]:
    """Values of slots in fours, filled up with zeros."""
    padded = (*values, *[0.0] * (-len(values) % SLOTS_PER_LAYER))
    return [padded[start : start + SLOTS_PER_LAYER] for start in range(0, len(padded), SLOTS_PER_LAYER)]
