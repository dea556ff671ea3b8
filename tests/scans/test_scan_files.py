"""Meshes, laser scans, texts and arrays, written by others' libraries, and their mistakes."""

import io
import json
import shutil
import struct
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import trimesh

from openrooms_usd.capture import Capture, read_capture
from openrooms_usd.description import load_room
from openrooms_usd.errors import InputError, MissingPackageError
from openrooms_usd.importing import import_capture
from openrooms_usd.importing.captures import check_scan
from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.rooms.levelling import level
from orusd_scans.formats.arrays import read_npz
from orusd_scans.formats.laser import read_e57, read_las
from orusd_scans.plainscan import READERS, ScanImporter, read_mesh, read_scanned
from tests.scan.scanned_rooms import RoomScan
from tests.scans import test_arkitscenes, test_scannet_scene, test_sunrgbd
from tests.scans.damage import cuts_are_refused
from tests.scans.laser import write_e57, write_las

CORNERS = ((0, 0), (5, 0), (5, 4), (0, 4))
THINGS = ((0.3, 0.2, 1.6, 0.8, 0.0, 0.75), (2.2, 1.4, 0.9, 0.9, 0.0, 0.45))


def scannet(folder: Path) -> Path:
    folder.mkdir()
    test_scannet_scene.sens(test_scannet_scene.scene(folder / "s") / "scene0000_00.sens")
    return folder / "s"


CASES = {
    "mesh and poses": ("scannet", scannet, {}),
    "fused": ("scannet", scannet, {"fuse": "2"}),
    "mesh alone": ("scannet", lambda folder: scannet(folder) / "scene0000_00_vh_clean_2.ply", {}),
    "arkit": ("arkitscenes", lambda folder: test_arkitscenes.scan(folder / "a"), {}),
    "arkit, side by side": ("arkitscenes", lambda folder: test_arkitscenes.scan(folder, ""), {}),
    "arkit, fused": ("arkitscenes", lambda f: test_arkitscenes.scan(f / "a"), {"fuse": "2"}),
    "votenet": ("sunrgbd", lambda folder: test_sunrgbd.votenet(folder / "v"), {"frame": "000018"}),
    "index": ("sunrgbd", lambda folder: test_sunrgbd.index(folder / "i"), {}),
    "raw": ("sunrgbd", lambda folder: test_sunrgbd.raw(folder / "r"), {}),
}


@pytest.mark.usefixtures("any_scan_will_do")
@pytest.mark.parametrize("case", CASES)
def test_a_copy_reads_as_the_original(tmp_path: Path, case: str) -> None:
    kind, build, options = CASES[case]
    source = build(tmp_path / "in")
    expected = read_capture(kind, source, options)
    import_capture(kind, source, tmp_path / "out", options)
    shutil.rmtree(tmp_path / "in")
    layout = load_room(tmp_path / "out/room.yaml").layout
    assert layout.reader == kind
    found = read_capture(kind, tmp_path / "out" / layout.file, layout.asked, tmp_path / "out")
    check(found, expected)
    assert "\\" not in layout.file
    assert not Path(layout.file).is_absolute()


def check(found: Capture, expected: Capture) -> None:
    for name in ("points", "colors", "normals", "label", "instance", "sensor_origins"):
        ours, theirs = getattr(found.cloud, name), getattr(expected.cloud, name)
        assert (ours is None) == (theirs is None), name
        if ours is not None:
            np.testing.assert_array_equal(ours, theirs, err_msg=name)
    np.testing.assert_array_equal(found.source_from_world, expected.source_from_world)
    assert len(found.boxes) == len(expected.boxes)
    assert [frame.id for frame in found.frames] == [frame.id for frame in expected.frames]
    for ours, theirs in zip(found.frames, expected.frames, strict=True):
        np.testing.assert_allclose(ours.K, theirs.K, rtol=1e-12)
        np.testing.assert_allclose(ours.world_from_camera, theirs.world_from_camera, atol=1e-12)


def test_one_frame_of_many_is_copied(tmp_path: Path) -> None:
    source = test_sunrgbd.votenet(tmp_path / "in")
    import_capture("sunrgbd", source, tmp_path / "out", {"frame": "000017"})
    names = {path.stem for path in (tmp_path / "out").rglob("*.*") if path.is_file()}
    assert names == {"room", "000017"}


