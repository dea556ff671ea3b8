"""Meshes, laser scans, texts and arrays, written by others' libraries, and their mistakes."""

import io
import json
import struct
import sys
import warnings
from pathlib import Path

import numpy as np
import pytest
import trimesh

from openrooms_usd.errors import InputError, MissingPackageError
from orusd_scans.formats.laser import read_e57, read_las
from orusd_scans.formats.meshfile import read_mesh
from orusd_scans.formats.pointtext import read_npz, read_text
from orusd_scans.plainscan import READERS, ScanImporter, read_scanned

POINTS = np.random.default_rng(0).uniform(-3, 3, (500, 3))
FAR = np.array([4e5, 5e6, 0.0])


@pytest.mark.one_in(2)
@pytest.mark.parametrize("ending", ["obj", "glb", "stl", "off", "ply"])
def test_a_box_by_trimesh(tmp_path: Path, ending: str) -> None:
    scene = trimesh.Scene()
    moved = trimesh.transformations.translation_matrix([5.0, 0.0, 0.0])
    scene.add_geometry(trimesh.creation.box((1.0, 2.0, 3.0)), transform=moved)
    path = tmp_path / f"box.{ending}"
    path.write_bytes(trimesh.util.concatenate(scene.dump()).export(file_type=ending).encode()
                     if ending in ("obj", "off") else scene.export(file_type=ending))  # fmt: skip
    scanned = read_scanned(path)
    assert scanned.cloud.points.min(axis=0) == pytest.approx([4.5, -1, -1.5])
    assert scanned.cloud.points.max(axis=0) == pytest.approx([5.5, 1, 1.5])
    assert len(scanned.faces) == 12
    assert scanned.up == ("Y" if ending == "glb" else "Z")
    cloud = ScanImporter().read(path, {"up": scanned.up}).cloud
    # 22 m2 at a point for 4 cm2, and on the surface.
    assert len(cloud) == pytest.approx(22 / 0.02**2, rel=0.02)
    half = [0.5, 1.5, 1.0] if ending == "glb" else [0.5, 1.0, 1.5]
    outward = (cloud.points - [5.0, 0, 0]) / half
    assert np.abs(outward).max(axis=1) == pytest.approx(np.ones(len(cloud)), abs=1e-5)
    sides = np.bincount(np.abs(outward).argmax(axis=1)) / len(cloud)
    areas = np.array([12, 6, 4]) if ending != "glb" else np.array([12, 4, 6])
    assert sides == pytest.approx(areas / 22, abs=0.01)
    assert np.mean(np.einsum("ni,ni->n", cloud.normals, outward) > 0.5) > 0.999


def test_draco_without_its_package_is_said(tmp_path: Path) -> None:
    header = json.dumps({"asset": {}, "extensionsUsed": ["KHR_draco_mesh_compression"]}).encode()
    body = struct.pack("<4sII", b"glTF", 2, 20 + len(header))
    (tmp_path / "d.glb").write_bytes(body + struct.pack("<I4s", len(header), b"JSON") + header)
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(sys.modules, "DracoPy", None)
        patch.setattr("importlib.util.find_spec", lambda name: None)
        with pytest.raises(MissingPackageError, match="Draco"):
            read_mesh(tmp_path / "d.glb")


@pytest.mark.parametrize("ending", ["las", "laz"])
def test_las_by_laspy(tmp_path: Path, ending: str) -> None:
    laspy = pytest.importorskip("laspy")
    header = laspy.LasHeader(point_format=2, version="1.2")
    header.scales, header.offsets = [1e-4] * 3, FAR
    las = laspy.LasData(header)
    las.x, las.y, las.z = (POINTS + FAR).T
    las.red = np.arange(500) * 131
    las.write(tmp_path / f"a.{ending}")
    cloud = read_las(tmp_path / f"a.{ending}").cloud
    assert cloud.points == pytest.approx(POINTS + FAR, abs=1e-4)
    assert cloud.colors[:, 0] == pytest.approx(np.arange(500) * 131 / 257, abs=0.51)
    capture = ScanImporter().read(tmp_path / f"a.{ending}")
    assert np.abs(capture.cloud.points).max() < 10
    back = capture.source_from_world @ [*capture.cloud.points[7], 1.0]
    assert back[:3] == pytest.approx(cloud.points[7], abs=1e-8)
    whole = (tmp_path / f"a.{ending}").read_bytes()
    for length in (1, 100, 226, 300, len(whole) - 3000):
        (tmp_path / f"cut.{ending}").write_bytes(whole[:length])
        with pytest.raises(InputError, match=r"cut\.la"):
            read_las(tmp_path / f"cut.{ending}")


