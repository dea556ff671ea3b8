"""Spoils bytes and texts: flips, cuts, repeats, absurd numbers, depth, and names that lead away."""

import math
import re
import struct
import sys
from collections.abc import Callable, Sequence
from random import Random
from typing import Final

Mutator = Callable[[bytes, Random], bytes]

# Where counts, offsets and sizes overflow.
_INTEGERS: Final = tuple(
    edge for bits in (7, 8, 15, 16, 31, 32, 63, 64) for edge in ((1 << bits) - 1, 1 << bits)
)
# Not a number, infinities, and the largest and least numbers, single and double precision.
_FLOATS: Final = tuple(
    struct.pack(form, value)
    for form, values in (
        ("<f", (math.nan, math.inf, -math.inf, 3.4028234e38, 1e-45)),
        ("<d", (math.nan, math.inf, -math.inf, sys.float_info.max, 5e-324)),
    )
    for value in values
)
_NUMBERS: Final = """
0 -0 -1 1 1e400 -1e400 nan NaN inf -Infinity 1e-320 1e9 1e38 1e39 1e300 2147483648 -2147483649
4294967296 9223372036854775808 99999999999999999999999999 0x10 1_000 ١ 1.5 0.1.2 1e
"""
NUMBERS: Final = (*_NUMBERS.split(), "", "9" * 5000)
# `beside` lies next to the input: a pipe that nobody writes, a link without end, a file.
_PATHS: Final = """
. .. / ../.. ../beside ../beside/keep.txt ../beside/pipe ../beside/endless ../beside/circle
/etc/passwd /dev/zero /dev/stdin /proc/self/mem ~/x C:\\x \\\\host\\x file:///etc/passwd
http://127.0.0.1:9/x con -rf \u202eexe
"""
_ODD_PATHS: Final = ("", "a" * 300, "a/" * 2500, "x\0y", "a\nb", "\ud800", "x" * 100_000)
PATHS: Final = (*_PATHS.split(), *_ODD_PATHS)
# What terminals act upon; C1, right to left and a mark of order; what is no UTF-8.
_CONTROLS: Final = "\0|\x1b[31m|\x1b]0;x\x07|\x07|\x08|\x0c|\x7f|\r|\r\n|\t|\x9b|\u202e|\ufeff"
_NO_UTF8: Final = (b"\xff", b"\xfe\xff", b"\xc3(", b"\xed\xa0\x80", b"\xf4\x90", b"\x80")
_CODES: Final = (*_CONTROLS.encode().split(b"|"), *_NO_UTF8)
_NESTS: Final = (b"[", b"{", b"(", b'{"a":', b"[[", b"- ", b"<a>", b'def "a" {\n', b"((", b'"')
_DEPTHS: Final = (20, 200, 2_000, 20_000, 100_000)
_NUMBER: Final = re.compile(rb"[-+]?\d+(?:\.\d*)?(?:[eE][-+]?\d+)?")
_STRING: Final = re.compile(rb'"[^"\n]*"|@[^@\n]*@|<[^<>\n]*>')
_WORD: Final = re.compile(rb"[A-Za-z_][\w:]*")


def _place(data: bytes, rng: Random) -> int:
    """Anywhere; as often near the beginning, where headers are."""
    end = len(data) if rng.random() < 0.5 else min(len(data), 400)
    return rng.randrange(end + 1)


def flip(data: bytes, rng: Random) -> bytes:
    """Turn bits of one to eight bytes."""
    changed = bytearray(data)
    for _ in range(rng.randint(1, 8) if data else 0):
        changed[min(_place(data, rng), len(data) - 1)] ^= 1 << rng.randrange(8)
    return bytes(changed)


def overwrite(data: bytes, rng: Random) -> bytes:
    """Put an absurd number, or noise, over some bytes."""
    at = _place(data, rng)
    what = rng.randrange(3)
    if what == 0:
        size = rng.choice((1, 2, 4, 8))
        order = "little" if rng.random() < 0.7 else "big"
        new = (rng.choice(_INTEGERS) % (1 << 8 * size)).to_bytes(size, order)
    else:
        new = rng.choice(_FLOATS) if what == 1 else rng.randbytes(rng.randint(1, 16))
    return data[:at] + new + data[at + len(new) :]


