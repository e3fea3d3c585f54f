"""Where these measurements agree with what the paper states, and where they do not: words made of the numbers alone."""

import numpy as np
from scipy.stats import spearmanr

from reports.findings import Finding, Stance
from reports.metrics import number
from reports.paper.documents.figures import TableRow
from reports.paper.documents.paper import PaperDocument

AGREES: Stance = "agrees"
DIFFERS: Stance = "differs"
BEYOND: Stance = "beyond"
# A start has converged when a sweep lowers its cost by less than this share.
STILL = 1e-3
# A gap between cost and lower bound that is rounding alone.
CLOSED = 1e-6


def find(document: PaperDocument) -> list[Finding]:
    """Every finding of a document of :func:`reports.paper.reproduction.reproduce`."""
    makers = (
        _against_pca, _permutation, _without, _refined, _sweeps, _search, _optimised, _masks, _cost_and_error,
        _memory, _time,
    )  # fmt: skip
    return [finding for finding in (make(document) for make in makers) if finding is not None]


def _finding(key: str, title: str, claim: str, here: str, agrees: bool | None = None) -> Finding:
    stance = BEYOND if agrees is None else AGREES if agrees else DIFFERS
    return Finding(key=key, title=title, claim=claim, here=here, stance=stance)


def _against_pca(document: PaperDocument) -> Finding:
    wins, count, means = _wins(document, "paper", "pca_4")
    return _finding(
        "paper_against_pca_4",
        "The paper’s method against PCA(4)",
        "It has the lowest error of all in every expression.",
        f"Its error is lower in {wins} of {count} expressions. {means}",
        wins == count,
    )


def _permutation(document: PaperDocument) -> Finding:
    wins, count, means = _wins(document, "paper", "paper_unpermuted")
    return _finding(
        "permutation",
        "What the permutation gains",
        "With it the error is constantly smaller than without.",
        f"It lowers the error in {wins} of {count} expressions. {means}",
        wins == count,
    )


def _without(document: PaperDocument) -> Finding:
    wins, count, means = _wins(document, "paper_unpermuted", "pca_4")
    return _finding(
        "unpermuted_against_pca_4",
        "Without permutation against PCA(4)",
        "Even without it the method is generally better than PCA.",
        f"Its error is lower in {wins} of {count} expressions. {means}",
        2 * wins > count,
    )


def _refined(document: PaperDocument) -> Finding:
    wins, count, means = _wins(document, "refined", "paper")
    below, _, _ = _wins(document, "refined", "pca_8")
    row = _reference(document)
    same = row.bytes_on_gpu["refined"] == row.bytes_on_gpu["paper"]
    return _finding(
        "refined",
        "The same textures, fitted better",
        "",
        f"Refined, in the paper’s format{' and bytes' if same else ''} with {row.fetches['refined']} fetches a "
        f"pixel, is below the paper in {wins} of {count} expressions and below PCA(8) in {below}. {means}",
    )


def _wins(document: PaperDocument, one: str, other: str) -> tuple[int, int, str]:
    """In how many expressions ``one`` is lower, of how many, and a sentence with both means."""
    figure = document.figure_6
    errors = figure.rmse_per_expression
    wins = sum(errors[one][name] < errors[other][name] for name in errors[one])
    mean, against = figure.rmse[one], figure.rmse[other]
    sentence = f"Mean RMSE {number(mean, 2)} against {number(against, 2)}: {_compared(mean, against)}."
    return wins, len(errors[one]), sentence


def _sweeps(document: PaperDocument) -> Finding:
    history = np.array(document.figure_7_convergence.history)
    gains = ((history[:, :-1] - history[:, 1:]) / np.maximum(history[:, :-1], 1e-300)).max(axis=0)
    moving = np.flatnonzero(gains > STILL)
    last = int(moving[-1]) + 1 if len(moving) else 0
    return _finding(
        "sweeps",
        "Sweeps until the search rests",
        "Ten sweeps reach convergence.",
        f"After sweep {last} no start of {len(history)} lowers its cost by more than {_share(STILL)} a sweep.",
        last < history.shape[1] - 1,
    )


def _search(document: PaperDocument) -> Finding:
    figure = document.figure_7_convergence
    final = np.array(figure.history)[:, -1]
    here = f"The starts end between {number(final.min(), 2)} and {number(final.max(), 2)}. "
    ours, bound = figure.cost.get("paper_optimised"), figure.lower_bound
    if ours is not None:
        seconds = figure.seconds
        here += (
            f"Our search ends at {number(ours, 2)}, {_compared(ours, final.min())} than the best of them, in "
            f"{_seconds(seconds['paper_optimised'])} against {_seconds(seconds['paper'])}. "
        )
    if bound is not None:
        best = min(final.min(), ours if ours is not None else np.inf)
        gap = 1 - bound / max(best, 1e-300)
        rest = "that is the optimum" if gap < CLOSED else f"at most {_share(gap)} is left to gain"
        here += f"No permutation is below {number(bound, 2)}: {rest}."
    return _finding(
        "search",
        "How near to the optimum",
        "A near-optimal permutation is left to future work.",
        here.strip(),
    )