def test_an_import_again_changes_nothing_unless_the_scan_has_changed(tmp_path: Path) -> None:
    source: Callable[[Path], Path] = test_sunrgbd.raw
    folder = source(tmp_path / "in")
    import_capture("sunrgbd", folder, tmp_path / "out", {})
    (tmp_path / "out/room.yaml").unlink()
    import_capture("sunrgbd", folder, tmp_path / "out", {})
    (tmp_path / "out/room.yaml").unlink()
    (folder / "intrinsics.txt").write_text("90 0 60 0 90 45 0 0 1")
    with pytest.raises(Exception, match="another capture has that name"):
        import_capture("sunrgbd", folder, tmp_path / "out", {})


POINTS = np.random.default_rng(0).uniform(-3, 3, (500, 3))
FAR = np.array([4e5, 5e6, 0.0])


@pytest.mark.one_in(2)
@pytest.mark.parametrize("ending", ["obj", "glb", "stl", "off", "ply"])
def test_a_box_by_trimesh(tmp_path: Path, ending: str) -> None:
    scene = trimesh.Scene()
    moved = trimesh.transformations.translation_matrix([5.0, 0.0, 0.0])
    scene.add_geometry(trimesh.creation.box((1.0, 2.0, 3.0)), transform=moved)
    path = tmp_path / f"box.{ending}"
    path.write_bytes(
        trimesh.util.concatenate(scene.dump()).export(file_type=ending).encode()
        if ending in ("obj", "off")
        else scene.export(file_type=ending)
    )
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


@pytest.mark.parametrize("based", [True, False])
def test_sparse_corners_of_a_glb_are_read(tmp_path: Path, based: bool) -> None:
    """One corner on a base that has it wrong, or all eight on nothing, which stands for zeros."""
    content = trimesh.creation.box((1.0, 2.0, 3.0)).export(file_type="glb")
    (size,) = struct.unpack_from("<I", content, 12)
    header, body = json.loads(content[20 : 20 + size]), bytearray(content[28 + size :])
    primitive = header["meshes"][0]["primitives"][0]
    corners = header["accessors"][primitive["attributes"]["POSITION"]]
    view = header["bufferViews"][corners["bufferView"]]
    start = view.get("byteOffset", 0) + corners.get("byteOffset", 0)
    count = 1 if based else corners["count"]
    parts = [np.arange(count, dtype="<u4").tobytes(), bytes(body[start : start + 12 * count])]
    body[start : start + 12] = np.full(3, 99.0, "<f4").tobytes()
    first = len(header["bufferViews"])
    for part in parts:
        at = {"buffer": 0, "byteOffset": len(body), "byteLength": len(part)}
        header["bufferViews"].append(at)
        body += part
    header["buffers"][0]["byteLength"] = len(body)
    indices = {"bufferView": first, "componentType": 5125}
    corners["sparse"] = {"count": count, "indices": indices, "values": {"bufferView": first + 1}}
    if not based:
        del corners["bufferView"]
    text = json.dumps(header).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text
    chunks += struct.pack("<I4s", len(body), b"BIN\0") + body
    path = tmp_path / "sparse.glb"
    path.write_bytes(struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks)
    points = read_scanned(path).cloud.points
    assert np.unique(points, axis=0) == pytest.approx(
        np.stack(np.meshgrid([-0.5, 0.5], [-1, 1], [-1.5, 1.5], indexing="ij"), -1).reshape(-1, 3)
    )


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
    file = write_las(tmp_path / f"a.{ending}", POINTS + FAR, red=np.arange(500) * 131)
    cloud = read_las(file).cloud
    assert cloud.points == pytest.approx(POINTS + FAR, abs=1e-4)
    assert cloud.colors[:, 0] == pytest.approx(np.arange(500) * 131 / 257, abs=0.51)
    capture = ScanImporter().read(file)
    assert np.abs(capture.cloud.points).max() < 10
    back = capture.source_from_world @ [*capture.cloud.points[7], 1.0]
    assert back[:3] == pytest.approx(cloud.points[7], abs=1e-8)
    cuts_are_refused(read_las, file, (1, 100, 226, 300, file.stat().st_size - 3000))


