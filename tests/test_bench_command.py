"""``facezip bench`` as its users call it; what it says is checked, how fast it is never."""

import json
import re
from statistics import median_low

import numpy as np
import pytest

from facezip.character.loading import load_character, save_character
from facezip.errors import ExitCode
from facezip.files.images import write_texture
from tests.facezip.conftest import random_character
from tests.test_cli import run


@pytest.fixture(scope="module")
def document():
    done = run("bench", "compress", "--resolution", 256, "--expressions", 3, "--repeats", 2, "--json")
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    return json.loads(done.stdout)


def test_sums_and_ratios_are_those_of_one_run(document):
    for run_ in (document, *document["runs"]):
        assert run_["total_s"] == pytest.approx(
            sum(run_[f"{part}_s"] for part in ("load", "check", "fit", "write", "measure"))
        )
        assert run_["io_s"] == pytest.approx(run_["decode_s"] + run_["encode_s"])
        assert run_["ratio"] == pytest.approx(run_["total_s"] / run_["io_s"])
        assert all(value > 0 for value in run_.values() if isinstance(value, float))


def test_the_run_of_median_ratio_is_reported(document):
    assert len(document["runs"]) == 2
    assert document["ratio"] == median_low(run_["ratio"] for run_ in document["runs"])
    assert document["peak_memory_mb"] == document["runs"][0]["peak_memory_mb"]


def test_conditions_belong_to_every_number(document):
    conditions = document["conditions"]
    assert (conditions["resolution"], conditions["expressions"], conditions["seed"]) == ([256, 256], 3, 0)
    assert {"facezip", "numba", "OpenImageIO"} < {*conditions["versions"]}
    assert document["bytes_on_gpu"] == 4 * 3 * 256**2 + 3 * 4 * 32**2
    assert conditions["cores"] >= 1


@pytest.mark.parametrize("dtype", [np.uint16, np.float32])
def test_own_scans_are_measured_as_they_are_stored(tmp_path, dtype):
    save_character(random_character(side=64, dtype=dtype), tmp_path / "scans")
    write_texture(tmp_path / "scans" / "mask.png", np.full((64, 64, 1), 255, np.uint8))
    before = {path: path.read_bytes() for path in (tmp_path / "scans").iterdir()}
    done = run("bench", "compress", "--character", tmp_path / "scans", "--repeats", 1, "--json")
    assert done.returncode == 0, done.stderr
    conditions = json.loads(done.stdout)["conditions"]
    assert (conditions["character"], conditions["seed"], conditions["texels"]) == ("scans", None, np.dtype(dtype).name)
    assert before == {path: path.read_bytes() for path in (tmp_path / "scans").iterdir()}
    assert load_character(tmp_path / "scans").first.mask.all()


@pytest.mark.parametrize(
    ("arguments", "code"),
    [
        (("--resolution", 255), ExitCode.USAGE),
        (("--resolution", 8193), ExitCode.USAGE),
        (("--expressions", 1), ExitCode.USAGE),
        (("--character", "nowhere", "--seed", 1), ExitCode.USAGE),
        (("--character", "nowhere"), ExitCode.BAD_INPUT),
    ],
)
def test_a_wrong_call_is_one_line(arguments, code):
    done = run("bench", "compress", *arguments)
    assert done.returncode == code
    assert "Traceback" not in done.stderr
    if code is not ExitCode.USAGE:
        assert len(done.stderr.splitlines()) == 1


@pytest.fixture(scope="module")
def scaling(tmp_path_factory):
    folder = tmp_path_factory.mktemp("scaling") / "report"
    sizes = ("--resolution", 512, "--resolution", 256, "--expressions", 2, "--repeats", 1)
    done = run("bench", "scaling", "-o", folder, *sizes, "--memory", "700M", "--json")
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout), folder


def test_what_a_megatexel_costs_is_that_of_each_size(scaling):
    document, _ = scaling
    assert [one["resolution"] for one in document["sizes"]] == [256, 512]
    costs = [one["total_s"] / (one["resolution"] ** 2 / 1e6) for one in document["sizes"]]
    assert [one["seconds_per_megatexel"] for one in document["sizes"]] == pytest.approx(costs)
    assert document["factor"] == pytest.approx(max(costs) / min(costs))
    assert all(one["peak_memory_mb"] < 700 for one in document["sizes"])


def test_the_page_plots_every_size(scaling):
    document, folder = scaling
    page = (folder / "index.html").read_text()
    assert {"256²", "512²"} <= {*re.findall(r"<text[^>]*>(\d+²)</text>", page)}
    assert f"{document['factor']:.2f} times the cheapest" in page
    kept = json.loads((folder / "scaling.json").read_text())
    assert kept["sizes"] == document["sizes"]


def test_the_bench_of_shaders_says_what_was_measured():
    done = run("bench", "shader", "--resolution", 64, "--expressions", 3, "--repeats", 1, "--json")
    document = json.loads(done.stdout)
    if done.returncode:
        assert (done.returncode, document["error"]["code"]) == (ExitCode.BAD_INPUT, "no-gpu")
        pytest.skip(document["error"]["message"])
    device = document["device"]
    assert {key: device[key] for key in document["devices"][0]} in document["devices"]
    shown = run("bench", "shader", "--resolution", 64, "--expressions", 3, "--repeats", 1).stdout
    assert device["renderer"] in shown
    assert ("no GPU was measured" in shown) == device["software"]
    assert run("bench", "shader", "--resolution", 100).returncode == ExitCode.USAGE
