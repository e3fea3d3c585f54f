"""What sharing weight maps saves and costs: all maps in one fit, beside one fit for each."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter

from facezip.character.scans import Character
from facezip.fit.methods import compress
from facezip.machine.progress import track
from facezip.pack.errors import Errors, MapErrors, pack_errors
from facezip.pack.model import CompressedTextures
from facezip.pack.write import write_pack

SHARED, SEPARATE, FINER, MORE = "shared", "one fit per map", "shared, weights at 1/4", "shared, 5 differences"
# Channels that one fetch gives, in the textures that are exported.
PACKED = 3
Fit = Callable[[Character], CompressedTextures]


@dataclass(frozen=True, kw_only=True)
class Way:
    """One way to fit all maps.

    Attributes
    ----------
    way : its name.
    bytes_on_gpu, bytes_raw : of it and of the textures that it stands for, at 8 bits a channel.
    fetches : a pixel, a texture for each map.
    fetches_packed : where the channels of maps lie side by side in textures of three.
    seconds : of the fit.
    errors : by map.
    """

    way: str
    bytes_on_gpu: int
    bytes_raw: int
    fetches: int
    fetches_packed: int
    seconds: float
    errors: Mapping[str, MapErrors]


def compare_sharing(character: Character) -> list[Way]:
    """Fits of a character with shared and with separate weight maps, each written as a pack and read back."""
    alone = [character.only(kind.name) for kind in character.maps]
    ways: dict[str, tuple[list[Character], Fit]] = {
        SHARED: ([character], compress),
        SEPARATE: (alone, compress),
        FINER: ([character], partial(compress, weight_scale=4)),
        MORE: ([character], partial(compress, differences=5)),
        "shared, PCA(4)": ([character], partial(compress, method="pca")),
        "one PCA(4) per map": (alone, partial(compress, method="pca")),
    }
    return [_row(way, *ways[way]) for way in track(ways, "Comparing", len(ways))]


def _row(way: str, characters: Sequence[Character], fit: Fit) -> Way:
    begin = perf_counter()
    models = [fit(character) for character in characters]
    seconds = perf_counter() - begin
    errors: Errors = {}
    for character, model in zip(characters, models, strict=True):
        with TemporaryDirectory(prefix="facezip-bench-") as place:
            pack = Path(place) / "bench.facezip"
            write_pack(model, pack)
            errors |= pack_errors(character, pack)
    costs = [model.footprint for model in models]
    return Way(
        way=way,
        bytes_on_gpu=sum(cost.bytes_on_gpu for cost in costs),
        bytes_raw=sum(cost.bytes_raw for cost in costs),
        fetches=sum(cost.fetches for cost in costs),
        fetches_packed=_packed(models),
        seconds=round(seconds, 2),
        errors=errors,
    )


def _packed(models: Sequence[CompressedTextures]) -> int:
    """Fetches where three channels of any maps share a texture; each set of weight maps is fetched as it is."""
    costs = [model.footprint for model in models]
    channels = sum(texture.channels for cost in costs for texture in cost.tiles[0])
    return -(-channels // PACKED) * (1 + costs[0].differences) + sum(cost.layers for cost in costs)
