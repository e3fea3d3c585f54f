"""Any line of an OBJ file, one at a time: read, known to say nothing about the mesh, or refused with its number.

Nothing is passed over because it is not understood: a line that a reader drops is a vertex or a face that is missing,
and the indices behind it then mean others.
"""

import re

import numpy as np

from facezip.files.objlists import CORNERS, FACES, MAX_COORDINATE, UVS, VERTICES, Lists, read_plain_lines

# Names, groups and shading: nothing of them changes a vertex or a face.
WITHOUT_EFFECT = frozenset(b"o g s mg mtllib usemap maplib bevel c_interp d_interp shadow_obj trace_obj vp".split())
# What follows a backslash at the end of these is certainly meant to go on.
CONTINUED = frozenset(b"v vt vn f l p vp".split())
_FREE_FORM = (
    b"cstype deg bmat step curv curv2 surf parm trim hole scrv sp end con ctech stech bsp bzp cdc cdp res".split()
)
REFUSED = {
    **dict.fromkeys(_FREE_FORM, "is of free-form curves and surfaces, which are not read; convert them to polygons"),
    b"lod": "is of levels of detail; export one of them alone",
    b"fo": "is the form of a face that was given up; write 'f'",
    b"call": "takes in another file; export everything as one mesh",
    b"csh": "runs a command, which is not done; remove the line",
}
_NUMBER = re.compile(rb"[+-]?(?:\d++(?:\.\d*+)?|\.\d++)(?:[eE][+-]?\d++)?")
_CORNER = re.compile(rb"([+-]?\d+)/([+-]?\d+)(?:/([+-]?\d+)?)?")
# Normals of triangles without area are often no numbers.
_NO_NUMBER = re.compile(rb"[+-]?(?:nan(?:\(\w*\))?|inf(?:inity)?|\d\.#\w+)", re.IGNORECASE)
# Of lines and points, which are no part of a surface.
_POINT = re.compile(rb"[+-]?0*[1-9]\d*(?:/(?:[+-]?0*[1-9]\d*)?)?")
_BLANKS = re.compile(rb"[ \t]+")
# Not within a word: old compilers print NaN as 1.#IND.
_REMARK = re.compile(rb"(?:^|[ \t])#")
_LINE_END = re.compile(rb"\r\n|\n|\r")
# A vertex may have a weight, a colour, or both; a UV may have a depth.
_VERTEX_NUMBERS, _UV_NUMBERS = (3, 4, 6, 7), (2, 3)
_SHOWN = 24


class LineFault(ValueError):
    """The number of a line, what is wrong with it, and what to do."""


