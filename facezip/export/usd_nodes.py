"""The nodes of a blend as templates of USD and of MaterialX say them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from facezip.export.network import Node, Value, blend_network, weights_file
from facezip.export.shaders import number
from facezip.export.source import Tile
from facezip.pack.footprint import SLOTS_PER_LAYER

USD_TYPES = {"vector2": "float2", "vector3": "float3", "vector4": "float4", "color3": "color3f", "filename": "asset"}
USD_TYPES |= {"integer": "int", "surfaceshader": "token"}


@dataclass(frozen=True)
class InputWords:
    """An input of a node, as templates say it.

    Attributes
    ----------
    name : of it.
    type, usd_type : in MaterialX and in USD.
    node, text : the node that it takes from, or else its value.
    frames : of a texture of weights, its files of all frames.
    """

    name: str
    type: str
    usd_type: str
    node: str
    text: str
    frames: Sequence[str]


@dataclass(frozen=True)
class NodeWords:
    """A node of the blend, as templates say it: what :class:`facezip.export.network.Node` has, and its type in USD."""

    name: str
    category: str
    definition: str
    type: str
    usd_type: str
    inputs: Sequence[InputWords]


@dataclass(frozen=True)
class MaterialWords:
    """A tile's material, as templates say it.

    Attributes
    ----------
    number : of the tile.
    place : the folder of its files, a slash at its end; empty where that is the export's.
    nodes : of its blend.
    roughness : the texture that has its neutral, and the channel; None where there is none.
    """

    number: int
    place: str
    nodes: Sequence[NodeWords]
    roughness: tuple[str, str] | None


def material_words(tile: Tile, apart: bool, frames: int) -> MaterialWords:
    """The material of a tile, whose files lie in a folder of its own where they are ``apart``."""
    grey, at = tile.sheet_of("roughness") if "roughness" in tile.known else (None, slice(0))
    return MaterialWords(
        number=tile.layout.number,
        place=f"{tile.layout.number}/" if apart else "",
        nodes=node_words(tile, frames),
        roughness=None if grey is None else (grey.textures[0], "rgb"[at.start]),
    )


def node_words(tile: Tile, frames: int) -> list[NodeWords]:
    """The nodes of the blend, whose weights have a file for each of so many frames."""
    found, layers = [], range(-(-len(tile.layout.weight_span) // SLOTS_PER_LAYER))
    files = {weights_file(layer, 0): [weights_file(layer, n) for n in range(frames)] for layer in layers}
    for node in blend_network(tile).nodes.values():
        inputs = [_said(name, value, files) for name, value in node.inputs.items()]
        usd_type = USD_TYPES.get(node.type, node.type)
        found.append(NodeWords(node.name, node.category, node.definition, node.type, usd_type, inputs))
    return found


def _said(name: str, value: Value, frames: Mapping[str, Sequence[str]]) -> InputWords:
    if isinstance(value, Node):
        kind, text = value.type, ""
    elif isinstance(value, tuple):
        kind, text = f"vector{len(value)}", ", ".join(map(number, value))
    elif isinstance(value, float):
        kind, text = "float", number(value)
    elif isinstance(value, int):
        kind, text = "integer", str(value)
    else:
        kind, text = "string" if isinstance(value, str) else "filename", str(value)
    node = value.name if isinstance(value, Node) else ""
    return InputWords(name, kind, USD_TYPES.get(kind, kind), node, text, frames.get(text, ()))
