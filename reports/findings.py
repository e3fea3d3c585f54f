"""What numbers say, in words."""

from dataclasses import dataclass
from typing import Literal

Stance = Literal["agrees", "differs", "beyond"]


@dataclass(frozen=True, kw_only=True)
class Finding:
    """One finding.

    Attributes
    ----------
    title : of what.
    here : what is measured.
    key : its name.
    claim : what the paper states; "" where it states nothing.
    stance : whether that ``agrees`` or ``differs``; ``beyond`` where it states nothing.
    """

    title: str
    here: str
    key: str | None = None
    claim: str | None = None
    stance: Stance | None = None
