"""What the paper prints, to stand beside what is measured here."""

from dataclasses import dataclass

MACHINE = "Intel 12600K, Windows 11, Python with scikit-learn"
EXPRESSIONS = 20
# Memory is stated for the 52 meshes that ARKit names: the neutral and 51 expressions.
EXPRESSIONS_IN_MEMORY = 51


@dataclass(frozen=True)
class Published:
    """One row of the paper's Table 1.

    Attributes
    ----------
    seconds : of clustering and stitching, which the paper calls permutation, and of both as ``paper``; it states none
        for masks and factorisation.
    megabytes : GPU memory by method, 1 MB is 10⁶ bytes.
    """

    seconds: dict[str, float]
    megabytes: dict[str, float]


TABLE_1 = {
    512: Published(
        {"clustering": 113, "stitching": 989, "paper": 1102},
        {"raw": 40.89, "pca_4": 3.93, "pca_8": 7.07, "paper": 4.77},
    ),
    1024: Published(
        {"clustering": 347, "stitching": 3447, "paper": 3794},
        {"raw": 163.58, "pca_4": 15.72, "pca_8": 28.30, "paper": 19.07},
    ),
    2048: Published(
        {"clustering": 1714, "stitching": 14502, "paper": 16216},
        {"raw": 654.31, "pca_4": 62.91, "pca_8": 113.24, "paper": 76.28},
    ),
}
