"""Version 1 of the pack: one albedo on one tile, in files without the names of map and tile."""

from facezip.pack.footprint import SLOTS_PER_LAYER
from facezip.pack.manifest import Fields
from facezip.pack.version_2 import COMMON, geometry_of, of_fields

FORMAT = "facezip-pack/1"

_FIELDS = {"size", "channels", "neutral_bits", "encoding", "difference_scale", "weight_size", "weight_columns"}
_FIELDS |= {"weight_scale", "weight_offset"}


def as_version_3(document: Fields) -> Fields:
    """The document of a manifest, as version 3 states the same; KeyError, TypeError or ValueError for any other."""
    old = of_fields(document, COMMON | _FIELDS)
    if old.pop("encoding") != "srgb":
        raise ValueError("its encoding is not srgb")
    spans = old.pop("difference_scale")
    texture = {
        "size": old.pop("size"),
        "neutral": "neutral.png",
        "differences": tuple(f"difference_{i}.png" for i in range(len(spans))),
        "neutral_bits": old.pop("neutral_bits"),
        "difference_span": spans,
    }
    layers = 0 if old["uniform_weights"] else -(-len(spans) // SLOTS_PER_LAYER)
    tile = {
        "number": 1001,
        "weight_size": old.pop("weight_size"),
        "weight_columns": old.pop("weight_columns"),
        "weight_span": old.pop("weight_scale"),
        "weight_offset": old.pop("weight_offset"),
        "weights": tuple(f"weights_{layer}.png" if layer else "weights.png" for layer in range(layers)),
        "textures": (texture,),
    }
    albedo = {"name": "albedo", "encoding": "srgb", "range": (0.0, 1.0), "channels": old.pop("channels")}
    return {**geometry_of(old), "maps": (albedo,), "tiles": (tile,)}
