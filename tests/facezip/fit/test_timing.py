import subprocess
import sys

import numpy as np
import pytest

from facezip import FaceZipError
from facezip.character.loading import save_character
from facezip.fit import timing
from facezip.machine.conditions import peak_memory


def dies(*_):
    import os

    os._exit(1)


@pytest.fixture
def scans(character, tmp_path):
    save_character(character, tmp_path / "scans")
    (tmp_path / "scans" / "mask_notes.png").write_bytes(b"an image that is not read")
    return tmp_path / "scans"


def test_the_images_alone_are_those_of_the_run(scans, tmp_path, monkeypatch):
    decoded, encoded = set(), {}
    read, write = timing.read_texture, timing.write_texture

    def reading(path):
        decoded.add(path.name)
        return read(path)

    def writing(path, texels):
        write(path, texels)
        encoded[path.name] = path.read_bytes() == (path.parent / "bench.facezip" / path.name).read_bytes()

    monkeypatch.setattr(timing, "read_texture", reading)
    monkeypatch.setattr(timing, "write_texture", writing)
    timing.compress_once(scans, tmp_path)
    assert decoded == {path.with_suffix(".png").name for path in scans.glob("*.obj")}
    names = ("neutral", *(f"difference_{i}" for i in range(4)))
    assert encoded == dict.fromkeys(("weights.1001.png", *(f"albedo.1001.{name}.png" for name in names)), True)
    assert list(tmp_path.iterdir()) == [scans]


def test_a_process_that_dies_is_said_in_one_line(scans, tmp_path, monkeypatch):
    monkeypatch.setattr(timing, "compress_once", dies)
    with pytest.raises(FaceZipError, match=r"scans: .*choose a smaller --resolution"):
        timing.bench_compress(scans, scans, tmp_path, 1)


def test_memory_is_what_this_process_took_not_the_one_that_started_it():
    before = peak_memory()
    much = np.ones(50_000_000)
    assert peak_memory() >= before + 0.9 * (much.nbytes - before)
    script = "from facezip.machine.conditions import peak_memory; print(peak_memory())"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=60, check=True)
    assert int(done.stdout) < much.nbytes // 2
