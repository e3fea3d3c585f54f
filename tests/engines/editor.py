"""What Godot's editor does when an export is copied into a project: it imports each image as its ``.import`` file says.

The engine itself has no PNGs at run time: it reads textures in a form of its own (CTEX), and an ``.import`` file says
where that lies.
"""

import struct
from pathlib import Path

import numpy as np
from PIL import Image

L8, RGB8, RGBA8 = 0, 4, 5
FORMATS = {1: L8, 3: RGB8, 4: RGBA8}
PLAIN_IMAGE = 0


def imported(folder: Path, place: str) -> dict[str, bytes]:
    """The files of a folder as they lie in an exported project, by path, under ``place``."""
    files = {}
    for file in sorted(path for path in folder.rglob("*") if path.is_file()):
        path = f"{place}/{file.relative_to(folder).as_posix()}"
        settings = file.with_name(f"{file.name}.import")
        if settings.is_file():
            texture = f".godot/imported/{path.replace('/', '-')}.ctex"
            text = settings.read_text(encoding="utf-8")
            files[f"{path}.import"] = text.replace("[remap]\n", f'[remap]\n\npath="res://{texture}"', 1).encode()
            files[texture] = ctex(np.asarray(Image.open(file)), "mipmaps/generate=true" in text)
        elif file.suffix != ".import":
            files[path] = file.read_bytes()
    return files


def ctex(texels: np.ndarray, with_levels: bool) -> bytes:
    """8-bit texels ``(H, W)`` or ``(H, W, C)`` in the engine's form, lossless, with mip-maps where asked for."""
    texels = texels if texels.ndim == 3 else texels[..., None]
    levels = [texels, *(smaller(texels) if with_levels else ())]
    height, width, channels = texels.shape
    header = struct.pack("<4s4Ii12x", b"GST2", 1, width, height, 0, -1)
    image = struct.pack("<I2H2I", PLAIN_IMAGE, width, height, len(levels) - 1, FORMATS[channels])
    return header + image + b"".join(level.tobytes() for level in levels)


def smaller(texels: np.ndarray) -> list[np.ndarray]:
    """The mip-maps of texels, each the average of the one before, down to one texel."""
    found = []
    while texels.shape[:2] != (1, 1):
        size = [max(side // 2, 1) for side in texels.shape[1::-1]]
        planes = [Image.fromarray(plane).resize(size, Image.Resampling.BOX) for plane in np.moveaxis(texels, 2, 0)]
        texels = np.stack(planes, axis=2)
        found.append(texels)
    return found
