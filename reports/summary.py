"""The numbers of a validation as tiles, tables and bars."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from facezip.commands.words import saving_words
from facezip.documents.document import Data
from facezip.pack.facts import maps_on_tiles
from reports.cards import place
from reports.figures import BarChart, Series, lying_bars, upright_bars
from reports.metrics import BY_KEY, METRICS, MISSING, Metric, floor_text, measured, megabytes, number
from reports.tables import Cell, Row, Table

Pack = Data


def headline(packs: Sequence[Pack]) -> int:
    """Index of the pack that a report opens with: the lowest image RMSE, the first of equals."""
    return min(range(len(packs)), key=lambda index: packs[index]["image_rmse"])


def distinctly_named(packs: Sequence[Pack]) -> list[Data]:
    """The packs with their method added to names that occur twice, and a number where that is not enough."""
    names = [pack["name"] for pack in packs]
    labels = [
        f"{name} ({pack['method']})" if names.count(name) > 1 else name for name, pack in zip(names, packs, strict=True)
    ]
    repeated = {label for label in labels if labels.count(label) > 1}
    return [
        {**pack, "name": f"{label} {i}" if label in repeated else label}
        for i, (label, pack) in enumerate(zip(labels, packs, strict=True), 1)
    ]


def tiles(pack: Pack) -> list[tuple[str, str, str]]:
    """Key figures of a pack: label, value, and what to hold it against."""
    rows = []
    for key in ("texture_rmse", "image_rmse", "delta_e_p95", "flip", "ssim"):
        metric = BY_KEY[key]
        floor, (worst, _) = floor_text(metric, pack), _worst(metric, pack)
        against = f"noise floor {floor}" if floor else f"worst {worst}" if worst else metric.unit
        rows.append((metric.label, metric.of(pack), against))
    saved = saving_words(pack["bytes_raw"] / pack["bytes_on_gpu"], "×")
    rows.append(("GPU memory", saved, f"{megabytes(pack['bytes_on_gpu'])} MB at 8 bits"))
    rows.append(("Texture fetches", _count(pack.get("fetches")), "a pixel"))
    return rows


def comparison_table(packs: Sequence[Pack]) -> Table:
    """Metrics by packs: the mean over all renders with the worst case beside it, best pack marked, and the floor."""
    metrics = measured(METRICS, packs)
    if len(packs) == 1:
        rows = [Row(metric.label, _single(metric, packs[0]), _direction(metric)) for metric in metrics]
        columns: tuple[str, ...] = ("Mean", "Noise floor", "Worst", "Where")
        return Table("Mean over all renders, and the worst of them.", "Metric", columns, tuple(rows))
    rows = [Row(metric.label, _several(metric, packs), _direction(metric)) for metric in metrics]
    columns = ("Noise floor", *(pack["name"] for pack in packs))
    caption = "Mean over all renders; in small print the worst of them, and where it is."
    return Table(caption, "Metric", columns, tuple(rows))


def _single(metric: Metric, pack: Pack) -> tuple[Cell, ...]:
    value, where = _worst(metric, pack)
    return Cell(metric.of(pack)), Cell(floor_text(metric, pack)), Cell(value), Cell(where)


def _several(metric: Metric, packs: Sequence[Pack]) -> tuple[Cell, ...]:
    best = _best(metric, packs)
    cells = [
        Cell(metric.of(pack), " · ".join(filter(None, _worst(metric, pack))), best=i in best)
        for i, pack in enumerate(packs)
    ]
    return (Cell(floor_text(metric, packs[0])), *cells)


def _best(metric: Metric, packs: Sequence[Pack]) -> set[int]:
    """Indices of the packs that lead; none where there is nothing to choose."""
    # Without a value a PSNR is infinite; any other metric was not measured and cannot lead.
    absent = -math.inf if metric.higher_is_better and metric.key != "psnr" else math.inf
    values = [absent if pack.get(metric.key) is None else pack[metric.key] for pack in packs]
    leading = max(values) if metric.higher_is_better else min(values)
    best = {i for i, value in enumerate(values) if value == leading}
    return best if len(best) < len(packs) else set()


def _worst(metric: Metric, pack: Pack) -> tuple[str, str]:
    """The worst value of a metric, and where it is; of the texture error, the worst expression."""
    worst = pack.get("worst", {}).get(metric.key)
    errors = pack.get("texture_rmse_per_expression")
    if worst is None and metric.key == "texture_rmse" and errors:
        name = max(errors, key=errors.__getitem__)
        worst = {"value": errors[name], "expression": name}
    if worst is None:
        return "", ""
    return metric.text(worst["value"]), " · ".join(part for part in (worst.get("expression"), place(worst)) if part)


def _direction(metric: Metric) -> str:
    better = "higher is better" if metric.higher_is_better else "lower is better"
    return ", ".join(filter(None, (metric.unit, better)))


@dataclass(frozen=True)
class ErrorBars:
    """A chart of errors as a wide page and a telephone show it, and the same as a table."""

    series: Sequence[Series]
    wide: BarChart
    narrow: BarChart
    table: Table


def error_bars(document: Data, order: Sequence[str]) -> ErrorBars | None:
    """The paper's Figure 6: texture RMSE of each expression and method, as a wide and a narrow chart."""
    series = _series(document)
    measured_somewhere = {name for one in series for name in one.values}
    groups = [name for name in order or document["character"]["expressions"] if name in measured_somewhere]
    if not series or not groups:
        return None
    wide: BarChart = upright_bars(groups, series)
    narrow: BarChart = lying_bars(groups, series)
    rows = tuple(Row(group, tuple(_error_cell(one, group) for one in series)) for group in groups)
    table = Table("Texture RMSE of 255, per expression.", "Expression", tuple(one.name for one in series), rows)
    return ErrorBars(series, wide, narrow, table)


