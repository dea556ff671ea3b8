"""Pickles: any Python reads ours, ours reads plain data of any Python, and nothing else happens."""

import datetime
import json
import os
import pickle
import pickletools
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from openrooms_usd import untrusted
from openrooms_usd.errors import InputError
from openrooms_usd.unpickling import read_pickled, unpickled
from orusd_openrooms.pickles import pickled, write_pickled

BOX: dict[str, Any] = {
    "isWindow": True,
    "box3D": {
        "center": np.array([0.1, -2.0, 1e-9]),
        "xAxis": np.eye(3)[0].astype(np.float32),
        "xLen": 1.25,
    },
    "box2D": {"x1": None, "x2": 639, "y1": 0, "y2": -5},
    "names": ["ä", ("s", np.arange(12).reshape(3, 4)), [], {}],
}


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


def same(a: Any, b: Any) -> bool:
    if isinstance(a, np.ndarray):
        return isinstance(b, np.ndarray) and a.dtype == b.dtype and np.array_equal(a, b)
    if isinstance(a, dict):
        return isinstance(b, dict) and [*a] == [*b] and all(same(a[k], b[k]) for k in a)
    if isinstance(a, list | tuple):
        return type(a) is type(b) and len(a) == len(b) and all(map(same, a, b))
    return type(a) is type(b) and bool(a == b)


def test_python_loads_what_is_written() -> None:
    assert same(pickle.loads(pickled(BOX)), BOX)


def test_every_python_since_2_3_knows_the_instructions() -> None:
    used = [opcode for opcode, _, _ in pickletools.genops(pickled(BOX))]
    assert max(opcode.proto for opcode in used) == 2


@pytest.mark.parametrize("kind", ["?", "u1", "<i4", ">i8", "<f4", ">f8", "f2"])
def test_arrays_keep_their_type_and_shape(kind: str) -> None:
    array = np.array([[0, 1, 2], [3, 4, 250]], kind)
    for found in (pickle.loads(pickled(array)), unpickled(pickled(array))):
        np.testing.assert_array_equal(found, array)
        assert found.dtype == array.dtype.newbyteorder("<") and found.shape == (2, 3)


@pytest.mark.parametrize("protocol", [0, 1, 2, 3, 4])
def test_what_python_wrote_is_read(protocol: int) -> None:
    data = pickle.dumps({**BOX, "x": np.int64(7), "y": np.float32(0.5)}, protocol)
    found = unpickled(data)
    assert (found.pop("x"), found.pop("y")) == (7, 0.5)
    assert same(found, BOX)


def test_an_array_by_columns_is_read() -> None:
    array = np.asfortranarray(np.arange(6.0).reshape(2, 3))
    np.testing.assert_array_equal(unpickled(pickle.dumps(array, 4)), array)


def test_arrays_that_share_their_type_are_read() -> None:
    data = [np.arange(3), np.arange(3), "again", "again"]
    assert same(unpickled(pickle.dumps(data, 4)), data)


def test_one_array_in_two_places_is_read() -> None:
    array = np.arange(3.0)
    found = unpickled(pickle.dumps([array, array], 4))
    np.testing.assert_array_equal(found[1], array)


def test_json_lies_beside_it(tmp_path: Path) -> None:
    write_pickled(tmp_path / "box0.dat", BOX)
    assert same(read_pickled(tmp_path / "box0.dat"), BOX)
    beside = json.loads((tmp_path / "box0.json").read_text("utf-8"))
    assert beside["box3D"]["center"] == [0.1, -2.0, 1e-9]
    assert beside["names"][1][0] == "s"


@pytest.mark.parametrize("value", [b"bytes", {1, 2}, object(), np.array([None]), 1j])
def test_what_is_no_plain_data_is_not_written(value: object) -> None:
    with pytest.raises(TypeError, match="not plain data"):
        pickled({"a": [value]})
