"""A character from whatever it is stored in, and back."""

from dataclasses import replace
from pathlib import Path

from facezip.character.appearance import seen
from facezip.character.folder import load_folder, save_folder
from facezip.character.gltf_read import load_gltf
from facezip.character.gltf_write import save_glb
from facezip.character.meshes import check_digits
from facezip.character.notes import say
from facezip.character.placement import placed
from facezip.character.scans import FEWEST, Character, check_names
from facezip.character.settings import read_settings
from facezip.character.sources import gltf_at
from facezip.files.reading import reading
from facezip.names import printable

GLB = ".glb"


def load_character(
    path: str | Path, *, keep_floats: bool = False, maps: tuple[str, ...] | None = None, fewest: int = FEWEST
) -> Character:
    """Read a character with all its maps and tiles: a folder, or one ``.glb`` or ``.gltf`` with named morph targets.

    A folder holds ``neutral.obj`` and ``NAME.obj``, and beside each the albedo, ``NAME.png``. More maps are optional:
    ``NAME.normal.png``, ``NAME.roughness.png``, ``NAME.specular.png``, ``NAME.cavity.png``. UDIM tiles are
    ``NAME.1001.png``, ``NAME.normal.1001.png`` … PNG, TIFF, JPEG and OpenEXR are read. ``mask.png`` limits the face
    region. ``character.toml`` may state other names (docs/maps.md).

    Expressions are in the order of their names. Meshes are turned upright, looking at +z, and brought to the neutral's
    place and size (docs/meshes.md). What was unusual, and what was done about it, is in the character's ``notes``, and
    in the log ``facezip`` as warnings.

    Parameters
    ----------
    path : the folder or file.
    keep_floats : whether floats outside [0, 1] are kept, with their range, instead of refused.
    maps : names of the maps that are wanted, albedo among them; None for all.
    fewest : expressions that there have to be.

    Raises
    ------
    FaceZipError
        One line that names the file: missing partners, too few expressions, textures of another size or type,
        meshes of another topology or UV layout, and everything that the readers of meshes and textures refuse.
    """
    character = read_character(Path(path), keep_floats, maps, fewest)
    say(character.name, character.notes)
    return character


def read_character(
    path: Path, keep_floats: bool = False, maps: tuple[str, ...] | None = None, fewest: int = FEWEST
) -> Character:
    """As :func:`load_character`, without a word in the log."""
    with reading(path):
        gltf = gltf_at(path)
        settings = read_settings(gltf.parent if gltf else path)
        if gltf is None:
            return load_folder(path, settings, keep_floats, maps, fewest)
        name = printable(path.resolve().name if path.is_dir() else path.stem)
        character = load_gltf(gltf, name, settings.part, maps, fewest)
        check_digits(gltf, character.meshes.neutral, character.meshes.topology)
        meshes, notes = placed(character.meshes, character.expressions, settings.placement, path)
        return replace(character, meshes=meshes, notes=(*character.notes, *notes, *seen(character)))


def save_character(character: Character, path: str | Path) -> None:
    """Write a folder, or one ``.glb`` where the path ends so, that :func:`load_character` reads back.

    Textures are PNG; OpenEXR where they are floats; normals PNG of 8 bits, or of 16 where their files had more.

    Raises
    ------
    FaceZipError
        ``UNSAFE_NAME``; ``BAD_VALUE``: a ``.glb`` holds one albedo on one tile; ``CANNOT_WRITE``: something is there
        already, or the disk refuses. Nothing is then written.
    """
    path = Path(path)
    check_names(character.expressions, character.name)
    if path.suffix.lower() == GLB:
        save_glb(character, path)
    else:
        save_folder(character, path)
