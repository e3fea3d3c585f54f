"""The command line as its users call it: in a process of its own, by its exit code and its two streams."""

import json
import subprocess
import sys

import click
import numpy as np
import pytest
from click.testing import CliRunner

from facezip.character.loading import save_character
from facezip.cli import ON_WINDOWS, VERBS, facezip, main
from facezip.commands.options import FiniteRange
from facezip.errors import ExitCode
from facezip.files.images import read_texture, write_texture
from facezip.pack.read import read_pack
from tests.documents.checked import checked
from tests.facezip.conftest import random_character

LIKE_WINDOWS = """
import os, sys
from facezip.cli import main

opened = os.open

def open_files_only(path, *flags):
    if os.path.isdir(path):
        raise PermissionError(13, "Permission denied", path)
    return opened(path, *flags)

os.open = open_files_only
del os.O_NOFOLLOW, os.O_NONBLOCK, os.getuid, os.posix_fallocate, os.sched_getaffinity
sys.modules |= dict.fromkeys(["fcntl", "resource"])
sys.platform = "win32"
main()
"""


def run(*arguments, **options):
    command = [sys.executable, "-c", "from facezip.cli import main; main()", *map(str, arguments)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=280, check=False, **options)
    checked(arguments, done.stdout)
    return done


@pytest.fixture(scope="module")
def scans(tmp_path_factory):
    folder = tmp_path_factory.mktemp("scans") / "sheet"
    save_character(random_character(side=64), folder)
    return folder


@pytest.fixture(scope="module")
def pack(scans):
    path = scans.parent / "sheet.facezip"
    done = run("compress", scans, "-o", path, "--method", "paper", "--masks", 9, "--json")
    assert done.returncode == 0, done.stderr
    return path, json.loads(done.stdout)


def test_help_teaches_every_verb_and_every_exit_code():
    done = run("--help")
    assert done.returncode == 0
    for verb in VERBS:
        assert verb in done.stdout
        assert run(verb, "--help").returncode == 0
    for code in ExitCode:
        assert f"{code.value}  {code.meaning}" in done.stdout


@pytest.mark.parametrize("verb", sorted({*VERBS} - {*ON_WINDOWS}))
def test_windows_hears_in_one_line_where_the_verb_runs(monkeypatch, capsys, verb):
    monkeypatch.setattr(sys, "platform", "win32")
    monkeypatch.setattr(sys, "argv", ["facezip", verb])
    # Whatever the verb needs is not looked for.
    monkeypatch.setitem(sys.modules, f"facezip.commands.{verb}", None)
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code == ExitCode.CANNOT_WRITE
    line = f"facezip: {verb}: runs on Linux and macOS, not on Windows; use WSL, Windows' own Linux\n"
    assert capsys.readouterr() == ("", line)


@pytest.mark.parametrize("verb", ["info", "verify"])
def test_windows_reads_packs_without_what_it_lacks(pack, verb):
    done = subprocess.run(
        [sys.executable, "-c", LIKE_WINDOWS, verb, pack[0]], capture_output=True, text=True, check=False, timeout=60
    )
    assert (done.stderr, done.stdout) == ("", run(verb, pack[0]).stdout)


def test_compress_states_the_error_of_what_was_written(pack):
    path, document = pack
    assert document["seconds"] > 0
    settings = {"differences": 4, "weight_scale": 8, "masks": 9, "seed": 0, "restarts": 100}
    assert document["made_with"] == {"method": "paper", **settings}
    assert document["rmse"] == pytest.approx(np.mean(list(document["rmse_per_expression"].values())))
    reconstructed = read_pack(path).reconstruct("expr_0")
    original = random_character(side=64).texture("expr_0")
    rmse = 255 * np.sqrt(np.mean((reconstructed - original) ** 2))
    assert document["rmse_per_expression"]["expr_0"] == pytest.approx(rmse, rel=1e-4)


def test_info_states_the_costs_and_starts_neither_renderer_nor_compiler(pack):
    script = "import sys; sys.argv[1:] = ['info', sys.argv[1], '--json']; from facezip.cli import main\n"
    script += "try: main()\nfinally: assert not {'mitsuba', 'numba', 'scipy', 'PIL'} & {*sys.modules}"
    done = subprocess.run(
        [sys.executable, "-c", script, pack[0]], capture_output=True, text=True, check=False, timeout=60
    )
    document = json.loads(done.stdout)
    assert document["bytes_on_gpu"] == 15 * 64**2 + 5 * 4 * 8**2
    assert (document["bytes_bc7"], document["bytes_raw_bc7"]) == (5 * 64**2 + 5 * 4 * 8**2, 6 * 64**2)
    assert (document["differences"], document["weight_scale"], document["resolution"]) == (4, 8, [64, 64])
    assert document["bytes_on_disk"] == sum(file.stat().st_size for file in pack[0].iterdir())
    assert done.stderr == ""


