"""One mesh in the many ways in which OBJ files are written, all of them valid."""

import random
import re
from collections import Counter
from dataclasses import dataclass

import numpy as np

WITHOUT_EFFECT = [
    "o head", "o", "g skin front", "g", "s 1", "s off", "mg 0", "mtllib head.mtl two.mtl", "mtllib C:\\scans\\a.mtl",
    "vp 0.5 0.5", "l 1 2", "p 1", "bevel on", "o Gesicht_Köpfle_顔", "g #1", "o 1/1 f v vt", "usemap off",
]  # fmt: skip
REMARKS = ["#", "# a remark", "#v 1 2 3", "# f 1/1 2/2 3/3 / é 顔", "#MRGB ffffffff", "## 25 vertices"]


@dataclass(frozen=True, eq=False)
class Mesh:
    """What a spelling has to be read as.

    Attributes
    ----------
    vertices : ``(V, 3)`` float64; one that no face uses may be among them.
    uv : ``(T, 2)`` float64.
    polygons : the corners of each, vertex and UV from 0.
    materials : the name of each polygon's.
    """

    vertices: np.ndarray
    uv: np.ndarray
    polygons: list[list[tuple[int, int]]]
    materials: list[str]

    @property
    def triangles(self) -> np.ndarray:
        """``(F, 3, 2)``, the polygons as fans."""
        return np.array([(p[0], p[k], p[k + 1]) for p in self.polygons for k in range(1, len(p) - 1)])


def random_mesh(rng: random.Random) -> Mesh:
    """A sheet of triangles, quads and pentagons, with a seam in its UVs, and vertices and UVs that nothing uses."""
    side = rng.randint(2, 4)
    decimals = rng.choice([1, 3, 6, 17])
    numbers = [round(rng.uniform(-9, 9) * 10.0 ** rng.choice([-6, 0, 0, 3]), decimals) for _ in range(3 * side**2 + 3)]
    vertices = np.array(numbers).reshape(-1, 3)
    seam = rng.randint(0, side)
    uv = [[round(rng.uniform(-1, 2), decimals) for _ in range(2)] for _ in range(2 * side**2 + rng.randint(0, 1))]
    polygons: list[list[tuple[int, int]]] = []
    for y in range(side - 1):
        for x in range(side - 1):
            corners = [y * side + x, y * side + x + 1, (y + 1) * side + x + 1, (y + 1) * side + x]
            cell = [(corner, corner + (x >= seam) * side**2) for corner in corners]
            kind = rng.choice("tqqp")
            if kind == "t":
                polygons += [cell[:3], [cell[0], cell[2], cell[3]]]
            else:
                polygons.append(cell if kind == "q" else [*cell, (rng.randrange(side**2), rng.randrange(side**2))])
    rng.shuffle(polygons)
    names = [rng.choice(["skin", "eyes", "Zähne #2"]) if rng.random() < 0.2 else "" for _ in polygons]
    materials = [next((name for name in reversed(names[: k + 1]) if name), "") for k in range(len(polygons))]
    return Mesh(vertices, np.array(uv), polygons, materials)


def spell(rng: random.Random, mesh: Mesh) -> bytes:
    """A valid OBJ file of a mesh."""
    spelling = _Spelling(rng, mesh)
    ends = rng.choice([["\n"], ["\r\n"], ["\r"], ["\n", "\r\n", "\r"]])
    text = "".join(spelling.laid_out(line, ends) + rng.choice(ends) for line in spelling.lines())
    if rng.random() < 0.2:
        text = text.rstrip("\r\n")
    if rng.random() < 0.1:
        return rng.choice([text.encode("utf-16"), b"\xfe\xff" + text.encode("utf-16-be")])
    return rng.choice([b"", b"", b"\xef\xbb\xbf"]) + text.encode()


def plain(text: bytes) -> bytes:
    """The same lines without what others stumble over: marks, remarks, continued lines, tabs, letters of names."""
    if text.startswith((b"\xff\xfe", b"\xfe\xff")):
        text = text.decode("utf-16", "replace").encode()
    text = re.sub(rb"\r\n|\r", b"\n", text.removeprefix(b"\xef\xbb\xbf")).replace(b"\\\n", b" ")
    bare = [re.sub(rb"[ \t]+", b" ", re.split(rb"(?:^|[ \t])#", line)[0]).strip(b" ") for line in text.split(b"\n")]
    return b"".join(re.sub(rb"[^ -~]", b"?", line) + b"\n" for line in bare if line)


def forwards(text: bytes) -> bytes:
    """Plain lines whose faces count from the front of the lists."""
    lines, counts = [], Counter()
    for line in text.splitlines():
        words = line.split(b" ")
        counts[words[0]] += 1
        if words[0] == b"f":
            ends = counts[b"v"], counts[b"vt"], 0
            words[1:] = [b"/".join(map(_forwards, word.split(b"/"), ends)) for word in words[1:]]
        lines.append(b" ".join(words))
    return b"\n".join(lines) + b"\n"


