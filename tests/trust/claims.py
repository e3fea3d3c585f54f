"""Files that claim to be huge: refused before the memory is asked for."""

import json
import struct
import time
import zlib
from collections.abc import Callable, Sequence
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np

from facezip import FaceZipError
from facezip.character.loading import load_character, save_character
from facezip.files.glb import Glb
from facezip.files.images import read_texture
from facezip.files.obj import read_obj
from facezip.files.packs import MANIFEST
from facezip.pack.read import read_pack
from facezip.pack.write import write_pack
from tests.facezip.conftest import masked, random_character, random_model
from tests.facezip.files import stored
from tests.trust.children import in_child, memory_above
from tests.trust.findings import Row

SECONDS = 1.0
BYTES = 64 * 2**20
FEW = zlib.compress(bytes(1000))
TEXELS = np.zeros((2, 2, 3), np.uint8)
CHANNEL = {"Y": (np.zeros((2, 2), np.float32), 1)}


def check_claims(work: Path, part: float) -> list[Row]:
    """Each claim in a child of its own, with its processor time and its memory; ``part`` leaves none out."""
    faults = {"accepted": 0, "other exceptions": 0, "slow": 0, "large": 0}
    examples, worst_seconds, worst_bytes = [], 0.0, 0
    claims = make_claims(work)
    for name, read in claims.items():
        outcome = in_child(lambda read=read: memory_above(lambda: _verdict(read)), limit=20)
        (fault, seconds), grown = outcome.answer if outcome.code == 0 else ((f"other exceptions: {outcome}", 0), 0)
        worst_seconds, worst_bytes = max(worst_seconds, seconds), max(worst_bytes, grown)
        slow, large = "slow" if seconds > SECONDS else "", "large" if grown > BYTES else ""
        for each in filter(None, (fault, slow, large)):
            faults[each.split(":")[0]] += 1
            examples.append(f"{name}: {each}, {seconds:.2f} s, {grown / 2**20:.0f} MB")
    notes = f"at most {worst_seconds:.2f} s and {worst_bytes / 2**20:.0f} MB"
    return [Row("crafted size claims", len(claims), faults, notes, tuple(examples))]


