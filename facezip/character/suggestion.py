"""A ``character.toml`` for the files in a folder: what can be told of them, and what a person has to fill in."""

import json
from collections import Counter
from pathlib import Path, PurePosixPath

from facezip.character.filenames import within
from facezip.character.maps import ALBEDO, KNOWN
from facezip.character.mesh_names import MESH_SUFFIX, NamedMeshes, named_in, neutral_among, owners_of
from facezip.character.scans import NEUTRAL
from facezip.character.spelled import Spelled, spelled
from facezip.errors import FaceZipError
from facezip.names import folded

# Names of meshes that a person is shown to choose from.
SHOWN = 6


def suggested(folder: Path) -> str:
    """The text of such a file; "" where no textures are called as meshes are.

    Raises
    ------
    FaceZipError
        ``BAD_CHARACTER``: two meshes of one name, or a texture's name that can be taken apart in two ways.
    """
    named = named_in(folder, below=True)
    neutral = _neutral(named)
    owners, _ = owners_of(named, neutral, folder)
    look = spelled(folder, NamedMeshes({owners[folded(name)]: path for name, path in named.items()}, owners))
    if not look.readings:
        return ""
    return "\n".join([*_neutral_lines(named, neutral), *_mesh_lines(folder, named), *_map_lines(look)]) + "\n"


def _neutral(named: dict[str, Path]) -> str | None:
    try:
        return neutral_among(named)
    except FaceZipError:
        # Several may be it.
        return None


def _neutral_lines(named: dict[str, Path], neutral: str | None) -> list[str]:
    if neutral is not None:
        return [] if folded(neutral) == NEUTRAL else [f"neutral = {_quoted(neutral)}"]
    if not named:
        return []
    few = ", ".join([*named][:SHOWN]) + (" …" if len(named) > SHOWN else "")
    return [f'neutral = ""   # fill in the mesh of the face at rest, one of: {few}']


def _mesh_lines(folder: Path, named: dict[str, Path]) -> list[str]:
    patterns = {
        "/".join(part.replace(name, "{name}") if part in (name, path.name) else part for part in parts)
        for name, path in named.items()
        if (parts := PurePosixPath(within(folder, path)).parts)
    }
    usual = len(patterns) != 1 or patterns == {f"{{name}}{MESH_SUFFIX}"}
    return [] if usual else [f"meshes = {_quoted(patterns.pop())}"]


def _map_lines(look: Spelled) -> list[str]:
    """A table for each map, the patterns that most meshes have first; what else there is in remarks."""
    owners: dict[str, set[str]] = {}
    for reading in look.readings.values():
        owners.setdefault(reading.like, set()).add(reading.owner)
    maps = {like: says.map for like, says in look.says.items() if says is not None and not says.guessed}
    spaces = {reading.like for reading in look.readings.values() if reading.space}
    unknown = [like for like in owners if like not in maps and like not in spaces]
    if ALBEDO not in maps.values() and unknown:
        maps[max(unknown, key=lambda like: len(owners[like]))] = ALBEDO
    lines, taken = list[str](), set[str]()
    for like in sorted(owners, key=lambda like: ([*KNOWN, "", None].index(maps.get(like)), -len(owners[like]), like)):
        map, files = maps.get(like), f"files = {_quoted(_pattern(look, like))}"
        if map and map not in taken:
            taken.add(map)
            says = look.says[like]
            lines += ["", f"[maps.{map}]", files, *(['green = "down"'] if says and says.green_down else [])]
        elif like in spaces:
            lines += ["", f"# Colours of another space than sRGB, to be converted first: {_pattern(look, like)}"]
        elif map != "":
            what = f"Another {map}" if map else "Of which map?"
            lines += ["", f"# {what}", f"# [maps.{map or 'NAME'}]", f"# {files}"]
    return lines


def _pattern(look: Spelled, like: str) -> str:
    """A pattern as most of its files are written, with their suffix."""
    alike = ((name, reading.pattern) for name, reading in look.readings.items() if reading.like == like)
    written = Counter(f"{pattern}{PurePosixPath(name).suffix}" for name, pattern in alike)
    return written.most_common(1)[0][0]


def _quoted(text: str) -> str:
    return json.dumps(text, ensure_ascii=False)
