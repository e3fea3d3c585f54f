"""The readers under random bytes: ``python -m tests.trust.fuzz [--seconds 600 | --inputs 8000] [--reader image]``.

A corpus of small valid files, and changes to them. A finding is whatever leaves a reader but a ``FaceZipError``: it is
kept under ``out/fuzz/``; once it is understood, it moves to ``tests/data/findings`` under a name that says what it is,
and is read by the tests from then on.
"""

import argparse
import hashlib
import itertools
import json
import logging
import math
import random
import re
import shutil
import sys
import tempfile
import time
import warnings
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from PIL import Image

from facezip import FaceZipError
from facezip.batch.finished import earlier
from facezip.batch.jobs import find_jobs
from facezip.character.loading import load_character, save_character
from facezip.character.settings import SETTINGS
from facezip.export.animation import read_animation
from facezip.files.images import read_texture
from facezip.files.obj import read_obj
from facezip.files.packs import MANIFEST
from facezip.files.values import read_values
from facezip.fit.mask_folder import read_masks
from facezip.pack.read import read_pack
from facezip.pack.verification import stored
from tests.facezip.character.gltfs import full_scene
from tests.facezip.conftest import random_character
from tests.facezip.surfaces import random_surface
from tests.trust import mutations
from tests.trust.children import in_child
from tests.trust.damage import GOLDEN, LAYERED, MASKED
from tests.trust.findings import Row
from tests.trust.mutants import COMPRESSIONS, store_as
from tests.trust.statements import make_statements

FINDINGS = Path(__file__).parent.parent / "data" / "findings"
BATCH = 200
TEXTUAL = {
    ".obj": [mutations.change_token] * 6,
    ".json": [mutations.change_token] * 6,
    ".toml": [mutations.change_token] * 6,
    ".glb": [mutations.change_number] * 12,
    ".gltf": [mutations.change_number, mutations.change_token] * 6,
}

LAYOUT = """meshes = "{name}.obj"
[maps.albedo]
files = "{name}.{tile}.png"
[maps.normal]
files = "{name}.normal.{tile}.png"
green = "down"
[maps.gloss]
files = "{name}.roughness.{tile}.png"
encoding = "data"
float = true
"""

MASKS = """activations = "0..1"
sum_to_one = false
layers = { brow = [0, 1] }
channels = { face = ["jaw", "nose", ""] }
"""
CHARACTERS = """method = "refined"
differences = 4
[[character]]
path = "one"
[[character]]
path = "two"
name = "b"
masks = "masks"
"""
ANIMATION = """smile,"gains.expressions.smile",gains.regions.jaw
0.0,1,1
.5,1e0,-2
"""

# Notes on valid files are no findings, and would fill the terminal.
logging.getLogger("facezip").addHandler(logging.NullHandler())

# A file of the corpus → the reader that gets it, and the folder in which it stands.
READERS: dict[str, Callable[[Path], Any]] = {
    "image": read_texture,
    "image of numbers": read_values,
    "mesh": read_obj,
    "pack": lambda file: read_pack(file.parent),
    "signed pack": lambda file: read_signed(file),
    "glb": load_character,
    "gltf": lambda file: load_character(next(file.parent.glob("*.gltf"))),
    "character": lambda file: load_character(file.parent),
    "surface": lambda file: load_character(file.parent),
    "masks": lambda file: read_masks(file.parent),
    "list of characters": lambda file: find_jobs([file]),
    "record of a batch": lambda file: earlier(file.parent, ()),
    "animation": read_animation,
}


def read_signed(manifest: Path) -> None:
    """Read a pack whose manifest has the checksum that it should have, whatever it says."""
    blank = re.sub(
        rb'"sha256": "[0-9a-f]{64}",\n "format"', b'"sha256": "' + b"0" * 64 + b'",\n "format"', manifest.read_bytes()
    )
    manifest.write_bytes(blank.replace(b"0" * 64, hashlib.sha256(blank).hexdigest().encode(), 1))
    read_pack(manifest.parent)


