"""Which file of a folder is which map of which expression on which tile: by custom, or as ``character.toml`` says."""

import re
import tomllib
from collections.abc import Collection, Iterator
from dataclasses import dataclass, field, fields
from difflib import get_close_matches
from pathlib import Path
from typing import Any

from facezip.character.maps import ALBEDO, ENCODINGS, KNOWN, Map, is_map_name
from facezip.character.placement import Placement
from facezip.character.scans import NEUTRAL
from facezip.character.tiles import FIRST_TILE
from facezip.errors import ErrorCode, FaceZipError
from facezip.files.opening import TEXTURE_SUFFIXES
from facezip.files.reading import reading

SETTINGS = "character.toml"
MASK = "mask"
# What a folder of scans has not, and a pack has.
MANIFEST = "manifest.json"
MAX_SETTINGS = 2**20
# What it says of how the meshes stand, and not of which files there are.
PLACEMENT = {field.name for field in fields(Placement)}

# What stands behind an expression's name in the name of its texture.
_BEHIND = re.compile(r"(?P<name>.+?)(\.(?P<map>" + "|".join(KNOWN) + r"))?(\.(?P<tile>1\d{3}))?", re.DOTALL)
_PLACES = {"{name}": r"[^/]+?", "{tile}": r"1\d{3}"}


@dataclass(frozen=True)
class MapFiles:
    """How the files of one map are read.

    Attributes
    ----------
    kind : what it holds.
    files : its textures by expression (``neutral`` too) and tile.
    keeps_floats : whether values outside [0, 1] are kept, with their range, instead of refused.
    green_down : whether normals have y down, as Direct3D does.
    """

    kind: Map
    files: dict[tuple[str, int], Path] = field(default_factory=dict)
    keeps_floats: bool = False
    green_down: bool = False


@dataclass(frozen=True)
class Layout:
    """The files of a character.

    Attributes
    ----------
    folder : where they are.
    meshes : by name, ``neutral`` among them.
    maps : albedo first.
    masks : by tile; a tile without one counts wholly.
    """

    folder: Path
    meshes: dict[str, Path]
    maps: tuple[MapFiles, ...]
    masks: dict[int, Path]

    @property
    def expressions(self) -> tuple[str, ...]:
        """Names in their order, without the neutral."""
        return tuple(sorted(name for name in self.meshes if name != NEUTRAL))

    @property
    def tiles(self) -> tuple[int, ...]:
        """UDIM numbers of the neutral's albedo."""
        return tuple(sorted(tile for name, tile in self.maps[0].files if name == NEUTRAL))


def read_layout(folder: Path) -> Layout:
    """The files of a character folder.

    Raises
    ------
    FaceZipError
        ``MISSING_FILE`` for a mesh, or a map of an expression on a tile, that others have; ``BAD_CHARACTER`` for a
        ``character.toml`` that says something else than it may, two files for one texture, or no albedo.
    """
    if not folder.is_dir():
        raise FaceZipError(ErrorCode.MISSING_FILE, f"{folder}: no such folder; give the folder with neutral.obj in it")
    if (folder / MANIFEST).is_file():
        reason = "is a pack; give the folder of scans that it was made of"
        raise FaceZipError(ErrorCode.BAD_CHARACTER, f"{folder}: {reason}")
    with reading(folder):
        stated = _settings(folder)
        layout = _stated(folder, stated) if {*stated} - PLACEMENT else _by_custom(folder)
    _check_complete(layout)
    return layout


def _by_custom(folder: Path) -> Layout:
    meshes = {path.stem: path for path in sorted(folder.glob("*.obj"))}
    _check_meshes(folder, meshes)
    maps: dict[str, MapFiles] = {}
    masks: dict[int, Path] = {}
    for found in _found(folder, {*meshes}):
        name, tile, path = found["name"], int(found["tile"] or FIRST_TILE), found["path"]
        if name == MASK and not found["map"]:
            _put(masks, tile, path)
        elif name in meshes:
            kind = KNOWN[found["map"] or ALBEDO]
            _put(maps.setdefault(kind.name, MapFiles(kind)).files, (name, tile), path)
        elif not name.startswith(MASK):
            raise without_mesh(path, meshes)
    return Layout(folder, meshes, _albedo_first(folder, maps), masks)


def _found(folder: Path, meshes: set[str]) -> Iterator[dict[str, Any]]:
    """The images of a folder: path, name, map and tile. A name that a mesh has is a name, whatever it ends in."""
    for path in sorted(folder.iterdir()):
        if path.suffix.lower() in TEXTURE_SUFFIXES:
            match = _BEHIND.fullmatch(path.stem)
            if path.stem in meshes or match is None:
                yield {"path": path, "name": path.stem, "map": None, "tile": None}
            else:
                yield {"path": path, **match.groupdict()}


