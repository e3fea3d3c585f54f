"""One test over a matrix: variants of Mitsuba, integrators, lights, or anything else that has names.

    @pytest.mark.facezip_matrix(
        variant=["llvm_ad_rgb", "scalar_rgb"], light={"sky": {"type": "constant"}, "spot": {...}}, agree="variant"
    )
    def test_ball(facezip_case):
        facezip_case({"type": "scene", "light": facezip_case["light"], ...})

Every combination is a test with a reference of its own. Along the axes that ``agree`` names they share one: what a
variant renders has to agree with what the first one does, unless it has a reference of its own, ``…@VARIANT.exr``.
"""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import product
from typing import TYPE_CHECKING, Any

import pytest

from render.plugin.names import file_stem
from render.plugin.selection import NODE_ID

if TYPE_CHECKING:
    from render.plugin.fixture import ImageCheck

MARKER, CASE = "facezip_matrix", "facezip_case"
VARIANT = "variant"
DESCRIPTION = (
    f"{MARKER}(agree=(), **axes): run the test for every combination of the axes, each a list of names or a dict from "
    f"names to values; the axis '{VARIANT}' has variants of Mitsuba; those along the axes in agree share a reference"
)


@dataclass(frozen=True, eq=False)
class Choice:
    """One combination: by axis its name there and its value, and along which axes references are shared."""

    names: Mapping[str, str]
    values: Mapping[str, Any]
    agree: tuple[str, ...]

    @property
    def label(self) -> str:
        """What stands in the brackets of the node id."""
        return "-".join(self.names.values())

    @property
    def own(self) -> str:
        """The same without the axes along which references are shared."""
        return "-".join(name for axis, name in self.names.items() if axis not in self.agree)


@dataclass(frozen=True, eq=False)
class Case:
    """What a test of a matrix gets: the values of its combination, and the comparison."""

    choice: Choice
    test: pytest.Item
    check: "ImageCheck"

    def __getitem__(self, axis: str) -> Any:
        """The value on an axis."""
        return self.choice.values[axis]

    def __call__(self, source: Any, *, name: str = "", **settings: Any) -> None:
        """Compare an image with the reference of its combination, as :class:`render.plugin.fixture.ImageCheck` does."""
        __tracebackhide__ = True
        reference = ""
        if self.choice.agree:
            whole = self.test.stash[NODE_ID].partition("[")[0]
            reference = file_stem(f"{whole}[{self.choice.own}]" if self.choice.own else whole, name)
        self.check(source, name=name, reference=reference, variant=self.choice.names.get(VARIANT, ""), **settings)


def choices(agree: str | tuple[str, ...] = (), **axes: Any) -> list[Choice]:
    """Every combination of the axes, the last one changing first.

    Raises
    ------
    pytest.UsageError
        An axis is empty, or ``agree`` names one that there is not.
    """
    shared = (agree,) if isinstance(agree, str) else tuple(agree)
    named = {axis: dict(zip(one, one, strict=True)) if isinstance(one, list) else one for axis, one in axes.items()}
    wrong = [axis for axis in shared if axis not in named] + [axis for axis, one in named.items() if not one]
    if wrong or not named:
        raise pytest.UsageError(f"{MARKER}: {f'no axis {wrong[0]!r}, or an empty one' if wrong else 'it has no axis'}")
    found = []
    for names in product(*named.values()):
        chosen = dict(zip(named, names, strict=True))
        found.append(Choice(chosen, {axis: named[axis][name] for axis, name in chosen.items()}, shared))
    return found


def parametrise(metafunc: pytest.Metafunc) -> None:
    """Make a test of each combination."""
    if CASE not in metafunc.fixturenames:
        return
    markers = [*metafunc.definition.iter_markers(MARKER)]
    if not markers or any(marker.args for marker in markers):
        wrong = f"{MARKER} takes axes by their names" if markers else f"{CASE} needs the marker {MARKER}"
        raise pytest.UsageError(f"{metafunc.definition.nodeid}: {wrong}")
    # A marker of a class or a module gives axes to all its tests; the closest one goes before.
    found = choices(**{axis: one for marker in reversed(markers) for axis, one in marker.kwargs.items()})
    metafunc.parametrize(CASE, found, ids=[choice.label for choice in found], indirect=True)


@contextmanager
def under(variant: str) -> Iterator[None]:
    """With a variant of Mitsuba set, and afterwards the one that was; skips the test where this build lacks it."""
    import mitsuba as mi

    if variant not in mi.variants():
        pytest.skip(f"this Mitsuba has no variant {variant}; it has {', '.join(mi.variants())}")
    before = mi.variant()
    mi.set_variant(variant)
    try:
        yield
    finally:
        if before:
            mi.set_variant(before)
