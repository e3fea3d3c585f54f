"""How many cores are at work on what while something runs: every thread is looked at, again and again (Linux)."""

import sys
import threading
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter, process_time
from types import FrameType

import numpy as np
from numpy.typing import NDArray

from facezip.machine.cores import cores

# Seconds between two looks at all threads.
STEP = 0.01
# Looks over which it is seen how many threads want a core.
SOME = 100
REST = "the rest"
# A stage, its colour, and how the modules begin whose functions are its work; a thread is at that of the innermost one.
STAGES = {
    "images decoded": ("#3b6ea5", ("facezip.files.decoding", "facezip.files.bands", "facezip.files.opening")),
    "meshes read": ("#6a4c93", ("facezip.files.obj", "facezip.character.obj_parts", "facezip.character.folder_meshes")),
    "meshes placed": ("#a58ac2", ("facezip.character.placement", "facezip.character.orientation")),
    "registration checked": ("#c9a227", ("facezip.character.alignment", "facezip.character.features")),
    "fitted": ("#b5652b", ("facezip.fit.",)),
    "pack written": ("#2e7d5b", ("facezip.files.images", "facezip.files.writing", "facezip.pack.write")),
    "pack hashed": ("#55606e", ("facezip.pack.verification",)),
    "errors measured": ("#8fb8a3", ("facezip.pack.measure", "facezip.pack.errors")),
    REST: ("#c9ccd1", ()),
}
# This one holds all stages together.
AROUND = "facezip.fit.pipeline"


@dataclass(frozen=True)
class Moment:
    """What happened between two looks.

    Attributes
    ----------
    seconds : how long that took.
    work : seconds on a core by stage.
    waited : seconds that threads were kept from a core by others, of this program or not.
    """

    seconds: float
    work: Mapping[str, float]
    waited: float


class Watch:
    """Looks at all threads of the process while its block runs (Linux)."""

    def __init__(self) -> None:
        self.moments: list[Moment] = []
        self._end = threading.Event()
        self._watcher = threading.Thread(target=self._run)
        self._main = threading.get_ident()

    def __enter__(self) -> "Watch":
        self._watcher.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._end.set()
        self._watcher.join()

    def _run(self) -> None:
        before, at, used = dict(self._threads()), perf_counter(), process_time()
        while not self._end.wait(STEP):
            now, after, used_now = dict(self._threads()), perf_counter(), process_time()
            self.moments.append(self._moment(before, now, after - at, used_now - used))
            before, at, used = now, after, used_now

    def _threads(self) -> Iterator[tuple[int, tuple[int, float, float]]]:
        """By the system's number of a thread: Python's, and seconds on a core, and waiting for one."""
        for thread in threading.enumerate():
            if thread is self._watcher or thread.native_id is None or thread.ident is None:
                continue
            try:
                ran, waited, _ = Path(f"/proc/self/task/{thread.native_id}/schedstat").read_text("ascii").split()
            except OSError:
                # It has come to its end.
                continue
            yield thread.native_id, (thread.ident, int(ran) / 1e9, int(waited) / 1e9)

    def _moment(
        self,
        before: Mapping[int, tuple[int, float, float]],
        now: Mapping[int, tuple[int, float, float]],
        passed: float,
        used: float,
    ) -> Moment:
        frames = sys._current_frames()
        otherwise = stage_of(frames.get(self._main)) or REST
        work, kept = dict.fromkeys(STAGES, 0.0), 0.0
        for number, (thread, ran, waited) in now.items():
            _, ran_before, waited_before = before.get(number, (0, 0.0, 0.0))
            work[stage_of(frames.get(thread)) or otherwise] += ran - ran_before
            kept += waited - waited_before
        # Threads that ended in between count as the others.
        seen = sum(work.values())
        work = {stage: seconds * used / seen for stage, seconds in work.items()} if seen else work
        return Moment(passed, work, kept)


def stage_of(frame: FrameType | None) -> str | None:
    """What a thread is at, by the innermost of its functions that belongs to a stage."""
    while frame is not None:
        module = str(frame.f_globals.get("__name__", ""))
        for stage, (_, begins) in STAGES.items():
            if module.startswith(begins) and module != AROUND:
                return stage
        frame = frame.f_back
    return None


def watched(run: Callable[[], object]) -> list[Moment]:
    """The moments of a run; of its second time, when all that is loaded once is."""
    run()
    with Watch() as watch:
        run()
    return watch.moments


def undisturbed(moments: list[Moment]) -> NDArray[np.float64]:
    """``(M,)``: seconds that each would have taken, had other programs left all cores to this one.

    Threads that are at work or wait for a core would have all cores between them. It is seen over some time, since the
    system counts waiting when it ends.
    """
    some = np.ones(min(SOME, len(moments)))
    passed = np.array([moment.seconds for moment in moments])
    time, waited = (np.convolve(values, some, "same") for values in (passed, [moment.waited for moment in moments]))
    used = np.convolve([sum(moment.work.values()) for moment in moments], some, "same")
    share = used / np.maximum(np.minimum(used + waited, cores() * time), 1e-9)
    return np.where(waited > 0, np.minimum(share, 1), 1) * passed