def test_e57_by_pye57(tmp_path: Path) -> None:
    turned = [np.cos(0.5), 0.0, 0.0, np.sin(0.5)]
    path = write_e57(tmp_path / "a.e57", POINTS, turned, [1.0, 2.0, 3.0])
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


def stored(path: Path, points: np.ndarray) -> Path:
    np.savez(path / "scan.npz", points=points)
    return path / "scan.npz"


def test_few_points_are_refused_in_the_words_of_compose(tmp_path: Path) -> None:
    points = RoomScan(CORNERS).cloud().points
    file = stored(tmp_path, points[:: len(points) // 36][:36])
    with pytest.raises(InputError) as composed:
        level(read_capture("scan", file).cloud)
    with pytest.raises(InputError, match="the scan has 36 points") as imported:
        import_capture("scan", file, tmp_path / "out")
    assert imported.value.message == composed.value.message
    assert imported.value.remedy == composed.value.remedy
    assert not (tmp_path / "out").exists()


def test_what_shows_little_of_its_room_needs_partial(tmp_path: Path) -> None:
    one_wall = RoomScan(CORNERS, boxes=THINGS, missing=(1, 2, 3), ceiling=False)
    said = check_scan(read_capture("scan", stored(tmp_path, one_wall.cloud().points)), tmp_path)
    assert "partial: true" in said
    assert "--up" in said


@pytest.mark.slow
def test_the_storey_is_judged_that_compose_takes(tmp_path: Path) -> None:
    small, large = (
        RoomScan(
            size * np.array(CORNERS), spacing=0.05, missing=missing, ceiling=not missing
        ).cloud()
        for size, missing in ((1.0, ()), (2.0, (1, 2, 3)))
    )
    cloud = Cloud(np.concatenate([small.points, large.points + np.array([0.0, 0.0, 3.0])]))
    capture = Capture(source="scan", source_from_world=np.eye(4), cloud=cloud)
    assert "partial: true" in check_scan(capture, tmp_path)


def test_a_whole_room_passes(tmp_path: Path) -> None:
    points = RoomScan(CORNERS, boxes=THINGS).cloud().points
    assert check_scan(read_capture("scan", stored(tmp_path, points)), tmp_path) == ""


@pytest.mark.parametrize("kind", ["roomplan", "sunrgbd", "scannet"])
def test_a_cloud_given_to_another_importer_names_the_right_one(tmp_path: Path, kind: str) -> None:
    (tmp_path / "scan.ply").write_bytes(b"ply\n\xff\xfe")
    with pytest.raises(InputError) as caught:
        import_capture(kind, tmp_path / "scan.ply", tmp_path / "out")
    assert "`orusd import scan`" in caught.value.remedy


@pytest.mark.parametrize("kind", ["roomplan", "scan", "scannet"])
def test_a_zipped_folder_shall_be_unzipped(tmp_path: Path, kind: str) -> None:
    (tmp_path / "scene.zip").write_bytes(b"PK\3\4")
    with pytest.raises(InputError) as caught:
        import_capture(kind, tmp_path / "scene.zip", tmp_path / "out")
    assert "unpack it" in caught.value.remedy


@pytest.mark.parametrize(
    ("kind", "inside", "said"),
    [
        ("scan", "scene_vh_clean_2.ply", "`orusd import scannet`, which reads such folders"),
        ("roomplan", "My room.usdz", "My room.usdz'`"),
        ("roomplan", "lounge.obj", "`orusd import scan "),
        ("scan", "lounge.obj", "`orusd import scan "),
    ],
)
def test_a_folder_names_its_importer_or_a_file_in_it(
    tmp_path: Path, kind: str, inside: str, said: str
) -> None:
    folder = tmp_path / "capture"
    folder.mkdir()
    (folder / inside).write_bytes(b"")
    with pytest.raises(InputError, match="this is a folder") as caught:
        import_capture(kind, folder, tmp_path / "out")
    assert said in caught.value.remedy


def test_a_folder_of_nothing_known_gets_no_hint(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="this is a folder") as caught:
        import_capture("scan", tmp_path, tmp_path / "out")
    assert caught.value.remedy == "give the file of the scan in it"
