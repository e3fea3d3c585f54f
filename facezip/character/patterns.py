"""Patterns of paths with ``{name}`` and ``{tile}``: which files of a folder are like one, and what they are of."""

import re
from collections.abc import Sequence
from difflib import get_close_matches
from pathlib import Path

from facezip.character.custom import put
from facezip.character.filenames import MASK, TILE, first_tile, tile_number, within
from facezip.character.tiles import FIRST_TILE
from facezip.errors import ErrorCode, FaceZipError
from facezip.names import one_form

_PLACES = {"{name}": r"[^/]+?", "{tile}": TILE}


def matching(folder: Path, files: list[Path], pattern: object) -> tuple[dict[tuple[str, int], Path], bool]:
    """Those of the folder's files whose path is like a pattern, by name and tile; and whether the pattern says tiles.

    Raises
    ------
    ValueError
        It is no pattern, or a tile in a path is none.
    FaceZipError
        ``BAD_CHARACTER``: two files are of one name and tile.
    """
    if not isinstance(pattern, str) or pattern.startswith("/") or ".." in Path(pattern).parts:
        raise ValueError(f"'{pattern}' is no pattern of files in the folder, such as 'albedo/{{name}}.{{tile}}.exr'")
    parts, seen = [], set()
    for part in re.split(r"(\{name\}|\{tile\})", one_form(pattern)):
        group = part[1:-1]
        if part in _PLACES:
            parts.append(f"(?P={group})" if part in seen else f"(?P<{group}>{_PLACES[part]})")
            seen.add(part)
        else:
            parts.append(re.escape(part))
    like = re.compile("".join(parts), re.IGNORECASE)
    matches = [(path, match) for path in files if (match := like.fullmatch(within(folder, path)))]
    numbered, found = "{tile}" in seen, dict[tuple[str, int], Path]()
    first = first_tile(match["tile"] for _, match in matches) if numbered else 1
    for path, match in matches:
        name = match["name"] if "{name}" in seen else MASK
        put(found, (name, tile_number(match["tile"], first) if numbered else FIRST_TILE), path)
    return found, numbered


def matches_nothing(settings: Path, key: str, pattern: str, files: Sequence[Path]) -> FaceZipError:
    """The error for a pattern of ``character.toml`` like which no file is, of the one that is nearest to it."""
    suffix = Path(pattern).suffix.lower()
    there = [within(settings.parent, path) for path in files if path.suffix.lower() == suffix]
    near = get_close_matches(pattern, there, 1, 0.0)
    rest = f"the nearest is {near[0]}" if near else f"no file ends in {suffix or pattern}"
    return FaceZipError(ErrorCode.BAD_CHARACTER, f"{settings}: {key} = '{pattern}' is like no file here; {rest}")