def make_claims(work: Path) -> dict[str, Callable[[], Any]]:
    """What is claimed → what reads it."""
    images = {
        "png-16384-square-in-no-data.png": _png(16384, 16384, FEW),
        "png-largest-sides.png": _png(2**31 - 1, 2**31 - 1, FEW),
        "png-60000-square-grey.png": _png(60000, 60000, FEW, colour=0),
        "png-bomb-of-zeros.png": _png(16384, 16384, _zeros(16384 * (3 * 16384 + 1))),
        "png-16-bit-rgba.png": _png(16384, 16384, FEW, bits=16, colour=6),
        "png-text-bomb-and-no-pixels.png": _png(64, 64, b"", chunks=[(b"zTXt", b"a\0\0" + _zeros(2**28))]),
        "png-profile-bomb-and-no-pixels.png": _png(64, 64, b"", chunks=[(b"iCCP", b"a\0\0" + _zeros(2**28))]),
        "png-chunk-of-2-gigabytes.png": b"\x89PNG\r\n\x1a\n" + struct.pack(">I4s", 2**31 - 1, b"IHDR") + b"\0" * 64,
        "tiff-largest-sides.tif": _tiff({256: 2**31 - 1, 257: 2**31 - 1, 258: 8, 273: 8, 277: 1, 278: 1, 279: 1}),
        "tiff-16384-square-in-no-data.tif": _tiff(
            {256: 16384, 257: 16384, 258: 8, 273: 8, 277: 3, 278: 16384, 279: 2**30}
        ),
        "tiff-one-strip-of-4-gigabytes.tif": _tiff({256: 64, 257: 64, 258: 8, 273: 8, 277: 3, 278: 64, 279: 2**32 - 1}),
        "tiff-largest-tile.tif": _tiff({256: 64, 257: 64, 258: 8, 277: 3, 322: 2**30, 323: 2**30, 324: 8, 325: 2**30}),
        "tiff-65535-samples.tif": _tiff({256: 64, 257: 64, 258: 8, 273: 8, 277: 65535, 278: 64, 279: 64}),
        "tiff-65535-entries.tif": b"II*\0\x08\0\0\0\xff\xff" + b"\0" * 64,
        "exr-largest-window.exr": _exr(-(2**30), 2**30),
        "exr-16384-square-in-no-data.exr": _exr(0, 16383),
        "exr-largest-tile.exr": _exr(0, 63, tile=2**31 - 1),
        "exr-attribute-of-2-gigabytes.exr": _exr(0, 63, text=2**31 - 1),
        "exr-display-window-of-16384.exr": stored.exr(CHANNEL, (16384, 16384), (0, 0, 2, 2)),
        "exr-largest-display-window.exr": stored.exr(CHANNEL, (2**31 - 1, 2**31 - 1), (0, 0, 2, 2)),
        "exr-300-channels.exr": stored.exr({f"c{n}": CHANNEL["Y"] for n in range(300)}, (2, 2)),
        "tga-16384-square-in-no-data.tga": stored.tga(TEXELS)[:12] + struct.pack("<HHBB", 16384, 16384, 24, 32),
        "tga-largest-sides.tga": stored.tga(TEXELS)[:12] + struct.pack("<HHBB", 65535, 65535, 24, 32) + bytes(99),
        "bmp-16384-square-in-no-data.bmp": _bmp(16384),
        "bmp-largest-sides.bmp": _bmp(2**31 - 1),
        "webp-16383-square-in-no-data.webp": _webp(16383),
        "jpeg-largest-sides.jpg": bytes.fromhex("ffd8ffc0001108ffffffff03012200021101031101ffd9"),
    }  # fmt: skip
    meshes = {
        "obj-10-million-lines.obj": b"v 0 0 0\n" * 10_000_000,
        "obj-index-beyond-all.obj": b"v 0 0 0\nvt 0 0\nf 1/1 1/1 4611686018427387904/1\n",
    }
    work.mkdir(exist_ok=True)
    claims: dict[str, Callable[[], Any]] = {}
    for files, read in ((images, read_texture), (meshes, read_obj)):
        for name, content in files.items():
            (work / name).write_bytes(content)
            claims[name] = lambda read=read, name=name: read(work / name)
    with open(work / "obj-of-a-terabyte.obj", "wb") as file:
        file.truncate(2**40)
    claims["obj-of-a-terabyte.obj"] = lambda: read_obj(work / "obj-of-a-terabyte.obj")
    claims |= _glbs(work)
    claims["character-of-500-bombs"] = _character_of_bombs(work / "bombs")
    return claims | dict(_packs(work))


def _glbs(work: Path) -> dict[str, Callable[[], Any]]:
    """Characters in one file, whose JSON states more than its bytes hold."""
    character = random_character(side=16, grid=3, expressions=2)
    changes: dict[str, Callable[[dict[str, Any]], Any]] = {
        "glb-accessor-of-4-billion": lambda d: d["accessors"][0].update(count=2**32 - 1),
        "glb-zeros-without-bytes": lambda d: (
            d["accessors"][0].update(count=2**32 - 1) or d["accessors"][0].pop("bufferView")
        ),
        "glb-view-of-4-gigabytes": lambda d: d["bufferViews"][0].update(byteLength=2**32 - 1),
        "glb-of-50000-targets": lambda d: _with_targets(d, 50_000),
        "glb-of-lists": lambda d: d.update(extras=[[]] * 10**6),
    }
    claims = {}
    for name, change in changes.items():
        save_character(character, work / f"{name}.glb")
        glb = Glb.read(work / f"{name}.glb")
        change(glb.document)
        (work / f"{name}.glb").write_bytes(glb.to_bytes())
        claims[name] = lambda name=name: load_character(work / f"{name}.glb")
    sparse = work / "glb-of-a-terabyte.glb"
    save_character(character, sparse)
    with open(sparse, "r+b") as file:
        file.truncate(2**40)
    return claims | {sparse.stem: lambda: load_character(sparse)}


