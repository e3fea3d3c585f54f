"""The fixture ``facezip_image``: one call compares, or generates, one image."""

import json
import shlex
import shutil
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

import pytest

from facezip.errors import FaceZipError
from render.plugin.names import file_stem
from render.plugin.settings import PROPERTY, Settings

if TYPE_CHECKING:
    from render.plugin.reference import Comparison, Reference
    from render.plugin.sources import Source

# References and tests never share a seed: their renders have to be independent.
REFERENCE_SEED = 1_000_000


@dataclass
class ImageCheck:
    """Compares images of one test with their references, or writes those.

    Attributes
    ----------
    test : the running test.
    settings : of this run of pytest.
    generated : references written so far.
    """

    test: pytest.Item
    settings: Settings
    generated: list[Path] = field(default_factory=list)
    _names: set[str] = field(default_factory=set)

    def __call__(
        self,
        source: "Source",
        *,
        name: str = "",
        spp: int = 16,
        renders: int = 8,
        reference_renders: int = 32,
        level: float | None = None,
    ) -> None:
        """Fail the test where the image differs from its reference by more than render noise.

        Parameters
        ----------
        source : a Mitsuba scene, as a dict or loaded; a function from a seed to an image; an image; or a list of
            independent renders of it. Images are ``(H, W)``, ``(H, W, 3)`` or ``(H, W, 4)``, scene-linear floats or 8-
            or 16-bit integers.
        name : which image of the test this is, where it checks several.
        spp : samples per pixel of a scene.
        renders, reference_renders : independent renders of a scene or function that make a test, and a reference.
        level : probability below which the comparison fails; that of the run by default.
        """
        __tracebackhide__ = True
        stem = file_stem(self.test.nodeid, name)
        if name in self._names:
            pytest.fail(f"facezip_image: a second image '{name}' in one test; give each its own name=", pytrace=False)
        self._names.add(name)
        try:
            if self.settings.generate:
                self._generate(source, stem, reference_renders, spp)
            else:
                self._compare(source, stem, renders, spp, level or self.settings.level)
        except FaceZipError as error:
            self._fail({"name": stem}, f"{stem}: {error}")

    def _generate(self, source: "Source", stem: str, count: int, spp: int) -> None:
        from render.plugin.reference import Reference
        from render.plugin.sources import renders_of

        path = Path(str(self.settings.generate)) / f"{stem}.exr"
        seeds = range(REFERENCE_SEED, REFERENCE_SEED + count)
        reference = Reference.of(renders_of(source, seeds, spp))
        path.parent.mkdir(parents=True, exist_ok=True)
        reference.write(path, {"test": self.test.nodeid})
        self.generated.append(path)
        self._note({"name": stem, "outcome": "generated", "reference": str(path), "renders": reference.renders})

    def _compare(self, source: "Source", stem: str, count: int, spp: int, level: float) -> None:
        __tracebackhide__ = True
        from render.plugin.reference import Reference
        from render.plugin.sources import renders_of

        path = self.settings.baseline_of(self.test.path) / f"{stem}.exr"
        result: dict[str, Any] = {"name": stem, "reference": str(path), "level": level}
        if not path.is_file():
            self._fail(result, f"{stem}: no reference {path}\n  generate it: {self._command(path)}")
        reference = Reference.read(path)
        renders = renders_of(source, range(count), spp)
        if renders.shape[1:] != reference.mean.shape:
            sizes = f"{_size(renders.shape[1:])} pixels, its reference {_size(reference.mean.shape)}"
            self._fail(result, f"{stem}: the image has {sizes}\n  if that is meant: {self._command(path)}")
        comparison = reference.compare(renders)
        result |= {"probability": comparison.probability, "statistic": comparison.statistic, "renders": len(renders)}
        result |= worst_place(comparison, reference)
        differs = comparison.probability < level
        folder = self._evidence(stem, differs, comparison, reference)
        result |= {"evidence": str(folder)} if folder else {}
        if differs:
            self._fail(result, f"{stem}: {described(result)}\n  if that is meant: {self._command(path)}")
        self._note({**result, "outcome": "passed"})

    def _evidence(self, stem: str, differs: bool, comparison: "Comparison", reference: "Reference") -> Path | None:
        """The folder of the pictures; a summary shows those of tests that pass as well, otherwise old ones go."""
        from render.plugin.evidence import is_evidence, write_evidence

        folder = self.settings.results / stem
        if differs or "html" in self.settings.summaries:
            write_evidence(folder, comparison, reference)
            return folder
        if folder.is_dir() and is_evidence(folder):
            shutil.rmtree(folder)
        return None

    def _command(self, path: Path) -> str:
        return shlex.join(["pytest", self.test.nodeid, "--facezip-generate", str(path.parent)])

    def _fail(self, result: dict[str, Any], message: str) -> NoReturn:
        __tracebackhide__ = True
        self._note({**result, "outcome": "failed", "message": message})
        pytest.fail(message, pytrace=False)

    def _note(self, result: dict[str, Any]) -> None:
        # Properties travel with a test's report, from the workers of pytest-xdist too.
        self.test.user_properties.append((PROPERTY, json.dumps({"test": self.test.nodeid, **result})))


def worst_place(comparison: "Comparison", reference: "Reference") -> dict[str, Any]:
    """The block, of the size that tells most, whose ratio is largest.

    Returns
    -------
    ``row``, ``column`` of its upper left pixel, its ``side``, the means of ``image`` and ``reference`` over it in the
    channel that tells most, and their difference in ``deviations``, standard errors.
    """
    import numpy as np

    values = comparison.ratios[comparison.scale].values
    row, column, channel = map(int, np.unravel_index(np.abs(values).argmax(), values.shape))
    side, step = comparison.scale, max(comparison.scale // 2, 1)
    block = (slice(row * step, row * step + side), slice(column * step, column * step + side), channel)
    return {
        "row": row * step,
        "column": column * step,
        "side": side,
        "image": float(comparison.image[block].mean()),
        "reference_image": float(reference.mean[block].mean()),
        "deviations": float(values[row, column, channel]),
    }


def described(result: dict[str, Any]) -> str:
    """A failed comparison in a few lines."""
    side = result["side"]
    place = f"{side} x {side} pixels from" if side > 1 else "pixel at"
    where = f"{place} row {result['row']}, column {result['column']}"
    values = f"{result['image']:.4g} instead of {result['reference_image']:.4g}"
    return (
        f"differs from its reference by more than noise: p = {result['probability']:.1e}, level {result['level']:g}\n"
        f"  worst {where}: {values}, {abs(result['deviations']):.1f} standard errors\n"
        f"  reference {result['reference']}\n"
        f"  evidence {result['evidence']}: image, reference, error, p_value as EXR and PNG"
    )


def _size(shape: tuple[int, ...]) -> str:
    return " x ".join(str(side) for side in (shape[1], shape[0], *shape[2:]))
