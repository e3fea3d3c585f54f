"""Smooth masks on the face: Poisson-disk samples and biharmonic functions between them (paper §3.1, Figure 4)."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.ndimage import distance_transform_edt
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import splu

from facezip.character.maps import Key
from facezip.character.raster import Raster, rasterise
from facezip.character.scans import Character, Stack
from facezip.errors import ErrorCode, FaceZipError
from facezip.machine import memory
from facezip.machine.kernels import kernel
from facezip.machine.rows import by_rows, map_rows

# A biharmonic function rings over the whole face. The paper's masks are zero outside their fragment: rings of less
# than one grey level are dropped, together with the negative lobes.
RINGING = 1 / 255


class MaskLookup(NamedTuple):
    """What a kernel reads of masks, by :func:`masks_at`.

    Attributes
    ----------
    first, active, values : as in :class:`Masks`.
    face : ``(H, W)``, the triangle under each texel, -1 for none.
    barycentric : ``(H, W, 3)``, where it lies in that triangle.
    faces : ``(F, 3)``, the triangles' vertices.
    """

    first: NDArray[np.int64]
    active: NDArray[np.int32]
    values: NDArray[np.float32]
    face: NDArray[np.int32]
    barycentric: NDArray[np.float32]
    faces: NDArray[np.int32]


@dataclass(frozen=True, eq=False)
class Masks:
    """K masks that sum to one on the face region and are zero elsewhere.

    Never held at full resolution: a kernel reads the few masks that are active on a triangle and interpolates them.

    Attributes
    ----------
    samples : ``(K,)`` vertex indices of the Poisson-disk samples.
    values : ``(V, K)`` float32, φ at the vertices, before normalisation in UV space.
    raster : the triangle under each texel; texels beside the chart look at the nearest one.
    first, active : the masks that are not zero on triangle f are ``active[first[f]:first[f + 1]]``, ascending.
    """

    samples: NDArray[np.int64]
    values: NDArray[np.float32]
    raster: Raster
    first: NDArray[np.int64]
    active: NDArray[np.int32]

    @property
    def count(self) -> int:
        """The number K of masks."""
        return len(self.samples)

    @property
    def lookup(self) -> MaskLookup:
        """The masks as kernels read them."""
        raster = self.raster
        return MaskLookup(self.first, self.active, self.values, raster.face, raster.barycentric, raster.faces)

    def dense(self, k: int) -> NDArray[np.float32]:
        """Mask ``M_k`` at full resolution, ``(H, W)`` float32 in [0, 1]."""
        total = self.raster.interpolate(self.values.sum(axis=1))
        mask = self.raster.interpolate(np.ascontiguousarray(self.values[:, k]))
        return np.divide(mask, total, out=np.zeros_like(mask), where=total > 0)

    def downsampled(self, scale: int) -> NDArray[np.float32]:
        """All masks at 1/``scale`` of the resolution, ``(K, ceil(H/scale), ceil(W/scale))``.

        Each low-resolution texel averages the part of the face region that it covers; one that covers none of it
        takes its nearest neighbour, so that bilinear sampling does not fade at the region's border.
        """
        height, width = self.raster.face.shape
        h, w = -(-height // scale), -(-width // scale)
        lookup = self.lookup
        blocks: NDArray[np.float32] = memory.empty((h, w, self.count), np.float32)

        def average(top: int, bottom: int) -> None:
            _average_blocks(top, bottom, scale, lookup, blocks)

        map_rows(average, h)
        filled = np.moveaxis(_fill_empty(blocks), 2, 0)
        return by_rows(lambda rows: filled[:, rows], filled.shape, np.float32, axis=1)


def compute_masks(character: Character, count: int, seed: int) -> dict[Key, Masks]:
    """``count`` masks on the character's face region, for each map on each tile, the same for the same seed.

    They live on the mesh, and so are continuous over the borders of tiles and alike at every resolution.

    Raises
    ------
    FaceZipError
        ``TOO_MANY_MASKS``: the region has fewer distinct vertices than masks were asked for.
    """
    neutral, faces = character.meshes.neutral, character.meshes.topology.faces
    # Maps of one size on a tile see the mesh alike.
    places = {key: (key[1], stack.resolution) for key, stack in character.stacks.items()}
    rasters = {place: rasterise(character.chart(place[0]), place[1]) for place in {*places.values()}}
    shown = [face_region(character, stack, rasters[places[key]]) for key, stack in character.stacks.items()]
    region = np.any(shown, axis=0)
    samples = poisson_disk_samples(neutral, region, count, seed)
    values = biharmonic(neutral, faces, region, samples)
    first, active = _active_masks(values, faces)
    masks = {place: Masks(samples, values, raster.dilated(), first, active) for place, raster in rasters.items()}
    return {key: masks[place] for key, place in places.items()}


def face_region(character: Character, stack: Stack, raster: Raster) -> NDArray[np.bool_]:
    """``(V,)``: the vertices of triangles that the stack's mask shows; all vertices of faces without a mask."""
    faces = character.meshes.topology.faces
    shown = np.zeros(len(character.meshes.neutral), bool)
    if stack.mask is None:
        shown[faces] = True
        return shown
    mask = stack.mask

    def visible(top: int, bottom: int) -> NDArray[np.int32]:
        face = raster.face[top:bottom]
        return np.unique(face[(mask[top:bottom] > 0.5) & (face >= 0)])

    for some in map_rows(visible, len(mask)):
        shown[faces[some]] = True
    return shown


