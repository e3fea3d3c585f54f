"""The images and arrays of a scene, called by the places of tiles and maps: ``tile_0.map_1.difference_2.png``."""

import io
import zlib
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from facezip.character.maps import Map
from facezip.character.meshes import Meshes
from facezip.character.neutrals import packed_neutral
from facezip.character.scans import NEUTRAL, Character
from facezip.character.tiles import tiles_of_faces
from facezip.files.accessors import GlbFault
from facezip.files.images import Texels
from facezip.pack.footprint import SLOTS_PER_LAYER
from facezip.pack.geometry import head_bytes
from facezip.pack.manifest import HEAD_FILE, Manifest
from facezip.pack.masked import MaskedWeights
from facezip.pack.parsing import bad_pack
from facezip.pack.quantise import StoredTextures, StoredWeights

Assets = dict[str, Callable[[], bytes]]


def pack_assets(pack: Path, manifest: Manifest, stored: StoredTextures) -> Assets:
    """What shows a pack: images as its files hold them, weight maps or masks one after the other, the head as a GLB."""
    masked = stored.weights if isinstance(stored.weights, MaskedWeights) else None
    assets: Assets = {"activations.zlib": _constant(_deflated(masked.vectors.astype("<f2")))} if masked else {}
    for t, tile in enumerate(manifest.tiles):
        if masked:
            assets[f"tile_{t}.masks.zlib"] = _constant(_deflated(masked.fours(tile.number)))
        else:
            assets[f"tile_{t}.weights.zlib"] = _constant(_deflated(_layers(stored.weight_maps(tile.number))))
        for m, (entry, texture) in enumerate(zip(manifest.maps, tile.textures, strict=True)):
            stem = f"tile_{t}.map_{m}"
            for i, file in enumerate(texture.differences):
                assets[f"{stem}.difference_{i}.png"] = _constant((pack / file).read_bytes())
            if texture.neutral_bits == 8:
                assets[f"{stem}.neutral.png"] = _constant((pack / texture.neutral).read_bytes())
            else:
                assets |= _in_two_halves(f"{stem}.neutral", stored.parts[entry.name, tile.number].neutral)
    if stored.meshes is not None:
        assets |= _head(pack, manifest, stored.meshes)
    return assets


def original_assets(character: Character, manifest: Manifest) -> Assets:
    """The scans' textures in 8 bits: ``tile_0.map_1.original.png`` and, in the order of the pack, ``original_N``."""
    assets: Assets = {}
    for t, tile in enumerate(manifest.tiles):
        for m, entry in enumerate(manifest.maps):
            for n, name in enumerate((NEUTRAL, *manifest.expressions)):
                texels = character.texels(name, (entry.name, tile.number))
                name_of = f"original_{n - 1}" if n else "original"
                assets[f"tile_{t}.map_{m}.{name_of}.png"] = partial(_packed_png, texels, entry.kind)
    return assets


def _layers(weights: StoredWeights) -> NDArray[Any]:
    """``(L, N, h, w, 4)``: every weight map in four of its slots, then in the next four; uint8, or float32."""
    texels = weights.texels
    count, height, width, slots = texels.shape
    layers = -(-slots // SLOTS_PER_LAYER)
    padded = np.zeros((count, height, width, layers * SLOTS_PER_LAYER), texels.dtype.newbyteorder("<"))
    padded[..., :slots] = texels
    return padded.reshape(count, height, width, layers, SLOTS_PER_LAYER).transpose(3, 0, 1, 2, 4)


def _in_two_halves(stem: str, neutral: Texels) -> Assets:
    """A neutral of 16 bits as two images of 8, since browsers keep no more: the upper bits, and the lower."""

    def half(first: int) -> bytes:
        return _png(neutral.astype("<u2").view(np.uint8)[..., first::2])

    return {f"{stem}.png": partial(half, 1), f"{stem}_low.png": partial(half, 0)}


def _head(pack: Path, manifest: Manifest, meshes: Meshes) -> Assets:
    tiles = [tile.number for tile in manifest.tiles]
    assets = {"head.zlib": _constant(zlib.compress(_head_bytes(pack, manifest, meshes)))}
    if len(tiles) > 1:
        assets["tiles_of_faces.zlib"] = _constant(_deflated(tiles_of_faces(meshes.topology, tiles).astype(np.uint8)))
    return assets


def _head_bytes(pack: Path, manifest: Manifest, meshes: Meshes) -> bytes:
    if manifest.geometry and manifest.geometry.files == (HEAD_FILE,):
        return (pack / HEAD_FILE).read_bytes()
    try:
        return head_bytes(manifest.name, meshes.topology, meshes.neutral, meshes.vertices, manifest.expressions)
    except GlbFault as fault:
        raise bad_pack(pack, f"its meshes cannot be shown: {fault}") from None


def _packed_png(texels: Texels, kind: Map) -> bytes:
    return _png(packed_neutral(texels, kind, 8))


def _png(texels: Texels) -> bytes:
    """Bytes ``(H, W, C)`` as a PNG file."""
    content = io.BytesIO()
    Image.fromarray(texels[..., 0] if texels.shape[2] == 1 else texels).save(content, "PNG", compress_level=3)
    return content.getvalue()


def _deflated(array: NDArray[Any]) -> bytes:
    return zlib.compress(np.ascontiguousarray(array).tobytes())


def _constant(content: bytes) -> Callable[[], bytes]:
    return lambda: content
