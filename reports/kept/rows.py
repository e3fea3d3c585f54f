"""A row of ``benchmarks/results.csv``: one character of one size, stored in one way."""

import csv
import io
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, fields
from pathlib import Path

from facezip.files.writing import write_whole


@dataclass(frozen=True, kw_only=True)
class Row:
    """What was measured.

    Attributes
    ----------
    character : ``embedded``, with another seed ``embedded-1``, with more maps ``embedded-maps``; or a capture's name.
    size : texels of a side.
    expressions : how many.
    method : as in :data:`reports.kept.measure.METHODS`; ``textures`` for every texture as it is.
    rmse : of the albedo of the written pack, 0 to 255, mean over expressions, inside the mask; 4 decimals.
    bytes_on_gpu, bytes_bc7 : at 8 bits a channel, and with textures in BC7; without mip-maps.
    bits : of BC7 and weight maps, a texel and channel of the expressions; 3 decimals.
    fetches : textures that a shader reads for a pixel.
    cpu : processor time of the whole run as a multiple of that of reading and writing the same images right before
        and after it (:mod:`reports.kept.cost`); 1 decimal; empty where runs are too short.
    cpu_spread : by how much of it repeats differ; 2 decimals. Beyond 0.1 the machine was too busy to tell.
    versions : of what measured the row.
    inputs : digest of the code and the scans that it depends on (:mod:`reports.kept.inputs`).
    command : after ``facezip``; ``scans`` is the character, ``me.facezip`` the pack.
    """

    character: str
    size: int
    expressions: int
    method: str
    rmse: float
    bytes_on_gpu: int
    bytes_bc7: int
    bits: float
    fetches: int
    cpu: float | None
    cpu_spread: float | None
    versions: str
    inputs: str
    command: str

    @property
    def key(self) -> str:
        """What docs call it: ``embedded/512/refined``."""
        return f"{self.character}/{self.size}/{self.method}"


COLUMNS = tuple(field.name for field in fields(Row))
DECIMALS = {"rmse": 4, "bits": 3, "cpu": 1, "cpu_spread": 2}


def read_rows(path: Path) -> dict[str, Row]:
    """The rows of a file by their keys; none where there is no file yet."""
    if not path.is_file():
        return {}
    with path.open(encoding="utf-8", newline="") as file:
        rows = [_row(cells) for cells in csv.DictReader(file)]
    return {row.key: row for row in rows}


def write_rows(path: Path, rows: Iterable[Row]) -> None:
    """Write rows in the order of their keys, sizes as numbers, so that a change of one figure is a change of one line.

    Raises
    ------
    FaceZipError
        ``CANNOT_WRITE``.
    """
    text = io.StringIO()
    table = csv.DictWriter(text, COLUMNS, lineterminator="\n")
    table.writeheader()
    for row in sorted(rows, key=lambda one: (one.character, one.size, one.method)):
        table.writerow(_cells(row))
    write_whole(path, text.getvalue().encode())


def _cells(row: Row) -> dict[str, str]:
    cells = {name: "" if value is None else str(value) for name, value in asdict(row).items()}
    return cells | {name: f"{float(cells[name]):.{digits}f}" for name, digits in DECIMALS.items() if cells[name]}


def _row(cells: Mapping[str, str]) -> Row:
    return Row(
        character=cells["character"],
        size=int(cells["size"]),
        expressions=int(cells["expressions"]),
        method=cells["method"],
        rmse=float(cells["rmse"]),
        bytes_on_gpu=int(cells["bytes_on_gpu"]),
        bytes_bc7=int(cells["bytes_bc7"]),
        bits=float(cells["bits"]),
        fetches=int(cells["fetches"]),
        cpu=float(cells["cpu"]) if cells["cpu"] else None,
        cpu_spread=float(cells["cpu_spread"]) if cells["cpu_spread"] else None,
        versions=cells["versions"],
        inputs=cells["inputs"],
        command=cells["command"],
    )
