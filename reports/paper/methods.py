"""The methods that the report compares, by their keys in its JSON, and how they look on every figure."""

from dataclasses import dataclass

from reports.plots import Mark, dot


@dataclass(frozen=True)
class Method:
    """One way to compress.

    Attributes
    ----------
    key : its name in ``report.json``.
    label : as people read it.
    tone : colour variable of the style sheet: ``pack`` for ours, ``rival`` for the paper's.
    shape : of its marks, so that colour alone tells nothing apart.
    """

    key: str
    label: str
    tone: str
    shape: str

    @property
    def mark(self) -> Mark:
        """Its mark about the origin, for a legend."""
        return dot((0, 0), self.shape, self.tone)


METHODS = {
    method.key: method
    for method in (
        Method("refined", "Refined", "pack-0", "disc"),
        Method("paper_optimised", "Paper, our stitching", "pack-1", "triangle"),
        Method("paper", "Paper", "rival-0", "diamond"),
        Method("paper_unpermuted", "Paper without permutation", "rival-0", "open-diamond"),
        Method("pca_4", "PCA(4)", "rival-2", "square"),
        Method("pca_8", "PCA(8)", "rival-2", "open-square"),
        Method("ours", "Refined, geometry-aware weight maps", "pack-0", "disc"),
        Method("naive", "Naive sum of differences", "rival-2", "square"),
        Method("neutral", "Scanned neutral", "rival-2", "open-square"),
    )
}