def _with_targets(document: dict[str, Any], count: int) -> None:
    mesh = document["meshes"][0]
    mesh["primitives"][0]["targets"] = [{}] * count
    mesh["extras"]["targetNames"] = [f"t{n}" for n in range(count)]


def _packs(work: Path) -> list[tuple[str, Callable[[], Any]]]:
    many = {"expressions": [f"e{n}" for n in range(4096)]}
    calls = []
    for name, meshes, change in (
        ("pack-16384-square", False, lambda document: _with_sizes(document, 16384, 16384)),
        ("pack-4096-weight-maps", False, lambda document: _with_sizes(document | many, 9000, 1024, weight_columns=64)),
        ("pack-2^24-vertices", True, lambda document: document["geometry"].update(vertices=2**24, triangles=2**24)),
        ("pack-manifest-of-empty-lists", False, lambda document: document.update(surprise=[[]] * 300_000)),
        ("pack-of-8-exabytes", False, lambda document: document["files"]["weights.1001.png"].update(bytes=2**63)),
    ):
        pack = work / f"{name}.facezip"
        write_pack(random_model(meshes=meshes), pack)
        document = json.loads((pack / MANIFEST).read_bytes())
        sign(pack, change(document) or document)
        calls.append((name, lambda pack=pack: read_pack(pack)))
    pack = work / "pack-of-4096-masks.facezip"
    write_pack(masked(random_model()), pack)
    document = json.loads((pack / MANIFEST).read_bytes())
    document["masks"]["names"] = [f"m{k}" for k in range(4096)]
    sign(pack, _with_sizes(document, 9000, 1024, weight_columns=32))
    calls.append((pack.stem, lambda: read_pack(pack)))
    sparse = work / "pack-manifest-of-a-terabyte.facezip"
    write_pack(random_model(), sparse)
    with open(sparse / MANIFEST, "r+b") as file:
        file.truncate(2**40)
    return [*calls, (sparse.stem, lambda: read_pack(sparse))]


def _with_sizes(document: dict[str, Any], size: int, weight_size: int, **changes: Any) -> dict[str, Any]:
    """The manifest, with other sizes stated of its textures and weight maps."""
    tile = document["tiles"][0]
    tile |= {"weight_size": [weight_size, weight_size], **changes}
    tile["textures"][0]["size"] = [size, size]
    return document


def sign(pack: Path, changes: dict[str, Any]) -> None:
    """Change fields of a manifest and give it the checksum that it should have: what only an attacker does."""
    document = json.loads((pack / MANIFEST).read_bytes()) | changes | {"sha256": "0" * 64}
    blank = json.dumps(document, indent=1, ensure_ascii=False).encode() + b"\n"
    (pack / MANIFEST).write_bytes(blank.replace(b"0" * 64, sha256(blank).hexdigest().encode(), 1))


def _character_of_bombs(folder: Path) -> Callable[[], Any]:
    """Five hundred images, each of them just below what one image may unfold to."""
    save_character(random_character(side=16, grid=3, expressions=2), folder)
    (folder / "neutral.png").write_bytes(_png(8192, 8192, _zeros(8192 * (3 * 8192 + 1))))
    for n in (*range(500), "xpr_0", "xpr_1"):
        for suffix in (".obj", ".png"):
            (folder / f"e{n}{suffix}").unlink(missing_ok=True)
            (folder / f"e{n}{suffix}").symlink_to(folder / f"neutral{suffix}")
    return lambda: load_character(folder)