def _optimised(document: PaperDocument) -> Finding | None:
    if "paper_optimised" not in document.figure_6.rmse:
        return None
    wins, count, means = _wins(document, "paper_optimised", "paper")
    below, _, against = _wins(document, "paper_optimised", "pca_4")
    return _finding(
        "optimised",
        "What a better permutation gains",
        "",
        f"With ours the paper’s method has a lower error in {wins} of {count} expressions. {means} "
        f"Below PCA(4) it is in {below}. {against}",
    )


def _masks(document: PaperDocument) -> Finding | None:
    figure, chosen = document.figure_7_masks, document.conditions.masks
    least = {row.masks: min(row.rmse) for row in figure.counts}
    if chosen not in least or max(least) == chosen:
        return None
    best = min(least, key=least.__getitem__)
    return _finding(
        "masks",
        "The number of masks",
        "The least error falls with their number up to 53, then no longer: too many permutations to search.",
        f"The least error over {figure.starts} starts is lowest with {best} masks: {number(least[best], 2)}, "
        f"against {number(least[chosen], 2)} with {chosen}. From {min(least)} to {max(least)} masks it moves between "
        f"{number(min(least.values()), 2)} and {number(max(least.values()), 2)}.",
        best <= chosen,
    )


def _cost_and_error(document: PaperDocument) -> Finding | None:
    ranks = [
        float(spearmanr(row.costs, row.rmse).statistic)
        for row in document.figure_7_masks.counts
        if len({*row.costs}) > 2 and len({*row.rmse}) > 2
    ]
    if not ranks:
        return None
    return _finding(
        "cost_and_error",
        "Whether a lower cost is a lower error",
        "",
        "Over the starts of one number of masks, the rank correlation of stitching cost and error lies between "
        f"{min(ranks):.2f} and {max(ranks):.2f}, {sum(ranks) / len(ranks):.2f} in the mean of {len(ranks)} numbers of "
        "masks; 1 would mean that the cost tells which permutation is better.",
    )


def _memory(document: PaperDocument) -> Finding | None:
    published = {tuple(row.resolution): row.megabytes for row in document.published.table_1}
    gaps = [
        abs(row.bytes_on_gpu_of_51[name] / 1e6 / value - 1)
        for row in document.table_1
        for name, value in published.get(tuple(row.resolution), {}).items()
    ]
    if not gaps or document.character.channels != 3 or len(document.character.tiles) > 1:
        return None
    return _finding(
        "memory",
        "GPU memory",
        "Table 1 states it for four ways of storing 51 expressions.",
        f"Computed for as many, {len(gaps)} of its figures are met within {_share(max(gaps), 2)}.",
        max(gaps) < 0.005,
    )


def _time(document: PaperDocument) -> Finding:
    row = document.table_1[-1]
    seconds, side = row.seconds, row.resolution[1]
    dearest = max(("masks", "clustering", "stitching", "factorisation"), key=seconds.__getitem__)
    here = (
        f"At {side}² the method takes {_seconds(seconds['paper'])}, most of it {dearest} "
        f"({_share(seconds[dearest] / seconds['paper'])}); refined takes {_seconds(seconds['refined'])}."
    )
    for other in document.published.table_1:
        if other.resolution == row.resolution:
            here += f" The paper states {_seconds(other.seconds['paper'])} on its own machine."
    claim = "The permutation takes most of the time, eight to ten times that of the clustering."
    return _finding("time", "Where the time goes", claim, here, dearest == "stitching")


def _reference(document: PaperDocument) -> TableRow:
    """The row of Table 1 at the size of the figures."""
    size = document.figure_6.resolution
    return next(row for row in document.table_1 if row.resolution == size)


def _compared(value: float, against: float) -> str:
    ratio = value / max(against, 1e-300)
    return f"{_share(abs(1 - ratio))} {'lower' if ratio <= 1 else 'higher'}"


def _share(share: float, digits: int = 1) -> str:
    return f"{share:.{digits}%}".replace("%", "\N{NO-BREAK SPACE}%")


def _seconds(seconds: float) -> str:
    amount = f"{seconds:,.0f}" if seconds >= 100 else number(seconds, 2 if seconds < 1 else 1)
    return f"{amount}\N{NO-BREAK SPACE}s"
