"""Packs that a reader must read: small models, each of them odd in one way."""

import json
import shutil
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from facezip.character.maps import KNOWN, Map
from facezip.character.meshes import Meshes
from facezip.files.images import read_texture_exactly
from facezip.files.obj import Topology
from facezip.pack.masked import MaskedWeights
from facezip.pack.model import CompressedTextures, Part
from facezip.pack.write import write_pack
from tests.conformance.signing import manifest_of, png, signed, with_content
from tests.trust.claims import sign

Write = Callable[[Path], None]
GOLDEN = Path(__file__).parent.parent / "data"
ALBEDO, NORMAL, ROUGHNESS = (KNOWN[name] for name in ("albedo", "normal", "roughness"))
NAMES = ("smile", "frown")


def model(
    maps=(ALBEDO,), tiles=(1001,), size=(8, 8), weights=(2, 2), slots=2, names=NAMES, bits=8, meshes=None, channels=None
):
    """Texels of no meaning, the same for ever; a normal's slopes stay within what a film's skin has."""
    random = np.random.RandomState(20)  # Its numbers never change, those of newer generators may.
    parts, atlas = {}, {}
    for number in tiles:
        atlas[number] = (random.randint(-128, 128, (len(names), *weights, slots)) / np.float32(64)).astype(np.float32)
        for kind in maps:
            depth = 2 if kind.is_normal else channels or (3 if kind.encoding == "srgb" else 1)
            low, high, reach = (112, 144, 0.02) if kind.is_normal else (0, 256, 0.2)
            neutral = (random.randint(low, high, (*size, depth)) / np.float32(255)).astype(np.float32)
            differences = (random.randint(-127, 128, (slots, *size, depth)) / 127 * reach).astype(np.float32)
            parts[kind.name, number] = Part(neutral, differences, bits)
    return CompressedTextures("refined", names, tuple(maps), parts, atlas, meshes)


def masked(names=("a", "b", "c", "d", "e"), clamped=False, **fields):
    """Weight maps that are sums of masks."""
    plain = model(**fields)
    random, slots = np.random.RandomState(22), len(next(iter(plain.parts.values())).differences)
    low = 0 if clamped else -1
    activations = random.uniform(low, 1, (len(plain.expressions), len(names), slots)).astype(np.float16)
    masks = {
        tile: random.randint(0, 256, (len(names), *weights.shape[1:3])).astype(np.uint8)
        for tile, weights in plain.weights.items()
    }
    return replace(plain, weights=MaskedWeights(names, masks, activations))


def sheet(seam=False, scale=1.0, idle=0):
    """Four triangles around one vertex; with a seam, the first vertex has another place in the layout on each side."""
    corners = [[0, 0, 0], [2, 0, 0.25], [2, 2, -0.5], [0, 2, 0.125], [1, 1, 1 / 3], *[[9, 9, n] for n in range(idle)]]
    neutral = np.array(corners, np.float32) * np.float32(scale)
    faces = np.array([[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]], np.int32)
    layout, face_uv = [[0.1, 0.1], [0.9, 0.1], [0.9, 0.9], [0.1, 0.9], [0.5, 0.5]], faces.copy()
    if seam:
        layout.append([0.05, 0.3])
        face_uv[3, 1] = 5
    moves = np.sin(np.arange(2 * neutral.size, dtype=np.float32)).reshape(2, *neutral.shape) * np.float32(0.1 * scale)
    moves[:, 1] = 0
    return Meshes(Topology(faces, np.array(layout, np.float32), face_uv), neutral, neutral + moves)


def valid() -> Iterator[tuple[str, Write]]:
    """Name and writer of each."""
    for name, made in _models():
        yield name, lambda pack, made=made: write_pack(made, pack, name="vector", made_with={"seed": 20})
    yield "without-a-name", lambda pack: write_pack(model(), pack)
    yield "with-an-odd-name", lambda pack: write_pack(model(), pack, name="Zoë “Z” O'Hara 👩 n°1")
    yield "with-other-file-names", _other_names
    yield "manifest-of-another-writer", _other_manifest
    yield "steep-normals", _steep
    yield "filters-of-png", _other_filters
    yield "made-with-anything", _made_with
    for version in (1, 2):
        yield f"version-{version}", lambda pack, n=version: _copied(GOLDEN / f"pack-{n}" / "golden.facezip", pack)