def make_corpus(work: Path) -> dict[str, list[Path]]:
    """Small valid files for each reader."""
    images = []
    for suffix, kinds in COMPRESSIONS.items():
        for kind in kinds:
            folder = work / "image" / f"{suffix[1:]}-{kind}"
            save_character(random_character(side=16, grid=3, expressions=2), folder)
            store_as(folder / "neutral.png", suffix, kind)
            images.append(folder / f"neutral{suffix}")
    images += make_statements(work / "image")
    save_character(random_character(side=16, grid=3, expressions=2), work / "character")
    (work / "glb").mkdir()
    shutil.copytree(GOLDEN, work / "pack")
    for golden in (GOLDEN, LAYERED, MASKED):
        shutil.copytree(golden, work / golden.parent.name)
    save_character(random_character(side=16, grid=3, expressions=2), work / "glb" / "sheet.glb")
    (work / "gltf").mkdir()
    gltf = full_scene().write(work / "gltf", "gltf, files beside")
    save_character(random_surface(side=16, expressions=2, tiles=(2, 1)), work / "surface")
    (work / "surface" / SETTINGS).write_text(LAYOUT, encoding="utf-8")
    _make_lists(work)
    character = sorted((work / "character").iterdir())
    return {
        "glb": [work / "glb" / "sheet.glb"],
        "gltf": [gltf, gltf, *sorted(gltf.parent.iterdir())],
        "image": images,
        "image of numbers": images,
        "mesh": [file for file in character if file.suffix == ".obj"],
        "pack": [work / "pack" / MANIFEST, *sorted((work / "pack").glob("*.png"))[:3]],
        "signed pack": [work / golden.parent.name / MANIFEST for golden in (GOLDEN, LAYERED, MASKED)],
        "character": character,
        "surface": [work / "surface" / SETTINGS, *sorted((work / "surface").glob("neutral.*.png"))],
        "masks": [work / "masks" / "masks.toml", *sorted((work / "masks").glob("*.png"))],
        "list of characters": [work / "lists" / "characters.toml"],
        "record of a batch": [work / "record" / "golden.facezip.json"],
        "animation": [work / "lists" / "animation.csv"],
    }


def _make_lists(work: Path) -> None:
    """What is not of a character or a pack."""
    for name in ("masks", "lists", "record"):
        (work / name).mkdir()
    (work / "masks" / "masks.toml").write_text(MASKS, encoding="utf-8")
    for name, kind in (("brow", "L"), ("lid.1002", "L"), ("face", "RGB")):
        Image.new(kind, (4, 3), 100).save(work / "masks" / f"{name}.png")
    (work / "lists" / "characters.toml").write_text(CHARACTERS, encoding="utf-8")
    (work / "lists" / "animation.csv").write_text(ANIMATION, encoding="utf-8")
    pack = work / "record" / "golden.facezip"
    shutil.copytree(GOLDEN, pack)
    record = {"character": "scans/golden", "digest": "0", "manifest": stored(pack / MANIFEST).sha256, "document": {}}
    (work / "record" / "golden.facezip.json").write_text(json.dumps(record, indent=1), encoding="utf-8")


def finding(reader: str, file: Path) -> str:
    """What leaves the reader of ``file`` that must not; empty if nothing does."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            READERS[reader](file)
    except FaceZipError as error:
        return "" if "\n" not in str(error) else f"more than one line: {error}"
    except Exception as error:
        return repr(error)
    return ""


def try_bytes(reader: str, file: Path, content: bytes) -> str:
    """:func:`finding` with ``content`` in the place of a file of the corpus, which is put back."""
    original = file.read_bytes()
    file.write_bytes(content)
    try:
        return finding(reader, file)
    finally:
        file.write_bytes(original)


def different(files: list[Path]) -> list[Path]:
    """The files of a reader's corpus, each once."""
    return list(dict.fromkeys(files))