def _verdict(read: Callable[[], Any]) -> tuple[str, float]:
    """What was wrong with the refusal, and the seconds of processor time that it took."""
    start = time.process_time()
    try:
        read()
        fault = "accepted"
    except FaceZipError:
        fault = ""
    except BaseException as error:
        fault = f"other exceptions: {error!r}"
    return fault, time.process_time() - start


def _zeros(count: int) -> bytes:
    """So many zero bytes, as deflate makes them small: one block of them, again and again."""
    size = 2**20
    packer = zlib.compressobj(9, wbits=-15)
    block = packer.compress(bytes(size)) + packer.flush(zlib.Z_FULL_FLUSH)
    rest = packer.compress(bytes(count % size)) + packer.flush()
    checksum = (count % 65521) << 16 | 1
    return b"\x78\xda" + block * (count // size) + rest + checksum.to_bytes(4, "big")


def _png(
    width: int, height: int, data: bytes, bits: int = 8, colour: int = 2, chunks: Sequence[tuple[bytes, bytes]] = ()
) -> bytes:
    header = struct.pack(">IIBBBBB", width, height, bits, colour, 0, 0, 0)
    every = [(b"IHDR", header), *chunks, *([(b"IDAT", data)] if data else []), (b"IEND", b"")]
    packed = [struct.pack(">I", len(d)) + kind + d + struct.pack(">I", zlib.crc32(kind + d)) for kind, d in every]
    return b"\x89PNG\r\n\x1a\n" + b"".join(packed)


def _tiff(tags: dict[int, int]) -> bytes:
    entries = b"".join(
        struct.pack("<HHII", tag, 4, 1, value) for tag, value in sorted(tags.items() | {(262, 2), (259, 1)})
    )
    return b"II*\0\x08\0\0\0" + struct.pack("<H", len(tags) + 2) + entries + b"\0" * 64


def _bmp(side: int) -> bytes:
    head = struct.pack("<IiiHHIIiiII", 40, side, side, 1, 24, 0, 0, 0, 0, 0, 0)
    return b"BM" + struct.pack("<IHHI", 64, 0, 0, 54) + head + bytes(64)


def _webp(side: int) -> bytes:
    """A lossless picture of such sides, of which a few bytes are there."""
    picture = b"\x2f" + struct.pack("<I", (side - 1) | (side - 1) << 14) + bytes(60)
    chunk = b"VP8L" + struct.pack("<I", len(picture)) + picture + bytes(len(picture) % 2)
    return b"RIFF" + struct.pack("<I", 4 + len(chunk)) + b"WEBP" + chunk


def _exr(low: int, high: int, tile: int = 0, text: int = 0) -> bytes:
    window = struct.pack("<iiii", low, low, high, high)
    channel = b"".join(name + struct.pack("<iiii", 1, 0, 1, 1) for name in (b"B\0", b"G\0", b"R\0"))
    attributes = [
        (b"channels", b"chlist", channel + b"\0"), (b"compression", b"compression", b"\x03"),
        (b"dataWindow", b"box2i", window), (b"displayWindow", b"box2i", window), (b"lineOrder", b"lineOrder", b"\0"),
        (b"pixelAspectRatio", b"float", struct.pack("<f", 1)), (b"screenWindowCenter", b"v2f", bytes(8)),
        (b"screenWindowWidth", b"float", struct.pack("<f", 1)),
    ]  # fmt: skip
    if tile:
        attributes.append((b"tiles", b"tiledesc", struct.pack("<IIB", tile, tile, 0)))
    packed = b"".join(name + b"\0" + kind + b"\0" + struct.pack("<i", len(v)) + v for name, kind, v in attributes)
    if text:
        packed += b"owner\0string\0" + struct.pack("<i", text)
    return b"v/1\x01" + struct.pack("<I", 2 | (0x200 if tile else 0)) + packed + b"\0" + bytes(64)