def poisson_disk_samples(
    vertices: NDArray[np.float32], region: NDArray[np.bool_], count: int, seed: int
) -> NDArray[np.int64]:
    """``count`` vertices of the region by dart throwing, at the largest radius that admits so many.

    The paper rejects darts within 3 cm and gets 53; asking for the number instead works in any unit.

    Raises
    ------
    FaceZipError
        ``TOO_MANY_MASKS``: the region has fewer distinct vertices than ``count``.
    """
    candidates = np.flatnonzero(region)
    darts = np.random.default_rng(seed).permutation(candidates)
    positions = vertices[darts].astype(np.float64)
    distinct = len(np.unique(positions, axis=0))
    if not 1 <= count <= distinct:
        raise FaceZipError(
            ErrorCode.TOO_MANY_MASKS,
            f"--masks {count}: the face region has {distinct} distinct vertices; ask for 1 to {distinct} masks",
        )
    low, high = 0.0, float(np.linalg.norm(np.ptp(positions, axis=0)))
    for _ in range(40):
        radius = (low + high) / 2
        low, high = (radius, high) if len(_throw_darts(positions, radius, count)) == count else (low, radius)
    samples: NDArray[np.int64] = darts[_throw_darts(positions, low, count)]
    return samples


def biharmonic(
    vertices: NDArray[np.float32], faces: NDArray[np.int32], region: NDArray[np.bool_], samples: NDArray[np.int64]
) -> NDArray[np.float32]:
    """``(V, K)`` functions that minimise ‖Lφ‖², 1 at their own sample and 0 at the others, clamped at zero.

    L is the combinatorial Laplacian of the region's part of the mesh. All functions share one sparse factorisation.
    A part of the region without a sample belongs to the mask of the nearest one.
    """
    laplacian = _laplacian(faces[region[faces].all(axis=1)], len(vertices))
    _, part = connected_components(laplacian)
    sampled = np.isin(part, part[samples])
    free = np.flatnonzero(region & sampled & ~np.isin(np.arange(len(vertices)), samples))
    values = np.zeros((len(vertices), len(samples)), np.float64)
    values[samples, np.arange(len(samples))] = 1
    if len(free):
        system = (laplacian.T @ laplacian).tocsc()
        factors = splu(
            system[free][:, free], permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
        )
        values[free] = factors.solve(-system[free][:, samples].toarray())
    lonely = np.flatnonzero(region & ~sampled)
    distances = np.linalg.norm(vertices[lonely, None] - vertices[samples], axis=2)
    values[lonely, distances.argmin(axis=1)] = 1
    return np.where(values > RINGING, values, 0).astype(np.float32)


