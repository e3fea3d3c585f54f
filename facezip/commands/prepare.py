"""``python -m facezip.commands.prepare``: compile what the usual commands need, once; setting up runs it.

Each command compiles what it lacks at its first run, too, and keeps it; after this it need not.
"""

from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from facezip.character.loading import save_character
from facezip.character.scans import Character
from facezip.files.images import as_texels, to_float
from facezip.fit.pipeline import Request, compress_into

# As few texels and expressions as compile the same kernels as any number.
TEXELS, EXPRESSIONS = 64, 3


def main() -> None:
    """Compress, and render, a tiny character of 16 and of 8 bits, with one map and with several."""
    from render.candidates import candidate
    from render.settings import Settings
    from render.validation import validate
    from scenes.character import make_character
    from scenes.face.capture import MAPS

    print("Preparing kernels (once)", flush=True)
    made = make_character(TEXELS, EXPRESSIONS, maps=MAPS[:2])
    with TemporaryDirectory(prefix="facezip-") as place:
        for name, character in (("words", of_type(made, np.uint16)), ("bytes", of_type(made, np.uint8))):
            work = Path(place) / name
            save_character(character, work / "character")
            compress_into(work / "character", work / "tiny.facezip", Request())
            (work / "report").mkdir()
            validate(
                character,
                [candidate(character, work / "tiny.facezip")],
                work / "report",
                Settings(resolution=32, spp=2),
            )


def of_type(character: Character, dtype: type[np.uint8] | type[np.uint16]) -> Character:
    """The same textures, all of 8 bits or all of 16."""
    stacks = {
        key: replace(
            stack,
            neutral=as_texels(to_float(stack.neutral), np.dtype(dtype)),
            textures=as_texels(to_float(stack.textures), np.dtype(dtype)),
        )
        for key, stack in character.stacks.items()
    }
    return replace(character, stacks=stacks)


if __name__ == "__main__":
    main()