def test_e57_by_pye57(tmp_path: Path) -> None:
    pye57 = pytest.importorskip("pye57")
    path = tmp_path / "a.e57"
    turned = np.array([np.cos(0.5), 0.0, 0.0, np.sin(0.5)])
    for_writing = {f"cartesian{axis}": POINTS[:, i] for i, axis in enumerate("XYZ")}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        file = pye57.E57(str(path), mode="w")
        file.write_scan_raw(for_writing, rotation=turned, translation=np.array([1.0, 2.0, 3.0]))
        file.close()
    cloud = read_e57(path).cloud
    c, s = np.cos(1.0), np.sin(1.0)
    expected = POINTS @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]).T + [1, 2, 3]
    assert cloud.points == pytest.approx(expected, abs=1e-6)
    assert cloud.sensor_origins == pytest.approx(np.array([[1.0, 2.0, 3.0]]))
    whole = path.read_bytes()
    for data in (b"ASTM-E57", b"x" * 2000, whole[:1024], whole[:-1024]):
        (tmp_path / "cut.e57").write_bytes(data)
        with pytest.raises(InputError, match=r"cut\.e57"):
            read_e57(tmp_path / "cut.e57")


@pytest.mark.parametrize(("ending", "package"), [("las", "laspy"), ("e57", "pye57")])
def test_packages_that_are_missing_are_named(
    tmp_path: Path, ending: str, package: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, package, None)
    (tmp_path / f"a.{ending}").write_bytes(b"whatever")
    with pytest.raises(MissingPackageError, match=f"{package} is not installed") as caught:
        read_scanned(tmp_path / f"a.{ending}")
    assert "openrooms_usd[scans]" in caught.value.remedy


@pytest.mark.parametrize(
    ("text", "names"),
    [
        ("1 2 3\n4 5 6\n", ""),
        ("1,2,3,0.5\n4,5,6,0.5\n", ""),
        ("1 2 3 255 0 10\n4 5 6 1 2 3\n", "colors"),
        ("1 2 3 0 0 1\n4 5 6 0.6 0.8 0\n", "normals"),
        ("2\n1 2 3 99 255 0 10\n4 5 6 99 1 2 3\n", "colors"),
        ("//X;Y;Z;label;instance\n1;2;3;5;1\n4;5;6;5;2\n", "label instance"),
        ('"x","y","z","nx","ny","nz"\n1,2,3,0,0,1\n4,5,6,0,0,1\n', "normals"),
    ],
)
def test_texts(tmp_path: Path, text: str, names: str) -> None:
    (tmp_path / "a.xyz").write_text(text)
    cloud = read_text(tmp_path / "a.xyz").cloud
    assert cloud.points.tolist() == [[1, 2, 3], [4, 5, 6]]
    known = ("colors", "normals", "label", "instance")
    assert [n for n in known if getattr(cloud, n) is not None] == names.split()


def test_arrays(tmp_path: Path) -> None:
    np.savez(tmp_path / "a.npz", points=POINTS, label=np.arange(500) % 41, other=np.eye(2))
    cloud = read_npz(tmp_path / "a.npz").cloud
    assert (cloud.points == POINTS).all()
    assert (cloud.label == np.arange(500) % 41).all()
    data = io.BytesIO()
    np.savez(data, points=np.array([{}], dtype=object))
    (tmp_path / "code.npz").write_bytes(data.getvalue())
    with pytest.raises(InputError, match="not a readable array"):
        read_npz(tmp_path / "code.npz")
    np.savez(tmp_path / "short.npz", points=POINTS, label=np.arange(3))
    with pytest.raises(InputError, match="differ in length"):
        read_npz(tmp_path / "short.npz")
    np.savez(tmp_path / "flat.npz", points=POINTS.ravel())
    with pytest.raises(InputError, match="shape"):
        read_npz(tmp_path / "flat.npz")


@pytest.mark.parametrize("ending", sorted(READERS))
@pytest.mark.parametrize("data", [b"", b"\x00\xff\xfe garbage\n" * 20, b"nan nan\n", b"glTF" * 9])
def test_garbage_is_refused_by_every_reader(tmp_path: Path, ending: str, data: bytes) -> None:
    (tmp_path / f"bad{ending}").write_bytes(data)
    with pytest.raises(InputError, match="bad") as caught:
        read_scanned(tmp_path / f"bad{ending}")
    assert len(str(caught.value)) < 600


@pytest.mark.parametrize("ending", sorted(READERS))
def test_what_is_not_there_is_said(tmp_path: Path, ending: str) -> None:
    with pytest.raises(InputError, match="no such file"):
        read_scanned(tmp_path / f"none{ending}")
    (tmp_path / f"folder{ending}").mkdir()
    with pytest.raises(InputError, match="this is a folder"):
        read_scanned(tmp_path / f"folder{ending}")