def _models() -> Iterator[tuple[str, CompressedTextures]]:
    cavity, depth = Map("cavity", "data", -2, 5), Map("depth", "data", -1e6, 1e6)
    yield "one-map", model()
    yield "neutral-of-16-bits", model(bits=16)
    for slots in range(1, 9):
        yield f"slots-{slots}", model(slots=slots)
    yield "uniform-weights", model(weights=(1, 1))
    yield "uniform-weights-on-two-tiles", model(weights=(1, 1), tiles=(1001, 1002), slots=8)
    yield "three-maps", model(maps=(ALBEDO, NORMAL, ROUGHNESS))
    yield "three-maps-of-16-bits", model(maps=(ALBEDO, NORMAL, ROUGHNESS), bits=16)
    yield "tiles", model(tiles=(1001, 1002, 1011, 1999))
    yield "maps-and-tiles-of-other-sizes", _sizes()
    yield "normals-first", model(maps=(NORMAL,), slots=5)
    yield "a-range", model(maps=(cavity,), bits=16)
    yield "the-widest-range", model(maps=(depth,), bits=16)
    yield "a-narrow-range", model(maps=(Map("narrow", "data", 0.25, 0.251),))
    yield "colours-with-a-range", model(maps=(Map("glow", "srgb", 0, 4),), bits=16)
    yield "grey-colours", model(channels=1)
    yield "two-channels", model(maps=(ROUGHNESS,), channels=2)
    yield "four-channels", model(channels=4, slots=5)
    yield "one-expression", model(names=("smile",))
    yield "seventeen-expressions", model(names=tuple(f"e{n}" for n in range(17)), weights=(2, 3))
    yield "weights-as-large-as-textures", model(weights=(8, 8))
    yield "weights-of-one-row", model(size=(9, 13), weights=(1, 5))
    yield "one-texel", model(size=(1, 1), weights=(1, 1))
    yield "32-texels-square", model(size=(32, 32), weights=(3, 5))
    yield "names-with-accents", model(names=("élan", "Überraschung", "ñandú", "ﬁn"))
    yield "names-with-quotes", model(names=('the "smile"', "it's", "<b>&amp;", "$HOME `x`", "a  b", "%s{0}"))
    yield "names-with-emoji", model(names=("😀", "👍🏽", "笑顔", "улыбка", "ابتسامة"))
    yield "names-of-javascript", model(names=("__proto__", "constructor", "toString", "0", "-1"))
    yield "the-longest-names", model(names=("x" * 128, "é" * 100, "😀" * 50))
    yield "no-differences", _still(model(), slots=2)
    yield "masks", masked()
    yield "masks-clamped", masked(names=("brow", "Nase", "über"), slots=8, clamped=True)
    yield "masks-on-tiles", masked(maps=(ALBEDO, NORMAL), tiles=(1001, 1002), size=(12, 9), weights=(3, 4))
    yield "masks-of-one", masked(names=("all",), slots=1)
    yield "mesh", model(meshes=sheet())
    yield "mesh-with-a-seam", model(meshes=sheet(seam=True))
    yield "mesh-in-millimetres", model(meshes=sheet(seam=True, scale=1000))
    yield "mesh-known-to-be-in-centimetres", model(meshes=replace(sheet(seam=True), centimetres=True))
    yield "mesh-with-unused-vertices", model(meshes=sheet(idle=3))
    yield "mesh-that-does-not-move", model(meshes=_unmoved(sheet()))
    yield "mesh-of-far-moves", model(meshes=_far(sheet()))
    yield "mesh-with-tiles", model(meshes=sheet(seam=True), tiles=(1001, 1002), maps=(ALBEDO, ROUGHNESS))


def _sizes() -> CompressedTextures:
    big, small = model(maps=(ALBEDO, ROUGHNESS), tiles=(1001, 1003), size=(12, 20)), model(maps=(ROUGHNESS,))
    parts = {**big.parts, ("roughness", 1003): small.parts["roughness", 1001]}
    weights = {1001: big.weights[1001], 1003: np.repeat(big.weights[1003], 3, axis=2)}
    return CompressedTextures("refined", NAMES, big.maps, parts, weights)


def _still(moving: CompressedTextures, slots: int) -> CompressedTextures:
    part = moving.parts["albedo", 1001]
    parts = {("albedo", 1001): Part(part.neutral, np.zeros_like(part.differences))}
    return CompressedTextures("refined", NAMES, moving.maps, parts, {1001: np.ones((2, 2, 2, slots), np.float32)})


def _unmoved(meshes: Meshes) -> Meshes:
    return Meshes(meshes.topology, meshes.neutral, np.repeat(meshes.neutral[None], 2, axis=0))


def _far(meshes: Meshes) -> Meshes:
    """One vertex moves by many times the head, so that its steps need more than 16 bits."""
    vertices = meshes.vertices.copy()
    vertices[1, 2] += np.float32(1000)
    return Meshes(meshes.topology, meshes.neutral, vertices)


def _other_manifest(pack: Path) -> None:
    """After the first two fields another order, no line breaks, and escapes: the same JSON."""
    write_pack(model(names=("élan", "😀")), pack, name="vector")
    document = manifest_of(pack)
    start, rest = {"sha256": "0" * 64, "format": document.pop("format")}, dict(reversed(document.items()))
    del rest["sha256"]
    head, tail = json.dumps(start, indent=1)[:-2], json.dumps(rest, separators=(",", ":"))[1:]
    signed(pack, f"{head},{tail}".encode())


def _other_names(pack: Path) -> None:
    """The manifest says which file is which."""
    write_pack(model(), pack, name="vector")
    document, name = manifest_of(pack), "Größe & Form.png"
    (pack / document["tiles"][0]["textures"][0]["neutral"]).rename(pack / name)
    document["files"][name] = document["files"].pop(document["tiles"][0]["textures"][0]["neutral"])
    document["tiles"][0]["textures"][0]["neutral"] = name
    sign(pack, document)


def _steep(pack: Path) -> None:
    """Neutrals that no unit vector has, differences that tip normals over: slopes end at 10."""
    write_pack(model(maps=(NORMAL,)), pack, name="vector")
    samples = np.random.RandomState(21).choice([0, 64, 128, 192, 255], (8, 8, 3)).astype(np.uint8)
    with_content(pack, "normal.1001.neutral.png", png(samples))
    document = manifest_of(pack)
    document["tiles"][0]["textures"][0]["difference_span"] = [[0.5, 2.0]] * 2
    sign(pack, document)


def _other_filters(pack: Path) -> None:
    """Rows of the neutral with each of PNG's filters, in two chunks of pixels after one that asks for another gamma."""
    write_pack(model(bits=16), pack, name="vector")
    name = "albedo.1001.neutral.png"
    with_content(pack, name, png(read_texture_exactly(pack / name), filters=range(5)))


def _made_with(pack: Path) -> None:
    write_pack(model(), pack, name="vector")
    sign(pack, {"made_with": {"": None, "seed": 2**40, "list": [True, 0.5, {"format": "x"}], "sha256": "0" * 64}})


def _copied(golden: Path, pack: Path) -> None:
    shutil.copytree(golden, pack)
