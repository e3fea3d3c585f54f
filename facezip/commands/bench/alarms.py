"""``facezip bench alarms``: how often the test of the pytest plugin errs, measured."""

from typing import TYPE_CHECKING, Any

import click

from facezip.commands import options

if TYPE_CHECKING:
    from render.plugin.alarms import AlarmsDocument, FlatRates, Rate


@click.command("alarms")
@click.option("--level", type=options.FiniteRange(0, 1, min_open=True), default=0.001, show_default=True, metavar="P")
@click.option("--references", type=click.IntRange(min=1), default=24, show_default=True, metavar="N")
@click.option("--tests", type=click.IntRange(min=1), default=10, show_default=True, help="Against each reference.")
@click.option("--reference-renders", type=click.IntRange(min=8), default=32, show_default=True, metavar="N")
@click.option("--renders", type=click.IntRange(min=1), default=8, show_default=True, help="In each test.")
@click.option("--resolution", type=click.IntRange(16, 1024), default=64, show_default=True, metavar="PIXELS")
@click.option("--spp", type=click.IntRange(1, 65536), default=100, show_default=True, metavar="N")
@click.option("--texels", type=click.IntRange(64, 4096), default=256, show_default=True, metavar="N")
@click.option("--seed", type=click.IntRange(0, 2**31), default=0, show_default=True, metavar="S")
@options.as_json
def command(level: float, as_json: bool, **settings: Any) -> None:
    """Measure the false alarms of the image test, and how surely it finds injected defects.

    It compares renders with references of independent renders: unchanged and spoilt ones of the embedded head, under
    every light rig and on both materials, and of scenes with regions of one value. LEVEL is the rate of false alarms
    that the test promises not to exceed.
    """
    from render.plugin.alarms import Trials, measure_alarms

    document = measure_alarms(Trials(**settings), level)
    options.answer(document, as_json, lambda: _lines(document))


def _lines(document: "AlarmsDocument") -> list[str]:
    trials = document.false_alarms.trials
    alarms = [f"  at level {row.level:<22g} {row.count:4} of {trials}  {_percent(row)}" for row in document.levels]
    found = [f"  {name:<31} {row.count:4} of {trials}  {_percent(row)}" for name, row in document.defects.items()]
    words = ["False alarms, nothing changed", *alarms, f"Defects found at level {document.level:g}", *found]
    return [*words, *(line for name, scene in document.flats.items() for line in _scene(name, scene))]


def _scene(name: str, scene: "FlatRates") -> list[str]:
    """A scene with regions of one value: its false alarms, and what is found of changes."""
    rows: list[tuple[str, Rate]] = [(f"nothing, at level {row.level:g}", row) for row in scene.levels]
    rows += [(f"the {part} part", row) for part, row in (("flat", scene.flat), ("noisy", scene.noisy)) if row]
    counts = [f"  {what:<31} {row.count:4} of {row.trials}  {_percent(row)}" for what, row in rows]
    return [f"{name[0].upper()}{name[1:]}, changed:", *counts]


def _percent(row: "Rate") -> str:
    low, high = row.interval
    return f"{100 * row.rate:6.2f} %  (95 % interval {100 * low:.2f} to {100 * high:.2f} %)"
