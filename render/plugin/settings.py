"""What a run of pytest was asked for: where references and results are, and what to do with them."""

from dataclasses import dataclass
from pathlib import Path

import pytest

from render.plugin.baseline import Baseline
from render.plugin.labels import PLATFORM, VARIANT, is_label
from render.plugin.store import Store

# The name under which a test's report carries its results.
PROPERTY = "facezip_image"
LEVEL = 0.001
SUMMARIES = ("html", "json")
PICTURES = ("kitty", "iterm", "sixel", "none")
# Which references are written; anything else is a folder, into which all are.
GENERATE = ("missing", "failed", "all")
DEFAULT_BASELINE, DEFAULT_RESULTS = "baseline", "facezip-results"


@dataclass(frozen=True)
class Settings:
    """Options of the command line, and where they are not given those of the configuration file.

    Attributes
    ----------
    generate : one of :data:`GENERATE`, or "" to compare alone.
    into : folder for new references, or None for where the old ones are.
    label : for what new references stand: see :func:`render.plugin.labels.labelled`.
    baseline : folder of the references, or None for ``baseline`` beside each test's file.
    store : folder or URL where the images of references are kept, or "" where they lie in the baseline.
    commit : the commit of git whose references count, or "" for those on disk.
    results : folder for evidence and summaries.
    summaries : of :data:`SUMMARIES`.
    markdown : file for a summary in Markdown, or None.
    level : probability below which a comparison fails.
    warn : probability below which it is listed though it passes; at least ``level``.
    pictures : how failures are shown in the terminal: a kind of :data:`PICTURES`, or "" for as it says of itself.
    allow_stale : whether stale references, and a run that compared nothing, are no failure.
    """

    generate: str
    into: Path | None
    label: str
    baseline: Path | None
    store: str
    commit: str
    results: Path
    summaries: tuple[str, ...]
    markdown: Path | None
    level: float
    warn: float
    pictures: str
    allow_stale: bool

    @staticmethod
    def of(config: pytest.Config) -> "Settings":
        """Raises ``pytest.UsageError`` for a value that there is not."""
        generate = config.getoption("facezip_generate") or ""
        is_mode = generate in ("", *GENERATE)
        level = _probability("level", _given(config, "level") or LEVEL)
        return Settings(
            generate=generate if is_mode else "all",
            into=None if is_mode else _here(config, generate),
            label=_label(config.getoption("facezip_as") or "", generate),
            baseline=_folder(config, "facezip_baseline"),
            store=_store(config),
            commit=_commit(config, generate),
            results=_folder(config, "facezip_results") or config.rootpath / DEFAULT_RESULTS,
            summaries=_summaries(config.getoption("facezip_summary") or ""),
            markdown=_folder(config, "facezip_markdown"),
            level=level,
            warn=max(level, _probability("warn", _given(config, "warn") or level)),
            pictures=_pictures(config.getoption("facezip_pictures") or ""),
            allow_stale=config.getoption("facezip_allow_stale") or config.getini("facezip_allow_stale"),
        )

    def baseline_of(self, test_file: Path) -> Baseline:
        """The references of the tests in a file."""
        return self.baseline_in(self.into or self.baseline or test_file.parent / DEFAULT_BASELINE)

    def baseline_in(self, folder: Path) -> Baseline:
        """The references in a folder."""
        return Baseline(folder, Store(self.store) if self.store else None, self.commit)


def add_options(parser: pytest.Parser) -> None:
    """The flags and configuration values of the plugin."""
    group = parser.getgroup("facezip", "comparison of renders with references (facezip)")
    modes = "write references: missing, failed (and missing ones) or all; a path writes all into that folder"
    flags = {
        "generate": ("MODE|PATH", modes),
        "as": ("LABEL", f"write them for this '{PLATFORM}' or '{VARIANT}', or under a name beside what is accepted"),
        "baseline": ("PATH", f"folder of the references; by default '{DEFAULT_BASELINE}' beside each test's file"),
        "baseline-commit": ("REV", "compare with the references of a commit of git, HEAD~1 say"),
        "store": ("URL", "folder or URL where the images of references are kept, the baseline having their digests"),
        "results": ("PATH", f"folder for evidence and summaries; by default '{DEFAULT_RESULTS}'"),
        "summary": ("KINDS", "html, json or both with a comma: a summary in the results folder"),
        "markdown": ("FILE", "a summary in Markdown, for the comment on a change"),
        "level": ("P", f"probability below which a comparison fails; by default {LEVEL:g}"),
        "pictures": ("KIND", "show failures as kitty, iterm, sixel or none; by default as the terminal can"),
        "warn": ("P", "probability below which a comparison that passes is listed"),
    }
    for name, (value, text) in flags.items():
        dest = f"facezip_{name.replace('-', '_')}"
        group.addoption(f"--facezip-{name}", dest=dest, metavar=value, default=None, help=text)
    stale = "stale references, and a run that compares nothing, are no failure: for runs of a part of the tests"
    group.addoption("--facezip-allow-stale", dest="facezip_allow_stale", action="store_true", help=stale)
    for name in ("baseline", "store", "results", "markdown", "level", "warn"):
        parser.addini(f"facezip_{name}", f"as --facezip-{name}; paths from the root folder", default="")
    parser.addini("facezip_allow_stale", "as --facezip-allow-stale", type="bool", default=False)


def _given(config: pytest.Config, name: str) -> str:
    return str(config.getoption(f"facezip_{name}") or config.getini(f"facezip_{name}"))


def _folder(config: pytest.Config, name: str) -> Path | None:
    given, configured = config.getoption(name), config.getini(name)
    if given:
        return _here(config, given)
    return config.rootpath / configured if configured else None


def _store(config: pytest.Config) -> str:
    place = _given(config, "store")
    return place if not place or "://" in place else str(_folder(config, "facezip_store"))


def _here(config: pytest.Config, path: str) -> Path:
    return config.invocation_params.dir / path


def _summaries(text: str) -> tuple[str, ...]:
    summaries = tuple(filter(None, text.split(",")))
    unknown = [kind for kind in summaries if kind not in SUMMARIES]
    if unknown:
        raise pytest.UsageError(f"--facezip-summary: no kind '{unknown[0]}'; choose from {','.join(SUMMARIES)}")
    return summaries


def _pictures(kind: str) -> str:
    if kind and kind not in PICTURES:
        raise pytest.UsageError(f"--facezip-pictures: no kind '{kind}'; choose from {','.join(PICTURES)}")
    return kind


def _label(label: str, generate: str) -> str:
    if label and not generate:
        raise pytest.UsageError("--facezip-as: says what new references are for; add --facezip-generate")
    if label and not is_label(label):
        raise pytest.UsageError(f"--facezip-as {label}: letters, digits, '_', '.' and '-' alone")
    return label


def _commit(config: pytest.Config, generate: str) -> str:
    revision = config.getoption("facezip_baseline_commit")
    if not revision:
        return ""
    if generate:
        raise pytest.UsageError(
            "--facezip-generate: a commit cannot be written to; leave --facezip-baseline-commit out"
        )
    from facezip.errors import FaceZipError
    from render.plugin.commit import commit_id

    try:
        return commit_id(revision, config.rootpath)
    except FaceZipError as error:
        raise pytest.UsageError(f"--facezip-baseline-commit: {error}") from None


def _probability(name: str, text: str | float) -> float:
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not 0 < value < 1:
        raise pytest.UsageError(f"facezip {name} {text}: must be a number between 0 and 1")
    return value
