"""Scans that lie in folders: what an import copies reads as what it was copied from."""

import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from openrooms_usd.capture import Capture, read_capture
from openrooms_usd.description import load_room
from openrooms_usd.importing import import_capture
from tests.scans import test_arkitscenes, test_scannet_scene, test_sunrgbd


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
