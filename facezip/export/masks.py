"""Fixed masks that weight maps are sums of, as a pre-pass takes them: K masks in the place of N weight maps.

On the CPU a blend β sums c = Σ_n β_n a_n, numbers that do not grow with N; the pre-pass sums W_i = Σ_k c_ki M_k.
"""

from base64 import b64encode
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from facezip.export.documents.textures import ExportedMasks
from facezip.pack.footprint import SLOTS_PER_LAYER

FILE_NAME = "masks.png"
# The longest array of vectors that every engine hands to a shader, Unity's.
MOST_VECTORS = 1023


@dataclass(frozen=True, eq=False)
class Masks:
    """The masks of a tile.

    Attributes
    ----------
    names : K of them.
    image : the bytes of the pack's PNG, an atlas of masks by four.
    columns : fours a row of the atlas.
    size : rows and columns of a mask.
    vectors : ``(N, L, K', 4)`` float16, as of :attr:`facezip.pack.masked.MaskedWeights.vectors`.
    clamped : whether all activations lie in 0..1.
    """

    names: tuple[str, ...]
    image: bytes
    columns: int
    size: tuple[int, int]
    vectors: NDArray[np.float16]
    clamped: bool

    @property
    def fours(self) -> int:
        """Places of the atlas that are taken."""
        return self.vectors.shape[2] // SLOTS_PER_LAYER

    @property
    def count(self) -> int:
        """L · K': vectors of four activations that the pre-pass takes of a blend."""
        return self.vectors.shape[1] * self.vectors.shape[2]

    def write(self, folder: Path) -> ExportedMasks:
        """Write the image, and say what a document says of masks."""
        (folder / FILE_NAME).write_bytes(self.image)
        return ExportedMasks(
            file=FILE_NAME,
            columns=self.columns,
            size=self.size,
            names=self.names,
            clamped=self.clamped,
            vectors=self.count,
            activations=b64encode(self.vectors.astype("<f2").tobytes()).decode("ascii"),
        )
