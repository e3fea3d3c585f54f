"""How much memory rendering takes whatever the limit: what the renderer holds cannot wait on a disk."""

from math import prod

from facezip.character.scans import Character
from facezip.character.tiles import Atlas
from facezip.machine import memory
from render.settings import Settings
from render.staging import rendered_maps

FLOAT = 4
# Mitsuba, Dr.Jit and their compiled kernels.
RENDERER = 100_000_000
# Of a sample: its path, and its radiance with each skin.
PATH, RADIANCE = 40, 12
# Copies of the largest map while it is made ready.
COPIES = 5
# The channels of a map as it is rendered; of all others one.
CHANNELS = {"albedo": 3, "normal": 3}


def check_budget(character: Character, skins: int, settings: Settings) -> None:
    """Raise ``BAD_VALUE``, naming the least that works, where a limit of memory has no room for so many skins."""
    maps = [_bytes(character, name) for name in rendered_maps(character)]
    rounds = max(settings.spp // 2, settings.most // 4)
    samples = settings.resolution**2 * rounds * (PATH + RADIANCE * skins)
    memory.check(0, RENDERER + skins * sum(maps) + COPIES * max(maps) + samples)


def _bytes(character: Character, name: str) -> int:
    """Of a map with all tiles in one texture, as floats."""
    sizes = [stack.resolution for stack in character.of_map(name).values()]
    atlas, largest = Atlas.of(character.tiles), (max(size[axis] for size in sizes) for axis in (0, 1))
    return FLOAT * CHANNELS.get(name, 1) * atlas.rows * atlas.columns * prod(largest)