def texture_path(folder: Path, name: str) -> Path:
    """The texture of a name in a folder, whatever its suffix; where there is none, what it would be called."""
    found = [folder / f"{name}{suffix}" for suffix in TEXTURE_SUFFIXES if (folder / f"{name}{suffix}").exists()]
    if len(found) > 1:
        raise _second(found[1], found[0])
    return found[0] if found else folder / f"{name}.png"


def without_mesh(texture: Path, meshes: Collection[str]) -> FaceZipError:
    """The error for a texture of none of the meshes; where its name begins like one of theirs, of what follows."""
    owner = max((name for name in meshes if texture.name.startswith(f"{name}.")), key=len, default=None)
    if owner is None:
        match = _BEHIND.fullmatch(texture.stem)
        mesh = texture.with_name(f"{match['name'] if match else texture.stem}.obj")
        return FaceZipError(ErrorCode.MISSING_FILE, f"{mesh}: missing beside its texture; add the mesh or remove it")
    behind = texture.stem.removeprefix(f"{owner}.")
    nearest = _nearest(behind.split("."))
    known = f"there are {', '.join(KNOWN)}, then a UDIM tile such as {FIRST_TILE}"
    remedy = f"call it {owner}.{nearest}{texture.suffix}" if nearest else "rename it"
    return FaceZipError(
        ErrorCode.BAD_CHARACTER,
        f"{texture}: '{behind}' is no map of '{owner}'; {known}; {remedy}, or list it in {SETTINGS} (docs/maps.md)",
    )


def _nearest(parts: list[str]) -> str | None:
    """A map, a tile, or both, in their order, as close as can be to what stands behind a name; None for no idea."""
    tiles = [found[0] for part in parts if (found := re.search(r"1\d{3}", part))]
    maps = [name for part in parts for name in get_close_matches(part.lower(), KNOWN, 1)]
    both = len(tiles) + len(maps) == len(parts) and max(len(tiles), len(maps)) == 1
    return ".".join((*maps, *tiles)) if both else None


def read_placement(folder: Path) -> Placement:
    """What ``character.toml`` in a folder says of axes and unit; nothing where there is none.

    Raises
    ------
    FaceZipError
        ``BAD_CHARACTER`` where it says something else than it may.
    """
    with reading(folder):
        try:
            return Placement.of({key: value for key, value in _settings(folder).items() if key in PLACEMENT})
        except ValueError as error:
            raise FaceZipError(ErrorCode.BAD_CHARACTER, f"{folder / SETTINGS}: {error}") from None


def _settings(folder: Path) -> dict[str, Any]:
    """The entries of ``character.toml``; none where there is no such file."""
    path = folder / SETTINGS
    if not path.is_file():
        return {}
    if path.stat().st_size > MAX_SETTINGS:
        raise FaceZipError(ErrorCode.TOO_LARGE, f"{path}: larger than {MAX_SETTINGS} bytes")
    try:
        return tomllib.loads(path.read_bytes().decode())
    except (ValueError, RecursionError) as error:
        raise FaceZipError(ErrorCode.BAD_CHARACTER, f"{path}: {error}") from None


def _stated(folder: Path, document: dict[str, Any]) -> Layout:
    path = folder / SETTINGS
    try:
        document = {key: value for key, value in document.items() if key not in PLACEMENT}
        maps = document.pop("maps", {})
        patterns = {"meshes": "{name}.obj", "mask": "mask.png", **document}
        if odd := {*patterns} - {"meshes", "mask"}:
            raise ValueError(f"'{min(odd)}' is not known; it holds meshes, mask, up, front, unit and [maps.NAME]")
        found = {name: _stated_map(folder, name, dict(entry)) for name, entry in maps.items()}
        meshes = {name: file for (name, _), file in _matching(folder, patterns["meshes"]).items()}
        masks = {tile: file for (_, tile), file in _matching(folder, patterns["mask"]).items()}
    except (ValueError, TypeError, AttributeError, RecursionError) as error:
        raise FaceZipError(ErrorCode.BAD_CHARACTER, f"{path}: {error}") from None
    _check_meshes(folder, meshes)
    for how in found.values():
        # A pattern may catch more than the scans.
        for key in [key for key in how.files if key[0] not in meshes]:
            del how.files[key]
    return Layout(folder, meshes, _albedo_first(folder, found), masks)


