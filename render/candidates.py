"""What ``validate`` judges: packs, or other characters in their place."""

from pathlib import Path

from facezip.character.loading import load_character
from facezip.character.scans import NEUTRAL, Character
from facezip.errors import ErrorCode, FaceZipError
from facezip.files.packs import is_pack
from facezip.pack.belonging import check_belongs
from facezip.pack.errors import model_errors, texture_errors
from facezip.pack.facts import pack_facts
from facezip.pack.footprint import Footprint, Texture
from facezip.pack.model import CompressedTextures
from facezip.pack.parsing import read_manifest
from facezip.pack.read import read_pack
from facezip.pack.same_neutral import warn_of_another
from render.documents.judged import TextureFacts
from render.staging import Source, staged
from render.validation import Candidate


def candidate(character: Character, path: Path) -> Candidate:
    """A pack, or a second character in its place: textures that another tool made are judged the same way.

    Raises
    ------
    FaceZipError
        What the readers raise, and ``UNKNOWN_NAME`` or ``SIZE_MISMATCH`` where it does not belong to ``character``.
    """
    if not path.exists():
        reason = "no such pack or character; give a NAME.facezip or the folder of a character"
        raise FaceZipError(ErrorCode.MISSING_FILE, f"{path}: {reason}")
    if is_pack(path):
        model = read_pack(path)
        check_belongs(character, model, path)
        warn_of_another(character, model, path)
        facts = pack_facts(path, read_manifest(path))
        errors = model_errors(character, model)
        return Candidate(path.stem, staged(character, texels_of(model)), facts, errors)
    other = load_character(path)
    check_belongs(character, other, path)
    cost = _footprint(other)
    raw, blocks = cost.bytes_raw, cost.bytes_raw_bc7
    costs = TextureFacts(
        bytes_on_gpu=raw, bytes_on_disk=None, bytes_raw=raw, fetches=None, bytes_bc7=blocks, bytes_raw_bc7=blocks
    )
    return Candidate(other.name, staged(character, other.texels), costs, texture_errors(character, other.texels))


def texels_of(model: CompressedTextures) -> Source:
    """The texels of a pack's expressions."""
    return lambda name, key: model.texels({} if name == NEUTRAL else {name: 1.0}, key)


def _footprint(character: Character) -> Footprint:
    """What uncompressed textures cost."""
    tiles = tuple(
        tuple(Texture(*character.stacks[kind.name, tile].neutral.shape) for kind in character.maps)
        for tile in character.tiles
    )
    return Footprint(tiles, ((1, 1),) * len(tiles), 0, len(character.expressions))
