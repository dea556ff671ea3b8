"""PCD files in their three forms, and LZF with a packer of our own."""

import struct
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from openrooms_usd.errors import InputError
from orusd_scans.formats.pcd import UnpackError, read_pcd, unpacked
from tests.scans.damage import cuts_are_refused, hits_are_told

POINTS = np.array([[0.5, 1, 2], [3, 4, 5], [np.nan, 7, 8], [9, 10, 11.25]], "<f4")
RGB = [0xFF8001, 0x000203, 0x111111, 0xABCDEF]
HEAD = (
    "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z rgb label _ d\nSIZE 4 4 4 4 4 1 4\n"
    "TYPE F F F U U U F\nCOUNT 1 1 1 1 1 3 2\nWIDTH 2\nHEIGHT 2\nVIEWPOINT 1 2 3 1 0 0 0\n"
    "POINTS 4\nDATA {}\n"
)
ROW = np.dtype(
    [
        ("x", "<f4"),
        ("y", "<f4"),
        ("z", "<f4"),
        ("rgb", "<u4"),
        ("label", "<u4"),
        ("_", "u1", 3),
        ("d", "<f4", 2),
    ]
)


def rows() -> np.ndarray:
    values = np.zeros(4, ROW)
    for i, axis in enumerate("xyz"):
        values[axis] = POINTS[:, i]
    values["rgb"], values["label"] = RGB, [1, 2, 3, 4]
    return values


def packed(data: bytes) -> bytes:
    """LZF with literals and copies, by a plain search: slow, and nothing of ours."""
    out, at, plain = bytearray(), 0, bytearray()

    def flush() -> None:
        for i in range(0, len(plain), 32):
            piece = plain[i : i + 32]
            out.extend([len(piece) - 1, *piece])
        plain.clear()

    while at < len(data):
        best, back = 0, 0
        for start in range(max(0, at - 8192), at):
            n = 0
            while at + n < len(data) and n < 264 and data[start + n] == data[at + n]:
                n += 1
            if n > best:
                best, back = n, at - start
        if best < 3:
            plain.append(data[at])
            at += 1
            continue
        flush()
        code, offset = best - 2, back - 1
        if code < 7:
            out.extend([code << 5 | offset >> 8, offset & 255])
        else:
            out.extend([7 << 5 | offset >> 8, code - 7, offset & 255])
        at += best
    flush()
    return bytes(out)


def written(path: Path, form: str) -> Path:
    values = rows()
    head = HEAD.format(form).encode()
    if form == "ascii":
        lines = []
        for v in values:
            numbers = [v["x"], v["y"], v["z"], v["rgb"], v["label"], *v["_"], *v["d"]]
            lines.append(" ".join(map(str, numbers)))
        path.write_bytes(head + "\n".join(lines).encode() + b"\n")
    elif form == "binary":
        path.write_bytes(head + values.tobytes())
    else:
        columns = b"".join(np.ascontiguousarray(values[name]).tobytes() for name in ROW.names)
        block = packed(columns)
        path.write_bytes(head + struct.pack("<II", len(block), len(columns)) + block)
    return path


@pytest.mark.parametrize("form", ["ascii", "binary", "binary_compressed"])
def test_all_forms_give_the_same(tmp_path: Path, form: str) -> None:
    cloud = read_pcd(written(tmp_path / "a.pcd", form)).cloud
    assert cloud.points == pytest.approx(POINTS.astype(float), nan_ok=True)
    assert cloud.label.tolist() == [1, 2, 3, 4]
    expected = [[c >> 16, c >> 8 & 255, c & 255] for c in RGB]
    assert cloud.colors.tolist() == expected
    assert cloud.sensor_origins.tolist() == [[1.0, 2.0, 3.0]]


@settings(max_examples=60, deadline=None)
@given(st.lists(st.sampled_from([b"a", b"bcd", b"aaaaaaaa", b"\x00" * 70]), max_size=30))
def test_lzf_gives_back_what_was_packed(pieces: list[bytes]) -> None:
    data = b"".join(pieces)
    assert unpacked(packed(data), len(data)) == data


def test_damaged_lzf_is_refused() -> None:
    data = b"abcabcabcabc" * 20
    block = packed(data)
    with pytest.raises(UnpackError, match="cannot hold"):
        unpacked(block, 10**9)
    for cut in range(len(block)):
        with pytest.raises(UnpackError):
            unpacked(block[:cut], len(data))
    with pytest.raises(UnpackError, match="before its beginning"):
        unpacked(b"\x20\x05", 3)


def test_every_cut_is_refused_and_no_byte_ends_in_a_traceback(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    for form in ("ascii", "binary", "binary_compressed"):
        whole = written(tmp_path / "whole.pcd", form)
        size = whole.stat().st_size
        # A last line that is cut costs its point alone.
        least = 5 if form != "ascii" else len(whole.read_bytes().splitlines()[-1]) + 1
        cuts_are_refused(read_pcd, whole, [*range(0, size - least, 5), size - least])
        hits_are_told(read_pcd, whole, rng, 120)


def test_a_damaged_line_is_told_by_its_number(tmp_path: Path) -> None:
    lines = written(tmp_path / "a.pcd", "ascii").read_text().splitlines()
    lines[-1] = "\n\n" + lines[-1].replace(" ", " x", 1)
    (tmp_path / "a.pcd").write_text("\n".join(lines))
    assert f"the first is line {len(lines) + 2}," in read_pcd(tmp_path / "a.pcd").notes[0]


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("# .PCD", "\x89PNG", "not a PCD file"),
        ("POINTS 4", "POINTS 5", "announces 5 points"),
        ("POINTS 4", "POINTS 9999999999999", "not a number of points"),
        ("WIDTH 2\nHEIGHT 2", "WIDTH 0\nHEIGHT 0", "announces 4 points"),
        ("WIDTH 2\nHEIGHT 2\n", "", "ends too early"),
        ("SIZE 4 4 4", "SIZE 3 4 4", "is not known"),
        ("TYPE F F F U U U F", "TYPE F F", "differ in length"),
        ("COUNT 1 1 1 1 1 3 2", "COUNT 1 1 1 1 1 3 99999", "make no sense"),
        ("FIELDS x y z", "FIELDS a b c", "no coordinates"),
        ("FIELDS x y z rgb", "FIELDS x y z x", "make no row"),
        ("DATA binary", "DATA zip", "is not known"),
        ("VIEWPOINT 1 2 3", "VIEWPOINT one 2 3", "VIEWPOINT"),
        ("TYPE F F F U U U F\n", "", "lacks TYPE"),
    ],
)
def test_nonsense_in_the_header_is_refused(tmp_path: Path, old: str, new: str, said: str) -> None:
    whole = written(tmp_path / "whole.pcd", "binary").read_bytes()
    if "WIDTH" in old and not new:
        new, whole = "WIDTH 500\nHEIGHT 2\n", whole.replace(b"POINTS 4\n", b"POINTS 1000\n")
    (tmp_path / "bad.pcd").write_bytes(whole.replace(old.encode(), new.encode("latin-1"), 1))
    with pytest.raises(InputError, match=said):
        read_pcd(tmp_path / "bad.pcd")
