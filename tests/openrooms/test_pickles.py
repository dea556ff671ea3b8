"""Pickles: what is written, any Python loads; what Pythons wrote, the restricted reader reads."""

import json
import pickle
import pickletools
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from openrooms_usd.unpickling import read_pickled, unpickled
from orusd_openrooms.pickles import pickled, write_pickled

BOX: dict[str, Any] = {
    "isWindow": True,
    "box3D": {
        "center": np.array([0.1, -2.0, 1e-9]), "xAxis": np.eye(3)[0].astype(np.float32),
        "xLen": 1.25,
    },
    "box2D": {"x1": None, "x2": 639, "y1": 0, "y2": -5},
    "names": ["ä", ("s", np.arange(12).reshape(3, 4)), [], {}],
}  # fmt: skip


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
    with pytest.raises(TypeError, match="no plain data"):
        pickled({"a": [value]})
