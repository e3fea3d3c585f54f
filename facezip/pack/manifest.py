"""``manifest.json``: what a pack holds, and a checksum over all bytes, its own too (docs/pack-format.md)."""

import hashlib
import json
from dataclasses import asdict, dataclass, field
from typing import Any, Final, Literal

from facezip.character.maps import Encoding, Key, Map
from facezip.pack.footprint import SLOTS_PER_LAYER, Footprint, Texture

FORMAT: Final = "facezip-pack/3"
HEAD_FILE = "head.glb"
ACTIVATIONS_FILE = "activations.f16"

# How a pack was made, in words and numbers by name: for people, whatever is there; readers ignore it.
MadeWith = dict[str, Any]
# The JSON of a manifest, or of a part, as it is read: checked afterwards.
Fields = dict[str, Any]


@dataclass(frozen=True)
class StoredFile:
    """Length in bytes and SHA-256 (hexadecimal) of one file of the pack."""

    bytes: int
    sha256: str


@dataclass(frozen=True)
class MapEntry:
    """A map as a pack holds it.

    Attributes
    ----------
    name, encoding : as of :class:`facezip.character.maps.Map`.
    range : what t = 0 and t = 1 of the neutral stand for.
    channels : of a texel; 2 for normals, whose images have a third one for people to look at.
    """

    name: str
    encoding: Encoding
    range: tuple[float, float]
    channels: int

    @property
    def kind(self) -> Map:
        """The map without its channels."""
        return Map(self.name, self.encoding, *self.range)

    @property
    def image_channels(self) -> int:
        """Of the images."""
        return 3 if self.kind.is_normal else self.channels


@dataclass(frozen=True)
class TextureEntry:
    """One map on one tile.

    Attributes
    ----------
    size : rows and columns of neutral and differences.
    neutral, differences : the files.
    neutral_bits : bits of a channel of the neutral, 8 or 16.
    difference_span : R lists of C numbers; D = (t - 128/255) · span, in units of the map, slopes for normals.
    """

    size: tuple[int, int]
    neutral: str
    differences: tuple[str, ...]
    neutral_bits: int
    difference_span: tuple[tuple[float, ...], ...]


@dataclass(frozen=True)
class TileEntry:
    """The weight maps of a tile, and its maps in the order of the manifest's ``maps``.

    Attributes
    ----------
    number : of the UDIM tile, 1001 + column + 10 · row.
    weight_size : rows and columns of one weight map or mask; ``[1, 1]`` for uniform weights.
    weight_columns : weight maps, or fours of masks, per row of an atlas.
    weight_span, weight_offset : R numbers each; W = t · span + offset.
    weights : the files, an atlas for every four slots; none for uniform weights and for masks.
    textures : one a map.
    """

    number: int
    weight_size: tuple[int, int]
    weight_columns: int
    weight_span: tuple[float, ...]
    weight_offset: tuple[float, ...]
    weights: tuple[str, ...]
    textures: tuple[TextureEntry, ...]


@dataclass(frozen=True)
class GeometryEntry:
    """The meshes.

    Attributes
    ----------
    files : ``head.glb``; of packs before version 3 ``neutral.obj`` and ``deltas.f32``.
    vertices, triangles : how many.
    """

    files: tuple[str, ...]
    vertices: int
    triangles: int


@dataclass(frozen=True)
class MasksEntry:
    """The masks of which weight maps are made (:class:`facezip.pack.masked.MaskedWeights`).

    Attributes
    ----------
    names : K names.
    files : one a tile, in the order of ``tiles``: an atlas of masks, four in each texel.
    activations : the file; N · K · R little-endian float16, R innermost.
    clamped : whether all of them lie in 0..1.
    """

    names: tuple[str, ...]
    files: tuple[str, ...]
    activations: str
    clamped: bool

    @property
    def fours(self) -> int:
        """How many RGBA images the masks fill."""
        return -(-len(self.names) // SLOTS_PER_LAYER)


@dataclass(frozen=True)
class Manifest:
    """The fields of ``manifest.json``, checked against their ranges when it is read.

    Attributes
    ----------
    name : what the character is called; where the file says nothing, the stem of the folder's name.
    method : what fitted the textures; for people.
    expressions : N names in the order of the weight maps.
    maps, tiles : what there is; albedo first, numbers ascending.
    uniform_weights : N lists of R numbers, for all tiles, where weights are uniform, else empty.
    geometry : the meshes, or None.
    masks : of which weight maps are made; None, and no field of the file, where those are stored.
    made_with : options and measured errors; for people, ignored by readers.
    files : every other file in the folder.
    """

    name: str
    method: str
    expressions: tuple[str, ...]
    maps: tuple[MapEntry, ...]
    tiles: tuple[TileEntry, ...]
    uniform_weights: tuple[tuple[float, ...], ...]
    geometry: GeometryEntry | None
    masks: MasksEntry | None = None
    made_with: MadeWith = field(default_factory=dict)
    files: dict[str, StoredFile] = field(default_factory=dict)

    @property
    def footprint(self) -> Footprint:
        """Bytes and fetches at run time."""
        return Footprint(
            tuple(
                tuple(Texture(*entry.size, kind.channels) for kind, entry in zip(self.maps, tile.textures, strict=True))
                for tile in self.tiles
            ),
            tuple(tile.weight_size for tile in self.tiles),
            len(self.tiles[0].weight_span),
            len(self.expressions),
            sum(self.files[name].bytes for name in self.geometry.files) if self.geometry else 0,
            len(self.masks.names) if self.masks else 0,
        )

    def entries(self) -> dict[Key, tuple[MapEntry, TextureEntry]]:
        """Every map on every tile."""
        return {
            (kind.name, tile.number): (kind, texture)
            for tile in self.tiles
            for kind, texture in zip(self.maps, tile.textures, strict=True)
        }

    def to_bytes(self) -> bytes:
        """The file's content; its first field is the SHA-256 of all its bytes with that field's digits set to 0."""
        whole = {"sha256": "0" * 64, "format": FORMAT, **asdict(self)}
        if self.masks is None:
            del whole["masks"]
        blank = json.dumps(whole, indent=1, ensure_ascii=False, allow_nan=False).encode() + b"\n"
        return blank.replace(b"0" * 64, hashlib.sha256(blank).hexdigest().encode(), 1)


@dataclass(frozen=True, kw_only=True)
class ManifestFile(Manifest):
    """``manifest.json`` as it stands in a pack.

    Attributes
    ----------
    sha256 : of all bytes of the file with the digits of this field set to 0.
    format : the version of packs.
    """

    sha256: str
    format: Literal["facezip-pack/3"] = FORMAT
