"""What commands and reports say about a pack."""

from pathlib import Path
from typing import Any

from facezip.manifest import Manifest
from facezip.verification import bytes_on_disk


def pack_facts(path: Path, manifest: Manifest) -> dict[str, Any]:
    """Sizes and make of a verified pack, from its manifest alone."""
    cost = manifest.footprint
    return {
        "name": manifest.name,
        "method": manifest.method,
        "resolution": list(manifest.size),
        "channels": manifest.channels,
        "differences": cost.differences,
        "weight_scale": round(manifest.size[0] / manifest.weight_size[0]) if cost.layers else None,
        "expressions": list(manifest.expressions),
        "bytes_on_gpu": cost.bytes_on_gpu,
        "bytes_on_disk": bytes_on_disk(path),
        "bytes_raw": cost.bytes_raw,
        "fetches": cost.fetches,
        "vertices": manifest.vertices,
        "made_with": manifest.made_with,
    }
