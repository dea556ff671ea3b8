"""Posed photographs: one walk in every form is read as the same cameras."""

import json
import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from openrooms_usd import adapters
from openrooms_usd.appearance.photographs import PosedPhotographs, read_posed
from openrooms_usd.errors import InputError
from orusd_scans.formats.depthpicture import read_sixteen_bits
from orusd_scans.frames import as_text, read_frames
from orusd_scans.posed.colmap import ColmapPhotographs
from tests.scans import posedforms as forms
from tests.scans import test_arkitscenes, test_sunrgbd

Write = Callable[[Path], Path]
# How it is written; whether scale and vertical are known; whether depth and the lens are there.
FORMS: dict[str, tuple[Write, bool, bool, bool, bool]] = {
    "colmap": (forms.colmap, False, False, False, True),
    "frames": (forms.framelist, True, True, False, True),
    "nerfstudio": (forms.nerfstudio, False, False, False, True),
    "redwood": (forms.redwood, True, False, True, False),
    "scannet": (forms.scannet, True, True, True, False),
    "sevenscenes": (forms.sevenscenes, True, False, True, False),
    "tum": (forms.tum, True, True, True, False),
}


def same_walk(found: PosedPhotographs, tolerance: float = 1e-6) -> None:
    assert len(found.frames) == forms.COUNT
    for frame, pose in zip(found.frames, forms.poses(), strict=True):
        assert frame.world_from_camera == pytest.approx(pose, abs=tolerance)
        assert pytest.approx(forms.K) == frame.K
        assert frame.resolution == forms.SIZE
        assert found.file(frame) is not None


@pytest.mark.parametrize("form", FORMS)
def test_the_walk_is_the_same_in_every_form(tmp_path: Path, form: str) -> None:
    write, scale, up, deep, bends = FORMS[form]
    found = read_posed(write(tmp_path / form))
    same_walk(found)
    assert (found.form, found.scale_known, found.up_known) == (form, scale, up)
    assert len({frame.id for frame in found.frames}) == forms.COUNT
    for frame in found.frames:
        assert frame.distortion == (forms.LENS if bends else ())
        assert (frame.depth is not None) == deep
        if deep:
            counts = read_sixteen_bits(found.depth_file(frame))
            assert counts[0, 0] * frame.depth_unit == pytest.approx(1.0 if form == "tum" else 1.5)


@pytest.mark.parametrize("lens", ["SIMPLE_PINHOLE", "PINHOLE", "SIMPLE_RADIAL", "RADIAL", "OPENCV",
                                  "FULL_OPENCV", "OPENCV_FISHEYE"])  # fmt: skip
def test_colmap_says_the_same_as_text_and_as_binary(tmp_path: Path, lens: str) -> None:
    binary, text = (
        read_posed(forms.colmap(tmp_path / str(kind), binary=kind, lens=lens)).frames
        for kind in (True, False)
    )
    k = forms.LENS
    expected = {
        "SIMPLE_RADIAL": (k[0], 0, 0, 0),
        "RADIAL": (k[0], k[1], 0, 0),
        "OPENCV": k,
        "FULL_OPENCV": (*k, 0.1, 0.2, 0.3, 0.4),
        "OPENCV_FISHEYE": k,
    }.get(lens, ())
    one_focal = "SIMPLE" in lens or lens == "RADIAL"
    for one, other in zip(binary, text, strict=True):
        assert one.world_from_camera == pytest.approx(other.world_from_camera, abs=1e-12)
        assert (one.K == other.K).all()
        assert one.K[1, 1] == (forms.K[0, 0] if one_focal else forms.K[1, 1])
        assert one.distortion == other.distortion == expected
        assert one.fisheye == other.fisheye == (lens == "OPENCV_FISHEYE")
        assert one.picture == other.picture


def test_colmap_finds_the_model_and_the_pictures_from_any_folder(tmp_path: Path) -> None:
    root = forms.colmap(tmp_path / "room")
    for path in (root, root / "sparse", root / "sparse/0"):
        same_walk(read_posed(path))
    (root / "images/walk 3.jpg").rename(tmp_path / "gone.jpg")
    found = read_posed(root)
    assert found.notes == ("1 of 12 pictures are not in 'images'",)
    assert found.file(found.frames[3]) is None


def test_cameras_that_are_not_read_are_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="model FOV are not read"):
        read_posed(forms.colmap(tmp_path / "a", lens="FOV"))
    with pytest.raises(InputError, match="'EQUIRECTANGULAR' are not read"):
        read_posed(forms.nerfstudio(tmp_path / "b", camera_model="EQUIRECTANGULAR"))
    with pytest.raises(InputError, match="k4 to k6"):
        read_posed(forms.nerfstudio(tmp_path / "c", k4=0.1))


