"""The blend as a network of MaterialX nodes: textures of blended weights in, all maps and a skin out."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import PurePosixPath
from typing import cast

from facezip.character.maps import LEAST_DIVISOR, Map
from facezip.export.shaders import GLSL, shader_words
from facezip.export.sheets import Sheet
from facezip.export.source import Tile
from facezip.export.words import SheetWords
from facezip.pack.footprint import SLOTS_PER_LAYER
from facezip.pack.quantise import ZERO

# Of skin without maps of them, and the share of what a cavity takes from the highlight that diffuse light loses too.
ROUGHNESS, SPECULAR, DIFFUSE_CAVITY = 0.48, 0.42, 0.3


@dataclass(frozen=True, eq=False)
class Node:
    """A node of MaterialX's libraries.

    Attributes
    ----------
    name, category : of it, and of its kind.
    definition : the name of its node definition.
    type : of its output.
    inputs : by name another node, or a value.
    """

    name: str
    category: str
    definition: str
    type: str
    inputs: "Mapping[str, Value]"


# Numbers, a text, or the path of a texture.
Value = Node | float | int | tuple[float, ...] | str | PurePosixPath


@dataclass(eq=False)
class Network:
    """Nodes in an order in which each comes after those that it takes from.

    Attributes
    ----------
    nodes : by name.
    maps : what a map gives, by its name: linear colours, normals as normal maps have them, values.
    """

    nodes: dict[str, Node] = field(default_factory=dict)
    maps: dict[str, Node] = field(default_factory=dict)

    def add(self, category: str, kind: str, output: str, inputs: "Mapping[str, Value]", name: str = "") -> Node:
        """A node ``ND_category_kind`` with an output of a type, named by its number unless it has a name."""
        node = Node(name or f"{category}_{len(self.nodes)}", category, f"ND_{category}_{kind}", output, inputs)
        self.nodes[node.name] = node
        return node

    def two(self, category: str, first: Node, second: Value) -> Node:
        """An operation on a number or vector and another; or on a vector and one number, which counts for all."""
        one = second.type == "float" if isinstance(second, Node) else not isinstance(second, tuple)
        kind = f"{first.type}FA" if one and first.type != "float" else first.type
        return self.add(category, kind, first.type, {"in1": first, "in2": second})

    def part(self, vector: Node, index: int) -> Node:
        """One number of a vector; a number has but one."""
        if vector.type == "float":
            return vector
        return self.add("extract", vector.type, "float", {"in": vector, "index": index})

    def joined(self, numbers: Sequence[Value]) -> Node:
        """Up to three numbers as a vector of three; further ones are the last."""
        last = numbers[-1]
        padded = [*numbers, last, last][:3]
        return self.add("combine3", "vector3", "vector3", {f"in{k}": value for k, value in enumerate(padded, 1)})

    def texture(self, name: str, file: str, output: str) -> Node:
        """A texture as plain numbers, bilinear and clamped."""
        place: dict[str, Value] = {"file": PurePosixPath(file), "texcoord": self.nodes["uv"]}
        sampled = {"filtertype": "linear", "uaddressmode": "clamp", "vaddressmode": "clamp"}
        return self.add("image", output, output, {**place, **sampled}, name)


def blend_network(tile: Tile) -> Network:
    """The network of a tile, whose textures lie in one folder; the gain of each map is a node ``gain_MAP``."""
    network, words = Network(), shader_words(tile, GLSL)
    network.add("texcoord", "vector2", "vector2", {}, "uv")
    layers = [network.texture(f"weights_{k}", weights_file(k, 0), "vector4") for k in cast(range, words["layers"])]
    slots = range(len(tile.layout.weight_span))
    weights = [network.part(layers[slot // SLOTS_PER_LAYER], slot % SLOTS_PER_LAYER) for slot in slots]
    for kind in tile.maps:
        network.add("constant", "float", "float", {"value": 1.0}, f"gain_{kind.name}")
    for sheet, said in zip(tile.sheets, cast(list[SheetWords], words["sheets"]), strict=True):
        value = _values(network, sheet, said, weights)
        network.maps |= {kind.name: _map(network, kind, at, value) for kind, at in sheet.maps}
    _skin(network, {name: network.maps[name] for name in tile.known})
    return network


def weights_file(layer: int, frame: int) -> str:
    """The file of the blended weights of a frame."""
    return f"weights_{layer}.{frame:04d}.exr"


def _values(network: Network, sheet: Sheet, said: SheetWords, weights: Sequence[Node]) -> Node:
    """The values of a sheet's maps side by side, of normals their slopes: what the shaders' function of it gives."""
    wide = len(said.low) > 1
    stored = "float" if sheet.channels == 1 else "vector3"
    textures = [network.texture(name, f"{name}.png", stored) for name in sheet.textures]
    if wide and stored == "float":
        textures = [network.add("convert", "float_vector3", "vector3", {"in": texture}) for texture in textures]
    value = textures[0]
    if said.gain:
        value = network.two("multiply", value, _numbers(said.gain))
        value = network.two("add", value, _numbers(said.bias))
    if said.slopes:
        value = _slopes(network, value, ["xyz".index(axis) for axis in said.slopes])
    steps = []
    for texture, weight, scale in zip(textures[1:], weights, said.scales, strict=True):
        step = network.two("subtract", texture, ZERO / 255)
        step = network.two("multiply", step, _numbers(scale))
        steps.append(network.two("multiply", step, weight))
    change = steps[0]
    for step in steps[1:]:
        change = network.two("add", change, step)
    value = network.two("add", value, network.two("multiply", change, _gain(network, sheet)))
    limited = {"in": value, "low": _numbers(said.low), "high": _numbers(said.high)}
    return network.add("clamp", value.type, value.type, limited)


def _numbers(values: Sequence[float]) -> Value:
    """One number, or three: those that a texture has beyond its maps do not count."""
    return float(values[0]) if len(values) == 1 else (*map(float, values), 0.0)[:3]


def _gain(network: Network, sheet: Sheet) -> Node:
    gains = [network.nodes[f"gain_{kind.name}"] for kind, at in sheet.maps for _ in range(at.start, at.stop)]
    return gains[0] if len(sheet.maps) == 1 else network.joined(gains)


def _slopes(network: Network, value: Node, channels: Sequence[int]) -> Node:
    """x/z and y/z of a normal in two of three numbers."""
    parts = [network.part(value, k) for k in range(3)]
    squares = [network.two("multiply", parts[k], parts[k]) for k in channels]
    rest = network.two("add", network.two("multiply", network.two("add", *squares), -1.0), 1.0)
    z = network.add("sqrt", "float", "float", {"in": network.two("max", rest, 0.0)})
    for k in channels:
        parts[k] = network.two("divide", parts[k], network.two("max", z, LEAST_DIVISOR))
    return network.joined(parts)


def _map(network: Network, kind: Map, at: slice, value: Node) -> Node:
    if kind.encoding == "srgb":
        colour = network.add("convert", "vector3_color3", "color3", {"in": value})
        return network.add("srgb_texture_to_lin_rec709", "color3", "color3", {"in": colour})
    numbers = [network.part(value, k) for k in range(at.start, at.stop)]
    if kind.is_normal:
        normal = network.add("normalize", "vector3", "vector3", {"in": network.joined([*numbers, 1.0])})
        return network.two("add", network.two("multiply", normal, 0.5), 0.5)
    return numbers[0] if len(numbers) == 1 else network.joined(numbers)


def _skin(network: Network, maps: dict[str, Node]) -> None:
    """A standard surface of those maps that it has a place for."""
    colour = maps["albedo"]
    inputs: dict[str, Value] = {"base": 1.0, "specular": 1.0, "specular_roughness": maps.get("roughness", ROUGHNESS)}
    if "cavity" in maps:
        inputs["specular"] = maps["cavity"]
        shade = network.two("multiply", maps["cavity"], DIFFUSE_CAVITY)
        colour = network.two("multiply", colour, network.two("add", shade, 1 - DIFFUSE_CAVITY))
    inputs["base_color"] = colour
    # F₀ = ((η - 1) / (η + 1))² = 0.08 · specular.
    inputs["specular_IOR"] = 2 / (1 - (0.08 * SPECULAR) ** 0.5) - 1
    if "specular" in maps:
        root = network.add("sqrt", "float", "float", {"in": network.two("multiply", maps["specular"], 0.08)})
        rest = network.two("add", network.two("multiply", root, -1.0), 1.0)
        eta = network.add("divide", "float", "float", {"in1": 2.0, "in2": rest})
        inputs["specular_IOR"] = network.two("subtract", eta, 1.0)
    if "normal" in maps:
        inputs["normal"] = network.add("normalmap", "float", "vector3", {"in": maps["normal"]})
    network.add("standard_surface", "surfaceshader", "surfaceshader", inputs, "skin")
