"""Tiles, images, masks and normals that a reader must refuse, in packs that are well signed."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from facezip.character.maps import KNOWN, Map
from facezip.files.images import read_texture_exactly
from facezip.pack.model import CompressedTextures
from facezip.pack.write import write_pack
from tests.conformance.editing import DIFFERENCE, NEUTRAL, SMALL, WEIGHTS, Change, Edit, edited
from tests.conformance.signing import manifest_of, png, with_content
from tests.conformance.valid import masked, model


def broken_tiles() -> dict[str, tuple[CompressedTextures, Change]]:
    """Packs whose every file is as stated, and readable but for one rule."""
    tint = model(**SMALL, maps=(KNOWN["albedo"], Map("tint", "srgb")))
    tiles = model(**SMALL, tiles=(1001, 1002))
    weights = np.zeros((2, 2, 4), np.uint8)
    return {
        "map-names-twice": (tint, lambda pack: edited(pack, lambda d: d["maps"][1].update(name="albedo"))),
        "textures-of-more-maps": (tint, lambda pack: edited(pack, lambda d: d["maps"].pop())),
        "tile-twice": (tiles, lambda pack: edited(pack, lambda d: d["tiles"][1].update(number=1001))),
        "tiles-that-descend": (tiles, lambda pack: edited(pack, lambda d: d["tiles"].reverse())),
        "uniform-weights-on-one-tile": (
            tiles, lambda pack: _weights(pack, "weights.1002.png", weights[:1], tile=1, weight_size=[1, 1])
        ),
        "weights-larger-than-textures": (
            model(**SMALL), lambda pack: _weights(pack, WEIGHTS, np.tile(weights, (1, 8, 1)), weight_size=[2, 8])
        ),
        "weight-columns-more-than-expressions": (
            model(**SMALL), lambda pack: _weights(pack, WEIGHTS, np.tile(weights, (1, 3, 1)), weight_columns=3)
        ),
    }  # fmt: skip


def _weights(pack: Path, name: str, samples: np.ndarray, tile: int = 0, **fields: Any) -> None:
    """Other weights, and what the manifest states of them."""
    with_content(pack, name, png(samples))
    edited(pack, lambda d: d["tiles"][tile].update(fields))


def broken_masks() -> dict[str, Edit]:
    return {
        "masks-null": lambda d: d.update(masks=None),
        "masks-field-missing": lambda d: d["masks"].pop("clamped"),
        "masks-with-one-name-twice": lambda d: d["masks"].update(names=["a", "A", "c", "d", "e"]),
        "masks-of-an-unsafe-name": lambda d: d["masks"].update(names=["a", "b", "c", "d", "../e"]),
        "masks-more-than-activations": lambda d: d["masks"].update(names=["a", "b", "c", "d", "e", "f"]),
        "masks-of-more-tiles": lambda d: d["masks"].update(files=d["masks"]["files"] * 2),
        "masks-with-another-span": lambda d: d["tiles"][0].update(weight_span=[2.0]),
        "masks-with-an-offset": lambda d: d["tiles"][0].update(weight_offset=[0.5]),
        "masks-in-too-many-columns": lambda d: d["tiles"][0].update(weight_columns=3),
        "masks-clamped-as-a-number": lambda d: d["masks"].update(clamped=0),
    }


def with_activations(pack: Path, content: bytes) -> None:
    """Other activations, all the same, of a pack that says that they are not clamped."""
    write_pack(masked(slots=1), pack, name="vector")
    name = manifest_of(pack)["masks"]["activations"]
    with_content(pack, name, content * ((pack / name).stat().st_size // 2))


def broken_normals() -> dict[str, Edit]:
    return {
        "normals-with-another-range": lambda d: d["maps"][0].update(range=[0.0, 1.0]),
        "normals-of-three-channels": lambda d: (
            d["maps"][0].update(channels=3),
            d["tiles"][0]["textures"][0].update(difference_span=[[1.0] * 3]),
        ),
    }


def broken_images() -> dict[str, Change]:
    """Rule 5: images with checksums that are right."""

    def replaced(name: str, change: Callable[[np.ndarray], bytes]) -> Change:
        return lambda pack: with_content(pack, name, change(read_texture_exactly(pack / name)))

    def changed(change: Callable[[bytes], bytes]) -> Change:
        return lambda pack: with_content(pack, NEUTRAL, change((pack / NEUTRAL).read_bytes()))

    return {
        "image-of-another-size": replaced(NEUTRAL, lambda samples: png(samples[:3])),
        "image-of-16-bits": replaced(NEUTRAL, lambda samples: png(samples.astype(np.uint16) * 257)),
        "image-of-half-the-columns-in-16-bits": replaced(
            NEUTRAL, lambda samples: png(np.ascontiguousarray(samples[:, :2]).astype(np.uint16) * 257)
        ),
        "image-of-another-signature": changed(lambda content: b"\x88" + content[1:]),
        "image-of-too-few-rows": replaced(NEUTRAL, lambda samples: png(samples, rows=3)),
        "image-of-8-bits": lambda pack: edited(pack, lambda d: _with_bits(d, 16)),
        "image-of-grey": replaced(NEUTRAL, lambda samples: png(samples[..., :1])),
        "difference-of-16-bits": replaced(DIFFERENCE, lambda samples: png(samples.astype(np.uint16) * 257)),
        "weights-of-one-channel": replaced(WEIGHTS, lambda samples: png(samples[..., :1])),
        "weights-of-16-bits": replaced(WEIGHTS, lambda samples: png(samples.astype(np.uint16) * 257)),
        "weights-of-another-size": replaced(WEIGHTS, lambda samples: png(np.repeat(samples, 2, 0))),
        "image-that-is-none": changed(lambda content: b"no image"),
        "image-cut-short": changed(lambda content: content[: len(content) // 2]),
        "image-of-a-wrong-checksum": changed(lambda content: content[:-16] + b"\0\0\0\0" + content[-12:]),
        "image-of-an-unknown-filter": replaced(NEUTRAL, lambda samples: png(samples, filters=(5,))),
    }


def _with_bits(document: dict[str, Any], bits: int) -> None:
    document["tiles"][0]["textures"][0]["neutral_bits"] = bits


def with_normals(pack: Path) -> None:
    write_pack(model(**SMALL, maps=(KNOWN["normal"],)), pack, name="vector")