class Lines:
    """The lines of a text, read; ``LineFault`` for the first that cannot be.

    Attributes
    ----------
    vertices : ``(V, 3)`` float32.
    uv : ``(T, 2)`` float32.
    corners : ``(C, 2)`` int32, vertex and UV of each corner, from 0; how many there are is not yet known to suffice.
    face_ends : ``(P,)`` int32, where the corners of each polygon end.
    materials : how many polygons came before each ``usemtl``, and its name.
    """

    def __init__(self, text: bytes | bytearray) -> None:
        self._may_be_cut = not text.endswith((b"\n", b"\r"))
        self._text = text + b"\n" if self._may_be_cut else text
        self._lists = Lists.sized_for(self._text)
        self._readers = {
            b"v": self._vertex,
            b"vt": self._uv,
            b"vn": self._normal,
            b"f": self._face,
            b"l": self._points,
            b"p": self._points,
        }
        self.materials: list[tuple[int, str]] = []
        plain, at = np.frombuffer(self._text, np.uint8), 0
        while at < len(self._text):
            at = read_plain_lines(plain, at, self._lists)
            if at < len(self._text):
                at = self._line(at)
        counts = self._lists.counts
        self.vertices = self._lists.vertices[: counts[VERTICES]].copy()
        self.uv = self._lists.uv[: counts[UVS]].copy()
        self.corners = self._lists.corners[: counts[CORNERS]]
        self.face_ends = self._lists.faces[: counts[FACES], 0]

    def number_of_corner(self, corner: int) -> int:
        """The number, from 1, of the line that a corner stands in."""
        face = np.searchsorted(self.face_ends, corner, side="right")
        return self._number(int(self._lists.faces[face, 1]))

    def _number(self, at: int) -> int:
        return len(_LINE_END.findall(self._text, 0, at)) + 1

    def _line(self, at: int) -> int:
        """Read the line that begins at ``at``, with those that continue it; where the next one begins."""
        self._at = at
        line, after = self._whole_line(at)
        words = _words(_REMARK.split(line, maxsplit=1)[0])
        key = words[0] if words else b""
        if words[1:] and b"\\" in words:
            raise self._fault("a blank follows the backslash at its end; remove the blank")
        is_last_cut = self._may_be_cut and after == len(self._text)
        if key in self._readers:
            try:
                self._readers[key](words[1:])
            except LineFault:
                if is_last_cut:
                    raise self._cut() from None
                raise
        elif key == b"usemtl":
            name = line.strip(b" \t")[len(key) :].strip(b" \t")
            self.materials.append((int(self._lists.counts[FACES]), name.decode("utf-8", "replace")))
        elif key in REFUSED:
            raise self._fault(f"'{_shown(key)}' {REFUSED[key]}")
        elif key and key not in WITHOUT_EFFECT:
            if is_last_cut and line == key and any(known.startswith(key) for known in WITHOUT_EFFECT | {b"usemtl"}):
                raise self._cut()
            raise self._fault(f"'{_shown(key)}' is no keyword of an OBJ file; remove the line or export the mesh again")
        return after

    def _whole_line(self, at: int) -> tuple[bytes, int]:
        parts: list[bytes] = []
        key = b""
        while True:
            end = _LINE_END.search(self._text, at)
            if end is None:
                raise self._fault("ends in a backslash, and nothing follows; the file was cut off, export it again")
            part, at = bytes(self._text[at : end.start()]), end.end()
            if parts and not (_ends_blank(parts[-1]) or _ends_blank(part[:1])):
                raise self._fault("goes on within a word; put a space before the backslash at its end")
            if not part.endswith(b"\\"):
                return b"".join([*parts, part]), at
            parts.append(part[:-1])
            key = key or b"".join(_words(parts[-1])[:1])
            if b"#" in part or (key and key not in CONTINUED):
                raise self._fault(
                    "ends in a backslash, which makes the next line a part of it or does not, as programs differ; "
                    "remove the backslash"
                )

    def _vertex(self, words: list[bytes]) -> None:
        numbers = self._numbers(words, "v", _VERTEX_NUMBERS)
        if len(numbers) == 4 and numbers[3] != 1:
            raise self._fault(f"the vertex has the weight {_shown(words[3])}; export it with x, y and z alone")
        row = self._lists.counts[VERTICES]
        self._lists.vertices[row] = numbers[:3]
        self._lists.counts[VERTICES] += 1

    def _uv(self, words: list[bytes]) -> None:
        numbers = self._numbers(words, "vt", _UV_NUMBERS)
        row = self._lists.counts[UVS]
        self._lists.uv[row] = numbers[:2]
        self._lists.counts[UVS] += 1

    def _normal(self, words: list[bytes]) -> None:
        # Not used, but what is something else shows that lines were lost or run together.
        numbers = [word for word in words if _NO_NUMBER.fullmatch(word) is None]
        self._numbers(numbers + [b"0"] * (len(words) - len(numbers)), "vn", (3,))

    def _points(self, words: list[bytes]) -> None:
        for word in words:
            if _POINT.fullmatch(word) is None:
                raise self._fault(f"'{_shown(word)}' is no index of a vertex; remove the line or export the mesh again")

    def _numbers(self, words: list[bytes], key: str, counts: tuple[int, ...]) -> list[float]:
        if len(words) not in counts:
            allowed = " or ".join(map(str, counts))
            raise self._fault(f"a '{key}' line holds {allowed} numbers, this one {len(words)}; export the mesh again")
        numbers = []
        for word in words:
            if _NUMBER.fullmatch(word) is None:
                raise self._fault(f"'{_shown(word)}' is no finite number such as -1.5e-3; repair the mesh")
            numbers.append(float(word))
            if abs(numbers[-1]) >= MAX_COORDINATE:
                raise self._fault(f"the number {_shown(word)} is huge; repair the mesh")
        return numbers

    def _face(self, words: list[bytes]) -> None:
        if len(words) < 3:
            raise self._fault(f"a face has at least 3 corners, this one {len(words)}; remove the line")
        counts, forms = self._lists.counts, set()
        for corner, word in enumerate(words, int(counts[CORNERS])):
            parts = _CORNER.fullmatch(word)
            if parts is None:
                raise self._fault(_corner_fault(word, int(counts[UVS])))
            vertex, uv, normal = parts.groups()
            self._lists.corners[corner] = (
                self._index(vertex, int(counts[VERTICES]), "vertex"),
                self._index(uv, int(counts[UVS]), "UV"),
            )
            forms.add(normal is not None)
            if normal is not None and not int(normal[:4000]):
                raise self._fault("a corner has the normal 0, they count from 1; export the mesh without normals")
        if len(forms) > 1:
            raise self._fault("some of the corners have normals and others have none; export the mesh without normals")
        counts[CORNERS] += len(words)
        self._lists.faces[counts[FACES]] = counts[CORNERS], self._at
        counts[FACES] += 1

    def _index(self, word: bytes, count: int, what: str) -> int:
        """OBJ counts from 1, or from the end of what came before where negative."""
        # Python refuses to read more digits than a few thousand.
        value = int(word[:4000])
        if value == 0 or value < -count or value > np.iinfo(np.int32).max:
            raise self._fault(f"there is no {what} {_shown(word)}, after {count} of them; export the mesh again")
        return value - 1 if value > 0 else count + value

    def _cut(self) -> LineFault:
        return LineFault(f"the file ends within line {self._number(self._at)}; export it again")

    def _fault(self, what: str) -> LineFault:
        return LineFault(f"line {self._number(self._at)}: {what}")


def _corner_fault(word: bytes, uvs: int) -> str:
    if re.fullmatch(rb"[+-]?\d+(?://?[+-]?\d*)?", word):
        beside = f", although there are {uvs} 'vt' lines before it" if uvs else ""
        return f"the corner '{_shown(word)}' names no UV{beside}; export the mesh with vertex/uv at every corner"
    return f"the corner '{_shown(word)}' is not vertex/uv or vertex/uv/normal; export the mesh with UVs on every face"


def _words(line: bytes) -> list[bytes]:
    return [word for word in _BLANKS.split(line) if word]


def _ends_blank(part: bytes) -> bool:
    return part[-1:] in (b" ", b"\t", b"")


def _shown(word: bytes) -> str:
    # A word has no blanks: what looks like one is what is wrong with it.
    text = re.sub(r"\s", lambda blank: ascii(blank[0])[1:-1], word.decode("utf-8", "replace"))
    return text if len(text) <= _SHOWN else f"{text[:_SHOWN]}…"
