"""Where nothing can be written to, libraries keep their caches in a folder of ours; elsewhere nothing is touched."""

import os
import subprocess
import sys
import tempfile

import pytest

from facezip.machine import caches

VARIABLES = ("NUMBA_CACHE_DIR", "DRJIT_CACHE_DIR", "MPLCONFIGDIR")
KERNEL = """
import facezip
from numba import njit

@njit(cache=True)
def twice(a):
    return 2 * a
"""


@pytest.fixture
def surroundings(tmp_path, monkeypatch):
    """An environment with a home and a temporary folder, as a dictionary."""
    (tmp_path / "tmp").mkdir(mode=0o777)
    (tmp_path / "home").mkdir()
    monkeypatch.setattr(os, "environ", {"HOME": str(tmp_path / "home")})
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "tmp"))
    return os.environ


def sealed(surroundings, tmp_path):
    """A home that nobody can make."""
    (tmp_path / "file").touch()
    surroundings["HOME"] = str(tmp_path / "file/home")


def test_where_all_is_well_nothing_is_named_and_nothing_made(surroundings, tmp_path):
    before = dict(surroundings)
    caches.settle()
    assert surroundings == before
    assert [*tmp_path.rglob("*/*")] == []


@pytest.mark.parametrize("home", ["file/home", "file", "~"])
def test_without_a_home_every_library_has_a_folder_of_its_own(surroundings, tmp_path, home):
    sealed(surroundings, tmp_path)
    surroundings["HOME"] = str(tmp_path / home) if home.startswith("file") else home
    caches.settle()
    folders = {surroundings[variable] for variable in VARIABLES}
    assert len(folders) == 3
    assert {os.path.dirname(folder) for folder in folders} == {str(caches.private_folder())}
    assert caches.private_folder().stat().st_mode & 0o777 == 0o700


def test_a_folder_that_a_person_named_stays(surroundings, tmp_path):
    sealed(surroundings, tmp_path)
    surroundings["NUMBA_CACHE_DIR"] = str(tmp_path / "mine")
    caches.settle()
    assert surroundings["NUMBA_CACHE_DIR"] == str(tmp_path / "mine")


def test_a_later_process_has_the_same_folder(surroundings):
    assert caches.private_folder() == caches.private_folder()


@pytest.mark.parametrize("kind", ["open to all", "a link", "a file"])
def test_a_folder_that_others_could_fill_is_not_taken(surroundings, tmp_path, kind):
    taken = caches.private_folder()
    taken.rmdir()
    if kind == "a file":
        taken.touch()
    elif kind == "a link":
        (tmp_path / "theirs").mkdir(mode=0o700)
        taken.symlink_to(tmp_path / "theirs")
    else:
        taken.mkdir()
        taken.chmod(0o777)
    other = caches.private_folder()
    assert other != taken
    assert other.stat().st_mode & 0o777 == 0o700
    assert not other.is_symlink()


# Some seconds: numba, in a process of its own.
def test_kernels_compile_where_neither_sources_nor_home_take_a_cache(tmp_path):
    (tmp_path / "kernel.py").write_text(KERNEL)
    (tmp_path / "__pycache__").touch()
    (tmp_path / "tmp").mkdir()
    around = {**os.environ, "HOME": f"{tmp_path}/kernel.py/home", "TMPDIR": f"{tmp_path}/tmp"}
    around = {name: value for name, value in around.items() if name not in VARIABLES and not name.startswith("XDG_")}
    around["PYTHONPATH"] = os.pathsep.join([str(tmp_path), *sys.path])
    command = [sys.executable, "-c", "from kernel import twice; print(twice(21))"]
    done = subprocess.run(command, env=around, capture_output=True, text=True, timeout=100, check=False)
    assert (done.stdout, done.stderr) == ("42\n", "")
    assert [*tmp_path.glob("tmp/facezip-*/numba/*/*.nbc")]
