"""Weight maps that are sums of fixed masks: W_in = Σ_k a_nki M_k, with K masks M and K·R activations a an expression.

Masks are stored once, whatever the number of expressions. A blend β needs no weight map of any expression: the CPU sums
c_ki = Σ_n β_n a_nki, and a pre-pass on the GPU W_i = Σ_k c_ki M_k.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from facezip.machine.kernels import kernel
from facezip.machine.rows import by_rows
from facezip.pack.footprint import SLOTS_PER_LAYER

# Of a byte of a mask.
STEP = np.float32(1 / 255)


@dataclass(frozen=True, eq=False)
class MaskedWeights(Mapping[int, NDArray[np.float32]]):
    """The weight maps ``(N, h, w, R)`` float32 by tile, made of masks when they are asked for.

    Attributes
    ----------
    names : K names of the masks.
    masks : by tile, ``(K, h, w)`` uint8; M_k = byte / 255.
    activations : ``(N, K, R)`` float16, as a pack stores them; for all tiles.

    Raises
    ------
    ValueError
        Masks, names and activations are not as many.
    """

    names: tuple[str, ...]
    masks: Mapping[int, NDArray[np.uint8]]
    activations: NDArray[np.float16]
    _expanded: dict[int, NDArray[np.float32]] = field(init=False, repr=False, default_factory=dict)

    def __post_init__(self) -> None:
        counts = {len(self.names), self.activations.shape[1], *map(len, self.masks.values())}
        if len(counts) > 1:
            raise ValueError(f"masks, their names and their activations are {sorted(counts)}: they must be as many")

    @property
    def clamped(self) -> bool:
        """Whether all activations lie in 0..1, as engines need that clamp them."""
        return bool((self.activations >= 0).all() and (self.activations <= 1).all())

    @property
    def vectors(self) -> NDArray[np.float16]:
        """Activations as a pre-pass takes them: ``(N, L, K', 4)``, of each layer of four slots and mask four numbers.

        K' is K filled up to fours, as masks lie in images; what is filled up is 0.
        """
        count, masks, slots = self.activations.shape
        padded = np.pad(self.activations, ((0, 0), (0, -masks % SLOTS_PER_LAYER), (0, -slots % SLOTS_PER_LAYER)))
        layered = padded.reshape(count, padded.shape[1], -1, SLOTS_PER_LAYER).transpose(0, 2, 1, 3)
        return np.ascontiguousarray(layered)

    def fours(self, tile: int) -> NDArray[np.uint8]:
        """The masks of a tile as images hold them: ``(K' / 4, h, w, 4)``, what is left of the last four 0."""
        masks = self.masks[tile]
        count, height, width = masks.shape

        def rows_of(rows: slice) -> NDArray[np.uint8]:
            padded = np.pad(masks[:, rows], ((0, -count % SLOTS_PER_LAYER), (0, 0), (0, 0)))
            return padded.reshape(-1, SLOTS_PER_LAYER, *padded.shape[1:]).transpose(0, 2, 3, 1)

        shape = -(-count // SLOTS_PER_LAYER), height, width, SLOTS_PER_LAYER
        return by_rows(rows_of, shape, np.uint8, axis=1)

    def combined(self, betas: NDArray[np.float32], tile: int) -> NDArray[np.float32]:
        """The weight map ``(h, w, R)`` of a blend of ``betas`` ``(N,)``, as a pre-pass makes it."""
        mixed = np.einsum("n,nki->ki", betas, self.activations.astype(np.float32))
        return expanded(self.masks[tile], mixed[None])[0]

    def __getitem__(self, tile: int) -> NDArray[np.float32]:
        if tile not in self._expanded:
            self._expanded[tile] = expanded(self.masks[tile], self.activations.astype(np.float32))
        return self._expanded[tile]

    def __iter__(self) -> Iterator[int]:
        return iter(self.masks)

    def __len__(self) -> int:
        return len(self.masks)


def expanded(masks: NDArray[np.uint8], activations: NDArray[np.float32]) -> NDArray[np.float32]:
    """Weight maps ``(N, h, w, R)`` of masks ``(K, h, w)`` and activations ``(N, K, R)``."""
    _, h, w = masks.shape
    count, _, slots = activations.shape

    def rows_of(rows: slice) -> NDArray[np.float32]:
        out = np.zeros((count, rows.stop - rows.start, w, slots), np.float32)
        _expand(rows.start, masks, activations, out)
        return out

    return by_rows(rows_of, (count, h, w, slots), np.float32, axis=1)


@kernel(fastmath={"contract"})
def _expand(top: int, masks: NDArray[np.uint8], activations: NDArray[np.float32], out: NDArray[np.float32]) -> None:
    count, height, width, slots = out.shape
    for y in range(height):
        for x in range(width):
            for k in range(len(masks)):
                value = STEP * np.float32(masks[k, top + y, x])
                if value > 0:
                    for n in range(count):
                        for i in range(slots):
                            out[n, y, x, i] += value * activations[n, k, i]
