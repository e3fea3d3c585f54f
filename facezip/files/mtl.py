"""Which images the materials of OBJ files name: the lines ``map_…`` of the material libraries beside them."""

import re
from collections.abc import Iterator
from pathlib import Path

from facezip.errors import ErrorCode, FaceZipError
from facezip.names import folded

MAX_BYTES = 2**24
# Words that stand between the key and the file: options with one value, with two, and with one to three numbers.
_ONE = {"-blendu", "-blendv", "-boost", "-texres", "-clamp", "-bm", "-imfchan", "-type", "-cc"}
_TWO, _NUMBERS = {"-mm"}, {"-o", "-s", "-t"}
_KEY = re.compile(r"(?:map_\w+|bump|disp|decal|norm|refl)", re.IGNORECASE)
COLOUR = "map_kd"


def images_by_material(folder: Path) -> dict[str, dict[str, str]]:
    """Images that the material libraries of a folder name: by material, the key of each, by its :func:`folded` name.

    Raises
    ------
    FaceZipError
        ``TOO_LARGE``.
    """
    found: dict[str, dict[str, str]] = {}
    for path in sorted(folder.iterdir()):
        if path.suffix.lower() == ".mtl" and path.is_file() and not path.name.startswith("."):
            for material, key, image in read_mtl(path):
                found.setdefault(material, {}).setdefault(folded(image), key)
    return found


def read_mtl(path: Path) -> Iterator[tuple[str, str, str]]:
    """Material, key in small letters, and the name of the image without its folder, of every line that names one.

    Raises
    ------
    FaceZipError
        ``TOO_LARGE``.
    """
    if path.stat().st_size > MAX_BYTES:
        raise FaceZipError(ErrorCode.TOO_LARGE, f"{path}: more than {MAX_BYTES >> 20} MB; a material library has less")
    material = ""
    for line in path.read_bytes().decode("utf-8-sig", "replace").splitlines():
        key, _, rest = line.strip().partition(" ") if " " in line.strip() else line.strip().partition("\t")
        if key.lower() == "newmtl":
            material = rest.strip()
        elif _KEY.fullmatch(key) and (file := _file(rest.strip())):
            yield material, key.lower(), file


def _file(rest: str) -> str:
    """What stands behind the options, without its folder; blanks are a part of it."""
    while rest.startswith("-"):
        option, _, behind = rest.partition(" ")
        words = behind.split()
        if option in _NUMBERS:
            count = next((k for k, word in enumerate(words[:3]) if not _is_number(word)), min(3, len(words)))
        elif option in _ONE | _TWO:
            count = 1 + (option in _TWO)
        else:
            break
        rest = " ".join(behind.split(None, count)[count:]) if count else behind
    return re.split(r"[/\\]", rest)[-1].strip()


def _is_number(word: str) -> bool:
    return re.fullmatch(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", word) is not None
