"""What sharing weight maps saves and costs: all maps in one fit, beside one fit for each."""

from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import Any

from facezip.character.scans import Character
from facezip.fit.methods import compress
from facezip.machine.progress import track
from facezip.pack.errors import pack_errors
from facezip.pack.model import CompressedTextures
from facezip.pack.write import write_pack

SHARED, SEPARATE, FINER, MORE = "shared", "one fit per map", "shared, weights at 1/4", "shared, 5 differences"
# Channels that one fetch gives, in the textures that are exported.
PACKED = 3


def compare_sharing(character: Character) -> list[dict[str, Any]]:
    """Fits of a character with shared and with separate weight maps, each written as a pack and read back.

    Returns
    -------
    For each way: ``way``; ``bytes_on_gpu`` (8 bits a channel); ``fetches`` a pixel, a texture for each map;
    ``fetches_packed``, where the channels of maps lie side by side in textures of three; ``seconds`` of the fit; and
    ``errors`` by map (:func:`facezip.pack.errors.model_errors`).
    """
    alone = [character.only(kind.name) for kind in character.maps]
    ways: dict[str, tuple[list[Character], dict[str, Any]]] = {
        SHARED: ([character], {}),
        SEPARATE: (alone, {}),
        FINER: ([character], {"weight_scale": 4}),
        MORE: ([character], {"differences": 5}),
        "shared, PCA(4)": ([character], {"method": "pca"}),
        "one PCA(4) per map": (alone, {"method": "pca"}),
    }
    return [_row(way, *ways[way]) for way in track(ways, "Comparing", len(ways))]


def _row(way: str, characters: Sequence[Character], settings: dict[str, Any]) -> dict[str, Any]:
    begin = perf_counter()
    models = [compress(character, **settings) for character in characters]
    seconds = perf_counter() - begin
    errors: dict[str, Any] = {}
    for character, model in zip(characters, models, strict=True):
        with TemporaryDirectory(prefix="facezip-bench-") as place:
            pack = Path(place) / "bench.facezip"
            write_pack(model, pack)
            errors |= pack_errors(character, pack)
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


def _packed(models: Sequence[CompressedTextures]) -> int:
    """Fetches where three channels of any maps share a texture; each set of weight maps is fetched as it is."""
    costs = [model.footprint for model in models]
    channels = sum(texture.channels for cost in costs for texture in cost.tiles[0])
    return -(-channels // PACKED) * (1 + costs[0].differences) + sum(cost.layers for cost in costs)
