"""A verified pack as the page wants it: one JSON document, and images and arrays by name."""

import io
import zlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from facezip.character.meshes import Meshes
from facezip.character.scans import Character
from facezip.errors import ErrorCode, FaceZipError
from facezip.files.images import Texels, read_texture_exactly, to_float
from facezip.pack.errors import mean_rmse, model_errors
from facezip.pack.footprint import SLOTS_PER_LAYER
from facezip.pack.manifest import Manifest
from facezip.pack.model import CompressedTextures
from facezip.pack.quantise import STEPS, ZERO
from facezip.pack.verification import bytes_on_disk, verify_pack
from facezip.pack.version_1 import NEUTRAL_FILE, read_verified

# Steps from the neutral to the farthest vertex of an expression.
DELTA_STEPS = 32767


@dataclass(frozen=True)
class Scene:
    """What a page shows.

    Attributes
    ----------
    document : names, sizes and ranges; plain JSON.
    assets : PNG images (``NAME.png``) and arrays (``NAME.zlib``: little-endian, row by row, deflated) that the document
        needs. No name of theirs comes out of a pack. Called when asked for: originals are many and rarely all seen.
    """

    document: dict[str, Any]
    assets: Mapping[str, Callable[[], bytes]]


def read_scene(pack: Path, character: Character | None = None) -> Scene:
    """Verify a pack and read it, with the original textures of ``character`` beside it if given.

    Raises
    ------
    FaceZipError
        What :func:`facezip.read_pack` raises; ``UNKNOWN_NAME`` or ``SIZE_MISMATCH`` where the character is another
        one; ``BAD_VALUE`` where textures are no pictures (2 or 4 channels).
    """
    manifest = verify_pack(pack)
    if manifest.channels not in (1, 3):
        raise FaceZipError(
            ErrorCode.BAD_VALUE, f"{pack}: textures of {manifest.channels} channels; the viewer shows 1 or 3"
        )
    if character is not None:
        _check_same(character, pack, manifest)
    model = read_verified(pack, manifest)
    document = _document(pack, manifest, model)
    assets = {"neutral.png": _constant(_neutral_png(pack))}
    for i in range(len(manifest.difference_scale)):
        assets[f"difference_{i}.png"] = _constant((pack / f"difference_{i}.png").read_bytes())
    for layer, texels in enumerate(_weight_layers(pack, manifest)):
        assets[f"weights_{layer}.zlib"] = _constant(_deflated(texels))
    if model.meshes is not None:
        arrays, document["mesh"] = _mesh(model.meshes)
        assets |= {f"{name}.zlib": _constant(_deflated(array)) for name, array in arrays.items()}
    if character is not None:
        errors = model_errors(character, model)
        document["original"] = {"rmse": mean_rmse(errors), "rmse_per_expression": list(errors.values())}
        assets["original.png"] = partial(_png, character.first.neutral)
        for n, name in enumerate(manifest.expressions):
            assets[f"original_{n}.png"] = partial(_png, character.first.textures[character.index(name)])
    return Scene(document, assets)


def _document(pack: Path, manifest: Manifest, model: CompressedTextures) -> dict[str, Any]:
    cost = manifest.footprint
    return {
        "name": manifest.name,
        "method": manifest.method,
        "expressions": list(manifest.expressions),
        "size": list(manifest.size),
        "difference_scale": np.broadcast_to(manifest.difference_scale, (cost.differences, 3)).tolist(),
        "difference_zero": ZERO / 255,
        "difference_steps": STEPS / 255,
        "weight_size": list(manifest.weight_size),
        # Uniform weights lie one below the other.
        "weight_columns": manifest.weight_columns,
        "weight_scale": list(manifest.weight_scale),
        "weight_offset": list(manifest.weight_offset),
        "weight_range": float(np.abs(model.weights).max()),
        "uniform": bool(manifest.uniform_weights),
        "costs": {
            "bytes_on_gpu": cost.bytes_on_gpu,
            "bytes_raw": cost.bytes_raw,
            "bytes_on_disk": bytes_on_disk(pack),
            "fetches": cost.fetches,
        },
        "mesh": None,
        "original": None,
    }


def _mesh(meshes: Meshes) -> tuple[dict[str, NDArray[Any]], dict[str, Any]]:
    """Arrays of the mesh, and their sizes: corners are the pairs of vertex and texture coordinate that a GPU draws."""
    topology = meshes.topology
    pairs = np.stack([topology.faces.ravel(), topology.face_uv.ravel()], axis=1)
    corners, triangles = np.unique(pairs, axis=0, return_inverse=True)
    scale = np.abs(meshes.deltas).max(axis=(1, 2)) / np.float32(DELTA_STEPS)
    deltas = np.rint(meshes.deltas / np.where(scale > 0, scale, 1)[:, None, None])
    arrays: dict[str, NDArray[Any]] = {
        "positions": meshes.neutral.astype("<f4"),
        "deltas": deltas.astype("<i2"),
        "corner_vertices": corners[:, 0].astype("<u4"),
        "corner_uv": topology.uv[corners[:, 1]].astype("<f4"),
        "triangles": triangles.astype("<u4"),
    }
    sizes = {"vertices": len(meshes.neutral), "triangles": len(topology.faces), "delta_scale": scale.tolist()}
    return arrays, sizes


def _weight_layers(pack: Path, manifest: Manifest) -> list[NDArray[Any]]:
    """RGBA texels of each layer of slots: the pack's atlases, or one row of float32 for uniform weights."""
    if not manifest.uniform_weights:
        files = sorted(name for name in manifest.files if name.startswith("weights"))
        return [read_texture_exactly(pack / name) for name in files]
    slots = len(manifest.weight_scale)
    padded = np.zeros((len(manifest.expressions), -(-slots // SLOTS_PER_LAYER) * SLOTS_PER_LAYER), "<f4")
    padded[:, :slots] = manifest.uniform_weights
    return [np.ascontiguousarray(layer) for layer in np.split(padded, padded.shape[1] // SLOTS_PER_LAYER, axis=1)]


def _neutral_png(pack: Path) -> bytes:
    content = (pack / NEUTRAL_FILE).read_bytes()
    texels = read_texture_exactly(pack / NEUTRAL_FILE)
    return content if texels.dtype == np.uint8 else _png(texels)


def _png(texels: Texels) -> bytes:
    """8-bit texels ``(H, W, 1 or 3)`` of encoded values as a PNG file."""
    if texels.dtype != np.uint8:
        texels = np.rint(to_float(texels) * 255).astype(np.uint8)
    content = io.BytesIO()
    Image.fromarray(texels[..., 0] if texels.shape[2] == 1 else texels).save(content, "PNG", compress_level=3)
    return content.getvalue()


def _deflated(array: NDArray[Any]) -> bytes:
    return zlib.compress(np.ascontiguousarray(array).tobytes(), 9)


def _constant(content: bytes) -> Callable[[], bytes]:
    return lambda: content


def _check_same(character: Character, pack: Path, manifest: Manifest) -> None:
    differing = {*character.expressions} ^ {*manifest.expressions}
    if differing:
        raise FaceZipError(
            ErrorCode.UNKNOWN_NAME,
            f"{pack}: not of {character.name}, only one of them has '{min(differing)}'; "
            "give the character that the pack was made from",
        )
    if character.first.resolution != manifest.size or character.first.neutral.shape[2] != manifest.channels:
        raise FaceZipError(
            ErrorCode.SIZE_MISMATCH,
            f"{pack}: textures of another size or other channels than {character.name}'s; compress it again",
        )
