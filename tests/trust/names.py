"""Hostile names: nothing is written outside the output folder, nothing runs in a page."""

import re
import shutil
import subprocess
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from facezip import FaceZipError
from facezip.character.loading import save_character
from facezip.export.web import export_web
from facezip.names import is_safe_name
from facezip.pack.read import read_pack
from facezip.pack.write import write_pack
from render.validation import Settings, validate
from reports.paper.experiments import Settings as PaperSettings
from reports.paper.report import write_paper_report
from reports.paper.reproduction import reproduce
from reports.rates.experiment import measure_rates
from reports.rates.report import write_rates_report
from reports.validation import write_validation_report
from tests.facezip.conftest import random_character, random_model
from tests.reports.conftest import make_document
from tests.trust.children import command, in_child
from tests.trust.claims import sign
from tests.trust.findings import Row

OWNED = "document.documentElement.dataset.owned=1"
PATHS = [
    "../escaped", "../../escaped", "..", ".", "", "/tmp/escaped", "a/../../escaped", "..\\escaped", "C:\\escaped",
    "nul", "CON.png", "a:stream", "a\0b", "line\nbreak", "\x1b]0;owned\x07\x1b[2J", "\u202egnp.esrever", "\udcff",
    "-rf", "~", "$(touch escaped)", "e" * 300,
]  # fmt: skip
MARKUP = [
    f"<script>{OWNED}</script>", f"</script><script>{OWNED}</script>", f"<img src=x onerror={OWNED}>",
    f"\"><svg onload='{OWNED}'>", f"' onmouseover='{OWNED}' autofocus onfocus='{OWNED}' x='",
    f"<!--<script>-->{OWNED}//", f"javascript:{OWNED}", f"</title><script>{OWNED}</script>",
    f"</style><script>{OWNED}</script>", f"]]><script>{OWNED}</script>", f"\u2028{OWNED}//", "{{ 7*7 }}{% raw %}",
    f"<iframe srcdoc='<script>parent.{OWNED}</script>'>", f"<base href='//owned'><a href=x>{OWNED}",
]  # fmt: skip
HOSTILE = PATHS + MARKUP
POLICY = re.compile(r'<meta http-equiv="Content-Security-Policy"[^>]*>')
CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
FLAGS = [
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-sync",
    "--disable-background-networking", "--disable-component-update", "--virtual-time-budget=3000", "--dump-dom",
]  # fmt: skip


def check_names(work: Path, part: float) -> list[Row]:
    """Every name by every way in; the pages with all names at once. A small ``part`` takes some names and one page."""
    names, pages = (HOSTILE, PAGES) if part == 1 else (HOSTILE[::5], list(PAGES)[-1:])
    return [_written(work / "files", names), *(_page(work / kind, kind) for kind in pages)]


def _written(work: Path, names: Sequence[str]) -> Row:
    """Names that a library call, a file system and a forged pack bring in."""
    faults, examples = {"written outside": 0, "other exceptions": 0}, []
    ways: list[Callable[[Path, str], Any]] = [_by_library, _by_folder, _by_forged_pack, _by_forged_files]
    for number, name in enumerate(names):
        for way in ways:
            place = work / f"{number}" / way.__name__
            (place / "here").mkdir(parents=True)
            outcome = in_child(lambda way=way, place=place, name=name: _try(way, place / "here", name))
            escaped = sorted(entry.name for entry in place.iterdir() if entry.name != "here")
            if escaped or Path("/tmp/escaped").exists() or Path("escaped").exists():
                faults["written outside"] += 1
                examples.append(f"{name!r} {way.__name__}: wrote {escaped}")
            if outcome.code or outcome.answer:
                faults["other exceptions"] += 1
                examples.append(f"{name!r} {way.__name__}: {outcome.code} {outcome.answer}")
    what = f"hostile names, {len(names)} by {len(ways)} ways"
    return Row(what, len(names) * len(ways), faults, examples=tuple(examples))


def _try(way: Callable[[Path, str], Any], here: Path, name: str) -> str:
    try:
        way(here, name)
    except FaceZipError as error:
        return "" if str(error).isprintable() else f"unprintable message {error!s}"
    except Exception as error:
        return ascii(error)
    return ""


def _by_library(here: Path, name: str) -> None:
    write_pack(random_model(), here / "good.facezip", name=name[:100] if name.isprintable() else "")
    character = replace(random_character(side=16, grid=3, expressions=2), expressions=(name, "b"))
    for save in (
        lambda: save_character(character, here / "saved"),
        lambda: write_pack(replace(random_model(expressions=2), expressions=(name, "b")), here / "me.facezip"),
        # A name that is safe would be rendered, which takes its time and shows nothing.
        lambda: is_safe_name(name) or validate(character, [], here / "report", Settings(resolution=32, spp=2)),
    ):
        _refused_or_done(save)


