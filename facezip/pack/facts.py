"""What commands and reports say about a pack."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from facezip.pack.manifest import Manifest, MasksEntry
from facezip.pack.verification import bytes_on_disk


def pack_facts(path: Path, manifest: Manifest) -> dict[str, Any]:
    """Sizes and make of a verified pack, from its manifest alone.

    The first map on the first tile stands for those that have one size; ``weight_scale`` says how many times smaller
    its weight maps are, None where weights are uniform. ``masks``, where weight maps are made of masks, names them and
    says whether all activations lie in 0..1 or are free.
    """
    first, cost = manifest.tiles[0], manifest.footprint
    size = first.textures[0].size
    return {
        "name": manifest.name,
        "method": manifest.method,
        "resolution": list(size),
        "channels": sum(kind.channels for kind in manifest.maps),
        "differences": cost.differences,
        "weight_scale": round(size[0] / first.weight_size[0]) if cost.layers else None,
        "expressions": list(manifest.expressions),
        "masks": _masks(manifest.masks) if manifest.masks else None,
        "maps": [
            {"name": kind.name, "encoding": kind.encoding, "channels": kind.channels, "range": list(kind.range)}
            for kind in manifest.maps
        ],
        "tiles": [
            {
                "tile": tile.number,
                "resolution": {
                    kind.name: list(texture.size) for kind, texture in zip(manifest.maps, tile.textures, strict=True)
                },
            }
            for tile in manifest.tiles
        ],
        "bytes_on_gpu": cost.bytes_on_gpu,
        "bytes_on_disk": bytes_on_disk(path),
        "bytes_raw": cost.bytes_raw,
        "bytes_bc7": cost.bytes_bc7,
        "bytes_raw_bc7": cost.bytes_raw_bc7,
        "bytes_geometry": cost.geometry,
        "bits_per_texel_channel": round(cost.bits_per_value, 4),
        "fetches": cost.fetches,
        "vertices": manifest.geometry.vertices if manifest.geometry else 0,
        "made_with": manifest.made_with,
    }


def _masks(masks: MasksEntry) -> dict[str, Any]:
    return {"names": list(masks.names), "activations": "0..1" if masks.clamped else "free"}


def several(facts: Mapping[str, Any]) -> str:
    """``, 3 maps on 2 tiles`` of a pack or a character that has more than one map on one tile; else nothing."""
    maps, tiles = len(facts["maps"]), len(facts["tiles"])
    return f", {maps} map{'s' * (maps > 1)} on {tiles} tile{'s' * (tiles > 1)}" if maps * tiles > 1 else ""
