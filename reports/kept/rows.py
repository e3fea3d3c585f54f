"""A row of ``benchmarks/results.csv``: one character of one size, stored in one way."""

from collections.abc import Iterable
from dataclasses import asdict, dataclass, fields
from pathlib import Path

from reports.kept.table import read_table, write_table


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
    cpu: float | None = None
    cpu_spread: float | None = None
    versions: str
    inputs: str
    command: str = ""

    @property
    def key(self) -> str:
        """What docs call it: ``embedded/512/refined``."""
        return f"{self.character}/{self.size}/{self.method}"


COLUMNS = tuple(field.name for field in fields(Row))
DECIMALS = {"rmse": 4, "bits": 3, "cpu": 1, "cpu_spread": 2}


def read_rows(path: Path) -> dict[str, Row]:
    """The rows of a file by their keys; none where there is no file yet."""
    return {row.key: row for row in read_table(path, Row)}


def write_rows(path: Path, rows: Iterable[Row]) -> None:
    """Write rows in the order of their keys, sizes as numbers, so that a change of one figure is a change of one line.

    Raises
    ------
    FaceZipError
        ``CANNOT_WRITE``.
    """
    ordered = sorted(rows, key=lambda one: (one.character, one.size, one.method))
    write_table(path, Row, map(_cells, ordered))


def _cells(row: Row) -> dict[str, object]:
    cells = asdict(row)
    return cells | {name: f"{cells[name]:.{digits}f}" for name, digits in DECIMALS.items() if cells[name] is not None}
