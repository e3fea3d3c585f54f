"""``facezip bench clean``: what cleaning does to scans and packs, against the known truth."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import click

from facezip.commands import options
from facezip.machine.conditions import conditions

if TYPE_CHECKING:
    from reports.cleaning import CleanErrors

LIBRARIES = ("facezip", "numpy", "numba", "scipy")


@click.command("clean")
@options.resolution
@options.seed
@click.option("--seeds", type=click.IntRange(min=1), default=1, show_default=True, metavar="N", help="Persons.")
@options.as_json
def command(resolution: int, seed: int, seeds: int, as_json: bool) -> None:
    """Clean the embedded head's scans step by step, and compare with the truth behind them.

    Reports the RMSE of 255 (inside the mask) of the neutral, the scans and packs of them, and the power of the
    neutral's detail over the truth's: without cleaning, then with one more step of --clean at a time.
    """
    from reports.cleaning import CleanBenchConditions, CleanBenchDocument, bench_clean

    people = {str(seed + n): bench_clean(resolution, seed + n) for n in range(seeds)}
    about = CleanBenchConditions(
        **vars(conditions(LIBRARIES)), character="embedded", resolution=(resolution, resolution)
    )
    options.answer(CleanBenchDocument(people=people, conditions=about), as_json, lambda: _lines(people))


def _lines(people: "Mapping[str, Mapping[str, CleanErrors]]") -> list[str]:
    lines = ["RMSE to the truth, of 255      neutral   scans    pack   detail"]
    for name, steps in people.items():
        for step, found in steps.items():
            numbers = "  ".join(f"{getattr(found, key):6.2f}" for key in ("neutral", "scans", "pack", "detail"))
            lines.append(f"  person {name:>3}  {step:<14} {numbers}")
    return lines
