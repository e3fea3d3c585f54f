"""References kept elsewhere, under their digests, and those of a commit."""

import hashlib
import json
import subprocess

import numpy as np
import pytest

from facezip.errors import ErrorCode, FaceZipError
from render.plugin.baseline import Baseline
from render.plugin.reference import Reference
from render.plugin.store import Store
from tests.documents.checked import check
from tests.render.plugin.conftest import BRIGHTER, EQUAL, STEM, renders

CONTENT = b"the bytes of a reference"
DIGEST = hashlib.sha256(CONTENT).hexdigest()


@pytest.fixture(autouse=True)
def cache(tmp_path, monkeypatch):
    """No test shares a cache with another, or with a user."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    return tmp_path / "cache" / "facezip" / "references"


@pytest.fixture(params=["folder", "file", "memory"])
def place(request, tmp_path):
    if request.param != "folder":
        pytest.importorskip("fsspec")
    # The memory of fsspec is one for the whole process.
    return {"folder": f"{tmp_path}/store", "file": f"file://{tmp_path}/store", "memory": f"memory://{tmp_path}"}[
        request.param
    ]


@pytest.fixture(scope="module")
def small():
    return Reference.of(renders(range(8))[:, :16, :16])


def test_what_was_put_is_fetched(place):
    assert Store(place).put(CONTENT) == DIGEST
    assert Store(place).put(CONTENT) == DIGEST
    assert Store(place).fetch(DIGEST).read_bytes() == CONTENT


def test_what_is_not_there_is_one_line(place):
    with pytest.raises(FaceZipError, match="no .*reference") as caught:
        Store(place).fetch(DIGEST)
    assert caught.value.code is ErrorCode.CANNOT_READ


def test_another_file_in_its_place_is_refused(place, tmp_path):
    Store(place).put(CONTENT)
    if place.startswith("memory"):
        import fsspec

        fsspec.filesystem("memory").pipe_file(f"{tmp_path}/{DIGEST[:2]}/{DIGEST}.exr", b"another")
    else:
        (tmp_path / "store" / DIGEST[:2] / f"{DIGEST}.exr").write_bytes(b"another")
    with pytest.raises(FaceZipError, match="sha256 is another"):
        Store(place).fetch(DIGEST)


def test_a_url_is_asked_once_and_a_spoilt_cache_again(tmp_path, cache):
    fsspec = pytest.importorskip("fsspec")
    store = Store(f"memory://{tmp_path}")
    store.put(CONTENT)
    kept = store.fetch(DIGEST)
    assert cache in kept.parents
    kept.write_bytes(b"spoilt")
    assert store.fetch(DIGEST).read_bytes() == CONTENT
    fsspec.filesystem("memory").rm(str(tmp_path), recursive=True)
    assert store.fetch(DIGEST).read_bytes() == CONTENT


def test_an_unknown_url_is_one_line():
    with pytest.raises(FaceZipError, match="facezip.store") as caught:
        Store("nothing-like-it://bucket").put(CONTENT)
    assert caught.value.code is ErrorCode.BAD_VALUE


def test_a_folder_holds_the_digest_or_the_image_never_both(tmp_path, small):
    here, elsewhere = Baseline(tmp_path / "b"), Baseline(tmp_path / "b", Store(str(tmp_path / "store")))
    path = elsewhere.write("a", small, "t.py::a")
    assert path.name == "a.exr.json"
    digest = elsewhere.digest("a")
    np.testing.assert_array_equal(elsewhere.read("a").mean, small.mean)
    assert (elsewhere.names(), elsewhere.test_of("a")) == (["a"], "t.py::a")
    with pytest.raises(FaceZipError, match="--facezip-store"):
        here.read("a")
    assert here.write("a", small, "t.py::a").name == "a.exr"
    assert [file.name for file in (tmp_path / "b").iterdir()] == ["a.exr"]
    assert (here.digest("a"), here.test_of("a")) == (digest, "t.py::a")
    (tmp_path / "b" / "a.exr.json").write_text("{}")
    with pytest.raises(FaceZipError, match="both a.exr and a.exr.json"):
        here.read("a")


POINTER = {"format": "facezip-pointer/1", "sha256": DIGEST, "size": 1, "test": ""}


@pytest.mark.parametrize("change", [{"sha256": "../../etc"}, {"sha256": DIGEST.upper()}, {"size": "1"}, {"test": None}])
def test_what_is_no_digest_is_one_line(tmp_path, change):
    (tmp_path / "a.exr.json").write_text(json.dumps(POINTER | change))
    with pytest.raises(FaceZipError, match=rf"a\.exr\.json: .*{next(iter(change))}") as caught:
        Baseline(tmp_path, Store(str(tmp_path))).read("a")
    assert caught.value.code is ErrorCode.BAD_VALUE


def test_a_digest_of_another_version_is_refused(tmp_path):
    (tmp_path / "a.exr.json").write_text(json.dumps(POINTER | {"format": "facezip-pointer/2"}))
    with pytest.raises(FaceZipError, match="facezip-pointer/2.*update facezip") as caught:
        Baseline(tmp_path, Store(str(tmp_path))).read("a")
    assert caught.value.code is ErrorCode.OTHER_FORMAT


def test_a_suite_with_its_images_elsewhere(project, pytester):
    pytester.makeini("[pytest]\nfacezip_store = ../store\n")
    project(EQUAL, "--facezip-generate=all").assert_outcomes(skipped=1)
    (pointer,) = (pytester.path / "baseline").iterdir()
    told = json.loads(pointer.read_text())
    assert check(told) == "pointer"
    assert (pointer.name, told["test"]) == (f"{STEM}.exr.json", "test_it.py::test_box")
    assert (pytester.path.parent / "store" / told["sha256"][:2] / f"{told['sha256']}.exr").is_file()
    assert project(EQUAL).ret == pytest.ExitCode.OK
    project(BRIGHTER).assert_outcomes(failed=1)
    result = project("def test_other(): pass\n")
    result.stdout.fnmatch_lines([f"*{STEM}.exr.json, made by test_it.py::test_box*"])


@pytest.fixture
def repository(generated, pytester):
    """The reference of ``EQUAL`` is committed; the one of ``BRIGHTER`` lies in the working tree."""

    def git(*arguments):
        identity = ("-c", "user.name=A", "-c", "user.email=a@b", "-c", "commit.gpgsign=false")
        subprocess.run(["git", *identity, *arguments], cwd=pytester.path, check=True, capture_output=True)

    git("init", "-q")
    git("add", "baseline")
    git("commit", "-qm", "one")
    generated(BRIGHTER, "--facezip-generate=all")
    return git


def test_the_references_of_a_commit_count(repository, project, pytester):
    project(BRIGHTER).assert_outcomes(passed=1)
    result = project(BRIGHTER, "--facezip-baseline-commit", "HEAD")
    result.assert_outcomes(failed=1)
    result.stdout.no_fnmatch_line("*--facezip-generate*")
    project(EQUAL, "--facezip-baseline-commit", "HEAD").assert_outcomes(passed=1)
    repository("rm", "-q", "--cached", "-r", "baseline")
    repository("commit", "-qm", "two")
    project(EQUAL, "--facezip-baseline-commit=HEAD").stdout.fnmatch_lines(["*no reference*"])
    project(EQUAL, "--facezip-baseline-commit=HEAD~1").assert_outcomes(passed=1)


@pytest.mark.parametrize("flags", [("no-such-commit",), ("--version",), ("HEAD", "--facezip-generate=all")])
def test_a_commit_that_there_is_not_stops_the_run(repository, project, flags):
    result = project(EQUAL, f"--facezip-baseline-commit={flags[0]}", *flags[1:])
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    result.stderr.fnmatch_lines(["*ERROR: --facezip*"])
