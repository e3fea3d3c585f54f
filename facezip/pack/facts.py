"""What commands and reports say about a pack."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from facezip.commands.options import megabytes
from facezip.pack.manifest import Manifest
from facezip.pack.surface_manifest import AnyManifest, SurfaceManifest
from facezip.pack.verification import bytes_on_disk


def pack_facts(path: Path, manifest: AnyManifest) -> dict[str, Any]:
    """Sizes and make of a verified pack, from its manifest alone; of several maps or tiles, ``maps`` and ``tiles``."""
    sizes = _of_one(manifest) if isinstance(manifest, Manifest) else _of_several(manifest)
    cost = manifest.footprint
    return {
        "name": manifest.name,
        "method": manifest.method,
        **sizes,
        "expressions": list(manifest.expressions),
        "bytes_on_gpu": cost.bytes_on_gpu,
        "bytes_on_disk": bytes_on_disk(path),
        "bytes_raw": cost.bytes_raw,
        "bytes_bc7": cost.bytes_bc7,
        "bytes_raw_bc7": cost.bytes_raw_bc7,
        "fetches": cost.fetches,
        "vertices": manifest.vertices,
        "made_with": manifest.made_with,
    }


def memory_words(facts: Mapping[str, Any]) -> tuple[str, str]:
    """GPU memory and fetches in the blocks that engines hold, and memory as the paper counts it."""
    (blocks, raw_blocks), (eight, raw) = (
        (megabytes(facts[ours]), f"{megabytes(facts[theirs])} ({facts[theirs] / facts[ours]:.1f}x less)")
        for ours, theirs in (("bytes_bc7", "bytes_raw_bc7"), ("bytes_on_gpu", "bytes_raw"))
    )
    return (
        f"{blocks} instead of {raw_blocks} in BC7, {facts['fetches']} fetches a pixel",
        f"{eight} instead of {raw} at 8 bits a channel",
    )


def _of_one(manifest: Manifest) -> dict[str, Any]:
    cost = manifest.footprint
    return {
        "resolution": list(manifest.size),
        "channels": manifest.channels,
        "differences": cost.differences,
        "weight_scale": round(manifest.size[0] / manifest.weight_size[0]) if cost.layers else None,
    }


def _of_several(manifest: SurfaceManifest) -> dict[str, Any]:
    """The first map on the first tile stands for those that have one size."""
    tile = manifest.tiles[0]
    size, uniform = tile.textures[0].size, tile.weight_size == (1, 1)
    return {
        "resolution": list(size),
        "channels": sum(kind.channels for kind in manifest.maps),
        "maps": [
            {"name": kind.name, "encoding": kind.encoding, "channels": kind.channels, "range": list(kind.range)}
            for kind in manifest.maps
        ],
        "tiles": [
            {
                "tile": one.number,
                "resolution": {
                    kind.name: list(texture.size) for kind, texture in zip(manifest.maps, one.textures, strict=True)
                },
            }
            for one in manifest.tiles
        ],
        "differences": len(tile.weight_scale),
        "weight_scale": None if uniform else round(size[0] / tile.weight_size[0]),
    }