def _stated_map(folder: Path, name: str, entry: dict[str, Any]) -> MapFiles:
    known = KNOWN.get(name, Map(name, "data"))
    fields = {"files": None, "encoding": known.encoding, "float": False, "green": "up"}
    if not is_map_name(name):
        raise ValueError(f"a map cannot be called '{name}'; use small letters, digits and _")
    if odd := {*entry} - {*fields}:
        raise ValueError(f"'{min(odd)}' of maps.{name} is not known; it has {', '.join(fields)}")
    fields |= entry
    if (
        fields["encoding"] not in ENCODINGS
        or fields["green"] not in ("up", "down")
        or type(fields["float"]) is not bool
    ):
        raise ValueError(
            f"maps.{name}: encoding is one of {', '.join(ENCODINGS)}; green is up or down; float is true or false"
        )
    low = -1.0 if fields["encoding"] == "normal" else 0.0
    kind = Map(name, str(fields["encoding"]), low, 1.0)
    files = _matching(folder, fields["files"])
    return MapFiles(kind, files, bool(fields["float"]), fields["green"] == "down")


def _matching(folder: Path, pattern: Any) -> dict[tuple[str, int], Path]:
    """Files by name and tile whose path within the folder is like a pattern with ``{name}`` and ``{tile}``."""
    if not isinstance(pattern, str) or pattern.startswith("/") or ".." in Path(pattern).parts:
        raise ValueError(f"'{pattern}' is no pattern of files in the folder, such as 'albedo/{{name}}.{{tile}}.exr'")
    parts, seen = [], set()
    for part in re.split(r"(\{name\}|\{tile\})", pattern):
        group = part[1:-1]
        if part in _PLACES:
            parts.append(f"(?P={group})" if part in seen else f"(?P<{group}>{_PLACES[part]})")
            seen.add(part)
        else:
            parts.append(re.escape(part))
    like = re.compile("".join(parts))
    found: dict[tuple[str, int], Path] = {}
    for path in sorted(folder.rglob("*" + Path(pattern).suffix)):
        match = like.fullmatch(path.relative_to(folder).as_posix())
        if match is not None:
            groups = match.groupdict()
            _put(found, (groups.get("name", MASK), int(groups.get("tile", FIRST_TILE))), path)
    return found


def _put(files: dict[Any, Path], key: Any, path: Path) -> None:
    if key in files:
        raise _second(path, files[key])
    files[key] = path


def _second(path: Path, beside: Path) -> FaceZipError:
    return FaceZipError(ErrorCode.BAD_CHARACTER, f"{path}: a second texture beside {beside.name}; keep one of them")


def _albedo_first(folder: Path, maps: dict[str, MapFiles]) -> tuple[MapFiles, ...]:
    if ALBEDO not in maps or not any(name == NEUTRAL for name, _ in maps[ALBEDO].files):
        raise FaceZipError(
            ErrorCode.BAD_CHARACTER,
            f"{folder}: no albedo of the neutral; it needs a neutral.png, and every expression a NAME.png",
        )
    return tuple(maps[name] for name in [ALBEDO, *sorted({*maps} - {ALBEDO})])


def _check_complete(layout: Layout) -> None:
    for how in layout.maps:
        for name in (NEUTRAL, *layout.expressions):
            for tile in layout.tiles:
                if (name, tile) not in how.files:
                    raise _missing(layout, how, name, tile)


def _missing(layout: Layout, how: MapFiles, name: str, tile: int) -> FaceZipError:
    """The error for a texture that others have, under the name that it has by custom."""
    behind = "" if how.kind.name == ALBEDO else f".{how.kind.name}"
    number = "" if layout.tiles == (FIRST_TILE,) else f".{tile}"
    file = layout.folder / f"{name}{behind}{number}.png"
    where = f" on tile {tile}" if number else ""
    return FaceZipError(
        ErrorCode.MISSING_FILE,
        f"{file}: missing, there is no {how.kind.name} of '{name}'{where}; add the file or remove {name}'s mesh",
    )


def _check_meshes(folder: Path, meshes: dict[str, Path]) -> None:
    if NEUTRAL not in meshes:
        raise FaceZipError(ErrorCode.MISSING_FILE, f"{folder}: no neutral.obj; a character needs a neutral mesh")
    if len(meshes) < 3:
        raise FaceZipError(
            ErrorCode.TOO_FEW_EXPRESSIONS,
            f"{folder}: {len(meshes) - 1} expression(s); at least two besides the neutral",
        )
