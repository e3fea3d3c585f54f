"""The site of the documentation: gathers its pages in ``out/pages``; Zensical builds ``out/site`` from them.

python -m reports.site
"""

import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import click

from facezip.cli import facezip

ROOT = Path(__file__).parent.parent
PAGES, SITE = ROOT / "out" / "pages", ROOT / "out" / "site"
# Pages that stand beside docs/, by their name on the site.
BESIDE = {
    "README.md": "index.md",
    "CHANGELOG.md": "changelog.md",
    "CONTRIBUTING.md": "contributing.md",
    "SECURITY.md": "security.md",
    "THIRD_PARTY.md": "third-party.md",
}
LINK = re.compile(r"\]\(([^)#:]+)((?:#[^)]*)?)\)")
# Of a code block, in characters.
WIDTH = 80
# Zensical has pages load this one script from a server; docs/worker.js does its work.
SHIM = "https://unpkg.com/iframe-worker/shim"


def gather(pages: Path = PAGES) -> None:
    """Fill a folder with all that the site is built from: one flat folder of pages and pictures.

    Parameters
    ----------
    pages : the folder; what was in it goes.

    """
    shutil.rmtree(pages, ignore_errors=True)
    pages.mkdir(parents=True)
    for source in sorted((ROOT / "docs").iterdir()):
        if source.suffix == ".md":
            (pages / source.name).write_text(_page(source), encoding="utf-8")
        else:
            shutil.copy(source, pages)
    for name, there in BESIDE.items():
        (pages / there).write_text(_page(ROOT / name), encoding="utf-8")
    shutil.copy(ROOT / "CITATION.cff", pages)
    (pages / "commands.md").write_text(command_line(), encoding="utf-8")


def _page(source: Path) -> str:
    """A page whose links to files of the repository point to pages of the site."""

    def moved(link: re.Match[str]) -> str:
        target = (source.parent / link[1]).resolve()
        if target.parent == ROOT / "docs":
            return f"]({target.name}{link[2]})"
        return f"]({BESIDE.get(target.name, link[1])}{link[2]})"

    return LINK.sub(moved, source.read_text(encoding="utf-8"))


def command_line() -> str:
    """Every verb's help as it is printed, one section a verb, in Markdown."""
    parts = ["# Command line", "What `facezip --help` and `facezip VERB --help` print, for all verbs."]
    for context in _contexts(click.Context(facezip, None, "facezip", terminal_width=WIDTH, **facezip.context_settings)):
        parts += [f"## {context.command_path}", f"```text\n{context.get_help()}\n```"]
    return "\n\n".join(parts) + "\n"


def _contexts(context: click.Context) -> Iterator[click.Context]:
    yield context
    if isinstance(context.command, click.Group):
        for name in context.command.list_commands(context):
            command = context.command.get_command(context, name)
            if command is not None:
                yield from _contexts(click.Context(command, context, name, terminal_width=WIDTH))


def main() -> int:
    """Gather the pages and build them; what Zensical warns of is an error."""
    gather()
    build = [sys.executable, "-m", "zensical", "build", "--strict", "--clean", "-f", str(ROOT / "zensical.toml")]
    status = subprocess.run(build, cwd=ROOT, check=False).returncode
    if status == 0:
        for page in SITE.glob("*.html"):
            page.write_text(page.read_text(encoding="utf-8").replace(SHIM, "worker.js"), encoding="utf-8")
        print("open out/site/index.html", file=sys.stderr)
    return status


if __name__ == "__main__":
    sys.exit(main())
