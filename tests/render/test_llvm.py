import os
import subprocess
import sys
from pathlib import Path

import pytest

from render.llvm import OLDEST, start

START = "from render.llvm import start; print(start().llvm)"
OLD = [path for n in (14, 15, 16) for path in Path("/usr/lib").glob(f"**/libLLVM-{n}.so.1")]


def started(**environment):
    return subprocess.run(
        [sys.executable, "-c", f"{START}"],
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )


def test_a_plain_install_renders_whatever_llvm_the_system_has():
    environment = {key: value for key, value in os.environ.items() if key != "DRJIT_LIBLLVM_PATH"}
    done = subprocess.run(
        [sys.executable, "-c", START], env=environment, capture_output=True, text=True, timeout=120, check=False
    )
    assert done.returncode == 0, done.stderr
    assert int(done.stdout.split(".")[0]) >= OLDEST


@pytest.mark.parametrize("library", ["/nowhere/libLLVM.so", sys.executable, "/usr", *map(str, OLD[:2])])
def test_an_unusable_library_is_one_clear_error_and_never_an_abort(library):
    done = started(DRJIT_LIBLLVM_PATH=library)
    assert done.returncode == 1
    assert "no LLVM 17 or newer" in done.stderr.splitlines()[-1]
    assert library in done.stderr.splitlines()[-1]


@pytest.mark.skipif(not OLD, reason="no LLVM 14 to 16 on this system")
def test_dr_jit_imported_too_early_is_one_clear_error():
    script = f"import drjit.llvm; {START}"
    environment = {key: value for key, value in os.environ.items() if key != "DRJIT_LIBLLVM_PATH"}
    done = subprocess.run(
        [sys.executable, "-c", script], env=environment, capture_output=True, text=True, timeout=120, check=False
    )
    assert done.returncode == 1
    assert "Dr.Jit was imported earlier" in done.stderr.splitlines()[-1]


@pytest.mark.skipif(not [path for path in OLD if "-14" not in path.name], reason="no LLVM 15 or 16 on this system")
def test_a_scene_of_the_image_test_is_not_begun_with_a_library_that_aborts():
    script = """import mitsuba as mi; mi.set_variant('llvm_ad_rgb')
from render.plugin.sources import renders_of
renders_of(mi.cornell_box(), range(1), 1)"""
    environment = {key: value for key, value in os.environ.items() if key != "DRJIT_LIBLLVM_PATH"}
    done = subprocess.run(
        [sys.executable, "-c", script], env=environment, capture_output=True, text=True, timeout=120, check=False
    )
    assert done.returncode == 1
    assert "Dr.Jit was imported earlier" in done.stderr.splitlines()[-1]


def test_starting_again_answers_the_same():
    assert start() == start()
