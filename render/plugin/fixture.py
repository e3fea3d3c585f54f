"""The fixture ``facezip_image``: one call compares, or generates, one image."""

import shlex
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

import pytest

from facezip.documents.document import to_json
from facezip.errors import FaceZipError
from render.plugin.baseline import Baseline
from render.plugin.labels import VARIANT, accepted, is_label
from render.plugin.names import file_stem
from render.plugin.results import Result
from render.plugin.selection import NODE_ID
from render.plugin.settings import PROPERTY, Settings

if TYPE_CHECKING:
    from render.plugin.call import Call
    from render.plugin.ignoring import Region
    from render.plugin.judging import Judged
    from render.plugin.sources import Source


@dataclass
class ImageCheck:
    """Compares images of one test with their references, or writes those.

    Attributes
    ----------
    test : the running test.
    settings : of this run of pytest.
    shared : references that several tests have and this run has written.
    generated : references written so far.
    calls, compared : how many images were handed over, and how many of them had a reference.
    """

    test: pytest.Item
    settings: Settings
    shared: set[Path]
    generated: list[Path] = field(default_factory=list)
    calls: int = 0
    compared: int = 0
    _names: set[str] = field(default_factory=set)

    def __call__(
        self,
        source: "Source",
        *,
        name: str = "",
        reference: str = "",
        variant: str = "",
        spp: int = 16,
        renders: int = 8,
        reference_renders: int = 32,
        level: float | None = None,
        warn: float | None = None,
        ignore: "Region" = None,
        must_differ: bool = False,
    ) -> None:
        """Fail the test where the image differs from its reference by more than render noise.

        Parameters
        ----------
        source : a Mitsuba scene, as a dict or loaded; a function from a seed to an image; an image; or a list of
            independent renders of it. Images are ``(H, W)``, ``(H, W, 3)`` or ``(H, W, 4)``, scene-linear floats or 8-
            or 16-bit integers.
        name : which image of the test this is, where it checks several.
        reference : of a reference that several tests share, its name; by default it is named after the test.
        variant : what the image was made under, a variant of Mitsuba say: a reference ``…@VARIANT.exr`` then stands in
            the place of the usual one.
        spp : samples per pixel of a scene.
        renders, reference_renders : independent renders of a scene or function that make a test, and a reference.
        level : probability below which the comparison fails; that of the run by default.
        warn : probability below which it is listed though it passes; that of the run by default.
        ignore : region that may differ; see :func:`render.plugin.ignoring.ignored_pixels`.
        must_differ : the image is spoilt on purpose: fail where it agrees with the reference that the test's own image
            of this name has.
        """
        __tracebackhide__ = True
        from render.plugin.call import Call

        self.calls += 1
        if name in self._names and not must_differ:
            pytest.fail(f"facezip_image: a second image '{name}' in one test; give each its own name=", pytrace=False)
        for label in filter(None, (reference, variant)):
            if not is_label(label):
                pytest.fail(f"facezip_image: '{label}': letters, digits, '_', '.' and '-' alone", pytrace=False)
        own = file_stem(self.test.stash[NODE_ID], name)
        if not must_differ:
            self._names.add(name)
        level = level or self.settings.level
        call = Call(
            name=f"{own}.must-differ-{self.calls}" if must_differ else own,
            stem=reference or own,
            shared=bool(reference),
            source=source,
            variant=variant,
            spp=spp,
            renders=renders,
            reference_renders=reference_renders,
            level=level,
            warn=max(level, warn or self.settings.warn),
            ignore=ignore,
            must_differ=must_differ,
        )
        baseline = self.settings.baseline_of(self.test.path)
        try:
            self._check(call, baseline)
        except FaceZipError as error:
            self._fail(self._passed(call), f"{call.name}: {error}")

    def _check(self, call: "Call", baseline: Baseline) -> None:
        __tracebackhide__ = True
        # Of tests that share a reference the first writes it, and the others are compared with that.
        mode = "" if baseline.path(call.stem) in self.shared else self.settings.generate
        names = accepted(baseline.names(), call.stem, call.variant)
        if mode == "all" or (mode and not names):
            if not call.must_differ:
                self._generate(call, baseline, names)
            return
        path = baseline.path(names[0] if names else call.stem)
        self.compared += 1
        result = replace(self._passed(call), reference=str(path))
        if not names:
            self._fail(result, f"{call.name}: no reference {path}{self._way_out(path, 'generate it')}")
        from render.plugin.judging import judged

        replaces = mode == "failed" and not call.must_differ
        try:
            found = judged(call, baseline, names)
        except FaceZipError:
            if not replaces:
                raise
            # A damaged reference has failed as well; an image that is none fails again.
            self._generate(call, baseline, names)
            return
        if found.differs and replaces:
            self._generate(call, baseline, names, found)
        else:
            self._conclude(call, replace(result, reference=found.path), found)

    def _conclude(self, call: "Call", result: Result, found: "Judged") -> None:
        __tracebackhide__ = True
        from render.plugin.words import described, described_agreement

        compared = found.compared
        failed = compared is None or found.differs != call.must_differ
        warned = not failed and not call.must_differ and found.probability < call.warn
        result = replace(result, comparison=compared, evidence=self._evidence(call, failed or warned, found))
        if not failed:
            self._note(replace(result, outcome="warned" if warned else "passed"))
            return
        if call.must_differ:
            words = described_agreement(result, compared) if compared else found.mismatch
            self._fail(result, f"{call.name}: {words}")
        words = described(result, compared) if compared else found.mismatch
        # A reference that variants share stays for the others.
        label = VARIANT if call.shared and call.variant else ""
        way_out = self._way_out(Path(found.path), "if that is meant", label)
        self._fail(result, f"{call.name}: {words}{way_out}")

    def _generate(self, call: "Call", baseline: Baseline, names: list[str], found: "Judged | None" = None) -> None:
        from render.plugin.generating import generate

        made = generate(call, baseline, names, self.settings.label, self.test.stash[NODE_ID], found)
        self.generated.append(made.path)
        if call.shared:
            self.shared.add(made.path)
        result = replace(self._passed(call), outcome="generated", reference=str(made.path), written=made.written)
        if made.before:
            evidence = self._evidence(call, True, made.before)
            result = replace(result, comparison=made.before.compared, evidence=evidence)
        self._note(result)

    def _passed(self, call: "Call") -> Result:
        return call.result(self.test.stash[NODE_ID])

    def _evidence(self, call: "Call", wanted: bool, found: "Judged") -> str | None:
        """The folder of the pictures; a summary shows those of tests that pass as well, otherwise old ones go."""
        from render.plugin.evidence import remove_evidence, write_evidence

        folder = self.settings.results / call.name
        if found.comparison is not None and (wanted or "html" in self.settings.summaries):
            write_evidence(folder, found.comparison, found.reference)
            return str(folder)
        remove_evidence(folder)
        return None

    def _way_out(self, path: Path, when: str, label: str = "") -> str:
        if self.settings.commit:
            return ""
        command = ["pytest", self.test.stash[NODE_ID], "--facezip-generate", str(path.parent)]
        command += ["--facezip-as", label] if label else []
        return f"\n  {when}: {shlex.join(command)}"

    def _fail(self, result: Result, message: str) -> NoReturn:
        __tracebackhide__ = True
        self._note(replace(result, outcome="failed", message=message))
        pytest.fail(message, pytrace=False)

    def _note(self, result: Result) -> None:
        # Properties travel with a test's report, from the workers of pytest-xdist too, and into JUnit's XML.
        properties = self.test.user_properties
        properties.append((PROPERTY, to_json(result, indent=None)))
        if result.comparison:
            properties.append((f"facezip_p[{result.name}]", result.comparison.probability))
        if result.evidence:
            properties.append((f"facezip_evidence[{result.name}]", result.evidence))
