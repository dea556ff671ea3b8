"""Scans that mean harm, or are damaged where it counts: one sentence, at once, without memory."""

import io
import json
import os
import struct
import tracemalloc
import zipfile
from pathlib import Path

import numpy as np
import pytest
from scipy.io import savemat

from openrooms_usd import untrusted
from openrooms_usd.capture import read_capture
from openrooms_usd.errors import InputError
from openrooms_usd.unpickling import read_pickled
from orusd_scans.plainscan import READERS, read_scanned
from orusd_scans.roomplan.importer import RoomPlanImporter
from orusd_scans.scannet.frames import Sens
from orusd_scans.sunrgbd.files import read_matrix
from tests.scans.laser import write_e57, write_las

POINTS = np.random.default_rng(0).random((300, 3))


pytestmark = pytest.mark.usefixtures("in_time")


NO_FILES = {"pipe": "a pipe", "endless": "a device", "folder": "a folder"}


def made(path: Path, kind: str) -> Path:
    if kind == "pipe":
        os.mkfifo(path)
    elif kind == "endless":
        path.symlink_to("/dev/zero")
    else:
        path.mkdir()
    return path


@pytest.mark.parametrize("kind", sorted(NO_FILES))
@pytest.mark.parametrize("ending", sorted(READERS))
def test_only_regular_files_are_read(tmp_path: Path, ending: str, kind: str) -> None:
    with pytest.raises(InputError, match=NO_FILES[kind]):
        read_scanned(made(tmp_path / f"a{ending}", kind))


@pytest.mark.parametrize("kind", ["pipe", "endless"])
@pytest.mark.parametrize(
    ("importer", "name"),
    [
        ("roomplan", "a.json"),
        ("roomplan", "a.usdz"),
        ("boxes", "a.csv"),
        ("boxes", "a.json"),
        ("scan2cad", "a.json"),
        ("sunrgbd", "a.pkl"),
    ],
)
def test_every_importer_comes_through_the_door(
    tmp_path: Path, importer: str, name: str, kind: str
) -> None:
    with pytest.raises(InputError, match=NO_FILES[kind]):
        read_capture(importer, made(tmp_path / name, kind))


