"""Patterns of paths with ``{name}`` and ``{tile}``: which files of a folder are like one, and what they are of."""

import re
from pathlib import Path

from facezip.character.custom import put
from facezip.character.filenames import MASK, TILE, first_tile, is_litter, tile_number, within
from facezip.character.tiles import FIRST_TILE
from facezip.names import one_form

_PLACES = {"{name}": r"[^/]+?", "{tile}": TILE}


def files_below(folder: Path) -> list[Path]:
    """All files in a folder and those within it that are a person's."""
    return [path for path in sorted(folder.rglob("*")) if not is_litter(path.relative_to(folder)) and path.is_file()]


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
