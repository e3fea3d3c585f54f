"""What commands and reports say about a pack."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from facezip.character.facts import CharacterFacts, MapName
from facezip.pack.manifest import Manifest, MasksEntry
from facezip.pack.verification import bytes_on_disk


@dataclass(frozen=True, kw_only=True)
class PackMap(MapName):
    """One map of a pack.

    Attributes
    ----------
    channels : numbers of a texel.
    range : the values that texels of 0 and 1 stand for.
    """

    channels: int
    range: tuple[float, float]


@dataclass(frozen=True, kw_only=True)
class PackTile:
    """One UDIM tile of a pack.

    Attributes
    ----------
    tile : its number.
    resolution : rows and columns of its textures, by map.
    """

    tile: int
    resolution: Mapping[str, tuple[int, int]]


@dataclass(frozen=True, kw_only=True)
class MaskFacts:
    """The masks that weight maps are made of.

    Attributes
    ----------
    names : of the masks.
    activations : whether all of them lie in 0..1.
    """

    names: Sequence[str]
    activations: Literal["0..1", "free"]


@dataclass(frozen=True, kw_only=True)
class PackFacts:
    """Sizes and make of a pack.

    The first map on the first tile stands for those that have one size.

    Attributes
    ----------
    name : of the character.
    method : that fitted it.
    resolution : rows and columns of the first map on the first tile.
    channels : of all maps together.
    differences : difference textures of a map.
    weight_scale : how many times smaller weight maps are, rounded where no fit makes them of that size; null where
        weights are uniform.
    expressions : in the order of the weight maps.
    masks : of which weight maps are made, or null.
    maps : albedo first.
    tiles : by ascending number.
    bytes_on_gpu : textures and weight maps at 8 bits a channel.
    bytes_on_disk : all files of the pack.
    bytes_raw : the textures of all expressions and the neutral at 8 bits a channel, which it stands for.
    bytes_bc7, bytes_raw_bc7 : the same two where textures lie in BC7 blocks.
    bytes_geometry : of the meshes' files.
    bits_per_texel_channel : of all expressions, at 8 bits a channel.
    fetches : of textures, a pixel.
    vertices : of the neutral's mesh; 0 where there is none.
    made_with : options and measured errors; for people.
    """

    name: str
    method: str
    resolution: tuple[int, int]
    channels: int
    differences: int
    weight_scale: int | None
    expressions: Sequence[str]
    masks: MaskFacts | None
    maps: Sequence[PackMap]
    tiles: Sequence[PackTile]
    bytes_on_gpu: int
    bytes_on_disk: int
    bytes_raw: int
    bytes_bc7: int
    bytes_raw_bc7: int
    bytes_geometry: int
    bits_per_texel_channel: float
    fetches: int
    vertices: int
    made_with: Mapping[str, Any]


def pack_facts(path: Path, manifest: Manifest) -> PackFacts:
    """Sizes and make of a verified pack, from its manifest alone."""
    first, cost = manifest.tiles[0], manifest.footprint
    size = first.textures[0].size
    return PackFacts(
        name=manifest.name,
        method=manifest.method,
        resolution=size,
        channels=sum(kind.channels for kind in manifest.maps),
        differences=cost.differences,
        weight_scale=cost.weight_scale or (round(size[0] / first.weight_size[0]) if cost.layers else None),
        expressions=manifest.expressions,
        masks=_masks(manifest.masks) if manifest.masks else None,
        maps=[
            PackMap(name=kind.name, encoding=kind.encoding, channels=kind.channels, range=kind.range)
            for kind in manifest.maps
        ],
        tiles=[
            PackTile(
                tile=tile.number,
                resolution={
                    kind.name: texture.size for kind, texture in zip(manifest.maps, tile.textures, strict=True)
                },
            )
            for tile in manifest.tiles
        ],
        bytes_on_gpu=cost.bytes_on_gpu,
        bytes_on_disk=bytes_on_disk(path),
        bytes_raw=cost.bytes_raw,
        bytes_bc7=cost.bytes_bc7,
        bytes_raw_bc7=cost.bytes_raw_bc7,
        bytes_geometry=cost.geometry,
        bits_per_texel_channel=round(cost.bits_per_value, 4),
        fetches=cost.fetches,
        vertices=manifest.geometry.vertices if manifest.geometry else 0,
        made_with=manifest.made_with,
    )


def _masks(masks: MasksEntry) -> MaskFacts:
    return MaskFacts(names=masks.names, activations="0..1" if masks.clamped else "free")


def several(facts: CharacterFacts | PackFacts) -> str:
    """:func:`maps_on_tiles` of a pack or a character."""
    return maps_on_tiles(len(facts.maps), len(facts.tiles))


def maps_on_tiles(maps: int, tiles: int) -> str:
    """``, 3 maps on 2 tiles`` where there is more than one map on one tile; else nothing."""
    return f", {maps} map{'s' * (maps > 1)} on {tiles} tile{'s' * (tiles > 1)}" if maps * tiles > 1 else ""
