"""A pack's numbers over all renders: means, the worst with its place, and the verdict."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from render.metrics import METRICS
from render.verdict import LEVELS, Thresholds, verdict, worst_render

Render = dict[str, Any]
_MEASURED = (*METRICS, "image_rmse_debiased")


def summarise(k: int, name: str, facts: dict[str, Any], renders: Sequence[Render], limits: Thresholds) -> Render:
    """Everything that the document says of candidate ``k``."""
    level, sentence = verdict(k, renders, limits)
    means = {metric: _mean(render["packs"][k][metric] for render in renders) for metric in _MEASURED}
    rmse = means["image_rmse"]
    levels = [render["packs"][k]["level"] for render in renders]
    return {
        **facts,
        "name": name,
        "level": level,
        "verdict": sentence,
        "decided": all(render["packs"][k]["decided"] for render in renders),
        "levels": {known: levels.count(known) for known in LEVELS if known in levels},
        **means,
        "psnr": None if rmse == 0 else float(20 * np.log10(255 / rmse)),
        "noise_floor": _mean(render["noise_floor"]["image_rmse"] for render in renders),
        "noise_floor_per_metric": {name: _mean(render["noise_floor"][name] for render in renders) for name in METRICS},
        "worst": {metric: _worst(k, metric, renders) for metric in _MEASURED},
        "regions": _regions(k, renders),
        "worst_place": _worst_place(k, worst_render(k, renders, limits)),
    }


def _mean(values: Any) -> float:
    return float(np.mean(list(values)))


def _worst(k: int, metric: str, renders: Sequence[Render]) -> Render:
    sign = -1 if metric == "ssim" else 1
    render = max(renders, key=lambda render: sign * render["packs"][k][metric])
    where = {key: render[key] for key in ("expression", "view", "light")}
    numbers = render["packs"][k]
    region = {"region": numbers["where"]["region"]} if numbers["where"] else {}
    return {"value": numbers[metric], **where, **region}


def _regions(k: int, renders: Sequence[Render]) -> dict[str, Render]:
    """The worst 95th percentile of ΔE2000 of every region, worst first, and where it was."""
    found: dict[str, Render] = {}
    for render in renders:
        for region, value in render["packs"][k]["regions"].items():
            if region not in found or value > found[region]["value"]:
                found[region] = {"value": value, **{key: render[key] for key in ("expression", "view", "light")}}
    return dict(sorted(found.items(), key=lambda item: -item[1]["value"]))


def _worst_place(k: int, render: Render) -> Render | None:
    """Where the render that the verdict names differs most: its image, and the box in it; None without a difference."""
    where = render["packs"][k]["where"]
    return where and {key: render[key] for key in ("expression", "view", "light", "exr", "spp")} | where
