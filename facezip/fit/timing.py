"""The time of the main job, a folder of scans in and a measured pack out, beside that of its images alone.

Reading and writing images is what no compressor of textures can avoid. So its time is taken right after each run, in
the same process, on the same files, by the functions and on as many threads as the product uses: the ratio depends
little on the machine and on what else it does.
"""

import signal
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass, replace
from multiprocessing import get_context
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import TypeVar

from facezip.character.alignment import alignments
from facezip.character.filenames import MASK
from facezip.character.loading import load_character
from facezip.character.maps import ALBEDO
from facezip.character.scans import NEUTRAL
from facezip.errors import ErrorCode, FaceZipError
from facezip.files.images import read_texture, read_texture_exactly, write_texture
from facezip.files.opening import TEXTURE_SUFFIXES
from facezip.fit.methods import compress
from facezip.machine.conditions import peak_memory
from facezip.machine.cores import cores
from facezip.machine.memory import limited
from facezip.machine.progress import track
from facezip.pack.errors import pack_errors
from facezip.pack.write import write_pack

Result = TypeVar("Result")


@dataclass(frozen=True, kw_only=True)
class TimedRun:
    """Wall time of one run, in seconds.

    Attributes
    ----------
    load_s, fit_s, check_s, write_s, measure_s : of its parts: ``check`` is whether textures are registered, as long as
        that lasts beyond the fit beside which it runs; ``measure`` reads the pack back and compares it.
    total_s : their sum.
    rmse : 0..255, mean over expressions.
    bytes_on_gpu : of the pack.
    peak_memory_mb : of the process up to then.
    decode_s, encode_s, io_s : of the same images alone, and their sum.
    ratio : of the sums.
    """

    load_s: float
    fit_s: float
    check_s: float
    write_s: float
    measure_s: float
    total_s: float
    rmse: float
    bytes_on_gpu: int
    peak_memory_mb: float
    decode_s: float
    encode_s: float
    io_s: float
    ratio: float


@dataclass(frozen=True, kw_only=True)
class CompressBench(TimedRun):
    """The run of median ratio, with the peak memory of the first.

    Attributes
    ----------
    runs : all of them.
    """

    runs: Sequence[TimedRun]


def bench_compress(folder: Path, tiny: Path, work: Path, repeats: int, memory: int | None = None) -> CompressBench:
    """Compress a character ``repeats`` times in a fresh process.

    Parameters
    ----------
    folder : the character.
    tiny : a small character with texels of the same type, compressed before in a process of its own: it leaves compiled
        kernels on disk, as every earlier use of the program does.
    work : an existing folder for what is written.
    repeats : at least 1.
    memory : most bytes that a run may have resident (:mod:`facezip.machine.memory`); None for no limit.

    Raises
    ------
    FaceZipError
        ``BAD_VALUE``: the process came to its end, as it does where memory runs out.
    """
    _runs(tiny, work, 1, None, "Compiling")
    runs = _runs(folder, work, repeats, memory, "Compressing")
    by_ratio = sorted(runs, key=lambda run: run.ratio)
    # Of the first run: the images alone, decoded after it, are not bound to any limit.
    median = replace(by_ratio[(repeats - 1) // 2], peak_memory_mb=runs[0].peak_memory_mb)
    return CompressBench(**vars(median), runs=runs)


def compress_once(folder: Path, work: Path, memory: int | None = None) -> TimedRun:
    """Compress a character with the defaults, write and measure the pack; then decode and encode the same images."""
    with TemporaryDirectory(dir=work) as place:
        with limited(memory, Path(place)):
            seconds, rmse, size = _compressed(folder, Path(place) / "bench.facezip")
            peak = peak_memory() / 1e6
        images = _coded(_images(folder), sorted((Path(place) / "bench.facezip").glob("*.png")), Path(place))
    total, io = sum(seconds.values()), sum(images.values())
    return TimedRun(
        **seconds,
        **images,
        total_s=total,
        io_s=io,
        ratio=total / io,
        rmse=rmse,
        bytes_on_gpu=size,
        peak_memory_mb=peak,
    )


def _compressed(folder: Path, pack: Path) -> tuple[dict[str, float], float, int]:
    """Seconds of the parts, the error, and bytes on the GPU."""
    character, load_s = _timed(lambda: load_character(folder))
    with ThreadPoolExecutor(1) as beside:
        checked = beside.submit(alignments, character)
        model, fit_s = _timed(lambda: compress(character))
        _, check_s = _timed(checked.result)
    _, write_s = _timed(lambda: write_pack(model, pack))
    errors, measure_s = _timed(lambda: pack_errors(character, pack))
    seconds = {"load_s": load_s, "fit_s": fit_s, "check_s": check_s, "write_s": write_s, "measure_s": measure_s}
    return seconds, errors[ALBEDO].mean, model.footprint.bytes_on_gpu


def _coded(inputs: list[Path], outputs: list[Path], work: Path) -> dict[str, float]:
    texels = {path.name: read_texture_exactly(path) for path in outputs}
    with ThreadPoolExecutor(cores()) as pool:
        # Nothing is kept of the inputs: reading them again must not add to the memory that compressing took.
        _, decode_s = _timed(lambda: list(pool.map(lambda path: read_texture(path).size, inputs)))
        _, encode_s = _timed(lambda: list(pool.map(lambda name: write_texture(work / name, texels[name]), texels)))
    return {"decode_s": decode_s, "encode_s": encode_s}


def _images(folder: Path) -> list[Path]:
    """The images that ``load_character`` reads: those that have a mesh, and the mask."""
    names = {NEUTRAL, MASK, *(path.stem for path in folder.glob("*.obj"))}
    return sorted(path for path in folder.iterdir() if path.suffix.lower() in TEXTURE_SUFFIXES and path.stem in names)


def _runs(folder: Path, work: Path, repeats: int, memory: int | None, description: str) -> list[TimedRun]:
    # An interrupt ends the process at once and without a word; this one says what there is to say.
    alone = ProcessPoolExecutor(1, get_context("spawn"), signal.signal, (signal.SIGINT, signal.SIG_DFL))
    try:
        with alone as pool:
            calls = track(range(repeats), description, repeats)
            return [pool.submit(compress_once, folder, work, memory).result() for _ in calls]
    except BrokenProcessPool:
        reason = "the process that compressed it was ended, most likely for memory; choose a smaller --resolution"
        raise FaceZipError(ErrorCode.BAD_VALUE, f"{folder}: {reason}") from None


def _timed(work: Callable[[], Result]) -> tuple[Result, float]:
    begin = perf_counter()
    return work(), perf_counter() - begin