def insert(data: bytes, rng: Random) -> bytes:
    """Put noise in between."""
    at = _place(data, rng)
    return data[:at] + rng.randbytes(rng.choice((1, 4, 32, 1000))) + data[at:]


def delete(data: bytes, rng: Random) -> bytes:
    """Take a block out."""
    at = _place(data, rng)
    return data[:at] + data[at + rng.choice((1, 2, 4, 16, 200)) :]


def repeat(data: bytes, rng: Random) -> bytes:
    """Have a block several times."""
    at = _place(data, rng)
    block = data[at : at + rng.choice((1, 16, 200, 4000))]
    return data[:at] + block * rng.choice((2, 3, 50)) + data[at + len(block) :]


def cut(data: bytes, rng: Random) -> bytes:
    """End too early."""
    return data[: _place(data, rng)]


def number(data: bytes, rng: Random) -> bytes:
    """An absurd number in place of one to four."""
    for _ in range(rng.randint(1, 4)):
        data = _replaced(data, _NUMBER, rng.choice(NUMBERS).encode(), rng)
    return data


def nest(data: bytes, rng: Random) -> bytes:
    """Open brackets so often that recursion ends."""
    at, opened = _place(data, rng), rng.choice(_NESTS)
    return data[:at] + opened * rng.choice(_DEPTHS) + data[at:]


def control(data: bytes, rng: Random) -> bytes:
    """Control characters, and bytes that are no UTF-8."""
    for _ in range(rng.randint(1, 3)):
        at = _place(data, rng)
        data = data[:at] + rng.choice(_CODES) + data[at:]
    return data


def name(data: bytes, rng: Random) -> bytes:
    """A name or path that is long, leads away, or is none."""
    new = rng.choice(PATHS).encode("utf-8", "surrogatepass")
    found = _some(_STRING, data, rng)
    if found is None:
        return _replaced(data, _WORD, new, rng)
    return data[: found.start() + 1] + new + data[found.end() - 1 :]


def word(data: bytes, rng: Random) -> bytes:
    """A word of the text in place of another."""
    other = _some(_WORD, data, rng)
    return data if other is None else _replaced(data, _WORD, other.group(), rng)


def line(data: bytes, rng: Random) -> bytes:
    """Remove, repeat or exchange lines."""
    lines = data.splitlines(keepends=True)
    if not lines:
        return data
    i, j = rng.randrange(len(lines)), rng.randrange(len(lines))
    what = rng.randrange(4)
    if what == 0:
        del lines[i]
    elif what == 1:
        lines[i:i] = lines[i : i + rng.randint(1, 20)] * rng.choice((1, 2, 100))
    elif what == 2:
        lines[i], lines[j] = lines[j], lines[i]
    else:
        del lines[min(i, j) : max(i, j)]
    return b"".join(lines)


def _replaced(data: bytes, pattern: re.Pattern[bytes], new: bytes, rng: Random) -> bytes:
    found = _some(pattern, data, rng)
    return data if found is None else data[: found.start()] + new + data[found.end() :]


def _some(pattern: re.Pattern[bytes], data: bytes, rng: Random) -> re.Match[bytes] | None:
    """One of the matches, the first one after some place."""
    if not data:
        return None
    return pattern.search(data, _place(data, rng)) or pattern.search(data)


BYTES: Final[Sequence[Mutator]] = (flip, flip, overwrite, overwrite, insert, delete, repeat, cut)
TEXT: Final[Sequence[Mutator]] = (
    *(number, number, number, name, name, word, line, line, control, nest, delete, cut, flip),
)


def is_text(data: bytes) -> bool:
    """Whether the beginning looks like text."""
    head = data[:200]
    return bool(head) and all(byte >= 32 or byte in b"\t\r\n\f" for byte in head)


def spoil(data: bytes, rng: Random) -> bytes:
    """One to three changes, of texts mostly those of texts."""
    text = is_text(data)
    for _ in range(rng.choice((1, 1, 1, 2, 3))):
        table = TEXT if text and rng.random() < 0.85 else BYTES
        if not text and rng.random() < 0.15:
            table = (number, name, control)  # headers within bytes
        data = rng.choice(table)(data, rng)
    return data