def _series(document: Data) -> list[Series]:
    methods = [(pack, f"pack-{i % 4}") for i, pack in enumerate(document["packs"])]
    methods += [(rival, f"rival-{i % 4}") for i, rival in enumerate(document.get("baselines", []))]
    return [
        Series(method["name"], method["texture_rmse_per_expression"], BY_KEY["texture_rmse"].of(method), tone)
        for method, tone in methods
        if method.get("texture_rmse_per_expression")
    ]


def _error_cell(series: Series, group: str) -> Cell:
    values = series.values
    return Cell(BY_KEY["texture_rmse"].text(values[group]) if group in values else MISSING)


def memory_table(document: Data) -> Table:
    """What each way of storing the character's textures costs at run time and on disk."""
    packs = document["packs"]
    raw = packs[0]["bytes_raw"]
    names = {pack["name"] for pack in packs}
    rows = [_memory_row({"name": "raw textures", "bytes_on_gpu": raw}, raw, False)]
    rows += [_memory_row(pack, raw, True) for pack in packs]
    for other in document.get("baselines", []):
        if other.get("bytes_on_gpu") and other["name"] not in names:
            names.add(other["name"])
            rows.append(_memory_row(other, raw, False))
    columns = ("GPU memory, MB", "Saving", "On disk, MB", "Fetches a pixel", "Texture RMSE")
    height, width = document["character"]["resolution"]
    count = len(document["character"]["expressions"])
    several = maps_on_tiles(*(len(document["character"].get(key, [0])) for key in ("maps", "tiles")))
    sizes = f"{width} × {height} texels{several}, at 8 bits a channel"
    caption = f"{count} expressions and the neutral, {sizes}; 1 MB is 10⁶ bytes."
    return Table(caption, "Stored as", columns, tuple(rows))


def _memory_row(entry: Data, raw: float, ours: bool) -> Row:
    on_gpu, on_disk = entry["bytes_on_gpu"], entry.get("bytes_on_disk")
    cells = (
        Cell(megabytes(on_gpu), share=on_gpu / raw),
        Cell(f"{number(raw / on_gpu, 1)}×"),
        Cell(MISSING if on_disk is None else megabytes(on_disk)),
        Cell(_count(entry.get("fetches"))),
        Cell(BY_KEY["texture_rmse"].of(entry)),
    )
    return Row(entry["name"], cells, strong=ours)


def _count(value: int | None) -> str:
    return MISSING if value is None else str(value)