def test_decompress_writes_what_the_model_reconstructs(pack, tmp_path):
    assert run("decompress", pack[0], "-o", tmp_path / "all").returncode == 0
    model = read_pack(pack[0])
    assert sorted(file.stem for file in (tmp_path / "all").iterdir()) == sorted(model.expressions)
    expected = np.rint(model.reconstruct("expr_2") * 255)
    np.testing.assert_array_equal(read_texture(tmp_path / "all" / "expr_2.png"), expected)
    done = run("decompress", pack[0], "-o", tmp_path / "mix", "--blend", "expr_0=0.5,expr_3=1")
    assert done.returncode == 0
    expected = np.rint(model.blend({"expr_0": 0.5, "expr_3": 1}) * 255)
    np.testing.assert_array_equal(read_texture(tmp_path / "mix" / "blend.png"), expected)


def test_verify_finds_a_changed_byte(pack, tmp_path):
    import shutil

    assert run("verify", pack[0]).returncode == 0
    shutil.copytree(pack[0], tmp_path / "spoilt")
    content = bytearray((tmp_path / "spoilt" / "albedo.1001.difference_1.png").read_bytes())
    content[len(content) // 2] ^= 1
    (tmp_path / "spoilt" / "albedo.1001.difference_1.png").write_bytes(content)
    done = run("verify", tmp_path / "spoilt")
    assert done.returncode == ExitCode.BAD_INPUT
    assert "albedo.1001.difference_1.png" in done.stderr


def bad_calls(scans, pack, folder):
    (folder / "empty").mkdir()
    return {
        "no such character": (("compress", folder / "nobody", "-o", folder / "x"), ExitCode.BAD_INPUT),
        "an empty folder": (("compress", folder / "empty", "-o", folder / "x"), ExitCode.BAD_INPUT),
        "too many masks": (
            ("compress", scans, "-o", folder / "x", "--method", "paper", "--masks", 999),
            ExitCode.BAD_INPUT,
        ),
        "masks for the refined method": (("compress", scans, "-o", folder / "x", "--masks", 20), ExitCode.USAGE),
        "masks for PCA": (
            ("compress", scans, "-o", folder / "x", "--method", "pca", "--masks", 20),
            ExitCode.USAGE,
        ),
        "restarts for masks": (
            ("compress", scans, "-o", folder / "x", "--method", "masks", "--restarts", 2),
            ExitCode.USAGE,
        ),
        "a target for the paper's": (
            ("compress", scans, "-o", folder / "x", "--method", "paper", "--target-rmse", 2),
            ExitCode.USAGE,
        ),
        "a target and a number of differences": (
            ("compress", scans, "-o", folder / "x", "--target-rmse", 2, "--differences", 2),
            ExitCode.USAGE,
        ),
        "a target out of reach": (("compress", scans, "-o", folder / "x", "--target-rmse", 1e-6), ExitCode.BAD_INPUT),
        "a budget below the least": (
            ("compress", scans, "-o", folder / "x", "--budget-mb", 1e-3),
            ExitCode.BAD_INPUT,
        ),
        "a target of nothing": (("compress", scans, "-o", folder / "x", "--target-rmse", 0), ExitCode.USAGE),
        "a budget below nothing": (("compress", scans, "-o", folder / "x", "--budget-mb", -1), ExitCode.USAGE),
        "an importance of another size": (
            ("compress", scans, "-o", folder / "x", "--importance", folder / "importance.png"),
            ExitCode.BAD_INPUT,
        ),
        "five differences by the paper": (
            ("compress", scans, "-o", folder / "x", "--method", "paper", "--differences", 5),
            ExitCode.BAD_INPUT,
        ),
        "an odd weight scale": (("compress", scans, "-o", folder / "x", "--weight-scale", 7), ExitCode.BAD_INPUT),
        "an unknown method": (("compress", scans, "-o", folder / "x", "--method", "magic"), ExitCode.USAGE),
        "no output": (("compress", scans), ExitCode.USAGE),
        "no such pack": (("info", folder / "nothing.facezip"), ExitCode.BAD_INPUT),
        "an unknown expression": (
            ("decompress", pack, "-o", folder / "x", "--expression", "nobody"),
            ExitCode.BAD_INPUT,
        ),
        "a weight that is no number": (
            ("decompress", pack, "-o", folder / "x", "--blend", "expr_0=a"),
            ExitCode.BAD_INPUT,
        ),
        "an existing output": (("compress", scans, "-o", pack), ExitCode.CANNOT_WRITE),
        "a folder that is not ours": (("compress", scans, "-o", scans, "--overwrite"), ExitCode.CANNOT_WRITE),
        "no folder to write in": (("compress", scans, "-o", "/proc/nowhere/x"), ExitCode.CANNOT_WRITE),
        "a pack of someone else": (("validate", folder / "other", pack, "-o", folder / "x"), ExitCode.BAD_INPUT),
    }


def test_a_call_that_fails_answers_programs_too(scans, pack, tmp_path):
    usage, wrong = ("info", "--jsom", pack[0]), ("info", tmp_path / "no.facezip")
    for arguments, name, status in (
        (usage, "usage", ExitCode.USAGE),
        (wrong, "missing-file", ExitCode.BAD_INPUT),
        (("compress", scans, "-o", scans), "cannot-write", ExitCode.CANNOT_WRITE),
    ):
        plain, done = run(*arguments), run(*arguments, "--json")
        assert (done.returncode, plain.stdout, done.stderr) == (status, "", plain.stderr)
        error = json.loads(done.stdout)["error"]
        assert error["code"] == name
        assert error["message"] in done.stderr


def commands(group=facezip, *words):
    """All verbs, and those of verbs that have several, by their words."""
    for name in group.list_commands(None):
        command = group.get_command(None, name)
        if isinstance(command, click.Group):
            yield from commands(command, *words, name)
        else:
            yield (*words, name), command


def given_to(kind):
    """Every option and argument of a type, as the words of a call up to it and a parameter."""
    return {
        f"{' '.join(words)} {each.opts[0]}": (words, each)
        for words, command in commands()
        for each in command.params
        if isinstance(each.type, kind)
    }


@pytest.mark.parametrize("value", ["nan", "inf", "-inf"])
@pytest.mark.parametrize("option", given_to(click.types.FloatParamType))
def test_no_option_takes_what_is_no_number(option, value):
    words, each = given_to(click.types.FloatParamType)[option]
    assert isinstance(each.type, FiniteRange)
    done = CliRunner().invoke(facezip, [*words, f"{each.opts[0]}={value}"])
    assert done.exit_code == ExitCode.USAGE
    assert f"Invalid value for '{each.opts[0]}'" in done.stderr


@pytest.mark.parametrize("place", given_to(click.Path))
def test_no_empty_path_is_taken_for_the_current_folder(place):
    words, each = given_to(click.Path)[place]
    with pytest.raises(click.BadParameter, match="the path is empty; ") as refused:
        each.type_cast_value(click.Context(click.Command(words[-1])), ("",) if each.nargs == -1 else "")
    assert refused.value.param is each


def test_an_empty_path_is_a_wrong_call_that_names_it():
    for words, named in (
        (("doctor", ""), "'PATH'"),
        (("doctor", "--json", ""), "'PATH'"),
        (("demo", "-o", ""), "'-o'"),
    ):
        done = run(*words)
        assert done.returncode == ExitCode.USAGE
        assert f"Invalid value for {named}" in done.stderr


def test_every_wrong_call_is_one_line_an_exit_code_and_no_output(scans, pack, tmp_path):
    save_character(random_character(side=32, expressions=7), tmp_path / "other")
    write_texture(tmp_path / "importance.png", np.full((16, 16, 1), 255, np.uint8))
    for case, (arguments, code) in bad_calls(scans, pack[0], tmp_path).items():
        done = run(*arguments)
        assert done.returncode == code, f"{case}: {done.stderr}"
        assert "Traceback" not in done.stderr, case
        if code is not ExitCode.USAGE:
            errors = [line for line in done.stderr.splitlines() if not line.startswith("facezip: warning: ")]
            assert len(errors) == 1, f"{case}: {done.stderr}"
        assert not (tmp_path / "x").exists(), case
        assert not list(tmp_path.glob(".*")), case


def test_the_demo_leaves_a_report_that_names_nothing_temporary(tmp_path):
    sizes = ("--resolution", 64, "--expressions", 2, "--image-resolution", 32, "--spp", 2)
    done = run("demo", "-o", tmp_path / "demo", *sizes, "--json")
    assert done.returncode == 0, done.stderr
    document = json.loads(done.stdout)
    assert read_pack(document["pack"]).expressions
    report = (tmp_path / "demo" / "report" / "report.json").read_text()
    assert ".tmp" not in report + done.stdout
    assert " ".join(map(str, sizes)) in json.loads(report)["command"]
