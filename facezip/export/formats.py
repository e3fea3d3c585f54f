"""In which files an engine takes textures: PNG, or blocks with mip-maps in DDS or KTX2."""

from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager, nullcontext
from dataclasses import dataclass

from facezip.blocks.basis import uastc
from facezip.blocks.codecs import Codec, bc4, bc5, bc7
from facezip.errors import ErrorCode, FaceZipError
from facezip.export.containers import BLOCK_SIDE, BLOCKS, Levels, Pieces, dds, ktx2
from facezip.export.source import Source

# Size, levels, codec and name of a texture to the content of its file.
Container = Callable[[tuple[int, int], Levels, str, str], Pieces]
# By the number of channels of a texture.
Codecs = Mapping[int, Codec]


@contextmanager
def _by_channels() -> Iterator[Codecs]:
    """What keeps channels best without more bytes: BC7's three pay for each other, those of BC5 and BC4 do not."""
    yield {1: bc4(), 2: bc5(), 3: bc7()}


@contextmanager
def _basis() -> Iterator[Codecs]:
    with uastc() as codec:
        yield dict.fromkeys((1, 2, 3), codec)


@dataclass(frozen=True)
class Format:
    """How textures are stored.

    Attributes
    ----------
    name : of the codec of three channels, as documents state it.
    suffix : of the files; ``{codec}`` is the codec's name.
    container : what makes a file of blocks; None for PNG.
    codecs : opens the codecs of blocks.
    normals_alone : whether its codecs keep normals better where these share with no map.
    halves : whether images of 16 bits are two of 8, the upper bits and the lower, for programs that read no more.
    """

    name: str
    suffix: str
    container: Container | None = None
    codecs: Callable[[], AbstractContextManager[Codecs]] = lambda: nullcontext({})
    normals_alone: bool = False
    halves: bool = False

    def pieces(self, size: tuple[int, int], levels: Levels, codec: str, name: str) -> Pieces:
        """The content of the file of a texture of blocks."""
        if self.container is None:
            raise ValueError(f"{self.name} is no format of blocks")
        return self.container(size, levels, codec, name)

    def suffix_of(self, codec: str) -> str:
        """The suffix of files of a codec."""
        return self.suffix.format(codec=codec)

    def check(self, source: Source) -> None:
        """Raise ``BAD_VALUE`` where a pack's textures cannot be stored so."""
        for sheet in (sheet for tile in source.tiles for sheet in tile.sheets):
            if self.container and any(side % BLOCK_SIDE for side in sheet.size):
                height, width = sheet.size
                raise FaceZipError(
                    ErrorCode.BAD_VALUE,
                    f"{source.path}: textures of {width}x{height}; GPUs take blocks of whole {BLOCK_SIDE} texels a "
                    "side: use --textures png",
                )


PNG = Format("png", ".png")
HALVES = Format("png", ".png", halves=True)
DDS = Format("bc7", ".dds", lambda size, levels, codec, name: dds(size, levels, BLOCKS[codec]), _by_channels, True)
KTX2 = Format("bc7", ".ktx2", lambda size, levels, codec, name: ktx2(size, levels, BLOCKS[codec]), _by_channels, True)
# glTF knows no BC7; its loaders transcode UASTC. The albedo's neutral is also shown on its own, as colour.
BASIS = Format(
    "uastc", ".ktx2", lambda size, levels, codec, name: ktx2(size, levels, BLOCKS[codec], name == "neutral"), _basis
)
