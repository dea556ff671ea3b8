"""What was found in a scan comes back to the last bit; a file that says otherwise is refused."""

import json
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from openrooms_usd.errors import InputError
from openrooms_usd.scan.artefact import FoundScan, digest_of, read_found, write_found
from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.registration.hints import Box
from openrooms_usd.scan.results import FoundOpening, FoundRoom

RNG = np.random.default_rng(0)
UP = np.array([0.0, 0.0, 1.0])
ROOM = FoundRoom(
    UP,
    np.zeros(3),
    RNG.random((5, 3)),
    guessed=(2,),
    ceiling=2.0 / 3.0,
    openings=(FoundOpening("door", RNG.random((4, 3)), 0.7, 1),),
    measures={"coverage": 0.1 + 0.2, "floor_residual": float("nan")},
    slopes=((UP, RNG.random(3)),),
    doubtful=(FoundOpening("window", RNG.random((4, 3)), 0.3, 0),),
)
WHOLE = Cloud(
    RNG.random((7, 3)),
    normals=RNG.random((7, 3)).astype("f4"),
    colors=RNG.integers(0, 255, (7, 3)).astype("u1"),
    label=np.arange(7, dtype="i4"),
    instance=np.arange(7, dtype="i4"),
    confidence=RNG.random(7).astype("f4"),
    sensor_origins=RNG.random((2, 3)),
    words={1: ("bath", "tub"), 0: ("\u00fc",)},
)


def scan(cloud: Cloud = WHOLE) -> FoundScan:
    box = Box(RNG.random(3), RNG.random(3), np.array([1.0, 0.0, 0.0, 0.0]))
    return FoundScan("a.ply", cloud, (ROOM, ROOM), (1,), RNG.random((4, 4)), (("sofa", box),))


@pytest.mark.parametrize("cloud", [WHOLE, Cloud(RNG.random((3, 3)))])
def test_everything_comes_back_to_the_last_bit(tmp_path: Path, cloud: Cloud) -> None:
    arrays = scan(cloud).arrays()
    files = [tmp_path / name for name in ("one.npz", "two.npz")]
    for file in files:
        write_found(file, arrays)
    assert files[0].read_bytes() == files[1].read_bytes()
    found = read_found(files[0], digest_of(arrays))
    again = found.arrays()
    assert {name: values.tobytes() for name, values in again.items()} == {
        name: values.tobytes() for name, values in arrays.items()
    }
    assert found.cloud.words == cloud.words
    for field in fields(Cloud):
        assert (getattr(cloud, field.name) is None) == (getattr(found.cloud, field.name) is None)


def changed(**facts: Any) -> dict[str, Any]:
    arrays = scan().arrays()
    said = {**json.loads(arrays["facts"].tobytes()), **facts}
    return {**arrays, "facts": np.frombuffer(json.dumps(said).encode(), np.uint8)}


@pytest.mark.parametrize(
    "arrays",
    [
        {**scan().arrays(), "points": np.zeros((7, 2))},
        {**scan().arrays(), "label": np.zeros(6, "i4")},
        {**scan().arrays(), "normals": np.zeros((7, 3))},
        {name: values for name, values in scan().arrays().items() if name != "points"},
        {name: values for name, values in scan().arrays().items() if name != "facts"},
        {**scan().arrays(), "facts": np.frombuffer(b"[" * 100_000, np.uint8)},
        changed(chosen=[2]),
        changed(rooms=[{}]),
        changed(rooms=None),
        changed(words=[[1]]),
        changed(scan_from_level=[[1.0]]),
        changed(captured=[["sofa", [0, 0], [1, 1, 1], [1, 0, 0, 0]]]),
    ],
)
def test_what_does_not_fit_is_refused(tmp_path: Path, arrays: dict[str, Any]) -> None:
    write_found(tmp_path / "found.npz", arrays)
    with pytest.raises(InputError, match="damaged"):
        read_found(tmp_path / "found.npz", digest_of(arrays))


def test_what_was_changed_or_is_missing_is_refused(tmp_path: Path) -> None:
    file, digest = tmp_path / "found.npz", digest_of(scan().arrays())
    with pytest.raises(InputError, match="no such file"):
        read_found(file, digest)
    write_found(file, {**scan().arrays(), "label": np.zeros(7, "i4")})
    with pytest.raises(InputError, match="not what compose wrote"):
        read_found(file, digest)
    file.write_bytes(b"PK")
    with pytest.raises(InputError):
        read_found(file, digest)
