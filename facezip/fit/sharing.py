"""What sharing weight maps saves and costs: all maps in one fit, beside one fit for each."""

from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import Any

from facezip.character.surface import Surface
from facezip.fit.joint import compress_surface
from facezip.machine.progress import track
from facezip.pack.errors import surface_errors
from facezip.pack.surface_model import CompressedSurface
from facezip.pack.version_2 import read_surface, write_surface

SHARED, SEPARATE, FINER, MORE = "shared", "one fit per map", "shared, weights at 1/4", "shared, 5 differences"
# Channels that one fetch gives, in the textures that are exported.
PACKED = 3


def compare_sharing(surface: Surface) -> list[dict[str, Any]]:
    """Fits of a surface with shared and with separate weight maps, each written as a pack and read back.

    Returns
    -------
    For each way: ``way``; ``bytes_on_gpu`` (8 bits a channel); ``fetches`` a pixel, a texture for each map;
    ``fetches_packed``, where the channels of maps lie side by side in textures of three; ``seconds`` of the fit; and
    ``errors`` by map (:func:`facezip.pack.errors.surface_errors`).
    """
    alone = [surface.only(kind.name) for kind in surface.maps]
    ways: dict[str, tuple[list[Surface], dict[str, Any]]] = {
        SHARED: ([surface], {}),
        SEPARATE: (alone, {}),
        FINER: ([surface], {"weight_scale": 4}),
        MORE: ([surface], {"differences": 5}),
        "shared, PCA(4)": ([surface], {"method": "pca"}),
        "one PCA(4) per map": (alone, {"method": "pca"}),
    }
    return [_row(way, *ways[way]) for way in track(ways, "Comparing", len(ways))]


def _row(way: str, surfaces: Sequence[Surface], settings: dict[str, Any]) -> dict[str, Any]:
    begin = perf_counter()
    models = [compress_surface(surface, **settings) for surface in surfaces]
    seconds = perf_counter() - begin
    errors: dict[str, Any] = {}
    for surface, model in zip(surfaces, models, strict=True):
        with TemporaryDirectory(prefix="facezip-bench-") as place:
            pack = Path(place) / "bench.facezip"
            write_surface(model, pack, neutral_bits=surface.neutral_bits)
            errors |= surface_errors(surface, read_surface(pack))
    costs = [model.footprint for model in models]
    return {
        "way": way,
        "bytes_on_gpu": sum(cost.bytes_on_gpu for cost in costs),
        "bytes_raw": sum(cost.bytes_raw for cost in costs),
        "fetches": sum(cost.fetches for cost in costs),
        "fetches_packed": _packed(models),
        "seconds": round(seconds, 2),
        "errors": errors,
    }


def _packed(models: Sequence[CompressedSurface]) -> int:
    """Fetches where three channels of any maps share a texture; each set of weight maps is fetched as it is."""
    tiles = [model.footprint.tiles[0] for model in models]
    channels = sum(one.channels for tile in tiles for one in tile)
    return -(-channels // PACKED) * (1 + tiles[0][0].differences) + sum(tile[0].layers for tile in tiles)