def test_transforms_say_intrinsics_for_all_or_for_each(tmp_path: Path) -> None:
    same_walk(read_posed(forms.nerfstudio(tmp_path / "each", each=True)))
    file = forms.nerfstudio(tmp_path / "angle") / "transforms.json"
    data = json.loads(file.read_text())
    for key in ("fl_x", "fl_y", "cx", "cy", "w", "h", "k1", "k2", "p1", "p2", "camera_model"):
        del data[key]
    data["camera_angle_x"] = 2.0 * math.atan(32.0 / 50.0)
    for frame in data["frames"]:
        frame["file_path"] = frame["file_path"].removesuffix(".jpg")
    file.write_text(json.dumps(data))
    found = read_posed(file)
    assert pytest.approx(np.array([[50.0, 0, 32], [0, 50, 24], [0, 0, 1]])) == found.frames[0].K
    assert found.frames[0].resolution == forms.SIZE
    assert found.frames[0].distortion == ()
    assert all(found.file(frame) for frame in found.frames)


def test_transforms_of_tracking_apps_are_metric_and_those_of_matching_are_not(
    tmp_path: Path,
) -> None:
    tracked = forms.nerfstudio(tmp_path / "a", orientation_override="none")
    found = read_posed(tracked)
    assert (found.scale_known, found.up_known) == (True, True)
    (tracked / "sparse").mkdir()
    found = read_posed(tracked)
    assert (found.scale_known, found.up_known) == (False, False)
    assert "scale is not known" in found.notes[0]
    fish = read_posed(forms.nerfstudio(tmp_path / "b", camera_model="OPENCV_FISHEYE", k3=0.5))
    assert fish.frames[0].fisheye
    assert fish.frames[0].distortion == (*forms.LENS[:2], 0.5, 0.0)


def test_transforms_have_depth_in_millimetres(tmp_path: Path) -> None:
    file = forms.nerfstudio(tmp_path) / "transforms.json"
    data = json.loads(file.read_text())
    for i, frame in enumerate(data["frames"]):
        frame["depth_file_path"] = f"depth/{i}.png" if i else "depth/0.npy"
        forms.picture(tmp_path / f"depth/{i}.png", 1500)
    file.write_text(json.dumps(data))
    found = read_posed(tmp_path)
    assert found.scale_known
    assert found.frames[0].depth is None
    assert "1 depth maps" in found.notes[0]
    assert found.depth_file(found.frames[1]) == tmp_path / "depth/1.png"


@pytest.mark.parametrize("name", ["/elsewhere/room/images/1.jpg", "../room/images/1.jpg",
                                  "C:\\room\\images\\1.jpg"])  # fmt: skip
def test_names_of_another_machine_are_found_by_their_end(tmp_path: Path, name: str) -> None:
    file = forms.nerfstudio(tmp_path / "in") / "transforms.json"
    data = json.loads(file.read_text())
    data["frames"] = [data["frames"][1] | {"file_path": name}]
    file.write_text(json.dumps(data))
    found = read_posed(file)
    assert found.file(found.frames[0]) == tmp_path / "in/images/1.jpg"


def test_depth_cameras_without_intrinsics_have_the_usual_ones(tmp_path: Path) -> None:
    found = read_posed(forms.sevenscenes(tmp_path / "a", intrinsics=False))
    assert found.frames[0].K[0].tolist() == [585.0, 0.0, 320.0]
    assert "585" in found.notes[0]
    folder = forms.tum(tmp_path / "rgbd_dataset_freiburg1_room")
    (folder / "calibration.txt").unlink()
    found = read_posed(folder)
    assert found.frames[0].K[0].tolist() == [517.3, 0.0, 319.1]
    assert found.frames[0].distortion == (0.2624, -0.9531, -0.0054, 0.0026, 1.1633)
    assert "freiburg1" in found.notes[0]


def test_moments_without_a_pose_are_left_out(tmp_path: Path) -> None:
    assert read_posed(forms.tum(tmp_path / "a")).notes == (
        "1 of 13 photographs have no pose: they were left out",
    )
    folder = forms.sevenscenes(tmp_path / "b")
    np.savetxt(folder / "frame-000004.pose.txt", np.full((4, 4), -np.inf))
    found = read_posed(folder)
    assert len(found.frames) == forms.COUNT - 1
    assert "1 of 12" in found.notes[0]


def test_depth_of_another_camera_is_left_out(tmp_path: Path) -> None:
    folder = forms.scannet(tmp_path)
    path = folder / "intrinsic/intrinsic_depth.txt"
    near, far = np.loadtxt(path), np.loadtxt(path)
    near[0, 0], far[0, 0] = 50.5, 70.0
    np.savetxt(path, near)
    found = read_posed(folder)
    assert found.frames[0].depth == "depth/0.png"
    assert "its own camera" in found.notes[0]
    np.savetxt(path, far)
    found = read_posed(folder)
    assert found.frames[0].depth is None
    assert "left out" in found.notes[0]


