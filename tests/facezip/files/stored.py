"""Image files as people's tools write them, made byte by byte where no library writes what they state."""

import struct
import zlib

import numpy as np


def png(texels, chunks=(), after=(), palette=None, bits=None):
    """A PNG of integers ``(H, W, C)``; ``chunks`` before the pixels and ``after`` them, as pairs of kind and bytes."""
    height, width, channels = texels.shape
    bits = bits or 8 * texels.dtype.itemsize
    colour = 3 if palette is not None else {1: 0, 2: 4, 3: 2, 4: 6}[channels]
    rows = texels.astype(">u2" if bits == 16 else np.uint8).reshape(height, -1)
    packed = [b"\0" + (_packed(row, bits) if bits < 8 else row.tobytes()) for row in rows]
    header = struct.pack(">IIBBBBB", width, height, bits, colour, 0, 0, 0)
    every = [(b"IHDR", header), *chunks, *([(b"PLTE", palette.tobytes())] if palette is not None else [])]
    every += [(b"IDAT", zlib.compress(b"".join(packed))), *after, (b"IEND", b"")]
    body = [struct.pack(">I", len(d)) + kind + d + struct.pack(">I", zlib.crc32(kind + d)) for kind, d in every]
    return b"\x89PNG\r\n\x1a\n" + b"".join(body)


def iccp(profile, name=b"a profile"):
    return b"iCCP", name + b"\0\0" + zlib.compress(profile)


def chrm(red, green, blue, white):
    return b"cHRM", struct.pack(">8I", *(round(100000 * x) for point in (white, red, green, blue) for x in point))


def gama(exponent):
    return b"gAMA", struct.pack(">I", round(100000 / exponent))


def exif(orientation):
    return b"MM\0*\0\0\0\x08\0\x01" + struct.pack(">HHIHH", 274, 3, 1, orientation, 0) + bytes(4)


def exr(channels, size, data=None, attributes=(), parts_flag=0):
    """An uncompressed OpenEXR of one part: by name, a type of numpy, sampling, and values of the data window."""
    height, width = size
    top, left, bottom, right = data or (0, 0, height, width)
    codes = {"uint32": 0, "float16": 1, "float32": 2}
    named = sorted(channels.items())
    listed = b"".join(
        name.encode() + b"\0" + struct.pack("<iB3xii", codes[values.dtype.name], 0, step, step)
        for name, (values, step) in named
    )
    box = struct.pack("<4i", left, top, right - 1, bottom - 1), struct.pack("<4i", 0, 0, width - 1, height - 1)
    header = [
        (b"channels", b"chlist", listed + b"\0"), (b"compression", b"compression", b"\0"),
        (b"dataWindow", b"box2i", box[0]), (b"displayWindow", b"box2i", box[1]), (b"lineOrder", b"lineOrder", b"\0"),
        (b"pixelAspectRatio", b"float", struct.pack("<f", 1)), (b"screenWindowCenter", b"v2f", bytes(8)),
        (b"screenWindowWidth", b"float", struct.pack("<f", 1)), *attributes,
    ]  # fmt: skip
    packed = b"".join(name + b"\0" + kind + b"\0" + struct.pack("<i", len(v)) + v for name, kind, v in header)
    start = b"v/1\x01" + struct.pack("<I", 2) + packed + b"\0"
    lines = []
    for y in range(top, bottom):
        line = b"".join(
            np.ascontiguousarray(values[(y - top) // step]).tobytes() for _, (values, step) in named if y % step == 0
        )
        lines.append(struct.pack("<ii", y, len(line)) + line)
    places = len(start) + 8 * len(lines) + np.cumsum([0, *map(len, lines[:-1])])
    return start + places.astype("<u8").tobytes() + b"".join(lines)


def tiff(texels, bits, photometric, tags=(), order="<", kind=1):
    """An uncompressed TIFF of ``(H, W, C)`` numbers of so many bits; each of ``tags`` is number, type, values."""
    height, width, channels = texels.shape
    if bits in (8, 16, 32):
        code = f"{order}{'f' if kind == 3 else 'u'}{bits // 8}"
        data = texels.astype(code).tobytes()
    else:
        data = b"".join(_packed(row.ravel(), bits) for row in texels)
    own = {
        256: (4, [width]), 257: (4, [height]), 258: (3, [bits] * channels), 259: (3, [1]), 262: (3, [photometric]),
        273: (4, [0]), 277: (3, [channels]), 278: (4, [height]), 279: (4, [len(data)]), 339: (3, [kind] * channels),
    }  # fmt: skip
    entries = {**own, **{number: (code, values) for number, code, values in tags}}
    return _tiff_of(entries, data, order)


def _tiff_of(entries, data, order):
    codes = {1: "B", 3: "H", 4: "I", 5: "II"}
    contents = {
        tag: struct.pack(order + codes[code] * len(values), *np.ravel(values).tolist())
        for tag, (code, values) in entries.items()
    }
    place = 8 + 2 + 12 * len(entries) + 4
    far = b"".join(content + bytes(len(content) % 2) for content in contents.values() if len(content) > 4)
    contents[273] = struct.pack(order + "I", place + len(far))
    index, at = b"", place
    for tag in sorted(entries):
        code, values, content = *entries[tag], contents[tag]
        index += struct.pack(order + "HHI", tag, code, len(values))
        index += content.ljust(4, b"\0") if len(content) <= 4 else struct.pack(order + "I", at)
        at += len(content) + len(content) % 2 if len(content) > 4 else 0
    far = b"".join(contents[tag] + bytes(len(contents[tag]) % 2) for tag in sorted(entries) if len(contents[tag]) > 4)
    start = (b"II*\0" if order == "<" else b"MM\0*") + struct.pack(order + "IH", 8, len(entries))
    return start + index + bytes(4) + far + data


def tga(texels, origin=0x20, alpha_type=None):
    """An uncompressed TGA of 8 bits; ``origin`` says which corner comes first."""
    height, width, channels = texels.shape
    head = struct.pack(
        "<BBBHHBHHHHBB", 0, 0, 2, 0, 0, 0, 0, 0, width, height, 8 * channels, origin | 8 * (channels == 4)
    )
    body = np.ascontiguousarray(texels[..., [2, 1, 0, 3][:channels]]).tobytes()
    if alpha_type is None:
        return head + body
    extension = struct.pack("<H", 495) + bytes(492) + bytes([alpha_type])
    return head + body + extension + struct.pack("<II", len(head) + len(body), 0) + b"TRUEVISION-XFILE.\0"


def _packed(numbers, bits):
    digits = "".join(format(int(number), f"0{bits}b") for number in numbers)
    digits += "0" * (-len(digits) % 8)
    return bytes(int(digits[at : at + 8], 2) for at in range(0, len(digits), 8))
