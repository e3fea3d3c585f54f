"""How much of each expression a layer makes, and where on the face."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from facezip.character.maps import ALBEDO
from facezip.character.raster import rasterise
from facezip.character.tiles import shifted
from facezip.pack.masked import STEP
from facezip.pack.model import CompressedTextures
from facezip.pack.sampling import bilinear_grid
from render.regions import NAMES, face_regions

# Statistics need no more texels a side of a tile.
MOST = 512
EVERYWHERE = "whole face"
# How many parts of the face name a layer.
NAMED = 2


@dataclass(frozen=True, eq=False)
class Uses:
    """What layers do, in the albedo.

    Attributes
    ----------
    regions : G names of parts of the face; one where the pack has no mesh.
    squares : ``(N, R, G)``, the sum over a region's texels and channels of (D_i ⊙ U W_in)².
    values : how many values of texels that is over the whole chart.
    masks : ``(K, R, G)``, the same of D_i ⊙ M_k; K = 0 where weight maps are not made of masks.
    """

    regions: tuple[str, ...]
    squares: NDArray[np.float64]
    values: float
    masks: NDArray[np.float64]

    @property
    def levels(self) -> NDArray[np.float64]:
        """``(N, R)``: the root mean square of each layer's part of each expression, of 255."""
        return self.root(self.squares.sum(axis=2))

    def root(self, squares: NDArray[np.float64]) -> NDArray[np.float64]:
        """The root mean square of 255 of sums of squares over the chart."""
        found: NDArray[np.float64] = 255 * np.sqrt(squares / max(self.values, 1))
        return found

    def regions_of(self, squares: NDArray[np.float64]) -> list[tuple[str, float]]:
        """Regions and their shares of ``(G,)`` squares, the largest first, those without any left out."""
        total = squares.sum()
        order = np.argsort(-squares, kind="stable")
        return [(self.regions[g], float(squares[g] / total)) for g in order if squares[g] > 0]

    def name_of(self, layer: int) -> str:
        """The parts of the face that a layer changes most beside what all layers do: ``mouth and eyes``.

        By each part's term in the divergence of the layer's shares from those of all (Kullback & Leibler, On
        Information and Sufficiency, 1951); the largest share counts where there is nothing to tell layers apart.
        """
        sides = [name.removeprefix("left ").removeprefix("right ") for name in self.regions]
        parts = list(dict.fromkeys(sides))
        by_part = np.stack([self.squares[..., [s == part for s in sides]].sum(axis=(0, 2)) for part in parts], axis=1)
        shares = by_part / np.maximum(by_part.sum(axis=1, keepdims=True), 1e-300)
        usual = by_part.sum(axis=0) / max(by_part.sum(), 1e-300)
        score = shares[layer] * np.log(np.maximum(shares[layer], 1e-12) / np.maximum(usual, 1e-12))
        order = np.argsort(-np.round(score, 6) - 1e-9 * shares[layer], kind="stable")
        chosen = [g for g in order[:NAMED] if score[g] > 0] or [int(np.argmax(shares[layer]))]
        return " and ".join(self._with_side(parts[g], layer) for g in chosen)

    def _with_side(self, part: str, layer: int) -> str:
        """``left eye`` where one side has twice of the other or more, else ``eyes``."""
        each = {
            side: self.squares[:, layer, self.regions.index(f"{side} {part}")].sum()
            for side in ("left", "right")
            if f"{side} {part}" in self.regions
        }
        if not each:
            return part
        more, less = sorted(each, key=each.__getitem__, reverse=True)
        return f"{more} {part}" if each[more] >= 2 * each[less] else f"{part}s"


def measure_uses(model: CompressedTextures) -> Uses:
    """Add up what every layer puts on every texel of the albedo, on all tiles."""
    meshes, count = model.meshes, len(model.expressions)
    names = NAMES if meshes else (EVERYWHERE,)
    slots = len(model.parts[ALBEDO, model.tiles[0]].differences)
    squares, values = np.zeros((count, slots, len(names))), 0.0
    masks = np.zeros((len(model.masked.names) if model.masked else 0, slots, len(names)))
    of_triangle = face_regions(meshes.topology, meshes.neutral) if meshes else np.zeros(1, np.int32)
    for tile in model.tiles:
        differences = model.parts[ALBEDO, tile].differences
        step = -(-max(differences.shape[1:3]) // MOST)
        energy = np.square(differences[:, ::step, ::step]).sum(axis=3)
        region = np.zeros(energy.shape[1:], np.int64)
        if meshes:
            face = rasterise(shifted(meshes.topology, tile), region.shape).face
            region = np.where(face >= 0, of_triangle[np.maximum(face, 0)], len(names))
        values += float((region < len(names)).sum()) * differences.shape[3]
        for n in range(count):
            weights = upsampled(model.weights[tile][n], differences.shape[1:3], step)
            for i in range(slots):
                squares[n, i] += _by_region(energy[i] * np.square(weights[..., i]), region, len(names))
        if model.masked:
            _add_masks(model.masked.masks[tile], differences.shape[1:3], energy, region, masks)
    return Uses(tuple(names), squares, values, masks)


def upsampled(maps: NDArray[np.float32], size: tuple[int, int], step: int = 1) -> NDArray[np.float32]:
    """Weight maps ``(h, w, R)`` as the GPU samples them, at every ``step``-th texel of a texture of ``size``."""
    rows, columns = bilinear_grid(size, maps.shape[:2])
    v, u = rows.fraction[::step, None, None], columns.fraction[::step, None]
    mixed = maps[rows.first[::step]] * (1 - v) + maps[rows.second[::step]] * v
    near, far = mixed[:, columns.first[::step]], mixed[:, columns.second[::step]]
    return (near * (1 - u) + far * u).astype(np.float32)


def _add_masks(
    masks: NDArray[np.uint8],
    size: tuple[int, int],
    energy: NDArray[np.float32],
    region: NDArray[np.int64],
    out: NDArray[np.float64],
) -> None:
    step = -(-max(size) // MOST)
    for k, mask in enumerate(masks):
        values = upsampled(STEP * mask[..., None].astype(np.float32), size, step)[..., 0]
        for i, layer in enumerate(energy):
            out[k, i] += _by_region(layer * np.square(values), region, out.shape[2])


def _by_region(values: NDArray[np.float32], region: NDArray[np.int64], count: int) -> NDArray[np.float64]:
    sums = np.bincount(region.ravel(), weights=values.ravel().astype(np.float64), minlength=count + 1)
    return sums[:count].astype(np.float64)