def _forwards(index: bytes, count: int) -> bytes:
    return b"%d" % (count + 1 + int(index)) if index.startswith(b"-") and count else index


class _Spelling:
    """The choices that a file makes once, and lines that follow them."""

    def __init__(self, rng: random.Random, mesh: Mesh) -> None:
        self._rng, self._mesh = rng, mesh
        self._number = rng.choice([repr, repr, "{:.17g}".format, "{:+.17g}".format, "{:.25e}".format, "{:.30f}".format])
        self._blanks = rng.choice([[" "], ["\t"], [" ", "  ", "\t", " \t "]])
        self._indent = rng.choice([[""], [""], ["", "  ", "\t"]])
        self._remarks, self._without_effect, self._continued = (rng.choice([0, 0, 0.2]) for _ in range(3))
        self._beside = rng.choice(["", "", "", " 1.0", " 0.5 .5 1.", " 0.5 .5 1. 0.25"])
        self._depths = rng.random() < 0.2
        self._normals = rng.choice([False, False, True])
        self._backwards = rng.choice([0, 0, 0.5, 1])
        # tinyobjloader takes a slash at the end behind indices from the front alone.
        self._slash = "" if self._backwards else rng.choice(["", "", "/"])
        self._counts = [0, 0]

    def lines(self) -> list[str]:
        """Vertices before UVs, mixed with them, or in blocks before the faces that use them."""
        rng, mesh = self._rng, self._mesh
        lists = [self._vertices(), self._uvs()]
        order = rng.choice(["lists", "mixed", "blocks"])
        written: list[str] = []
        if order == "lists":
            written += self._until(lists, 0, len(lists[0])) + self._until(lists, 1, len(lists[1]))
        elif order == "mixed":
            while any(count < len(entries) for count, entries in zip(self._counts, lists, strict=True)):
                which = rng.randrange(2)
                written += self._until(lists, which, min(len(lists[which]), self._counts[which] + 1))
        written += rng.choices(["vn 0 0.5 1e0", "vn nan -nan 1."], k=rng.randint(1, 3)) if self._normals else []
        material = ""
        for polygon, name in zip(mesh.polygons, mesh.materials, strict=True):
            for which in range(2):
                needed = max(corner[which] for corner in polygon) + 1
                written += self._until(lists, which, max(needed, self._counts[which]))
            if name != material or (name and rng.random() < 0.1):
                written.append(f"usemtl {name}")
                material = name
            written.append(self._face(polygon))
        for which in range(2):
            written += self._until(lists, which, len(lists[which]))
        return [noise for line in written for noise in (*self._between(), line)]

    def _until(self, lists: list[list[str]], which: int, end: int) -> list[str]:
        begin, self._counts[which] = self._counts[which], end
        return lists[which][begin:end]

    def _vertices(self) -> list[str]:
        return [f"v {' '.join(map(self._number, row))}{self._beside}" for row in self._mesh.vertices.tolist()]

    def _uvs(self) -> list[str]:
        tail = ["", " 0", " 0.000"] if self._depths else [""]
        return [f"vt {' '.join(map(self._number, row))}{self._rng.choice(tail)}" for row in self._mesh.uv.tolist()]

    def _face(self, polygon: list[tuple[int, int]]) -> str:
        tail = "/1" if self._normals else self._slash
        return "f " + " ".join("/".join(map(self._index, corner, self._counts)) + tail for corner in polygon)

    def _index(self, index: int, count: int) -> str:
        return str(index - count) if self._rng.random() < self._backwards else str(index + 1)

    def _between(self) -> list[str]:
        rng = self._rng
        lines = [rng.choice([*REMARKS, "", ""])] if rng.random() < self._remarks else []
        return [*lines, rng.choice(WITHOUT_EFFECT)] if rng.random() < self._without_effect else lines

    def laid_out(self, line: str, ends: list[str]) -> str:
        """A line with its blanks, indented, continued, and with a remark behind it."""
        rng = self._rng
        if not line or line[0] == "#":
            return line
        words = line.split(" ", 1 if line.startswith("usemtl") else -1)
        text = words[0]
        for word in words[1:]:
            goes_on = words[0] in ("v", "vt", "vn", "f") and rng.random() < self._continued / 2
            text += rng.choice(self._blanks) + (f"\\{rng.choice(ends)}" if goes_on else "") + word
        if words[0] in ("v", "vt", "vn", "f", "s") and rng.random() < self._remarks:
            text += f" {rng.choice(REMARKS)}"
        return rng.choice(self._indent) + text + rng.choice([*self._indent, ""])
