"""Small images that state something about their numbers, for the fuzzer to change."""

import struct
from pathlib import Path

import numpy as np
from PIL import Image

from tests.facezip.files import profiles, stored


def make_statements(folder: Path) -> list[Path]:
    """Profiles, chunks, tags, windows and layers, each in a file of a format that has it."""
    rng = np.random.default_rng(0)
    rgba = rng.integers(0, 256, (12, 10, 4)).astype(np.uint8)
    rgb, halves = np.ascontiguousarray(rgba[..., :3]), (rgba / 255).astype(np.float16)
    profile = profiles.icc(profiles.COLUMNS["Display P3"], [profiles.curve(2.4, 0.9, 0.1, 0.1, 0.04, kind=3)] * 3)
    sampled = profiles.icc(profiles.COLUMNS["Adobe RGB"], [profiles.SRGB_SAMPLED] * 3)
    exif = Image.Exif()
    exif[274] = 6
    exif._ifds[0x8769] = {0xA001: 65535, 0xA005: {1: "R03"}}
    layers = {f"{name}{leaf}": (halves[2:, 3:, c], 1) for name in ("", "diffuse.") for c, leaf in enumerate("RGBA")}
    points = (
        b"chromaticities",
        b"chromaticities",
        struct.pack("<8f", 0.708, 0.292, 0.17, 0.797, 0.131, 0.046, 0.31, 0.33),
    )
    name = b"colorInteropID", b"string", b"lin_ap1_scene"
    contents = {
        "profile.png": stored.png(rgb, [stored.iccp(profile)], [(b"eXIf", stored.exif(7))]),
        "chunks.png": stored.png(rgba, [stored.gama(1.8), stored.chrm((0.7, 0.3), (0.2, 0.8), (0.1, 0), (0.31, 0.33))]),
        "code.png": stored.png(rgb.astype(np.uint16), [(b"cICP", bytes([9, 8, 0, 1]))]),
        "tags.tif": stored.tiff(rgba, 8, 2, [(274, 3, [8]), (338, 3, [1]), (34675, 1, list(sampled))]),
        "primaries.tif": stored.tiff(rgb, 16, 2, [(318, 5, [[3, 9], [3, 9]]), (319, 5, [[k, 9] for k in range(6)])]),
        "white.tif": stored.tiff(rgb[..., :1], 12, 0, order=">"),
        "window.exr": stored.exr(layers, (14, 14), (2, 3, 12, 10), [points]),
        "named.exr": stored.exr({"N.x": layers["R"], "N.y": layers["G"]}, (14, 14), (2, 3, 12, 10), [name]),
        "alpha.tga": stored.tga(rgba, 0x10, 4),
    }  # fmt: skip
    for file, content in contents.items():
        (folder / file).write_bytes(content)
    saved = {
        "camera.jpg": {"exif": exif},
        "profile.jpg": {"icc_profile": sampled},
        "profile.webp": {"icc_profile": profile},
    }
    for file, options in saved.items():
        Image.fromarray(rgb).save(folder / file, **options)
    return [folder / file for file in (*contents, *saved)]
