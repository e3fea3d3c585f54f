"""What the curves say, in words made of the numbers alone."""

from collections.abc import Sequence
from typing import Any

from facezip.documents.document import Data
from reports.findings import Finding
from reports.metrics import number
from reports.rates.comparison import LEAST, MOST, Row, envelope, in_use, of_family, on_gpu, on_wire

Round = Data


def find(document: Data) -> list[Finding]:
    """Every finding of a document of :func:`reports.rates.experiment.measure_rates`."""
    found = []
    for one in document["rounds"]:
        found += [_ratio(one), _loop(one), _baselines(one), _files(one)]
    return [finding for finding in found if finding is not None]


def _ratio(one: Round) -> Finding | None:
    rows = [row for row in in_use(one["comparison"]) if row["rival"]["family"] == "textures_astc"]
    if not rows:
        return None
    fetches = sorted({row["ours"]["fetches"] for row in rows})
    here = (
        f"Between {LEAST:g} and {MOST:g} bytes a texel a pack leaves {_spread([row['ratio'] for row in rows])} of its "
        f"error at no more bytes, with {_range(fetches)} texture fetches a pixel in the place of "
        f"{rows[0]['rival']['fetches']}."
    )
    few = [row for row in rows if "few" in row]
    if few:
        most = max(row["few"]["fetches"] for row in few)
        here += f" Packs of at most {most} fetches leave {_spread([row['few_ratio'] for row in few])}."
    return Finding(title=f"{one['expressions']} expressions, against ASTC on every texture", here=here)


def _spread(ratios: Sequence[float]) -> str:
    least, most = number(min(ratios), 2), number(max(ratios), 2)
    return least if least == most else f"{least} to {most}"


def _loop(one: Round) -> Finding | None:
    """In the loop against afterwards, at the same codec, rank and scale, so at the same bytes."""
    loop = {_way(point): point["rmse"] for point in of_family(one["points"], "refined_astc")}
    pairs = [
        loop[_way(point)] / point["rmse"]
        for point in of_family(one["points"], "refined_afterwards")
        if _way(point) in loop
    ]
    if not pairs:
        return None
    return Finding(
        title=f"{one['expressions']} expressions, what the loop gains",
        here=f"With the codec in the loop of the fit the error is {number(min(pairs), 2)} to "
        f"{number(max(pairs), 2)} of what coding the same fit afterwards leaves, byte for byte.",
    )


def _baselines(one: Round) -> Finding | None:
    """The best pack of the paper's method or of PCA that costs no more than the rival's largest in use."""
    best = {
        label: min((point["rmse"] for point in _in_reach(one, family)), default=None)
        for label, family in (
            ("the paper’s method", "paper"),
            ("PCA", "pca"),
            ("ASTC on every texture", "textures_astc"),
        )
    }
    words = [f"{number(error, 2)} by {label}" for label, error in best.items() if error is not None]
    ours = min((point["rmse"] for point in _in_reach(one, "refined_astc")), default=None)
    if ours is None or not words:
        return None
    return Finding(
        title=f"{one['expressions']} expressions, the least error within {MOST:g} bytes a texel",
        here=f"{number(ours, 2)} by a refined pack, {', '.join(words)}.",
    )


def _files(one: Round) -> Finding | None:
    """What Zstandard leaves of blocks, of packs and of every texture."""
    shares = {
        whose: [on_wire(point) / on_gpu(point) for point in of_family(one["points"], family)]
        for whose, family in (("packs in ASTC", "refined_astc"), ("every texture in ASTC", "textures_astc"))
    }
    words = [f"{_spread(found)} for {whose}" for whose, found in shares.items() if found]
    if not words:
        return None
    return Finding(
        title=f"{one['expressions']} expressions, what is sent",
        here=f"KTX2 files under Zstandard are as large as this share of GPU memory: {', '.join(words)}.",
    )


def _in_reach(one: Round, family: str) -> list[Row]:
    return [point for point in envelope(of_family(one["points"], family)) if point["bytes_per_texel"] <= MOST]


def _way(point: Row) -> tuple[Any, ...]:
    return point["codec"], point["differences"], point["weight_scale"], point["weights"]


def _range(values: list[int]) -> str:
    return str(values[0]) if len(values) == 1 else f"{values[0]} to {values[-1]}"
