"""The contact sheet of ``facezip check`` for the embedded character, three of whose expressions were moved.

python -m reports.misplaced docs/alignment.webp
"""

import sys
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image
from scipy.ndimage import map_coordinates

from facezip.character.alignment import alignments
from facezip.character.scans import Character
from reports.alignment import write_contact_sheet
from scenes.character import make_character

# How far, in texels.
MOVED = {"funnel": 4.0, "frown": 2.0, "disgust": 1.5}


def misplaced(character: Character) -> Character:
    """An 8-bit character of one tile and one map, its :data:`MOVED` expressions off by smooth fields."""
    ((key, stack),) = character.stacks.items()
    textures = stack.textures.copy()
    for name, texels in MOVED.items():
        textures[character.index(name)] = moved(textures[character.index(name)], texels)
    return replace(character, stacks={key: replace(stack, textures=textures)})


def moved(texture: NDArray[Any], texels: float) -> NDArray[np.uint8]:
    """A texture ``(R, R, C)`` of 8 bits whose places are about ``texels`` off, in directions that turn over it."""
    rows, columns = np.indices(texture.shape[:2])
    height, width = texture.shape[:2]
    places = rows - texels * np.sin(2.5 * columns / width), columns - texels * np.cos(3 * rows / height + 1)
    channels = [
        map_coordinates(channel.astype(np.float32), places, mode="nearest") for channel in np.moveaxis(texture, 2, 0)
    ]
    return np.clip(np.rint(np.stack(channels, axis=2)), 0, 255).astype(np.uint8)


if __name__ == "__main__":
    shown = misplaced(make_character())
    with TemporaryDirectory() as folder:
        sheet = Path(folder) / "sheet.png"
        write_contact_sheet(sheet, shown, alignments(shown))
        Image.open(sheet).convert("RGB").save(Path(sys.argv[1]), quality=85, method=6)