def test_scans_that_have_importers_give_their_frames(tmp_path: Path) -> None:
    found = read_posed(test_arkitscenes.scan(tmp_path / test_arkitscenes.ID))
    assert found.form == "arkitscenes"
    assert found.depth_file(found.frames[0]) is not None
    found = read_posed(test_sunrgbd.votenet(tmp_path / "votenet", frames=("000017",)))
    assert found.form == "sunrgbd"
    assert len(found.frames) == 1
    with pytest.raises(InputError, match="several frames"):
        read_posed(test_sunrgbd.votenet(tmp_path / "more"))


def test_two_forms_in_one_folder_are_told(tmp_path: Path) -> None:
    forms.colmap(tmp_path)
    forms.nerfstudio(tmp_path)
    found = read_posed(tmp_path)
    assert found.form == "colmap"
    assert "--form for nerfstudio" in found.notes[-1]
    assert read_posed(tmp_path, "nerfstudio").form == "nerfstudio"


def test_lenses_and_depth_of_a_list_come_back(tmp_path: Path) -> None:
    found = read_posed(forms.scannet(tmp_path / "a"))
    lens = read_posed(forms.framelist(tmp_path / "b"))
    file = tmp_path / "frames.json"
    for frames in (found.frames, lens.frames):
        file.write_bytes(as_text(frames))
        for one, other in zip(read_frames(file), frames, strict=True):
            assert one.distortion == other.distortion
            assert (one.depth, one.depth_unit) == (other.depth, other.depth_unit)
    plain = json.loads(file.read_text())
    assert "fisheye" not in plain[0]
    file.write_text(json.dumps([plain[0] | {"distortion": [0.1, 0.2]}]))
    with pytest.raises(InputError, match="coefficients"):
        read_frames(file)


# Damage.


def small_files(folder: Path) -> list[Path]:
    endings = (".txt", ".bin", ".json", ".log")
    return sorted(f for f in folder.rglob("*") if f.suffix in endings and f.is_file())


@pytest.mark.parametrize("form", [*FORMS, "colmap text"])
def test_damaged_files_are_refused_with_their_place_or_read(tmp_path: Path, form: str) -> None:
    name = form.partition(" ")[0]
    text = form != name
    folder = forms.colmap(tmp_path / "x", binary=False) if text else FORMS[name][0](tmp_path / "x")
    reader = adapters.load(adapters.PHOTOGRAPHS, name)
    rng = np.random.default_rng(5)
    refused = 0
    files = small_files(folder)
    for file in [files[int(i)] for i in rng.integers(len(files), size=40)]:
        whole = bytearray(file.read_bytes())
        data = whole[: rng.integers(len(whole))] if rng.random() < 0.5 else bytearray(whole)
        for _ in range(rng.integers(1, 4) if data else 0):
            data[rng.integers(len(data))] = rng.integers(256)
        file.write_bytes(data)
        try:
            found = reader.read(folder)
            assert all(np.isfinite(frame.world_from_camera).all() for frame in found.frames)
        except InputError as error:
            assert error.place
            assert str(tmp_path) in error.place
            refused += 1
        file.write_bytes(whole)
    assert refused > 10
    assert len(reader.read(folder).frames) == forms.COUNT


def test_binary_models_that_are_cut_off_or_longer_are_refused(tmp_path: Path) -> None:
    model = forms.colmap(tmp_path) / "sparse/0"
    read = ColmapPhotographs().read
    for file in (model / "cameras.bin", model / "images.bin"):
        whole = file.read_bytes()
        for length in (*range(0, len(whole), 13), len(whole) - 1):
            file.write_bytes(whole[:length])
            with pytest.raises(InputError, match=file.name):
                read(tmp_path)
        for wrong in (whole + b"x", b"\xff" * 8 + whole[8:]):
            file.write_bytes(wrong)
            with pytest.raises(InputError, match=file.name):
                read(tmp_path)
        file.write_bytes(whole)


def test_poses_that_mirror_or_are_not_rigid_are_refused(tmp_path: Path) -> None:
    folder = forms.sevenscenes(tmp_path / "a")
    for wrong, said in (
        (np.diag([1.0, 1, -1, 1]), "left-handed"),
        (np.diag([2.0, 2, 2, 1]), "not a rotation"),
        (forms.poses()[3].T, "last row"),
    ):
        np.savetxt(folder / "frame-000003.pose.txt", wrong)
        with pytest.raises(InputError, match=said) as caught:
            read_posed(folder)
        assert "frame-000003.pose.txt" in caught.value.place


def test_pictures_and_depth_of_a_trajectory_must_match(tmp_path: Path) -> None:
    folder = forms.redwood(tmp_path)
    (folder / "depth/3.png").unlink()
    with pytest.raises(InputError, match="12 pictures and 11 depth maps"):
        read_posed(folder)
    (folder / "second.log").write_text("")
    with pytest.raises(InputError, match="2 trajectories"):
        read_posed(folder)