@pytest.mark.parametrize("ending", sorted(READERS))
def test_what_is_too_large_is_not_even_read(
    tmp_path: Path, ending: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    for kind in untrusted.MOST_BYTES:
        monkeypatch.setitem(untrusted.MOST_BYTES, kind, 10)
    (tmp_path / f"a{ending}").write_bytes(b"x" * 11)
    with pytest.raises(InputError, match="at most"):
        read_scanned(tmp_path / f"a{ending}")


def refused(path: Path, data: bytes, says: str, most: int = 50_000_000) -> None:
    """It is refused, in words, and takes no memory."""
    path.write_bytes(data)
    tracemalloc.start()
    try:
        with pytest.raises(InputError, match=says) as caught:
            read_scanned(path)
        assert tracemalloc.get_traced_memory()[1] < most
    finally:
        tracemalloc.stop()
    assert len(str(caught.value)) < 600


def npy(header: bytes, data: bytes = b"") -> bytes:
    header = header.ljust(117) + b"\n"
    return b"\x93NUMPY\x01\0" + struct.pack("<H", len(header)) + header + data


def npz(member: bytes) -> bytes:
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("points.npy", member)
    return out.getvalue()


@pytest.mark.parametrize(
    ("header", "says"),
    [
        (b"{'descr': '<f8', 'fortran_order': False, 'shape': (22906492245, 3)}", "ends too early"),
        (b"{'descr': '<f8', 'fortran_order': False, 'shape': (-1, 3)}", "its shape"),
        (b"{'descr': '<f8', 'fortran_order': False, 'shape': (1, 3), ", "not a readable array"),
        (b"{'descr': '|O', 'fortran_order': False, 'shape': (1, 3)}", "no numbers but object"),
        (b"{'descr': '<U9', 'fortran_order': False, 'shape': (1, 3)}", "no numbers but"),
        (b"(" * 100, "not a readable array"),
        (b"{'descr': '<f8', 'fortran_order': '''", "not a readable array"),
    ],
)
def test_headers_of_arrays(tmp_path: Path, header: bytes, says: str) -> None:
    refused(tmp_path / "a.npz", npz(npy(header)), says)


@pytest.mark.slow
def test_arrays_that_unfold_without_end(tmp_path: Path) -> None:
    rows = 1 << 24
    header = f"{{'descr': '<f8', 'fortran_order': False, 'shape': ({rows}, 3)}}".encode()
    refused(tmp_path / "a.npz", npz(npy(header, bytes(24 * rows))), "its arrays claim 0.4 GiB")
    data = bytearray(npz(npy(b"{'descr': '<f8', 'fortran_order': False, 'shape': (1, 3)}")))
    data[60:80] = bytes(20)
    refused(tmp_path / "b.npz", bytes(data), "archive is damaged|no array")


PLY = "ply\nformat {}\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
CORNERS = np.eye(3, dtype="<f4").tobytes()


@pytest.mark.parametrize(
    ("head", "data"), [("binary_little_endian 1.0", b"\1"), ("ascii 1.0", b"")]
)
def test_faces_that_are_no_lists_are_told(tmp_path: Path, head: str, data: bytes) -> None:
    text = PLY.format(head) + "element face 1\nproperty uchar vertex_indices\nend_header\n"
    corners = CORNERS if data else b"1 0 0\n0 1 0\n0 0 1\n1\n"
    (tmp_path / "a.ply").write_bytes(text.encode() + corners + data)
    scanned = read_scanned(tmp_path / "a.ply")
    assert scanned.faces is None
    assert scanned.notes == ("elements that are not used: 1 face",)


def test_coordinates_that_are_lists(tmp_path: Path) -> None:
    text = "ply\nformat binary_little_endian 1.0\nelement vertex 1\n"
    text += "".join(f"property list uchar uchar {axis}\n" for axis in "xyz") + "end_header\n"
    refused(tmp_path / "a.ply", text.encode() + b"\2aa" * 3, "no coordinates")


@pytest.mark.parametrize("form", ["ascii", "binary", "binary_compressed"])
def test_fields_of_nothing(tmp_path: Path, form: str) -> None:
    text = "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 0 0 0\nWIDTH 5\nHEIGHT 1\n"
    refused(tmp_path / "a.pcd", f"{text}POINTS 5\nDATA {form}\n".encode() + bytes(8), "nothing")


@pytest.mark.parametrize("at", [96, 100])
def test_records_that_las_announces(tmp_path: Path, at: int) -> None:
    path = tmp_path / "a.las"
    data = bytearray(write_las(path, POINTS).read_bytes())
    struct.pack_into("<I", data, at, 0xFFFFFFF0)
    refused(path, bytes(data), "ends too early")
    more = bytearray(write_las(path, POINTS, 7, "1.4").read_bytes())
    struct.pack_into("<QI", more, 235, len(more) - 60, 0xFFFFFFF0)
    refused(path, bytes(more), "ends too early")


def test_chunks_that_laz_announces(tmp_path: Path) -> None:
    pytest.importorskip("lazrs")
    path = tmp_path / "a.laz"
    data = bytearray(write_las(path, POINTS).read_bytes())
    (start,) = struct.unpack_from("<I", data, 96)
    (table,) = struct.unpack_from("<q", data, start)
    struct.pack_into("<I", data, table + 4, 0x61000000)
    refused(path, bytes(data), "chunks, more than the file can hold")
    struct.pack_into("<q", data, start, 1 << 60)
    refused(path, bytes(data), "outside the file")
    # The size of its chunks stands 12 bytes after the head of the record that says how it packs.
    whole = bytearray(write_las(path, POINTS).read_bytes())
    at = whole.index(b"laszip encoded") - 2 + 54 + 12
    assert struct.unpack_from("<I", whole, at) == (50_000,)
    struct.pack_into("<I", whole, at, 0x91000000)
    refused(path, bytes(whole), "chunks of 2,432,696,320 points")


@pytest.mark.filterwarnings("ignore")
def test_descriptions_of_e57_declare_no_entities(tmp_path: Path) -> None:
    path = tmp_path / "a.e57"
    data = bytearray(write_e57(path, POINTS).read_bytes())
    at = data.index(b"<?xml")
    for text in (b"<!DOCTYPE a>", b"<! entity a "):
        changed = data[:at] + data[at:].replace(b"<e57Root type", text, 1)
        refused(path, bytes(changed), "declares entities")
    struct.pack_into("<Q", data, 32, 1 << 40)
    refused(path, bytes(data), "ends too early")


@pytest.mark.slow
def test_matrices_are_of_numbers(tmp_path: Path) -> None:
    nested = np.empty(1, object)
    nested[0] = np.eye(3)
    for name, value in (("cell", nested), ("struct", {"a": 1.0}), ("text", "abc")):
        savemat(tmp_path / f"{name}.mat", {"instance": value})
        with pytest.raises(InputError, match="not a readable MAT file"):
            read_matrix(tmp_path / f"{name}.mat", [])
    savemat(tmp_path / "bomb.mat", {"instance": np.zeros((1 << 16, 1100))}, do_compression=True)
    with pytest.raises(InputError, match="65536x1100"):
        read_matrix(tmp_path / "bomb.mat", [])


@pytest.mark.parametrize("units", [0.0, -1.0, 1e-40, float("inf"), float("nan")])
def test_depth_has_a_unit(tmp_path: Path, units: float) -> None:
    path = tmp_path / "a.sens"
    sensor_origins = np.eye(4, dtype="<f4").tobytes() * 4
    head = struct.pack("<2i4IfQ", 0, 0, 4, 4, 4, 4, units, 0)
    path.write_bytes(struct.pack("<IQ", 4, 0) + sensor_origins + head)
    with path.open("rb") as stream, pytest.raises(InputError, match="make no sense"):
        list(Sens(stream, path).depths())


def test_names_may_be_in_any_encoding(tmp_path: Path) -> None:
    (tmp_path / "a.json").write_bytes(
        b'[{"id": "caf\xe9", "label": "chair", "center": [0, 0, 1], "size": [1, 1, 1]}]'
    )
    assert read_capture("boxes", tmp_path / "a.json").boxes[0].id == "caf\ufffd"
    text = b"label,x,y,z,width,depth,height\nst\xfchl,1,1,0,1,1,1\n"
    (tmp_path / "a.csv").write_bytes(text)
    assert read_capture("boxes", tmp_path / "a.csv").boxes[0].label == "st\ufffdhl"


@pytest.mark.parametrize("name", ["a\0b", "x" * 256, "a/" * 3000])
@pytest.mark.parametrize("importer", ["roomplan", "scan", "scannet", "sunrgbd", "arkitscenes"])
def test_paths_that_no_file_has(importer: str, name: str) -> None:
    with pytest.raises(InputError, match="cannot be the path of a file"):
        read_capture(importer, Path(name))
    with pytest.raises(InputError, match="cannot be the path of a file"):
        read_capture("boxes", Path("a.csv"), {"polygon": name})


def test_damaged_archives_are_said_in_short(tmp_path: Path) -> None:
    path = tmp_path / "a.usdz"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("n" * 5000 + ".usda", "#usda 1.0\n")
    data = bytearray(path.read_bytes())
    data[40] ^= 1  # the name beside the data is another one
    path.write_bytes(bytes(data))
    with pytest.raises(InputError, match="archive is damaged") as caught:
        RoomPlanImporter().read(path)
    assert len(str(caught.value)) < 600


def test_layers_that_nest_too_deeply(tmp_path: Path) -> None:
    text = "#usda 1.0\n" + 'def "A" {\n' * 20_000 + "}\n" * 20_000
    with zipfile.ZipFile(tmp_path / "a.usdz", "w") as archive:
        archive.writestr("a.usda", text)
    with pytest.raises(InputError, match="nests deeper"):
        RoomPlanImporter().read(tmp_path / "a.usdz")


def test_a_header_of_many_columns_ends(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text(",".join(f"c{i}" for i in range(200_000)) + "\n")
    with pytest.raises(InputError, match="the header lacks"):
        read_capture("boxes", tmp_path / "a.csv")
    names = "label,x,y,z,width,depth,height," + ",".join(f"c{i}" for i in range(100_000))
    (tmp_path / "a.csv").write_text(names + "\n")
    assert not read_capture("boxes", tmp_path / "a.csv").boxes


def test_json_of_no_end_is_refused(tmp_path: Path) -> None:
    for text in ("[" * 100_000, '{"a":' * 100_000, "1" * 10_000, json.dumps({"a": 1})[:-1]):
        (tmp_path / "a.json").write_text(text)
        with pytest.raises(InputError, match="not readable as JSON"):
            read_capture("boxes", tmp_path / "a.json")


def test_messages_quote_little(tmp_path: Path) -> None:
    (tmp_path / "a.xyz").write_text("1 2 3\n" + "9" * 20_000 + "x 2 3\n")
    with pytest.raises(InputError) as caught:
        read_scanned(tmp_path / "a.xyz")
    assert len(str(caught.value)) < 800


def test_pickles_come_through_the_door(tmp_path: Path) -> None:
    for kind in ("pipe", "endless"):
        with pytest.raises(InputError, match=NO_FILES[kind]):
            read_pickled(made(tmp_path / kind, kind))
