"""Small changes to the bytes of a file, of the kinds that disks, networks and attackers make."""

import random
import re
from collections.abc import Callable

Mutation = Callable[[random.Random, bytes], bytes]

_NUMBERS = (0, 1, 0x10000, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFF)
INTERESTING = [number.to_bytes(4, order) for number in _NUMBERS for order in ("little", "big")]


def flip_bit(rng: random.Random, content: bytes) -> bytes:
    return _set(content, at := rng.randrange(len(content)), bytes([content[at] ^ 1 << rng.randrange(8)]))


def truncate(rng: random.Random, content: bytes) -> bytes:
    return content[: rng.randrange(len(content))]


def overwrite_window(rng: random.Random, content: bytes) -> bytes:
    length = rng.randint(1, min(64, len(content)))
    other = rng.randrange(len(content) - length + 1)
    fill = rng.choice([b"\0" * length, b"\xff" * length, rng.randbytes(length), content[other : other + length]])
    return _set(content, rng.randrange(len(content) - length + 1), fill)


def mutate_header(rng: random.Random, content: bytes) -> bytes:
    """A number at the front, where formats keep their sizes, becomes another."""
    front = max(1, min(len(content) - 4, rng.choice([32, 400])))
    return _set(content, rng.randrange(front), rng.choice([*INTERESTING, rng.randbytes(4)]))


def append_tail(rng: random.Random, content: bytes) -> bytes:
    return content + rng.choice([b"\0", b"\n", content, rng.randbytes(rng.randint(1, 4096))])


def insert_or_cut(rng: random.Random, content: bytes) -> bytes:
    at, length = rng.randrange(len(content)), rng.randint(1, 32)
    if rng.random() < 0.5:
        return content[:at] + content[at + length :]
    other = rng.randrange(len(content))
    return content[:at] + content[other : other + length] * rng.choice([1, 1, 100]) + content[at:]


def change_token(rng: random.Random, content: bytes) -> bytes:
    """A word of a text becomes one that a parser may not expect."""
    odd = b"nan inf -inf 1e999 -1 0 99999999999999999999 1e-320 0x10 1_0 1/1/1/1 // / - v f vt # \\ \xff\xfe".split()
    words = content.split(b" ")
    words[rng.randrange(len(words))] = rng.choice([*odd, b"", b"\n", b"\0"])
    return b" ".join(words)


def change_line(rng: random.Random, content: bytes) -> bytes:
    """A line of a text is lost, doubled, moved, run together with the next one, or gets another first word."""
    lines = re.findall(rb"[^\r\n]*(?:\r\n|\r|\n|$)", content)
    at, other = rng.randrange(len(lines)), rng.randrange(len(lines))
    line = lines[at]
    words = [b"v", b"vt", b"vn", b"f", b"fo", b"l", b"F", b"#", b"\\", b"call", b"surf", b"x", b"usemtl"]
    change = rng.choice(["lost", "doubled", "moved", "joined", "renamed"])
    if change == "renamed":
        lines[at] = re.sub(rb"^\s*\S*", lambda _: rng.choice(words), line)
    elif change == "joined":
        lines[at] = line.rstrip(b"\r\n")
    else:
        lines[at] = b"" if change == "lost" else line + line if change == "doubled" else lines[other]
        lines[other] = line if change == "moved" else lines[other]
    return b"".join(lines)


def change_number(rng: random.Random, content: bytes) -> bytes:
    """A number of a text becomes another one of as many digits, so that no length before it gives that away."""
    digits = rng.choice([*re.finditer(rb"\d+", content[:4096])] or [re.match(b"", content)])
    length = digits.end() - digits.start()
    others = [b"9" * length, b"-" + b"9" * (length - 1), b"1e" + b"9" * (length - 2), str(rng.random()).encode()]
    return _set(content, digits.start(), rng.choice(others)[:length])


ALL: tuple[Mutation, ...] = (flip_bit, truncate, overwrite_window, mutate_header, append_tail, insert_or_cut)


def mutate(rng: random.Random, content: bytes, kinds: tuple[Mutation, ...] = ALL) -> bytes:
    """One to four changes, so that the result differs."""
    changed = content
    while changed == content:
        for _ in range(rng.choice([1, 1, 2, 4])):
            changed = rng.choice(kinds)(rng, changed or content)
    return changed


def _set(content: bytes, at: int, value: bytes) -> bytes:
    return content[:at] + value + content[at + len(value) :]
