"""Pickles that want to do something: none of it happens, and each is refused with a reason."""

import datetime
import os
import pickle
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from openrooms_usd import untrusted
from openrooms_usd.errors import InputError
from openrooms_usd.unpickling import read_pickled
from orusd_openrooms.pickles import pickled


class Calls:
    """Pickles as the call of a function."""

    def __init__(self, function: Callable[..., object], *arguments: object) -> None:
        self.call = (function, arguments)

    def __reduce__(self) -> tuple[Callable[..., object], tuple[object, ...]]:
        return self.call


class Plain:
    """An object with a state."""


def laughs() -> list[object]:
    """Ten lists of ten lists ...: small as a file, large when it is walked."""
    value: list[object] = ["ha"]
    for _ in range(6):
        value = [value] * 10
    return value


def itself() -> list[object]:
    value: list[object] = []
    value.append(value)
    return value


def nested() -> list[object]:
    value: list[object] = []
    for _ in range(60):
        value = [value]
    return value


RECORDS = np.zeros(2, [("a", "f4"), ("b", "i4")])
HOSTILE: dict[str, object] = {
    "command": Calls(os.system, "touch {marker}"),
    "evaluated": Calls(eval, "open('{marker}', 'w')"),
    "opened": Calls(open, "{marker}", "w"),
    "attribute": Calls(getattr, "a", "upper"),
    "numpy's own loader": Calls(np.load, "{marker}"),
    "array of objects": np.array([None, "x"], object),
    "array of texts": np.array(["a", "bc"]),
    "array of bytes": np.array([b"a"]),
    "array of dates": np.array(["2020-01-01"], "datetime64[D]"),
    "array of complex numbers": np.array([1j]),
    "array of records": RECORDS,
    "object": Plain(),
    "class": Plain,
    "date": datetime.date(2020, 1, 1),
    "set": {1, 2},
    "bytes": b"abc",
    "complex number": 1j,
    "list of itself": itself(),
    "shared lists": laughs(),
    "nested lists": nested(),
    "masked array": np.ma.array([1.0], mask=[True]),
    "type": np.dtype("f4"),
    "key": {(1, 2): 3},
}
RAW: dict[str, bytes] = {
    "empty": b"",
    "text": b"hello",
    "cut off": pickled({"a": np.arange(9)})[:-9],
    "two values": b"\x80\x02K\x01K\x02.",
    "a bare mark": b"\x80\x02(.",
    "nothing on the stack": b"\x80\x02R.",
    "a call of a text": b"\x80\x02X\x01\x00\x00\x00a)R.",
    "an old instance": b"(S'true'\nios\nsystem\n.",
    "an object by its class": b"\x80\x02cnumpy\nndarray\n)\x81.",
    "an extension": b"\x80\x02\x82\x01.",
    "a persistent name": b"Pname\n.",
    "a name alone": b"\x80\x02cnumpy\nndarray\n.",
    "a dotted name": b"\x80\x04\x8c\x05numpy\x8c\x0bndarray.fly\x93.",
    "a blank array": b"\x80\x02cnumpy.core.multiarray\n_reconstruct\n(cnumpy\nndarray\nK\x00\x85"
    b"X\x01\x00\x00\x00btR.",
    "another encoding": b"\x80\x02c_codecs\nencode\nX\x01\x00\x00\x00aX\x05\x00\x00\x00rot13\x86R.",
    "a shape that is too large": pickled(np.arange(4.0)).replace(
        b"(J\x04\x00\x00\x00t", b"(J\x04\x10\x00\x00t"
    ),
    "a type with fields": pickled(np.arange(4.0)).replace(
        b"X\x01\x00\x00\x00<NN", b"X\x01\x00\x00\x00<N}X\x01\x00\x00\x00aK\x01s"
    ),
    "a length that is too large": b"\x80\x02X\xff\xff\xff\x7fabc.",
    "a memory that is not there": b"\x80\x02h\x07.",
    "a length that no memory holds": b"\x80\x05\x96" + (1 << 40).to_bytes(8, "little") + b".",
    # Hashing would take 2^60 steps, or a stack of half a million calls.
    "a key that unfolds": b"\x80\x02})" + b"q\0h\0\x86" * 60 + b"K\x01s.",
    "a key that is nested": b"\x80\x02}K\x01" + b"\x85" * 500_000 + b"K\x01s.",
}


@pytest.mark.parametrize("protocol", [2, 4, 5])
@pytest.mark.parametrize("name", HOSTILE)
def test_nothing_but_plain_data_is_read(name: str, protocol: int, tmp_path: Path) -> None:
    marker = tmp_path / "marker"
    value = HOSTILE[name]
    if isinstance(value, Calls):
        texts = [str(text).format(marker=marker) for text in value.call[1]]
        value = Calls(value.call[0], *texts)
    file = tmp_path / "box0.dat"
    file.write_bytes(pickle.dumps({"isWindow": value}, protocol))
    with pytest.raises(InputError, match="not a pickle of plain data") as caught:
        read_pickled(file)
    assert not marker.exists()
    assert str(file) in str(caught.value)


@pytest.mark.parametrize("name", RAW)
def test_bytes_that_are_no_sound_pickle_are_refused(name: str, tmp_path: Path) -> None:
    file = tmp_path / "box0.dat"
    file.write_bytes(RAW[name])
    with pytest.raises(InputError, match="not a pickle of plain data"):
        read_pickled(file)


def test_random_damage_is_refused_or_harmless(tmp_path: Path) -> None:
    """Whatever single byte changes: plain data, or our own error."""
    sound = pickled({"center": np.arange(3.0), "xLen": 0.5, "box2D": (None, 3)})
    rng = np.random.default_rng(5)
    file = tmp_path / "box0.dat"
    for _ in range(600):
        damaged = bytearray(sound)
        damaged[rng.integers(len(sound))] = rng.integers(256)
        file.write_bytes(bytes(damaged))
        try:
            value = read_pickled(file)
        except InputError:
            continue
        assert isinstance(value, dict | list | tuple | str | int | float | np.ndarray | None)


def test_a_file_that_is_too_large_is_not_even_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(untrusted.MOST_BYTES, "pickle", 10)
    (tmp_path / "box0.dat").write_bytes(pickled([1.0] * 9))
    with pytest.raises(InputError, match="at most"):
        read_pickled(tmp_path / "box0.dat")


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such file"):
        read_pickled(tmp_path / "none.dat")