def parted(files: list[Path], data: bytes) -> tuple[Path, bytes]:
    """An input of :mod:`tests.trust.guided`: a byte that picks one of the files, and the bytes that it gets."""
    return files[data[0] % len(files)], data[1:]


def check_fuzz(work: Path, part: float) -> list[Row]:
    """The first batches of each reader, always the same ones."""
    corpus = make_corpus(work)
    return [_row(reader, files, max(1, round(5 * part))) for reader, files in corpus.items()]


def _row(reader: str, files: list[Path], batches: int) -> Row:
    found = [fault for seed in range(batches) for *_, fault in _batch(reader, files, seed)]
    return Row(
        f"fuzzed inputs of the {reader} reader", batches * BATCH, {"findings": len(found)}, examples=tuple(found)
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=60)
    parser.add_argument("--inputs", type=int, help="of each reader, instead of so many seconds")
    parser.add_argument("--reader", choices=READERS)
    parser.add_argument("--seed", type=int, default=0, help="of the first batch; the table begins with 0")
    options = parser.parse_args()
    readers = [options.reader] if options.reader else list(READERS)
    cases, found = Counter[str](), Counter[str]()
    with tempfile.TemporaryDirectory() as work:
        corpus = make_corpus(Path(work))
        for seed in _seeds(options, len(readers)):
            reader = readers[seed % len(readers)]
            for kind, content, fault in _batch(reader, corpus[reader], seed):
                keep(kind, bytes.fromhex(content), fault)
                found[reader] += 1
            cases[reader] += BATCH
            print(f"\r{cases.total()} cases, {found.total()} findings", end="", file=sys.stderr)
    print(file=sys.stderr)
    print(
        *(Row(f"fuzzed inputs of the {name} reader", cases[name], {"findings": found[name]}) for name in readers),
        sep="\n",
    )
    sys.exit(1 if found else 0)


def _seeds(options: argparse.Namespace, readers: int) -> Iterator[int]:
    """Of batches that readers get in turn."""
    if options.inputs is not None:
        return iter(range(options.seed, options.seed + math.ceil(options.inputs / BATCH) * readers))
    end = time.monotonic() + options.seconds
    return itertools.takewhile(lambda _: time.monotonic() < end, itertools.count(options.seed))


def _batch(reader: str, files: list[Path], seed: int) -> list[tuple[str, str, str]]:
    """Findings of a batch: reader and file, the bytes as hexadecimal digits, and what happened."""
    cases = _cases(files, seed)
    outcome = in_child(lambda: [try_bytes(reader, file, content) for file, content in cases], limit=300)
    if outcome.code == 0:
        faults = outcome.answer
    else:
        faults = []
        for file, content in cases:
            single = in_child(lambda file=file, content=content: try_bytes(reader, file, content), limit=20)
            faults.append(single.answer if single.code == 0 else f"ended with {single.code}")
    pairs = zip(cases, faults, strict=True)
    return [(f"{reader}-{file.name}", content.hex(), fault) for (file, content), fault in pairs if fault]


def _cases(files: list[Path], seed: int) -> list[tuple[Path, bytes]]:
    rng = random.Random(seed)
    cases = []
    for _ in range(BATCH):
        file = rng.choice(files)
        kinds = (*mutations.ALL, *TEXTUAL.get(file.suffix, ()))
        cases.append((file, mutations.mutate(rng, file.read_bytes(), kinds)))
    return cases


def keep(kind: str, content: bytes, fault: str) -> None:
    """Store what a reader did not survive, and say so."""
    folder = Path("out") / "fuzz"
    folder.mkdir(parents=True, exist_ok=True)
    name = folder / f"{hashlib.sha256(content).hexdigest()[:12]}-{kind}"
    name.write_bytes(content)
    print(f"\n{name}: {fault}", file=sys.stderr)


if __name__ == "__main__":
    main()
