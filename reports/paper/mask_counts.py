"""Figure 7, right: the error against the number of masks, from many random starts of the stitching."""

from facezip.character.scans import Character
from facezip.errors import ErrorCode, FaceZipError
from facezip.fit.paper.stitching import Stitching, search
from facezip.machine.progress import track
from facezip.pack.errors import mean_rmse
from reports.paper.documents.figures import Chosen, MaskCount, MasksFigure
from reports.paper.experiments import WEIGHT_SCALE, Settings, Trial, stitch
from reports.paper.steps import Fragments, make_fragments, stored_errors


def figure_7_masks(character: Character, settings: Settings, shared: Trial | None = None) -> MasksFigure:
    """Cost and error of every start and method, by number of masks; numbers too large for the face are left out.

    ``shared`` is a trial of the same character, whose fragments serve again where the number of masks is the same.
    """
    counts = sorted({*settings.mask_counts, settings.masks})
    rows = []
    for count in track(counts, "Numbers of masks", len(counts)):
        fragments = _fragments(character, count, settings, shared)
        if fragments is None:
            break
        rows.append(_starts(fragments, settings))
    return MasksFigure(resolution=character.first.resolution, starts=settings.starts, counts=rows)


def _fragments(character: Character, count: int, settings: Settings, shared: Trial | None) -> Fragments | None:
    if shared is not None and count == settings.masks:
        return shared.fragments
    try:
        return make_fragments(character, count, settings.seed)
    except FaceZipError as error:
        if error.code is ErrorCode.TOO_MANY_MASKS:
            return None
        raise


def _starts(fragments: Fragments, settings: Settings) -> MaskCount:
    """Single random starts, each taken to its end, and what each method chooses."""

    def judged(stitching: Stitching) -> Chosen:
        errors = stored_errors(fragments.character, fragments.stitched(stitching, WEIGHT_SCALE))
        return Chosen(cost=stitching.cost, rmse=mean_rmse(errors))

    single = [judged(search(fragments.table, 1, settings.seed + start)) for start in range(settings.starts)]
    chosen, _ = stitch(fragments.table, settings)
    return MaskCount(
        masks=fragments.mask_count,
        costs=[one.cost for one in single],
        rmse=[one.rmse for one in single],
        chosen={name: judged(stitching) for name, stitching in chosen.items()},
    )