def _by_folder(here: Path, name: str) -> None:
    """A folder of scans with that name in it, through the commands."""
    if "/" in name:
        return  # No file can have that name.
    scans = here / "scans"
    save_character(random_character(side=16, grid=3, expressions=3), scans)
    try:
        for suffix in (".obj", ".png"):
            (scans / f"expr_0{suffix}").rename(scans / f"{name}{suffix}")
    except (OSError, ValueError):
        return  # No file can have that name.
    if not (scans / f"{name}.obj").is_file() or len(list(scans.iterdir())) != 8:
        raise RuntimeError("the file left the folder by itself")
    for arguments in (
        ["compress", scans, "-o", here / "me.facezip"],
        ["decompress", here / "me.facezip", "-o", here / "textures"],
        ["info", here / "me.facezip"],
    ):
        code = command(arguments, here / "messages")
        said = (here / "messages").read_text(encoding="utf-8")
        if code not in (0, 3) or "Traceback" in said or not said.replace("\n", "").isprintable():
            raise RuntimeError(f"{code} {said}")


def _by_forged_pack(here: Path, name: str) -> None:
    _forged(here, {"expressions": [name, "b", "c"], "name": name, "method": name, "made_with": {name: name}})
    _forged(here, {"made_with": {name: name}})


def _by_forged_files(here: Path, name: str) -> None:
    _forged(here, {"files": {name: {"bytes": 1, "sha256": "0" * 64}}})


def _forged(here: Path, changes: dict[str, Any]) -> None:
    pack = here / "forged.facezip"
    for old in (pack, here / "textures"):
        shutil.rmtree(old, ignore_errors=True)
    write_pack(random_model(), pack)
    try:
        sign(pack, changes)
    except UnicodeEncodeError:
        return  # Not even a forger can write that.
    _refused_or_done(lambda: read_pack(pack))
    for arguments in (["info", pack], ["decompress", pack, "-o", here / "textures"]):
        code = command(arguments, here / "messages")
        said = (here / "messages").read_text(encoding="utf-8")
        if code not in (0, 3) or not said.replace("\n", "").isprintable():
            raise RuntimeError(f"{code} {said!r}")


def _refused_or_done(work: Callable[[], Any]) -> None:
    try:
        work()
    except FaceZipError as error:
        if not str(error).isprintable():
            raise RuntimeError(f"unprintable message {error!s}") from None


def _page(work: Path, kind: str) -> Row:
    """A page with every name in it, opened in Chromium, with its content security policy and without."""
    what = f"page of {kind} with hostile names, opened in Chromium"
    if CHROMIUM is None:
        return Row(what, 0, skipped="Chromium is not installed")
    page = PAGES[kind](work)
    content = page.read_text(encoding="utf-8")
    bare = page.with_name("bare.html")
    bare.write_text(POLICY.sub("", content), encoding="utf-8")
    ran = sum("data-owned" in dom_of(each) for each in (page, bare))
    return Row(what, 2, {"ran": ran, "without a policy": int(not POLICY.search(content))})


def _names(count: int) -> tuple[str, ...]:
    """All names, each one different, none empty: what the library lets into a document, whatever the readers refuse."""
    return tuple(name.encode(errors="backslashreplace").decode() or "empty" for name in HOSTILE)[:count]


def _validation_page(folder: Path) -> Path:
    names = _names(len(HOSTILE))
    document = make_document(folder, packs=(MARKUP[0], MARKUP[1]), expressions=names, views=("front",), name=MARKUP[2])
    document["conditions"]["texture_region"] = MARKUP[3]
    return write_validation_report(document | {"command": MARKUP[7]}, folder)


def _paper_page(folder: Path) -> Path:
    folder.mkdir(parents=True)
    names = _names(len(HOSTILE))
    character = replace(random_character(side=32, expressions=len(names)), expressions=names, name=MARKUP[0])
    document = reproduce([character], 1, PaperSettings(masks=5, restarts=2, starts=2, mask_counts=(3, 5)), MARKUP[2])
    return write_paper_report(replace(document, command=MARKUP[1]), folder)


def _rates_page(folder: Path) -> Path:
    folder.mkdir(parents=True)
    names = _names(len(HOSTILE))[-4:]
    character = replace(random_character(side=32, expressions=4), expressions=names, name=MARKUP[0])
    document = measure_rates(character, 0, "fast", 0)
    about = replace(document.conditions, texture_region=MARKUP[3])
    return write_rates_report(replace(document, conditions=about, command=MARKUP[1]), folder)


def _viewer_page(folder: Path) -> Path:
    """Of the names that a pack may hold; the others are refused before (see above)."""
    folder.mkdir(parents=True)
    names = tuple(name for name in _names(len(HOSTILE)) if is_safe_name(name))
    model = replace(random_model(expressions=len(names), meshes=True), expressions=names)
    write_pack(model, folder / "h.facezip", name=MARKUP[1], made_with={MARKUP[0]: MARKUP[7]})
    return Path(export_web(folder / "h.facezip", folder / "index.html").output)


PAGES = {"paper": _paper_page, "rates": _rates_page, "validate": _validation_page, "the viewer": _viewer_page}


def dom_of(page: Path) -> str:
    with tempfile.TemporaryDirectory() as profile:
        call = [str(CHROMIUM), *FLAGS, f"--user-data-dir={profile}", page.as_uri()]
        return subprocess.run(call, capture_output=True, text=True, timeout=120, check=True).stdout
