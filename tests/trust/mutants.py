"""Hostile meshes and images through ``facezip compress``: exit code 0 or 3, one line, never a traceback or a signal."""

import random
import shutil
import signal
import subprocess
import sys
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import OpenImageIO as oiio

from facezip import compress
from facezip.character.loading import load_character, save_character
from facezip.errors import ExitCode
from tests.facezip.conftest import random_character
from tests.trust import mutations
from tests.trust.children import command, in_child
from tests.trust.findings import Row

# The mesh matters to the paper's method alone.
PAPER = ("--method", "paper", "--masks", 4, "--restarts", 2)
REFINED = ()
COMPRESSIONS = {
    ".exr": ("zip", "piz", "none", "dwaa", "pxr24", "b44", "rle", "htj2k"),
    ".tif": ("none", "lzw", "zip", "packbits"),
    ".png": ("8", "16"),
    ".jpg": ("jpeg:98",),
    ".webp": ("lossless", "webp:90"),
    ".tga": ("none", "rle"),
    ".bmp": ("none",),
}


def check_mutants(work: Path, part: float) -> list[Row]:
    """250 mutants of each kind of file, in the place of an expression or of the neutral."""
    rows = []
    for suffix in (".obj", *COMPRESSIONS):
        originals = _originals(work / suffix[1:], suffix)
        _warm(originals[0], suffix)
        rows.append(_row(suffix, originals, max(4, round(250 * part))))
    return rows


def _originals(work: Path, suffix: str) -> list[Path]:
    """Characters whose expressions are stored in each of the ways that a format knows."""
    dtype = np.float32 if suffix == ".exr" else np.uint8
    scans = random_character(side=32, grid=5, expressions=3, dtype=dtype)
    folders = []
    for kind in COMPRESSIONS.get(suffix, ("",)):
        folders.append(work / (kind or "mesh"))
        save_character(scans, folders[-1])
        for image in () if suffix == ".obj" else (*folders[-1].glob("*.png"), *folders[-1].glob("*.exr")):
            store_as(image, suffix, kind)
    return folders


def store_as(image: Path, suffix: str, kind: str) -> None:
    texels = oiio.ImageBuf(str(image)).get_pixels(oiio.FLOAT)
    bits = "uint16" if kind == "16" else "uint8"
    spec = oiio.ImageSpec(*texels.shape[1::-1], texels.shape[2], "half" if suffix == ".exr" else bits)
    spec.attribute("compression", kind)
    image.unlink()
    output = oiio.ImageOutput.create(str(image.with_suffix(suffix)))
    output.open(str(image.with_suffix(suffix)), spec)
    output.write_image(texels)
    output.close()


def _warm(folder: Path, suffix: str) -> None:
    """Kernels are compiled once here, not in every child."""
    scans = load_character(folder)
    compress(scans, "paper", masks=4, restarts=2) if suffix == ".obj" else compress(scans)


def _row(suffix: str, originals: list[Path], count: int) -> Row:
    faults = {"other exit codes": 0, "tracebacks": 0, "signals or hangs": 0}
    examples, codes = [], Counter()
    for number, (folder, target, content) in zip(range(count), _cases(suffix, originals), strict=False):
        mutant = folder.parent / "mutant"
        shutil.rmtree(mutant, ignore_errors=True)
        shutil.copytree(folder, mutant)
        (mutant / target).write_bytes(content)
        fault, code = _fault(mutant, PAPER if suffix == ".obj" else REFINED)
        codes[code] += 1
        if fault:
            faults[fault.split(":")[0]] += 1
            kept = folder.parent / f"fault-{number}-{target}"
            kept.write_bytes(content)
            examples.append(f"{kept}: {fault}")
    notes = ", ".join(f"{n} times {code}" for code, n in sorted(codes.items()))
    return Row(f"mutants of *{suffix} through compress", count, faults, notes, tuple(examples))


def _cases(suffix: str, originals: list[Path]) -> Iterator[tuple[Path, str, bytes]]:
    rng = random.Random(suffix)
    kinds = (*mutations.ALL, *([mutations.change_token] * 6 if suffix == ".obj" else []))
    while True:
        folder = rng.choice(originals)
        target = rng.choice(["neutral", "expr_0", "expr_2"]) + suffix
        yield folder, target, mutations.mutate(rng, (folder / target).read_bytes(), kinds)


def _fault(mutant: Path, options: tuple) -> tuple[str, int]:
    messages, output = mutant.parent / "messages", mutant.parent / "out.facezip"
    outcome = in_child(lambda: command(["compress", mutant, "-o", output, "--overwrite", *options], messages))
    if outcome.code == -signal.SIGALRM and _ends(mutant, output, options):
        # A lock that was held during the fork: the file itself hangs nothing.
        return "", ExitCode.BAD_INPUT
    if outcome.code:
        return f"signals or hangs: {outcome.code} {outcome.answer}", outcome.code
    said = messages.read_text(encoding="utf-8", errors="replace")
    if "Traceback" in said or "Warning" in said:
        return f"tracebacks: {said[-600:]}", outcome.answer
    if outcome.answer == ExitCode.BAD_INPUT and said.count("\n") == 1:
        return "", outcome.answer
    return "" if outcome.answer == ExitCode.DONE else f"other exit codes: {outcome.answer} {said}", outcome.answer


def _ends(mutant: Path, output: Path, options: tuple) -> bool:
    """Whether the same call ends well in a process of its own."""
    call = [
        sys.executable,
        "-c",
        "from facezip.cli import main; main()",
        "compress",
        mutant,
        "-o",
        output,
        "--overwrite",
    ]
    try:
        done = subprocess.run([*map(str, (*call, *options))], capture_output=True, timeout=120, check=False)
    except subprocess.TimeoutExpired:
        return False
    return done.returncode in (ExitCode.DONE, ExitCode.BAD_INPUT) and b"Traceback" not in done.stderr
