"""The renderer as a sparse matrix: image = A · texture + specular, both linear, for one pose, view and light.

With direct light an image is affine in the albedo, whatever the other maps of the skin, so all that a camera and a
light do to a texture is in one matrix of pixels x texels and one image. Built from the light paths of the paired
renderer, it gives the same image to rounding, in milliseconds for every further texture; and transposed it says which
texels an image is made of.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from facezip.machine.kernels import inner, kernel
from facezip.machine.rows import map_rows
from render.paired import PairedRenderer, Paths
from render.skins import Skin
from scenes.cameras import View

TAPS = 4
# A sparse matrix of pixels x texels for each colour channel.
Channels = tuple[csr_array, csr_array, csr_array]


@dataclass(frozen=True, eq=False)
class ImageOperator:
    """A and the specular image; one matrix a colour channel, as lights of different colours demand.

    Attributes
    ----------
    channels : three sparse ``(H·W, h·w)`` float32 matrices ≥ 0 with one pattern: the share of every texel's linear
        albedo in a pixel's linear radiance. Rows of pixels without the head are empty.
    specular : ``(H, W, 3)`` float32, the image of a black texture; zero for a diffuse material.
    coverage : ``(H, W)`` float32 in [0, 1], how much of a pixel the head fills.
    texture_size : ``(h, w)``.
    """

    channels: Channels
    specular: NDArray[np.float32]
    coverage: NDArray[np.float32]
    texture_size: tuple[int, int]

    def image(self, texture: NDArray[np.float32]) -> NDArray[np.float32]:
        """A · texture + specular: the renderer's radiance ``(H, W, 3)`` of a linear texture ``(h, w, 3)``."""
        return self.apply(texture) + self.specular

    def apply(self, texture: NDArray[np.float32]) -> NDArray[np.float32]:
        """A · texture: ``(h, w, 3)`` to ``(H, W, 3)``."""
        flat = texture.reshape(-1, 3)
        columns = [matrix @ np.ascontiguousarray(flat[:, c]) for c, matrix in enumerate(self.channels)]
        return np.stack(columns, axis=1).reshape(self.specular.shape)

    def transposed(self, image: NDArray[np.float32]) -> NDArray[np.float32]:
        """Aᵀ · image: ``(H, W, 3)`` to ``(h, w, 3)``."""
        flat = image.reshape(-1, 3)
        columns = [matrix.T @ np.ascontiguousarray(flat[:, c]) for c, matrix in enumerate(self.channels)]
        return np.stack(columns, axis=1).reshape(*self.texture_size, 3)


def image_operator(renderer: PairedRenderer, skin: Skin, view: View, rig: str, spp: int, seed: int) -> ImageOperator:
    """The operator of the pose that the renderer is in, from the random numbers that its ``render`` takes.

    Parameters
    ----------
    renderer : posed.
    skin : of its albedo only the size counts, what textures then are applied to; the other maps are part of the
        operator, which is linear in the albedo alone.
    view, rig, spp, seed : as in :meth:`render.paired.PairedRenderer.render`.
    """
    paths, texture_size = renderer.trace(skin, view, rig, spp, seed), skin.sizes["albedo"]
    black = renderer.render([skin.blackened()], view, rig, spp, seed)
    (channels,) = _matrices(paths, [(paths.diffuse, texture_size)], black.coverage.shape)
    return ImageOperator(channels, black.linear[0], black.coverage, texture_size)


def map_slopes(
    renderer: PairedRenderer, skin: Skin, view: View, rig: str, spp: int, seed: int
) -> dict[str, tuple[Channels, ...]]:
    """What small changes of the maps beside the albedo do to an image, to first order; as :func:`image_operator`.

    Returns
    -------
    By map, for each channel (values; of normals the slopes x/z and y/z), three sparse ``(H·W, h·w)`` matrices, one a
    colour channel, of the map's own size.
    """
    paths, sizes = renderer.trace(skin, view, rig, spp, seed), skin.sizes
    wanted = [(light, sizes[name]) for name, channels in paths.slopes.items() for light in channels]
    found = iter(_matrices(paths, wanted, (renderer.resolution, renderer.resolution)))
    return {name: tuple(next(found) for _ in channels) for name, channels in paths.slopes.items()}


