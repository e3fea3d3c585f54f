"""The families of storage that are compared, what is tried of each, and how they look on every figure."""

from collections.abc import Iterator
from dataclasses import dataclass

from facezip.blocks.codecs import ASTC_BLOCKS, astc, bc1, bc4, bc7, raw
from facezip.character.scans import Character
from facezip.fit.storage import Storage
from reports.plots import Mark, dot
from reports.rates.points import Pack, Textures

# Rank, scale, and the codecs of textures and weight maps are chosen together: all of these are tried.
RANKS, SCALES = (4, 6, 8), (4, 8, 16)
RAW_RANKS = (1, 2, 3, 4, 6, 8)
PACK_BLOCKS = ((5, 5), (6, 5), (6, 6), (8, 6), (8, 8), (10, 8), (10, 10), (12, 12))
# Large weight maps of few bits a texel: one channel in ASTC, two thirds and half of what BC4 takes.
FINE_SCALE, FINE_BLOCKS = 4, ((8, 6), (8, 8))
PAPER_RANK, PAPER_SCALE, PCA_RANKS = 4, 8, (4, 6, 8)
# Uncompressed; textures of fewer channels cost no more than those.
RAW = Storage(raw(3))


@dataclass(frozen=True)
class Family:
    """One curve: its key in ``rates.json``, what people read, its colour and the shape of its marks."""

    key: str
    label: str
    tone: str
    shape: str

    @property
    def mark(self) -> Mark:
        """Its mark about the origin, for a legend."""
        return dot((0, 0), self.shape, self.tone)


FAMILIES = {
    family.key: family
    for family in (
        Family("refined_astc", "Refined, ASTC in the loop", "pack-0", "disc"),
        Family("refined_bc", "Refined, BC1 and BC7 in the loop", "pack-0", "open-disc"),
        Family("refined_afterwards", "Refined, ASTC afterwards", "pack-1", "triangle"),
        Family("refined_raw", "Refined, raw", "pack-1", "open-triangle"),
        Family("textures_astc", "Every texture, ASTC", "rival-0", "diamond"),
        Family("textures_bc", "Every texture, BC1 and BC7", "rival-0", "open-diamond"),
        Family("paper", "Paper", "rival-1", "square"),
        Family("pca", "PCA", "rival-2", "open-square"),
    )
}
# What each way to code every texture is compared with: packs of the same codecs.
OURS = {"textures_astc": "refined_astc", "textures_bc": "refined_bc"}


# Storages last: where the codec is not in the loop, those of one rank and scale share a fit.
def tried(character: Character, effort: str) -> list[Textures | Pack]:
    """Everything that is measured on a character; ``effort`` is that of the ASTC encoder, for all alike."""
    count = len(character.expressions)
    smallest = min(min(stack.resolution) for stack in character.stacks.values())
    ways: list[Textures | Pack] = [*_textures(effort), *_baselines(effort), *_refined(effort), *_in_the_loop(effort)]
    return [
        way for way in ways if isinstance(way, Textures) or (way.differences <= count and way.weight_scale <= smallest)
    ]


def _textures(effort: str) -> Iterator[Textures]:
    for codec in (bc1(), bc7()):
        yield Textures("textures_bc", codec)
    for block in ASTC_BLOCKS:
        yield Textures("textures_astc", astc(block, effort))


def _baselines(effort: str) -> Iterator[Pack]:
    for method, ranks in (("paper", (PAPER_RANK,)), ("pca", PCA_RANKS)):
        for rank in ranks:
            for storage in (RAW, *_coded(effort)):
                yield Pack(method, method, rank, PAPER_SCALE, storage)


def _refined(effort: str) -> Iterator[Pack]:
    for rank in RAW_RANKS:
        for scale in SCALES:
            yield Pack("refined_raw", "refined", rank, scale, RAW)
    for scale in (FINE_SCALE, PAPER_SCALE):
        for storage in _coded(effort):
            yield Pack("refined_afterwards", "refined", PAPER_RANK, scale, storage)


def _in_the_loop(effort: str) -> Iterator[Pack]:
    for rank in RANKS:
        for scale in SCALES:
            for storage in (*_coded(effort), *(_fine(effort) if scale == FINE_SCALE else ())):
                family = "refined_astc" if storage.textures.name.startswith("astc") else "refined_bc"
                yield Pack(family, "refined", rank, scale, storage, in_the_loop=True)


def _coded(effort: str) -> Iterator[Storage]:
    for codec in (bc1(), bc7(), *(astc(block, effort) for block in PACK_BLOCKS)):
        yield Storage(codec, bc4())


def _fine(effort: str) -> Iterator[Storage]:
    for block in PACK_BLOCKS:
        for fine in FINE_BLOCKS:
            yield Storage(astc(block, effort), astc(fine, effort, channels=1))
