"""Error against bytes: every measurement as a mark, and a line through the best of each family."""

from collections.abc import Mapping

from facezip.documents.document import Data
from reports.maps import headline, unit
from reports.metrics import BY_KEY, MISSING, megabytes, number
from reports.plots import Axis, Mark, Plot, dot, line
from reports.rates.comparison import LEAST, MOST, Row, Size, envelope, in_use, of_family, on_gpu, on_wire
from reports.rates.families import FAMILIES, Family
from reports.tables import Cell, Table
from reports.tables import Row as TableRow

RMSE = "RMSE, of 255"
# What error is drawn against, and its words.
SIZES = {"GPU memory": (on_gpu, "Bytes of GPU memory a texel"), "files": (on_wire, "Bytes of files a texel")}
LEFT, TOP, BOTTOM = 52.0, 36.0, 400.0
# What is drawn; the rest is in the table.
MOST_BYTES, MOST_RMSE = 8.0, 4.0
Round = Data


def families_of(one: Round) -> list[Family]:
    """The families that were measured, in the report's order."""
    return [family for family in FAMILIES.values() if of_family(one["points"], family.key)]


def maps_of(one: Round) -> dict[str, Mapping[str, float]]:
    """The maps that were measured, with the errors of some point of each."""
    return dict(one["points"][0]["errors"])


def legend(one: Round) -> tuple[tuple[Mark, str, str], ...]:
    """Mark and label of every family."""
    return tuple((family.mark, family.label, "") for family in families_of(one))


def curves(one: Round, width: float, against: str) -> Plot:
    """All families, against one of ``SIZES``; ours on top."""
    size, words = SIZES[against]
    right = width - 8
    across, up = _axis(MOST_BYTES, LEFT, right, 8), _axis(MOST_RMSE, BOTTOM, TOP, 8)
    marks = []
    for family in reversed(families_of(one)):
        drawn = [
            point
            for point in of_family(one["points"], family.key)
            if size(point) <= MOST_BYTES and point["rmse"] <= MOST_RMSE
        ]
        best = envelope(drawn, size)
        if len(best) > 1:
            places = [(across.at(size(point)), up.at(point["rmse"])) for point in best]
            marks.append(line(places, family.tone, family.label))
        for point in drawn:
            place = across.at(size(point)), up.at(point["rmse"])
            opacity = 1 if point in best else 0.3
            marks.append(dot(place, family.shape, family.tone, _words(point, size), opacity=opacity))
    frame = (width, BOTTOM + 48, LEFT, right, TOP, BOTTOM)
    title = f"{one['expressions']} expressions: error against {against}"
    error = f"{RMSE}, over {len(maps_of(one))} maps" if len(maps_of(one)) > 1 else RMSE
    return Plot(title, *frame, across.marks(), up.marks(), words, error, tuple(marks))


def comparison(one: Round) -> Table:
    """Our best at no more bytes than each size of the rivals, and our best of few fetches."""
    rows = []
    for row in one["comparison"]:
        rival = row["rival"]
        cells = (
            Cell(number(rival["bytes_per_texel"], 2), f"{number(rival['bits'], 2)} bits; {_files(rival)}"),
            Cell(number(rival["rmse"], 2), f"{_decibels(rival)}, {rival['fetches']} fetches"),
            *_ours(row["ours"], row["ratio"]),
            *_ours(row.get("few"), row.get("few_ratio")),
        )
        rows.append(TableRow(_block(rival["codec"]), cells, strong=row in in_use(one["comparison"])))
    columns = ("Bytes a texel", "Its RMSE", "Ours", "Ours / its", f"Ours, {_fewest(one)}", "Ours / its")
    caption = (
        f"{one['expressions']} expressions: every texture coded alone, and our best packs of no more GPU memory. Bits "
        f"are a texel and channel, files bytes a texel. Bold: {LEAST:g} to {MOST:g} bytes a texel."
    )
    return Table(caption, "Codec", columns, tuple(rows))


def _ours(point: Row | None, ratio: float | None) -> tuple[Cell, Cell]:
    if point is None or ratio is None:
        return Cell(MISSING), Cell(MISSING)
    size = f"{number(point['bytes_per_texel'], 2)} bytes, {_files(point)}, {point['fetches']} fetches"
    return Cell(number(point["rmse"], 2), f"{_decibels(point)}; {size}; {_coded(point)}"), Cell(number(ratio, 2))


def _files(point: Row) -> str:
    return f"files {number(on_wire(point), 2)}"


def _fewest(one: Round) -> str:
    """The fetches of a pack of four differences, in words."""
    fetches = {row["few"]["fetches"] for row in one["comparison"] if "few" in row}
    return f"at most {max(fetches)} fetches" if fetches else "few fetches"


def table(one: Round) -> Table:
    """Every measurement as numbers, family by family."""
    rows = []
    # The error of one map is its own; of several each is shown beside that over all.
    maps = maps_of(one) if len(maps_of(one)) > 1 else {}
    for family in families_of(one):
        best = envelope(of_family(one["points"], family.key))
        for point in of_family(one["points"], family.key):
            cells = (
                Cell(number(point["bytes_per_texel"], 2), f"{megabytes(point['bytes'])} MB"),
                Cell(number(on_wire(point), 2), f"{megabytes(point['bytes_on_wire'])} MB"),
                Cell(number(point["bits"], 2)),
                Cell(number(point["rmse"], 2)),
                Cell(_decibels(point)),
                *(Cell(number(headline(point["errors"][name]), 2)) for name in maps),
                Cell(str(point["fetches"])),
                Cell(number(point["seconds"], 1)),
            )
            rows.append(TableRow(family.label, cells, _made(point), strong=point in best))
    each = (f"{name.capitalize()}, {unit(found)}" for name, found in maps.items())
    columns = ("Bytes a texel", "Of files", "Bits a value", "RMSE", "PSNR", *each, "Fetches", "Seconds")
    return Table(f"{one['expressions']} expressions", "Stored", columns, tuple(rows))


def _axis(most: float, begin: float, end: float, count: int) -> Axis:
    return Axis.around((0.0, most), begin, end, count, zero=True)


def _words(point: Row, size: Size) -> str:
    cost, error = number(size(point), 2), number(point["rmse"], 2)
    return f"{FAMILIES[point['family']].label}, {_made(point)}: {cost} bytes a texel, RMSE {error}"


def _made(point: Row) -> str:
    """Codec, rank and scale in words."""
    return f"{point['differences']} differences, {_coded(point)}" if point["differences"] else _coded(point)


def _coded(point: Row) -> str:
    """Codecs of textures and weight maps, and the scale of these."""
    weights = f", weights 1/{point['weight_scale']} in {_block(point['weights'])}" if point["differences"] else ""
    return _block(point["codec"]) + weights


def _decibels(point: Row) -> str:
    return f"{BY_KEY['psnr'].text(point['psnr'])} dB"


def _block(codec: str) -> str:
    if codec.startswith("astc"):
        return codec.replace("astc_", "ASTC ").replace("x", " × ")
    return codec if codec == "raw" else codec.upper()
