import hashlib
import re
import sys
import threading
from concurrent.futures import ThreadPoolExecutor
from time import thread_time

import numpy as np
import pytest

from facezip.machine.cores import cores
from reports.timeline import picture
from reports.watching import REST, STAGES, STEP, Moment, Watch, stage_of, undisturbed

ON_LINUX = pytest.mark.skipif(sys.platform != "linux", reason="the time that threads take is Linux's to tell")


def moments(count, seconds, at_work, waiting):
    work = dict.fromkeys(STAGES, 0.0) | {"fitted": seconds * at_work}
    return [Moment(seconds, work, seconds * waiting)] * count


@ON_LINUX
def test_all_time_on_a_core_is_seen():
    used = []

    def busy():
        begin = thread_time()
        for _ in range(200):
            hashlib.sha256(bytes(2**20)).hexdigest()
        used.append(thread_time() - begin)

    with Watch() as watch, ThreadPoolExecutor(2) as pool:
        for future in [pool.submit(busy) for _ in range(2)]:
            future.result()
    seen = sum(sum(moment.work.values()) for moment in watch.moments)
    assert seen == pytest.approx(sum(used), rel=0.5, abs=5 * STEP)


def test_a_thread_is_at_what_its_innermost_function_is_of():
    frames = {}

    def inside():
        frames["here"] = sys._current_frames()[threading.get_ident()]

    outer = {"__name__": "facezip.fit.sweep", "inside": inside}
    exec("def run(): inside()", outer)
    outer["run"]()
    assert stage_of(frames["here"]) == "fitted"
    between = {"__name__": "facezip.files.decoding", "run": lambda: outer["run"]()}
    exec("def through(): run()", between)
    between["through"]()
    assert stage_of(frames["here"]) == "fitted"
    exec("def through(): inside()", {**outer, "__name__": "facezip.character.alignment"}, between)
    between["through"]()
    assert stage_of(frames["here"]) == "registration checked"
    assert stage_of(None) is None


@pytest.mark.parametrize("at_work", [0.25, 1.0, float(cores())])
def test_of_a_machine_that_does_nothing_else_seconds_are_its_clocks(at_work):
    np.testing.assert_allclose(undisturbed(moments(300, 0.01, at_work, 0.0)), 0.01)


def test_what_others_take_of_the_cores_does_not_count():
    """As many threads as there are cores are at work a fourth of the time, and wait for a core otherwise."""
    many = float(cores())
    found = undisturbed(moments(300, 0.01, many / 4, many * 3 / 4))
    np.testing.assert_allclose(found, 0.0025)


def test_the_areas_of_a_picture_are_the_time_on_a_core():
    work = dict.fromkeys(STAGES, 0.0)
    parts = [
        *[Moment(0.01, work | {"images decoded": 0.01 * cores()}, 0.0)] * 100,
        *[Moment(0.01, work | {"fitted": 0.005 * cores()}, 0.0)] * 300,
    ]
    text = picture(parts, "a run")
    assert f"a run: 4.0 s, 62% of {cores()} cores" in text
    areas = {colour: _area(steps) for steps, colour in re.findall(r'<path d="(M[^"]*)z" fill="([^"]*)"', text)}
    both = {STAGES[stage][0]: area for stage, area in (("images decoded", 1.0), ("fitted", 2.5), (REST, 2.5))}
    whole = max(areas.values()) / 2.5
    assert {colour: areas[colour] / whole for colour in both} == pytest.approx(both, rel=0.02)


def _area(steps):
    """Under a path of steps to the right, above the line that it begins at."""
    x, y = map(float, re.match(r"M([\d.]+) ([\d.]+)", steps).groups())
    total, floor = 0.0, y
    for up, right in re.findall(r"V([\d.]+)H([\d.]+)", steps):
        total += (floor - float(up)) * (float(right) - x)
        x = float(right)
    return total
