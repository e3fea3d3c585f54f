"""Which channels of an OpenEXR file are the texture: it may have several parts and layers, and channels have names."""

from collections.abc import Sequence
from dataclasses import dataclass

# What a layer's channels are called, in the order in which they are read; alpha may follow each.
_COLOURS = (("R", "G", "B"), ("RED", "GREEN", "BLUE"))
_OTHERS = (("X", "Y", "Z"), ("R", "G"), ("X", "Y"), ("U", "V"), ("Y",))
_ALPHA = ("A", "ALPHA")
_CHROMA = ("RY", "BY")
_DEPTH = ("Z", "ZBACK")


# Of a message that lists channels.
LONGEST = 300


class LayerFault(Exception):
    """Why no channels can be chosen, in words that follow the file's name."""


@dataclass(frozen=True)
class Layer:
    """Channels that belong together.

    Attributes
    ----------
    part, name : where they are; the name is what stands before the last dot of a channel's.
    channels : their numbers in the part, in the order in which they are read, alpha last.
    has_alpha : whether the last one is alpha.
    is_colour : whether they are called red, green and blue.
    """

    part: int
    name: str
    channels: tuple[int, ...]
    has_alpha: bool
    is_colour: bool


def chosen_layer(parts: Sequence[tuple[str, Sequence[str]]]) -> Layer:
    """The one layer that is meant, of the name and the channels' names of every part.

    Red, green and blue without a layer's name are the picture by custom, whatever layers are beside them. Otherwise
    there has to be but one layer, depth aside.

    Raises
    ------
    LayerFault
        There are several; it names them.
    """
    layers = [layer for part, (_, names) in enumerate(parts) for layer in _layers(part, names)]
    plain = [layer for layer in layers if layer.is_colour and not layer.name]
    flat = [layer for layer in layers if not _is_depth(layer, parts[layer.part][1])]
    for candidates in (plain, flat, layers):
        if len(candidates) == 1:
            return candidates[0]
    known = "; ".join(f"{f'part {part}: ' if part else ''}{' '.join(names)}" for part, names in parts)
    raise LayerFault(f"several of its channels may be meant ({known[:LONGEST]})")


def _is_depth(layer: Layer, names: Sequence[str]) -> bool:
    return len(layer.channels) == 1 and names[layer.channels[0]].rpartition(".")[2].upper() in _DEPTH


def _layers(part: int, names: Sequence[str]) -> list[Layer]:
    found: dict[str, dict[str, int]] = {}
    for number, name in enumerate(names):
        layer, _, leaf = name.rpartition(".")
        found.setdefault(layer, {})[leaf.upper()] = number
    return [one for layer, channels in found.items() for one in _layers_of_name(part, layer, channels)]


def _layers_of_name(part: int, name: str, channels: dict[str, int]) -> list[Layer]:
    if any(chroma in channels for chroma in _CHROMA):
        raise LayerFault("its colours are stored as luminance and chroma")
    alpha = tuple(channels[leaf] for leaf in _ALPHA if leaf in channels)[:1]
    for leaves in (*_COLOURS, *_OTHERS):
        if all(leaf in channels for leaf in leaves):
            numbers = tuple(channels[leaf] for leaf in leaves)
            return [Layer(part, name, numbers + alpha, bool(alpha), leaves in _COLOURS)]
    # Each is a map of its own, of one number a texel, which no alpha was multiplied into.
    alone = [number for number in channels.values() if number not in alpha] or alpha
    return [Layer(part, name, (number,), False, False) for number in alone]