def _matrices(paths: Paths, lights: Sequence[tuple[Any, tuple[int, int]]], image: tuple[int, ...]) -> list[Channels]:
    """A matrix a colour channel of each light per texel, with the size of the texture that the texels are of."""
    import drjit as dr

    dr.eval(paths.uv, paths.head, *(light for light, _ in lights))
    uv, head = np.array(paths.uv), np.array(paths.head)
    # What is the same for all samples is no array of them.
    every = [np.ascontiguousarray(np.broadcast_to(np.array(light), (3, len(head)))) for light, _ in lights]
    return [_matrix(paths, uv, head, light, size, image) for light, (_, size) in zip(every, lights, strict=True)]


def _matrix(
    paths: Paths,
    uv: NDArray[np.float32],
    head: NDArray[np.bool_],
    light: NDArray[np.float32],
    size: tuple[int, int],
    image: tuple[int, ...],
) -> Channels:
    """Of samples ``uv`` ``(2, n)``, ``head`` ``(n,)`` and ``light`` ``(3, n)``."""
    left, top, width, height = paths.window

    def block(first: int, last: int) -> _Entries:
        some = slice(first * width * paths.count, last * width * paths.count)
        return _merge_taps(uv[:, some], head[some], light[:, some], paths.count, *size)

    counts, texels, shares = (np.concatenate(parts) for parts in zip(*map_rows(block, height), strict=True))
    entries = np.zeros(image, np.int64)
    entries[top : top + height, left : left + width] = counts.reshape(height, width)
    starts = np.concatenate([[0], np.cumsum(entries)])
    shape = entries.size, size[0] * size[1]
    red, green, blue = (csr_array((np.ascontiguousarray(share), texels, starts), shape=shape) for share in shares.T)
    return red, green, blue


# Entries in each row, and their columns ``(n,)`` and values ``(n, 3)``.
_Entries = tuple[NDArray[np.int64], NDArray[np.int32], NDArray[np.float32]]


@kernel()
def _merge_taps(
    uv: NDArray[np.float32],
    head: NDArray[np.bool_],
    diffuse: NDArray[np.float32],
    count: int,
    height: int,
    width: int,
) -> _Entries:
    """The rows of a block of pixels: the texels that its samples look up, each once, in ascending order."""
    pixels = len(head) // count
    lengths = np.zeros(pixels, np.int64)
    texels = np.empty(TAPS * len(head), np.int32)
    shares = np.empty((TAPS * len(head), 3), np.float32)
    looked_up = np.empty(TAPS * count, np.int64)
    weights = np.empty((TAPS * count, 3), np.float64)
    end = 0
    for pixel in range(pixels):
        taps = 0
        for sample in range(pixel * count, (pixel + 1) * count):
            if head[sample]:
                _look_up(uv[:, sample], diffuse[:, sample], height, width, looked_up[taps:], weights[taps:])
                taps += TAPS
        begin = end
        for tap in np.argsort(looked_up[:taps], kind="mergesort"):
            if end == begin or texels[end - 1] != looked_up[tap]:
                texels[end] = looked_up[tap]
                shares[end] = 0
                end += 1
            for c in range(3):
                shares[end - 1, c] += weights[tap, c] / count
        lengths[pixel] = end - begin
    return lengths, texels[:end].copy(), shares[:end].copy()


@inner(inline="always")
def _look_up(
    uv: NDArray[np.float32],
    diffuse: NDArray[np.float32],
    height: int,
    width: int,
    texels: NDArray[np.int64],
    weights: NDArray[np.float64],
) -> None:
    """The four texels of a bilinear look-up, in the arithmetic of Dr.Jit's textures, times a sample's light."""
    # One rounding, as of a fused multiplication and addition: doubles hold the product exactly.
    x = np.float32(np.float64(uv[0]) * width - 0.5)
    y = np.float32(np.float64(uv[1]) * height - 0.5)
    column, row = np.floor(x), np.floor(y)
    right, below = x - column, y - row
    for tap in range(TAPS):
        one, two = tap % 2, tap // 2
        at = min(max(int(row) + two, 0), height - 1), min(max(int(column) + one, 0), width - 1)
        share = (right if one else 1 - right) * (below if two else 1 - below)
        texels[tap] = at[0] * width + at[1]
        for c in range(3):
            weights[tap, c] = share * diffuse[c]
