"""A folder that another one replaces while it is read is read again: what comes out is never of both."""

import pytest

from facezip.errors import ErrorCode, FaceZipError
from facezip.files.reading import undisturbed
from facezip.files.renaming import exchange, put_in_place


def folder(path, content):
    path.mkdir()
    (path / "first").write_text(content)
    (path / "second").write_text(content)
    return path


def reading(path, between):
    """Reads two files; something happens between."""

    def read():
        found = [(path / "first").read_text()]
        between()
        return [*found, (path / "second").read_text()]

    return read


@pytest.mark.parametrize("times", [0, 1, 5])
def test_the_last_folder_is_read_whole(tmp_path, times):
    here, other = folder(tmp_path / "here", "0"), tmp_path / "other"
    left = list(range(1, times + 1))

    def replace():
        if left:
            put_in_place(folder(other, str(left.pop(0))), here)
            if other.exists():
                other.rename(tmp_path / f"old_{len(left)}")

    assert undisturbed(here, reading(here, replace)) == [str(times)] * 2


def test_an_error_of_a_folder_that_stays_is_its_own(tmp_path):
    calls = []

    def read():
        calls.append(1)
        raise FaceZipError(ErrorCode.DAMAGED_PACK, "damaged")

    with pytest.raises(FaceZipError, match="damaged"):
        undisturbed(folder(tmp_path / "here", "0"), read)
    assert len(calls) == 1


def test_an_error_of_a_folder_that_was_replaced_meanwhile_is_not(tmp_path):
    here, other = folder(tmp_path / "here", "0"), folder(tmp_path / "other", "1")
    calls = []

    def read():
        calls.append(1)
        if len(calls) == 1:
            assert exchange(here, other)
            raise FaceZipError(ErrorCode.DAMAGED_PACK, "of both")
        return (here / "first").read_text()

    assert undisturbed(here, read) == "1"


def test_no_folder_is_an_error_at_once(tmp_path):
    def read():
        raise FaceZipError(ErrorCode.MISSING_FILE, "no such pack")

    with pytest.raises(FaceZipError, match="no such pack"):
        undisturbed(tmp_path / "nowhere", read)


def test_a_folder_that_never_stays_is_an_error(tmp_path, monkeypatch):
    monkeypatch.setattr("time.sleep", lambda _: None)
    here, other = folder(tmp_path / "here", "0"), folder(tmp_path / "other", "1")
    with pytest.raises(FaceZipError, match="replaces it again and again") as refused:
        undisturbed(here, reading(here, lambda: exchange(here, other)))
    assert refused.value.code is ErrorCode.CANNOT_READ