def _laplacian(faces: NDArray[np.int32], count: int) -> sparse.csr_matrix:
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    ones = np.ones(2 * len(edges))
    both = (np.r_[edges[:, 0], edges[:, 1]], np.r_[edges[:, 1], edges[:, 0]])
    adjacency = sparse.csr_matrix((ones, both), (count, count))
    adjacency.data[:] = 1
    adjacency.setdiag(0)
    adjacency.eliminate_zeros()
    return (sparse.diags(np.asarray(adjacency.sum(axis=1)).ravel()) - adjacency).tocsr()


def _active_masks(values: NDArray[np.float32], faces: NDArray[np.int32]) -> tuple[NDArray[np.int64], NDArray[np.int32]]:
    positive = sparse.csr_matrix(values > 0)
    corners = [positive[faces[:, j]] for j in range(3)]
    union = (corners[0] + corners[1] + corners[2]).tocsr()
    union.sort_indices()
    return union.indptr.astype(np.int64), union.indices.astype(np.int32)


def _fill_empty(blocks: NDArray[np.float32]) -> NDArray[np.float32]:
    empty = by_rows(lambda rows: blocks[rows].sum(axis=2) == 0, blocks.shape[:2], np.bool_)
    if not empty.any() or empty.all():
        return blocks
    near, beside = distance_transform_edt(empty, return_distances=False, return_indices=True)
    return by_rows(lambda rows: blocks[near[rows], beside[rows]], blocks.shape, np.float32)


@kernel()
def _throw_darts(positions: NDArray[np.float64], radius: float, most: int) -> NDArray[np.int64]:
    accepted = np.empty(most, np.int64)
    count = 0
    for i in range(len(positions)):
        near = False
        for j in range(count):
            d = positions[i] - positions[accepted[j]]
            if d[0] * d[0] + d[1] * d[1] + d[2] * d[2] <= radius * radius:
                near = True
                break
        if not near:
            accepted[count] = i
            count += 1
            if count == most:
                break
    return accepted[:count]


@kernel(inline="always")
def masks_at(lookup: MaskLookup, y: int, x: int, out: NDArray[np.float32]) -> tuple[int, int]:
    """Write the normalised masks of a texel to ``out``; they are those of ``active[begin:end]``."""
    f = lookup.face[y, x]
    if f < 0:
        return 0, 0
    begin, end = lookup.first[f], lookup.first[f + 1]
    a, b, c = lookup.faces[f]
    barycentric, values = lookup.barycentric, lookup.values
    total = np.float32(0)
    for j in range(begin, end):
        k = lookup.active[j]
        value = (
            barycentric[y, x, 0] * values[a, k]
            + barycentric[y, x, 1] * values[b, k]
            + barycentric[y, x, 2] * values[c, k]
        )
        out[j - begin] = value
        total += value
    if total <= 0:
        return 0, 0
    for j in range(end - begin):
        out[j] /= total
    return begin, end


@kernel()
def _average_blocks(
    top: int,
    bottom: int,
    scale: int,
    lookup: MaskLookup,
    blocks: NDArray[np.float32],
) -> None:
    height, width = lookup.face.shape
    mask = np.empty(lookup.values.shape[1], np.float32)
    for by in range(top, bottom):
        for bx in range(blocks.shape[1]):
            total = blocks[by, bx]
            total[:] = 0
            covered = 0
            for y in range(by * scale, min((by + 1) * scale, height)):
                for x in range(bx * scale, min((bx + 1) * scale, width)):
                    begin, end = masks_at(lookup, y, x, mask)
                    covered += end > begin
                    for j in range(begin, end):
                        total[lookup.active[j]] += mask[j - begin]
            if covered:
                total /= covered
