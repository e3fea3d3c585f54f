"""ICC profiles of matrices and curves (ICC.1:2022, 8.3.3 and 8.4.3), in full precision.

Littlecms as Pillow offers it converts 8 bits a channel, and textures have 16. Such profiles are three columns and three
curves; profiles of tables, for printers, scanners and some displays, are named and refused.
"""

import struct
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from facezip.files.colour_space import ColourFault, ColourSpace, Transfer, power

# sRGB's columns in a profile's own space, XYZ under D50, as the profile of the ICC has them (sRGB2014).
SRGB_COLUMNS = np.array([(0.43607, 0.38515, 0.14307), (0.22249, 0.71687, 0.06061), (0.01392, 0.09708, 0.71410)])
MAX_BYTES = 2**24
# Curves of real devices miss black and white by less.
SLACK = 0.05
# Tables of colours that count before matrix and curves, whatever the intent.
_TABLES = (b"A2B0", b"A2B1", b"A2B2", b"D2B0", b"D2B1", b"D2B2", b"D2B3")
# How many numbers a parametric curve has, by its kind.
_PARAMETERS = (1, 3, 4, 5, 7)


@lru_cache(maxsize=32)
def profile_space(profile: bytes, channels: int) -> ColourSpace:
    """The space that a profile states for an image of 1 or 3 channels.

    Raises
    ------
    ColourFault
        It is for other channels, made of tables, or damaged.
    """
    if len(profile) > MAX_BYTES or profile[36:40] != b"acsp":
        raise ColourFault("of an ICC profile that is damaged")
    name = "an ICC profile"
    try:
        tags = _tags(profile)
        name = f"the ICC profile '{_description(tags.get(b'desc', b''))}'"
        return _space(name, profile[16:20], profile[20:24], tags, channels)
    except (struct.error, IndexError, KeyError, ZeroDivisionError, np.linalg.LinAlgError):
        raise ColourFault(f"of {name}, which is damaged") from None


def _space(name: str, model: bytes, connection: bytes, tags: dict[bytes, bytes], channels: int) -> ColourSpace:
    if model not in (b"RGB ", b"GRAY") or (model == b"GRAY" and channels != 1):
        raise ColourFault(f"of {name}, which is for {model.decode('ascii', 'replace').strip()}, not for these channels")
    if connection != b"XYZ " or any(table in tags for table in _TABLES):
        raise ColourFault(f"of {name}, which is made of tables and not converted here")
    if model == b"GRAY":
        return ColourSpace(name, _curves(name, [tags[b"kTRC"]]))
    curves = [tags[kind] for kind in (b"rTRC", b"gTRC", b"bTRC")]
    same = curves[:1] if curves[0] == curves[1] == curves[2] else curves
    if channels == 1 and len(same) > 1:
        raise ColourFault(f"of {name}, which is for colours and ambiguous for grey")
    columns = np.array([_xyz(tags[kind]) for kind in (b"rXYZ", b"gXYZ", b"bXYZ")]).T
    matrix = np.linalg.solve(SRGB_COLUMNS, columns)
    if not np.abs(matrix.sum(axis=1) - 1).max() < SLACK:
        raise ColourFault(f"of {name}, whose white is not neutral")
    return ColourSpace(name, _curves(name, same), matrix)


def _tags(profile: bytes) -> dict[bytes, bytes]:
    (count,) = struct.unpack_from(">I", profile, 128)
    entries = [struct.unpack_from(">4sII", profile, 132 + 12 * k) for k in range(min(count, 256))]
    return {name: profile[start : start + length] for name, start, length in entries}


def _xyz(tag: bytes) -> tuple[float, float, float]:
    x, y, z = struct.unpack_from(">3i", tag, 8)
    return x / 65536, y / 65536, z / 65536


def _curves(name: str, tags: list[bytes]) -> Transfer | None:
    """Linear light by one curve, or by one for each channel; None where values are that."""
    curves, steps = [_curve(tag) for tag in tags], np.linspace(0, 1, 1024, dtype=np.float32)
    # Of a damaged profile they may be beyond all numbers.
    with np.errstate(all="ignore"):
        ramps = np.array([curve(steps) for curve in curves])
        is_sound = np.abs(ramps[:, [0, -1]] - (0, 1)).max() < SLACK and np.diff(ramps).min() > -SLACK
    if not is_sound:
        raise ColourFault(f"of {name}, whose curves do not lead from black to white")
    if np.abs(ramps - steps).max() < 1e-6:
        return None
    if len(curves) == 1:
        return curves[0]

    def transfer(values: NDArray[np.float32]) -> NDArray[np.float32]:
        return np.stack([curve(values[..., channel]) for channel, curve in enumerate(curves)], axis=-1)

    return transfer


def _curve(tag: bytes) -> Transfer:
    if tag[:4] == b"para":
        (kind,) = struct.unpack_from(">H", tag, 8)
        return _parametric(kind, [x / 65536 for x in struct.unpack_from(f">{_PARAMETERS[kind]}i", tag, 12)])
    if tag[:4] != b"curv":
        raise KeyError(tag[:4])
    (count,) = struct.unpack_from(">I", tag, 8)
    samples = struct.unpack_from(f">{min(count, 65536)}H", tag, 12)
    if count < 2:
        return power(samples[0] / 256 if samples else 1.0)
    table, steps = np.array(samples) / 65535, np.linspace(0, 1, len(samples))
    return lambda values: np.interp(values, steps, table).astype(np.float32)


def _parametric(kind: int, numbers: list[float]) -> Transfer:
    """(a x + b)^g + e from x = d on, c x + f below: what all kinds of parametric curves are (10.18, table 68)."""
    g, *rest = numbers
    if kind >= 3:
        a, b, c, d, e, f = (*rest, 0, 0)[:6]
    else:
        # One number more is a constant, below where the base vanishes too.
        a, b, constant = (*rest, *(1.0, 0.0, 0.0)[len(rest) :])
        c, d, e, f = 0, -b / a, constant, constant

    def transfer(values: NDArray[np.float32]) -> NDArray[np.float32]:
        above = np.power(np.maximum(a * values + b, 0), g) + e
        return np.where(values >= d, above, c * values + f).astype(np.float32)

    return transfer


def _description(tag: bytes) -> str:
    """The profile's name: of text (version 2) or of its first language (version 4)."""
    if tag[:4] == b"mluc":
        length, start = struct.unpack_from(">II", tag, 20)
        return tag[start : start + min(length, 128)].decode("utf-16-be", "replace").rstrip("\0")
    return tag[12:76].split(b"\0")[0].decode("ascii", "replace")
