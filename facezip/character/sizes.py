"""Of what size the textures of every map and tile are, by headers alone, and which are placeholders.

Exporters write a texture of one value, of a few texels, for a map that a character does not have. It is that constant.
"""

from dataclasses import dataclass, field
from pathlib import Path

from facezip.character.layout import Layout, MapFiles
from facezip.character.maps import ALBEDO, Key
from facezip.character.notes import Note
from facezip.character.scans import NEUTRAL
from facezip.errors import ErrorCode, FaceZipError, Refuse, raised
from facezip.files.decoding import decoded_bands
from facezip.files.facts import Facts
from facezip.files.reading import check_expansion
from facezip.files.statements import stated
from facezip.machine import memory

# Fifty flat 2048 x 2048 textures are no attack; what unfolds to more has to be in proportion to its files.
SPARE = 2**32
# The side below which a texture is none: too small for weight maps, and for blocks of engines.
LEAST_SIDE = 4

Size = tuple[int, int]


@dataclass(frozen=True)
class Sizes:
    """What headers state.

    Attributes
    ----------
    of : rows and columns of a map on a tile.
    constants : textures of another size and of one value.
    notes : what is done to the numbers of images, and placeholders.
    """

    of: dict[Key, Size] = field(default_factory=dict)
    constants: set[Path] = field(default_factory=set)
    notes: list[Note] = field(default_factory=list)


def read_sizes(layout: Layout) -> Sizes:
    """Sizes of all textures.

    Raises
    ------
    FaceZipError
        ``SIZE_MISMATCH`` for a texture of another size than the neutral's that is no placeholder, or too small;
        ``TOO_LARGE`` where textures unfold out of proportion; and what readers of headers raise.
    """
    sizes = Sizes()
    decoded = stored = row = 0
    for how in layout.maps:
        for tile in layout.tiles:
            facts = {name: stated(how.files[name, tile]) for name in (NEUTRAL, *layout.expressions)}
            height, width = add_size(sizes, layout, how, tile, facts)
            sizes.of[how.kind.name, tile] = height, width
            unfolded = height * width * sum(each.texel_bytes for each in facts.values())
            decoded, row = decoded + unfolded, max(row, unfolded // height)
            stored += sum(each.path.stat().st_size for each in facts.values())
    check_expansion(layout.folder, decoded, stored, SPARE)
    memory.check(row)
    return sizes


def add_size(
    sizes: Sizes, layout: Layout, how: MapFiles, tile: int, facts: dict[str, Facts], refuse: Refuse = raised
) -> Size:
    """The size of a map on a tile, of textures that state ``facts``; what is found on the way goes into ``sizes``."""
    for each in facts.values():
        for words in each.applied(how.kind.encoding == "srgb"):
            sizes.notes.append(layout.note(each.path, words))
    size = _of_most(facts)
    if min(size) < LEAST_SIDE:
        size = _of_albedo(sizes, how, tile, facts, size)
    others = [each for each in facts.values() if each.size != size]
    for each in others:
        if not is_constant(each.path):
            refuse(_differs(each, facts, size))
            continue
        sizes.constants.add(each.path)
        words = f"{words_for(each.size)} of one value; taken for that constant, {words_for(size)}"
        asks = how.kind.name == ALBEDO or len(others) < len(facts)
        sizes.notes.append(layout.note(each.path, words, asks))
    return size


def _of_most(facts: dict[str, Facts]) -> Size:
    """The neutral's size; where that is of one value, the largest of those that are not."""
    sizes = {each.size for each in facts.values()}
    if len(sizes) == 1 or not is_constant(facts[NEUTRAL].path):
        return facts[NEUTRAL].size
    largest_first = sorted(sizes, key=lambda size: size[0] * size[1], reverse=True)
    varied = (
        size for size in largest_first for each in facts.values() if each.size == size and not is_constant(each.path)
    )
    return next(varied, largest_first[0])


def _of_albedo(sizes: Sizes, how: MapFiles, tile: int, facts: dict[str, Facts], size: Size) -> Size:
    """Of a map that is no more than a few texels, the size of the albedo, if there is that."""
    albedo = sizes.of.get((ALBEDO, tile))
    if albedo is None or not all(is_constant(each.path) for each in facts.values()):
        first = facts[NEUTRAL]
        without = "" if how.kind.name == ALBEDO else f", or remove all textures of {how.kind.name}"
        raise FaceZipError(
            ErrorCode.SIZE_MISMATCH,
            f"{first.path}: {words_for(first.size)} texels, too small for a texture; export it in full size{without}",
        )
    return albedo


def _differs(texture: Facts, facts: dict[str, Facts], size: Size) -> FaceZipError:
    like = "the neutral is" if facts[NEUTRAL].size == size else "the others are"
    return FaceZipError(
        ErrorCode.SIZE_MISMATCH,
        f"{texture.path}: {words_for(texture.size)}, {like} {words_for(size)}; export both alike",
    )


def words_for(size: Size) -> str:
    """A size as people write it, columns first."""
    return f"{size[1]}x{size[0]}"


def is_constant(path: Path) -> bool:
    """Whether all texels of an image are alike."""
    first = None
    for _, _, band in decoded_bands(path):
        first = band[:1, :1] if first is None else first
        if not (band == first).all():
            return False
    return True
