"""Pictures in terminals: which understand which, and that what is sent is the picture."""

import re
from base64 import b64decode

import numpy as np
import pytest

from facezip.files.images import read_texture, write_texture
from render.plugin.evidence import PICTURES
from render.plugin.pictures import KINDS, kind_of, shown


@pytest.fixture
def evidence(tmp_path):
    rng = np.random.default_rng(0)
    pictures = {name: rng.integers(0, 6, (40, 32, 3)) * 51 for name in PICTURES}
    for name, picture in pictures.items():
        write_texture(tmp_path / f"{name}.png", picture.astype(np.uint8))
    return tmp_path, np.concatenate([*pictures.values()], axis=1)


@pytest.mark.parametrize(
    ("environment", "kind"),
    [
        ({"TERM": "xterm-kitty"}, "kitty"), ({"KITTY_WINDOW_ID": "1"}, "kitty"), ({"TERM_PROGRAM": "WezTerm"}, "iterm"),
        ({"LC_TERMINAL": "iTerm2", "TERM": "xterm-256color"}, "iterm"), ({"TERM": "foot"}, "sixel"),
        ({"TERM": "xterm-256color"}, ""), ({}, ""), ({"TERM": "xterm-kitty", "TMUX": "x"}, ""), ({"TERM": "dumb"}, ""),
    ],
)  # fmt: skip
def test_terminals_are_known_by_their_variables(environment, kind):
    assert kind_of(environment) == kind


def decoded_png(data, tmp_path):
    (tmp_path / "sent.png").write_bytes(b64decode(data))
    return read_texture(tmp_path / "sent.png")


def test_kitty_gets_the_picture_in_chunks(evidence):
    folder, strip = evidence
    parts = re.findall(r"\x1b_G([^;]*);([A-Za-z0-9+/=]*)\x1b\\", shown(folder, "kitty"))
    assert parts[0][0] == "a=T,f=100,m=1"
    assert [control for control, _ in parts[1:]] == ["m=1"] * (len(parts) - 2) + ["m=0"]
    assert max(len(data) for _, data in parts) <= 4096
    np.testing.assert_array_equal(decoded_png("".join(data for _, data in parts), folder), strip)


def test_iterm_gets_the_picture_at_once(evidence):
    folder, strip = evidence
    size, data = re.fullmatch(r"\x1b\]1337;File=inline=1;size=(\d+):([^\a]*)\a", shown(folder, "iterm")).groups()
    assert len(b64decode(data)) == int(size)
    np.testing.assert_array_equal(decoded_png(data, folder), strip)


def test_sixels_are_the_picture(evidence):
    """A reader of sixels gets back every pixel, of colours that its palette has."""
    folder, strip = evidence
    body = re.fullmatch(r"\x1bPq(.*)\x1b\\", shown(folder, "sixel"), re.DOTALL).group(1)
    palette = {int(k): [int(v) for v in rgb] for k, *rgb in re.findall(r"#(\d+);2;(\d+);(\d+);(\d+)", body)}
    read = np.full((42, strip.shape[1], 3), -1)
    for band, text in enumerate(re.sub(r"#\d+;2;\d+;\d+;\d+", "", body).split("-")):
        for colour, characters in re.findall(r"#(\d+)([?-~]*)", text):
            for x, character in enumerate(characters):
                for row in range(6):
                    if (ord(character) - 63) >> row & 1:
                        read[6 * band + row, x] = palette[int(colour)]
    np.testing.assert_array_equal(read[:40], strip * 100 // 255)
    assert (read[40:] == -1).all()


def test_a_run_shows_what_failed_where_it_is_asked_to(generated, pytester):
    from tests.render.plugin.conftest import BRIGHTER, EQUAL

    assert "\x1b_G" not in generated(BRIGHTER).stdout.str()
    assert "\x1b_Ga=T" in generated(BRIGHTER, "--facezip-pictures", "kitty").stdout.str()
    assert "\x1b_G" not in generated(EQUAL, "--facezip-pictures", "kitty").stdout.str()
    assert {"kitty", "iterm", "sixel"} == {*KINDS}
