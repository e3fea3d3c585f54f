"""ICC profiles of published spaces, made byte by byte."""

import struct

import numpy as np

from facezip.files.srgb import decode_srgb

# Columns of red, green and blue in a profile's own XYZ (D50), as published profiles have them.
COLUMNS = {
    "sRGB": [(0.43607, 0.22249, 0.01392), (0.38515, 0.71687, 0.09708), (0.14307, 0.06061, 0.71410)],
    "Display P3": [(0.51512, 0.24120, -0.00105), (0.29198, 0.69225, 0.04189), (0.15710, 0.06657, 0.78407)],
    "Adobe RGB": [(0.60974, 0.31111, 0.01947), (0.20528, 0.62567, 0.06087), (0.14919, 0.06322, 0.74457)],
    "ProPhoto": [(0.79767, 0.28804, 0.0), (0.13519, 0.71188, 0.0), (0.03134, 0.00009, 0.82491)],
}
WHITE = (0.9642, 1.0, 0.8249)


def icc(columns, curves, name="A profile", space=b"RGB ", connection=b"XYZ ", tables=()):
    """A profile of three columns (or none) and of curves as :func:`curve` makes them."""
    text = name.encode("utf-16-be")
    described = b"mluc" + struct.pack(">IIIHHII", 0, 1, 12, 0x656E, 0x5553, len(text), 28) + text
    tags = {b"desc": described, b"wtpt": _xyz(WHITE), b"cprt": b"text" + bytes(5)}
    kinds = (b"r", b"g", b"b")
    tags |= {kind + b"XYZ": _xyz(column) for kind, column in zip(kinds, columns, strict=False)}
    tags |= dict(zip([kind + b"TRC" for kind in kinds] if columns else [b"kTRC"], curves, strict=False))
    tags |= dict.fromkeys(tables, b"mft2" + bytes(60))
    start, index, body = 132 + 12 * len(tags), b"", b""
    for kind, content in tags.items():
        index += struct.pack(">4sII", kind, start + len(body), len(content))
        body += content + bytes(-len(content) % 4)
    head = struct.pack(">I4sI4s4s4s", start + len(body), b"lcms", 0x04300000, b"mntr", space, connection)
    head += struct.pack(">6H", 2020, 1, 1, 0, 0, 0) + b"acsp" + bytes(28) + struct.pack(">3i", *_fixed(WHITE))
    return head + bytes(128 - len(head)) + struct.pack(">I", len(tags)) + index + body


def curve(*numbers, kind=None, samples=None):
    """A curve of samples in [0, 1], a parametric one of a kind, or a power."""
    if samples is not None:
        return (
            b"curv" + struct.pack(">II", 0, len(samples)) + np.rint(np.multiply(samples, 65535)).astype(">u2").tobytes()
        )
    if kind is None:
        return b"curv" + struct.pack(">IIH", 0, 1, round(256 * numbers[0]))
    return b"para" + struct.pack(f">IHH{len(numbers)}i", 0, kind, 0, *_fixed(numbers))


def _xyz(values):
    return b"XYZ " + bytes(4) + struct.pack(">3i", *_fixed(values))


def _fixed(values):
    return [round(65536 * value) for value in values]


# sRGB's curve as the specification writes it.
SRGB_CURVE = curve(2.4, 1 / 1.055, 0.055 / 1.055, 1 / 12.92, 0.04045, kind=3)
# ... and as most profiles of version 2 do.
SRGB_SAMPLED = curve(samples=decode_srgb(np.linspace(0, 1, 1024)))
