"""Pictures in terminals that show them: what kitty, iTerm2 and WezTerm, and terminals with sixels understand."""

import os
from base64 import b64encode
from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from facezip.files.images import png, read_texture, to_float
from render.plugin.evidence import PICTURES

KINDS = ("kitty", "iterm", "sixel")
# Bytes of a chunk that kitty takes.
_CHUNK = 4096
# Steps of each colour channel in sixels, whose palette has at least 216 colours.
_STEPS = 6


def kind_of(environment: Mapping[str, str] = os.environ) -> str:
    """Which of :data:`KINDS` the terminal understands, as its variables say, or ""."""
    terminal, program = environment.get("TERM", ""), environment.get("TERM_PROGRAM", "")
    if "TMUX" in environment or terminal.startswith(("screen", "tmux", "dumb")):
        # They pass no picture on.
        return ""
    if "KITTY_WINDOW_ID" in environment or terminal in ("xterm-kitty", "xterm-ghostty"):
        return "kitty"
    if program in ("iTerm.app", "WezTerm") or environment.get("LC_TERMINAL") == "iTerm2":
        return "iterm"
    return "sixel" if "sixel" in terminal or terminal.startswith(("foot", "mlterm")) else ""


def shown(evidence: Path, kind: str) -> str:
    """The four pictures of a failed comparison side by side, as the characters that a terminal shows them for."""
    rows = [to_float(read_texture(evidence / f"{name}.png"))[..., :3] for name in PICTURES]
    strip = np.concatenate(rows, axis=1)
    return {"kitty": _kitty, "iterm": _iterm, "sixel": _sixel}[kind](strip)


def _kitty(picture: NDArray[np.float32]) -> str:
    """https://sw.kovidgoyal.net/kitty/graphics-protocol: a PNG in chunks, each of which says if there are more."""
    data = b64encode(_png(picture)).decode()
    chunks = [data[at : at + _CHUNK] for at in range(0, len(data), _CHUNK)]
    parts = []
    for k, chunk in enumerate(chunks):
        control = f"{'a=T,f=100,' if k == 0 else ''}m={int(k + 1 < len(chunks))}"
        parts.append(f"\x1b_G{control};{chunk}\x1b\\")
    return "".join(parts)


def _iterm(picture: NDArray[np.float32]) -> str:
    """https://iterm2.com/documentation-images.html: a PNG in one sequence."""
    content = _png(picture)
    return f"\x1b]1337;File=inline=1;size={len(content)}:{b64encode(content).decode()}\a"


def _png(picture: NDArray[np.float32]) -> bytes:
    return png(np.round(255 * picture).astype(np.uint8))


def _sixel(picture: NDArray[np.float32]) -> str:
    """Bands of six rows, in each a line of characters for every colour: VT330/VT340 Programmer Reference, ch. 14."""
    steps = np.round(picture * (_STEPS - 1)).astype(np.int64)
    colours = steps @ np.array([_STEPS * _STEPS, _STEPS, 1])
    used = np.unique(colours)
    percent = [np.array(np.unravel_index(colour, (_STEPS,) * 3)) * 100 // (_STEPS - 1) for colour in used]
    palette = "".join(f"#{k};2;{r};{g};{b}" for k, (r, g, b) in enumerate(percent))
    index = np.searchsorted(used, colours)
    return f"\x1bPq{palette}{'-'.join(_bands(index))}\x1b\\"


def _bands(index: NDArray[np.int64]) -> Iterator[str]:
    """The characters of each band of six rows of ``(H, W)`` colours."""
    for top in range(0, len(index), 6):
        band = index[top : top + 6]
        weights = 1 << np.arange(len(band))[:, None]
        lines = {colour: ((band == colour) * weights).sum(axis=0) for colour in np.unique(band)}
        yield "$".join(f"#{colour}{bytes((63 + line).tolist()).decode()}" for colour, line in lines.items())
