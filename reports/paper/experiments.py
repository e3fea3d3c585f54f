"""What is measured for Table 1, Figure 6 and the left of Figure 7: RMSE, 0..255, of maps as packs store them."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from facezip.character.scans import Character
from facezip.fit.methods import compress
from facezip.fit.paper.beam import beam_search
from facezip.fit.paper.certificate import certify
from facezip.fit.paper.stitching import Stitching, search, unpermuted
from facezip.pack.errors import mean_rmse
from facezip.pack.footprint import Footprint
from reports.paper.documents.figures import ConvergenceFigure, ErrorFigure, TableRow
from reports.paper.published import EXPRESSIONS_IN_MEMORY
from reports.paper.steps import Clock, Fragments, make_fragments, stored_errors

WEIGHT_SCALE = 8
MASK_COUNTS = (5, 13, 23, 33, 43, 53, 63, 83, 103)
WHOLE = {
    "refined": partial(compress, method="refined", differences=4, weight_scale=WEIGHT_SCALE),
    "pca_4": partial(compress, method="pca", differences=4),
    "pca_8": partial(compress, method="pca", differences=8),
}


@dataclass(frozen=True)
class Settings:
    """What the experiments may be told.

    Attributes
    ----------
    masks : number of masks (53 in the paper).
    restarts : random starts of the paper's search (100).
    starts : random starts measured for each number of masks (1000 in the paper's Figure 7, right).
    mask_counts : those numbers of masks, besides ``masks``.
    seed : of every random choice.
    """

    masks: int = 53
    restarts: int = 100
    starts: int = 20
    mask_counts: tuple[int, ...] = MASK_COUNTS
    seed: int = 0


@dataclass(frozen=True, eq=False)
class Trial:
    """All methods on one character: what Table 1 needs, and what the figures go on with.

    Attributes
    ----------
    fragments : what all stitchings share.
    stitchings : by method.
    search_seconds : of each stitching, by method.
    seconds : of every other step and method.
    errors : RMSE by method and expression.
    footprints : by method.
    """

    fragments: Fragments
    stitchings: dict[str, Stitching]
    search_seconds: dict[str, float]
    seconds: dict[str, float]
    errors: Mapping[str, Mapping[str, float]]
    footprints: dict[str, Footprint]

    @property
    def character(self) -> Character:
        """The character of the trial."""
        return self.fragments.character


def stitch(table: NDArray[np.float64], settings: Settings) -> tuple[dict[str, Stitching], dict[str, float]]:
    """What every search makes of a table of costs, and its seconds, by method."""
    searches: dict[str, Callable[[], Stitching]] = {
        "paper": lambda: search(table, settings.restarts, settings.seed),
        "paper_optimised": lambda: beam_search(table),
        "paper_unpermuted": lambda: unpermuted(table),
    }
    clock, found = Clock(), {}
    for name, run in searches.items():
        with clock.step(name):
            found[name] = run()
    return found, clock.seconds


def run_trial(character: Character, settings: Settings) -> Trial:
    """Compress once by the paper and with every method that shares nothing with it; measure what packs would hold."""
    clock = Clock()
    fragments = make_fragments(character, settings.masks, settings.seed)
    stitchings, search_seconds = stitch(fragments.table, settings)
    with clock.step("factorisation"):
        model = fragments.stitched(stitchings["paper"], WEIGHT_SCALE)
    errors, footprints = {"paper": stored_errors(character, model)}, {"paper": model.footprint}
    for name, fit in WHOLE.items():
        with clock.step(name):
            model = fit(character)
        errors[name], footprints[name] = stored_errors(character, model), model.footprint
    return Trial(fragments, stitchings, search_seconds, {**fragments.seconds, **clock.seconds}, errors, footprints)


def table_1(trial: Trial) -> TableRow:
    """One row: seconds of every step and method, bytes of GPU memory, fetches a pixel, mean RMSE."""
    seconds = trial.seconds
    steps = {
        "masks": seconds["masks"],
        "clustering": seconds["clustering"],
        "stitching": seconds["table"] + trial.search_seconds["paper"],
        "factorisation": seconds["factorisation"],
    }
    return TableRow(
        resolution=trial.character.first.resolution,
        expressions=len(trial.character.expressions),
        seconds={
            **steps,
            "paper": sum(steps.values()),
            "stitching_optimised": seconds["table"] + trial.search_seconds["paper_optimised"],
            **{name: seconds[name] for name in WHOLE},
        },
        bytes_on_gpu=_bytes(trial.footprints, len(trial.character.expressions)),
        bytes_on_gpu_of_51=_bytes(trial.footprints, EXPRESSIONS_IN_MEMORY),
        fetches={name: footprint.fetches for name, footprint in trial.footprints.items()},
        rmse={name: mean_rmse(errors) for name, errors in trial.errors.items()},
    )


def _bytes(footprints: Mapping[str, Footprint], expressions: int) -> dict[str, int]:
    costs = {name: replace(cost, expressions=expressions) for name, cost in footprints.items()}
    return {"raw": costs["paper"].bytes_raw, **{name: cost.bytes_on_gpu for name, cost in costs.items()}}


def figure_6(trial: Trial) -> ErrorFigure:
    """RMSE of every expression and method; the stitchings share masks and clusters."""
    errors = dict(trial.errors)
    for name, stitching in trial.stitchings.items():
        if name not in errors:
            errors[name] = stored_errors(trial.character, trial.fragments.stitched(stitching, WEIGHT_SCALE))
    return ErrorFigure(
        resolution=trial.character.first.resolution,
        rmse={name: mean_rmse(one) for name, one in errors.items()},
        rmse_per_expression=errors,
    )


def figure_7_convergence(trial: Trial) -> ConvergenceFigure:
    """Cost of equation (3) from every random start, sweep by sweep; what every search ends with; a lower bound."""
    clock = Clock()
    with clock.step("lower_bound"):
        bound = certify(trial.fragments.table, trial.stitchings["paper_optimised"]).lower_bound
    certified = {name: replace(stitching, lower_bound=bound) for name, stitching in trial.stitchings.items()}
    return ConvergenceFigure(
        resolution=trial.character.first.resolution,
        masks=trial.fragments.mask_count,
        history=trial.stitchings["paper"].history.tolist(),
        cost={name: stitching.cost for name, stitching in trial.stitchings.items()},
        seconds={**trial.search_seconds, **clock.seconds},
        lower_bound=bound,
        gap={name: stitching.gap for name, stitching in certified.items()},
    )
