"""A pack's numbers over all renders: means, the worst with its place, and the verdict."""

from collections.abc import Iterable, Sequence

import numpy as np

from facezip.character.maps import ALBEDO
from facezip.pack.errors import Errors
from facezip.pack.facts import PackFacts
from render.documents.images import Look, Render
from render.documents.judged import Judged, JudgedCharacter, JudgedPack, RegionWorst, TextureFacts, Worst, WorstPlace
from render.limits import LEVELS, Thresholds
from render.metrics import METRICS
from render.verdict import verdict, worst_render

_MEASURED = (*METRICS, "image_rmse_debiased")


def summarise(
    k: int,
    name: str,
    facts: PackFacts | TextureFacts,
    errors: Errors,
    renders: Sequence[Render],
    limits: Thresholds,
) -> Judged:
    """Everything that the document says of candidate ``k``."""
    level, sentence = verdict(k, renders, limits)
    packs, floors = [render.packs[k] for render in renders], [render.noise_floor for render in renders]
    means = {metric: _mean(getattr(pack, metric) for pack in packs) for metric in _MEASURED}
    rmse, levels = means["image_rmse"], [pack.level for pack in packs]
    return (JudgedPack if isinstance(facts, PackFacts) else JudgedCharacter)(
        **{**vars(facts), **means, "name": name},
        texture_rmse=errors[ALBEDO].mean,
        texture_rmse_per_expression=errors[ALBEDO].per_expression,
        map_errors=errors,
        level=level,
        verdict=sentence,
        decided=all(pack.decided for pack in packs),
        levels={known: levels.count(known) for known in LEVELS if known in levels},
        psnr=None if rmse == 0 else float(20 * np.log10(255 / rmse)),
        noise_floor=_mean(floor.image_rmse for floor in floors),
        noise_floor_per_metric={metric: _mean(getattr(floor, metric) for floor in floors) for metric in METRICS},
        worst={metric: _worst(k, metric, renders) for metric in _MEASURED},
        regions=_regions(k, renders),
        worst_place=_worst_place(k, worst_render(k, renders, limits)),
    )


def _mean(values: Iterable[float]) -> float:
    return float(np.mean(list(values)))


def _look(render: Render) -> dict[str, str]:
    return {key: getattr(render, key) for key in Look.__dataclass_fields__}


def _worst(k: int, metric: str, renders: Sequence[Render]) -> Worst:
    sign = -1 if metric == "ssim" else 1
    render = max(renders, key=lambda render: sign * getattr(render.packs[k], metric))
    where = render.packs[k].where
    return Worst(value=getattr(render.packs[k], metric), **_look(render), region=where.region if where else None)


def _regions(k: int, renders: Sequence[Render]) -> dict[str, RegionWorst]:
    """The worst 95th percentile of ΔE2000 of every region, worst first, and where it was."""
    found: dict[str, RegionWorst] = {}
    for render in renders:
        for region, value in render.packs[k].regions.items():
            if region not in found or value > found[region].value:
                found[region] = RegionWorst(value=value, **_look(render))
    return dict(sorted(found.items(), key=lambda item: -item[1].value))


def _worst_place(k: int, render: Render) -> WorstPlace | None:
    """Where the render that the verdict names differs most: its image, and the box in it; None without a difference."""
    where = render.packs[k].where
    return WorstPlace(**{**vars(where), **_look(render)}, exr=render.exr, spp=render.spp) if where else None
