"""A verified pack as the page wants it: one JSON document, and images and arrays by name."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

from facezip.character.maps import MAX_SLOPE
from facezip.character.scans import Character
from facezip.character.tiles import place_of
from facezip.errors import ErrorCode, FaceZipError
from facezip.files.reading import reading, undisturbed
from facezip.pack.belonging import check_belongs
from facezip.pack.errors import Errors, model_errors
from facezip.pack.manifest import Manifest, MapEntry, TextureEntry, TileEntry
from facezip.pack.masked import MaskedWeights
from facezip.pack.quantise import ZERO, StoredTextures
from facezip.pack.read import read_stored
from facezip.pack.same_neutral import warn_of_another
from facezip.pack.verification import bytes_on_disk, verify_pack
from facezip.rigging.sequences import poses_for
from facezip.viewer.assets import Assets, original_assets, pack_assets
from facezip.viewer.documents import SceneCosts, SceneDocument, SceneMap, SceneMesh, ScenePose, SceneTexture, SceneTile

COLOURS = 3


@dataclass(frozen=True)
class Scene:
    """What a page shows.

    Attributes
    ----------
    document : names, sizes and ranges.
    assets : PNG images (``NAME.png``) and arrays (``NAME.zlib``: little-endian, row by row, deflated) that the document
        needs. No name of theirs comes out of a pack. Called when asked for: originals are many and rarely all seen.
    """

    document: SceneDocument
    assets: Mapping[str, Callable[[], bytes]]


def read_scene(pack: Path, character: Character | None = None) -> Scene:
    """Verify a pack and read it, with the original textures of ``character`` beside it if given.

    Raises
    ------
    FaceZipError
        What :func:`facezip.read_pack` raises; ``UNKNOWN_NAME`` or ``SIZE_MISMATCH`` where the character is another
        one; ``BAD_VALUE`` where a map is no picture (colours of 2 channels, anything of 4).
    """
    read = undisturbed(pack, lambda: _read(pack, character))
    if character is None:
        return Scene(_document(read, None), read.assets)
    errors = model_errors(character, read.stored)
    return Scene(_document(read, errors), {**read.assets, **original_assets(character, read.manifest)})


class _Read(NamedTuple):
    """What is read of a pack: what becomes of its folder afterwards changes nothing."""

    manifest: Manifest
    stored: StoredTextures
    assets: Assets
    bytes: int


def _read(pack: Path, character: Character | None) -> _Read:
    manifest = verify_pack(pack)
    _check_channels(manifest, pack)
    if character is not None:
        _check_same(character, manifest, pack)
    stored = read_stored(pack, manifest)
    if character is not None:
        warn_of_another(character, stored, pack)
    with reading(pack):
        return _Read(manifest, stored, pack_assets(pack, manifest, stored), bytes_on_disk(pack))


def _document(read: _Read, errors: Errors | None) -> SceneDocument:
    manifest, stored = read.manifest, read.stored
    cost, geometry = manifest.footprint, manifest.geometry
    return SceneDocument(
        name=manifest.name,
        method=manifest.method,
        expressions=manifest.expressions,
        poses=list(_poses(manifest.expressions)),
        maps=[_map(entry, errors) for entry in manifest.maps],
        tiles=[_tile(tile, manifest.maps) for tile in manifest.tiles],
        slots=cost.differences,
        difference_zero=ZERO / 255,
        max_slope=MAX_SLOPE,
        uniform=bool(manifest.uniform_weights),
        weight_range=max(_largest_weight(stored, tile) for tile in stored.weights),
        fours=manifest.masks.fours if manifest.masks else None,
        costs=SceneCosts(
            bytes_on_gpu=cost.bytes_on_gpu,
            bytes_raw=cost.bytes_raw,
            bytes_on_disk=read.bytes,
            fetches=cost.fetches,
        ),
        mesh=SceneMesh(vertices=geometry.vertices, triangles=geometry.triangles) if geometry else None,
        originals=errors is not None,
    )


def _poses(expressions: tuple[str, ...]) -> Iterator[ScenePose]:
    """The key poses that these expressions can make, then each expression alone that is none of them."""
    poses = {pose.name: pose.weights for pose in poses_for(expressions)}
    alone = {name: {name: 1.0} for name in expressions if name not in poses}
    for name, weights in {**poses, **alone}.items():
        yield ScenePose(name=name, weights=[(expressions.index(key), weight) for key, weight in weights.items()])


def _map(entry: MapEntry, errors: Errors | None) -> SceneMap:
    return SceneMap(
        name=entry.name,
        encoding=entry.encoding,
        range=entry.range,
        channels=entry.channels,
        image_channels=entry.image_channels,
        error=errors[entry.name].mean if errors else None,
    )


def _largest_weight(stored: StoredTextures, tile: int) -> float:
    if isinstance(stored.weights, MaskedWeights):
        # One after another: all weight maps are what masks spare.
        maps = (stored.weights.combined(betas, tile) for betas in np.eye(len(stored.expressions), dtype=np.float32))
        return max(float(np.abs(weights).max()) for weights in maps)
    return float(np.abs(stored.weights[tile].values).max())


def _tile(tile: TileEntry, maps: tuple[MapEntry, ...]) -> SceneTile:
    return SceneTile(
        number=tile.number,
        place=place_of(tile.number),
        weight_size=tile.weight_size,
        weight_span=tile.weight_span,
        weight_offset=tile.weight_offset,
        textures=[_texture(*each) for each in zip(maps, tile.textures, strict=True)],
    )


def _texture(entry: MapEntry, texture: TextureEntry) -> SceneTexture:
    # As what the shader adds to: slopes of normals, else texels in [0, 1].
    unit = 1.0 if entry.kind.is_normal else entry.kind.unit
    spans = np.array(texture.difference_span) / unit
    spans = np.repeat(spans, COLOURS, axis=1) if entry.channels == 1 else spans
    padding = [(0, 0), (0, COLOURS - spans.shape[1])]
    return SceneTexture(
        size=texture.size,
        neutral_bits=texture.neutral_bits,
        difference_span=np.pad(spans, padding).tolist(),
    )


def _check_channels(manifest: Manifest, pack: Path) -> None:
    for entry in manifest.maps:
        if entry.channels > COLOURS or (entry.encoding == "srgb" and entry.channels == 2):
            raise FaceZipError(
                ErrorCode.BAD_VALUE,
                f"{pack}: its {entry.name} has {entry.channels} channels; the viewer shows colours of 1 or 3 and data "
                "of up to 3; compress it without that map, or without alpha",
            )


def _check_same(character: Character, manifest: Manifest, pack: Path) -> None:
    check_belongs(character, manifest, pack)
    more = [f"expression '{name}'" for name in manifest.expressions if name not in character.expressions]
    more += [f"{name} on tile {tile}" for name, tile in manifest.entries() if (name, tile) not in character.stacks]
    if more:
        raise FaceZipError(
            ErrorCode.UNKNOWN_NAME,
            f"{pack}: has {more[0]}, which {character.name} has not; give the character that the pack was made from",
        )
