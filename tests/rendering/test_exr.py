"""What is written to EXR is what is read back."""

import struct
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from openrooms_usd.channels import CHANNELS
from openrooms_usd.errors import InputError, OutputError
from openrooms_usd.rendering import exr


def header(path: Path) -> dict[str, bytes]:
    """The attributes of an EXR header, read by the format's definition and by nothing else."""
    data = path.read_bytes()
    assert data[:4] == b"v/1\x01"
    at, found = 8, {}
    while data[at] != 0:
        name, kind, _ = data[at : at + 600].split(b"\0", 2)
        at += len(name) + len(kind) + 2
        size = struct.unpack("<i", data[at : at + 4])[0]
        found[name.decode()] = data[at + 4 : at + 4 + size]
        at += 4 + size
    return found


def channel_types(path: Path) -> dict[str, str]:
    table, at, found = header(path)["channels"], 0, {}
    while table[at] != 0:
        end = table.index(b"\0", at)
        kind = struct.unpack("<i", table[end + 1 : end + 5])[0]
        found[table[at:end].decode()] = ("uint", "half", "float")[kind]
        at = end + 17
    return found


SETS = [tuple(CHANNELS), tuple(reversed(CHANNELS)), *((name,) for name in CHANNELS)]


@pytest.mark.parametrize("names", SETS, ids="-".join)
def test_every_channel_is_stored_as_the_table_says(tmp_path, numbers, names):
    path = tmp_path / "a.exr"
    exr.write_channels(path, {name: numbers(name, 20, 30, 1) for name in names})
    rows = [CHANNELS[name] for name in names]
    assert channel_types(path) == {
        f"{row.name}.{part}": row.storage for row in rows for part in row.components
    }


@pytest.mark.parametrize("names", SETS, ids="-".join)
def test_round_trip(tmp_path, numbers, names):
    images = {name: numbers(name, 300, 7, 1) for name in names}
    exr.write_channels(tmp_path / "a.exr", images)
    back = exr.read_channels(tmp_path / "a.exr")
    assert set(back) == set(names)
    for name, pixels in images.items():
        if CHANNELS[name].storage == "float":
            assert np.array_equal(back[name], pixels), name
        else:
            # Half has 11 significant bits: half a unit in the last place, and none below 2^-25.
            assert np.all(np.abs(back[name] - pixels) <= np.abs(pixels) * 2.0**-11 + 2.0**-25), name


def test_pixels_in_any_memory_order(tmp_path, numbers):
    pixels = numbers("radiance", 20, 30, 1)
    for name, same in {
        "a.exr": np.asfortranarray(pixels),
        "b.exr": np.flip(np.flip(pixels, 2).copy(), 2),
        "c.exr": np.repeat(pixels, 2, axis=1)[:, ::2],
    }.items():
        exr.write_channels(tmp_path / name, {"radiance": same, "position": same})
        back = exr.read_channels(tmp_path / name)
        assert np.array_equal(back["radiance"], pixels)
        assert np.array_equal(back["position"], pixels)


@given(hnp.arrays(np.int64, (3, 5, 1), elements=st.integers(0, 2**24 - 1)))
def test_ids_are_exact(tmp_path_factory, ids):
    path = tmp_path_factory.mktemp("ids") / "a.exr"
    exr.write_channels(path, {"instance": ids.astype(np.float32)})
    assert np.array_equal(exr.read_channels(path)["instance"].astype(np.int64), ids)


def test_what_is_not_finite_stays_what_it_is(tmp_path):
    pixels = np.array([[[np.nan, np.inf, -np.inf], [1e30, -1.0, 0.0]]], np.float32)
    exr.write_channels(tmp_path / "a.exr", {"radiance": pixels})
    back = exr.read_channels(tmp_path / "a.exr")["radiance"]
    assert np.array_equal(back, pixels, equal_nan=True)


def test_header_knows_no_time_and_says_what_white_is(tmp_path, numbers):
    exr.write_rgb(tmp_path / "a.exr", numbers("radiance", 4, 4, 0))
    found = header(tmp_path / "a.exr")
    assert not {"capDate", "utcOffset", "Software", "owner"} & found.keys()
    assert struct.unpack("<f", found["whiteLuminance"])[0] == 1
    rec709 = (0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290)
    assert struct.unpack("<8f", found["chromaticities"]) == pytest.approx(rec709)
    assert list(channel_types(tmp_path / "a.exr")) == ["B", "G", "R"]


@pytest.mark.parametrize("size", [1, 20, 400])
def test_full_disk_is_an_error(tmp_path, size):
    full = tmp_path / "a.exr"
    full.symlink_to("/dev/full")
    pixels = np.random.default_rng(0).random((size, size, 3)).astype(np.float32)
    with pytest.raises(OutputError, match="cannot write"):
        exr.write_rgb(full, pixels)


def test_missing_and_broken_files(tmp_path):
    (tmp_path / "broken.exr").write_bytes(b"v/1\x01 and nothing more")
    for name, said in (("missing.exr", "no such file"), ("broken.exr", "not a readable image")):
        with pytest.raises(InputError, match=said):
            exr.read_channels(tmp_path / name)
