"""What a run of pytest was asked for: where references and results are, and what to do with them."""

from dataclasses import dataclass
from pathlib import Path

import pytest

# The name under which a test's report carries its results.
PROPERTY = "facezip_image"
LEVEL = 0.001
SUMMARIES = ("html", "json")
DEFAULT_BASELINE, DEFAULT_RESULTS = "baseline", "facezip-results"


@dataclass(frozen=True)
class Settings:
    """Options of the command line, and where they are not given those of the configuration file.

    Attributes
    ----------
    generate : folder for new references, or None to compare.
    baseline : folder of the references, or None for ``baseline`` beside each test's file.
    results : folder for evidence and summaries.
    summaries : of :data:`SUMMARIES`.
    level : probability below which a comparison fails.
    """

    generate: Path | None
    baseline: Path | None
    results: Path
    summaries: tuple[str, ...]
    level: float

    @staticmethod
    def of(config: pytest.Config) -> "Settings":
        """Raises ``pytest.UsageError`` for a summary or level that there is not."""
        summaries = tuple(filter(None, (config.getoption("facezip_summary") or "").split(",")))
        unknown = [kind for kind in summaries if kind not in SUMMARIES]
        if unknown:
            raise pytest.UsageError(f"--facezip-summary: no kind '{unknown[0]}'; choose from {','.join(SUMMARIES)}")
        generate = config.getoption("facezip_generate")
        return Settings(
            generate=_here(config, generate) if generate else None,
            baseline=_folder(config, "facezip_baseline"),
            results=_folder(config, "facezip_results") or config.rootpath / DEFAULT_RESULTS,
            summaries=summaries,
            level=_level(config.getoption("facezip_level") or config.getini("facezip_level") or LEVEL),
        )

    def baseline_of(self, test_file: Path) -> Path:
        """The folder of the references of the tests in a file."""
        return self.baseline or test_file.parent / DEFAULT_BASELINE


def add_options(parser: pytest.Parser) -> None:
    """The flags and configuration values of the plugin."""
    group = parser.getgroup("facezip", "comparison of renders with references (facezip)")
    flags = {
        "generate": ("PATH", "write references into this folder instead of comparing with them"),
        "baseline": ("PATH", "folder of the references; by default 'baseline' beside each test's file"),
        "results": ("PATH", f"folder for evidence and summaries; by default '{DEFAULT_RESULTS}'"),
        "summary": ("KINDS", "html, json or both with a comma: a summary in the results folder"),
        "level": ("P", f"probability below which a comparison fails; by default {LEVEL:g}"),
    }
    for name, (value, text) in flags.items():
        group.addoption(f"--facezip-{name}", dest=f"facezip_{name}", metavar=value, default=None, help=text)
    for name in ("baseline", "results", "level"):
        parser.addini(f"facezip_{name}", f"as --facezip-{name}; paths from the root folder", default="")


def _folder(config: pytest.Config, name: str) -> Path | None:
    given, configured = config.getoption(name), config.getini(name)
    if given:
        return _here(config, given)
    return config.rootpath / configured if configured else None


def _here(config: pytest.Config, path: str) -> Path:
    return config.invocation_params.dir / path


def _level(text: str | float) -> float:
    try:
        level = float(text)
    except ValueError:
        level = 0.0
    if not 0 < level < 1:
        raise pytest.UsageError(f"facezip level {text}: must be a number between 0 and 1")
    return level
