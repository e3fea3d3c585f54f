"""What a check found, as lines of one table."""

from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True)
class Row:
    """One line of the table.

    Attributes
    ----------
    what : the cases.
    cases : how many.
    faults : each thing that must not happen → how often it did.
    notes : what else is worth knowing.
    examples : a line for each of the first faults.
    skipped : why there are no cases, where there are none.
    """

    what: str
    cases: int
    faults: Mapping[str, int] = field(default_factory=dict)
    notes: str = ""
    examples: tuple[str, ...] = ()
    skipped: str = ""

    @property
    def passed(self) -> bool:
        return self.cases > 0 and not any(self.faults.values())

    def __str__(self) -> str:
        if self.skipped:
            return f"  skip  {self.what}: {self.skipped}"
        faults = ", ".join(f"{count} {fault}" for fault, count in self.faults.items())
        line = f"  {'ok  ' if self.passed else 'FAIL'}  {self.cases:6,}  {self.what}: {faults}"
        return "\n".join(
            [f"{line} ({self.notes})" if self.notes else line, *(f"          {e}" for e in self.examples[:5])]
        )
