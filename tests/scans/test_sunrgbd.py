"""Frames of SUN RGB-D in three layouts, written by ourselves from one known frame."""

import json
import pickle
from pathlib import Path

import numpy as np
import OpenImageIO
import pytest
from scipy.io import savemat
from scipy.spatial.transform import Rotation

from openrooms_usd.capture import Capture, read_capture
from openrooms_usd.errors import InputError

# The camera's own axes against upright depth without a tilt, and one that looks down by 10 degrees.
LEVEL = np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])
TILT = Rotation.from_euler("x", -10, degrees=True).as_matrix()
K = np.array([[100.0, 0, 60], [0, 100.0, 45], [0, 0, 1]])  # pixels from 1
SIZE = (120, 90)
# A wall at y = 3 m. A box that looks to the right and towards the camera, 30 degrees off x.
ANGLE = np.radians(-30.0)
CENTER, ACROSS, ALONG, HIGH = np.array([0.4, 2.5, -0.5]), 0.6, 0.9, 1.1


def wall() -> tuple[np.ndarray, np.ndarray]:
    """(H, W) depth and (H, W, 3) points in upright depth."""
    v, u = np.mgrid[1 : SIZE[1] + 1, 1 : SIZE[0] + 1].astype(float)
    rays = np.stack([(u - 60) / 100, (v - 45) / 100, np.ones_like(u)], -1) @ (TILT @ LEVEL).T
    depth = np.round(3000.0 / rays[..., 1]) / 1000.0
    return depth, rays * depth[..., None]


def colored(every: int) -> np.ndarray:
    """(N, 6) rows of one in so many points of the wall."""
    points = wall()[1].reshape(-1, 3)[::every]
    return np.column_stack([points, np.tile([0.5, 1.0, 0.0], (len(points), 1))])


def votenet(folder: Path, frames: tuple[str, ...] = ("000017", "000018"), every: int = 1) -> Path:
    for name in ("depth", "calib", "label"):
        (folder / name).mkdir(parents=True)
    for frame in frames:
        columns = [" ".join(map(str, M.T.ravel())) for M in (TILT, K)]
        (folder / f"calib/{frame}.txt").write_text("\n".join(columns) + "\n")
        savemat(folder / f"depth/{frame}.mat", {"instance": colored(every)})
        numbers = [*CENTER, ACROSS / 2, ALONG / 2, HIGH / 2, np.cos(ANGLE), np.sin(ANGLE)]
        (folder / f"label/{frame}.txt").write_text(
            "chair 1 2 30 40 " + " ".join(map(str, numbers)) + "\n"
        )
    return folder


def index(folder: Path, every: int = 1) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    colored(every).astype("<f4").tofile(folder / "000017.bin")
    box = {"bbox_3d": [*CENTER, ALONG, ACROSS, HIGH, ANGLE], "bbox_label_3d": 3}
    camera = {"depth2img": (K @ LEVEL.T @ TILT.T).tolist(), "img_path": "000017.jpg"}
    entry = {
        "images": {"CAM0": camera | {"width": SIZE[0], "height": np.int32(SIZE[1])}},
        "instances": [box],
        "lidar_points": {"lidar_path": "000017.bin", "num_pts_feats": 6},
    }
    data = {"metainfo": {"DATASET": "SUNRGBD"}, "data_list": [entry]}
    (folder / "infos.pkl").write_bytes(pickle.dumps(data, 2))
    return folder / "infos.pkl"


def raw(folder: Path) -> Path:
    for name in ("depth_bfx", "extrinsics", "annotation3Dfinal"):
        (folder / name).mkdir(parents=True)
    (folder / "intrinsics.txt").write_text(" ".join(map(str, K.ravel())))
    own = LEVEL.T @ TILT @ LEVEL
    np.savetxt(folder / "extrinsics/2014.txt", np.column_stack([own, np.zeros(3)]))
    stored = np.round(1000 * wall()[0]).astype(np.uint16)
    rotated = (stored << 3) | (stored >> 13)
    image = OpenImageIO.ImageBuf(OpenImageIO.ImageSpec(*SIZE, 1, "uint16"))
    image.set_pixels(OpenImageIO.ROI(), rotated.reshape(SIZE[1], SIZE[0], 1))
    image.write(str(folder / "depth_bfx/1.png"))
    front = np.array([np.cos(ANGLE), np.sin(ANGLE)])
    side = np.array([-front[1], front[0]])
    corners = [
        CENTER[:2] + 0.5 * (ALONG * f * front + ACROSS * s * side)
        for f, s in ((1, -1), (1, 1), (-1, 1), (-1, -1))
    ]
    polygon = {
        "X": [c[0] for c in corners],
        "Z": [c[1] for c in corners],
        "Ymin": -CENTER[2] - HIGH / 2,
        "Ymax": -CENTER[2] + HIGH / 2,
    }
    floor = {"name": "floor", "polygon": [polygon]}
    objects = [None, {"name": "empty", "polygon": []}, floor]
    objects.append({"name": "chair:truncated", "polygon": [polygon]})
    (folder / "annotation3Dfinal/index.json").write_text(json.dumps({"objects": objects}))
    return folder


def check(capture: Capture) -> None:
    cloud, (frame,), (box,) = capture.cloud, capture.frames, capture.boxes
    assert cloud.points[:, 1] == pytest.approx(np.full(len(cloud), 3.0), abs=3e-3)
    assert cloud.sensor_origins.tolist() == [[0, 0, 0]]
    assert frame.world_from_camera[:3, :3] == pytest.approx(TILT @ LEVEL, abs=1e-6)
    # Pixels from 1 at the first one's centre are pixels from 0.5 there.
    assert pytest.approx(K - [[0, 0, 0.5], [0, 0, 0.5], [0, 0, 0]], abs=1e-3) == frame.K
    assert box.label == "chair"
    assert box.center == pytest.approx(CENTER)
    assert box.size == pytest.approx([ACROSS, ALONG, HIGH])
    # Its front looks along its own -Y.
    assert -box.rotation[:, 1] == pytest.approx([np.cos(ANGLE), np.sin(ANGLE), 0])
    assert np.linalg.det(box.rotation) == pytest.approx(1.0)


def test_the_folder_of_votenet(tmp_path: Path) -> None:
    capture = read_capture("sunrgbd", votenet(tmp_path / "v"), {"frame": "000018"})
    check(capture)
    assert capture.cloud.colors[0].tolist() == [128, 255, 0]
    assert capture.frames[0].id == "000018"
    with pytest.raises(InputError, match="holds 2 frames") as caught:
        read_capture("sunrgbd", tmp_path / "v")
    assert "000017" in caught.value.remedy


def test_the_index_of_mmdetection(tmp_path: Path) -> None:
    capture = read_capture("sunrgbd", index(tmp_path / "m"))
    check(capture)
    assert (capture.frames[0].picture, capture.frames[0].resolution) == ("000017.jpg", SIZE)


def test_a_raw_frame(tmp_path: Path) -> None:
    capture = read_capture("sunrgbd", raw(tmp_path / "r"))
    check(capture)
    assert len(capture.cloud) > 1000


def test_code_in_an_index_is_not_executed(tmp_path: Path) -> None:
    path = index(tmp_path / "m")
    path.write_bytes(b"cposix\nsystem\n(S'touch " + str(tmp_path).encode() + b"/done'\ntR.")
    with pytest.raises(InputError, match="not a pickle of plain data"):
        read_capture("sunrgbd", path)
    assert not (tmp_path / "done").exists()


def test_points_outside_the_folder_are_not_read(tmp_path: Path) -> None:
    path = index(tmp_path / "m")
    (tmp_path / "m/000017.bin").rename(tmp_path / "secret.bin")
    data = path.read_bytes()
    moved = data.replace(b"X\n\x00\x00\x00000017.bin", b"X\r\x00\x00\x00../secret.bin")
    assert moved != data
    path.write_bytes(moved)
    with pytest.raises(InputError, match="are missing"):
        read_capture("sunrgbd", path)


@pytest.mark.parametrize(
    ("file", "data", "said"),
    [
        ("calib/000017.txt", b"1 0 0 0 1 0 0 0 1\n", "two lines"),
        ("calib/000017.txt", b"2 0 0 0 1 0 0 0 1\n1 0 0 0 1 0 0 0 1\n", "not a rotation"),
        ("calib/000017.txt", b"1 0 0 0 1 0 0 0 1\n1 0 0 0 0 0 0 0 1\n", "focal length"),
        ("calib/000017.txt", b"a b c\nd\n", "line 1"),
        ("label/000017.txt", b"chair 1 2 3\n", "12 numbers"),
        ("label/000017.txt", b"chair 1 2 3 4 0 0 0 -1 1 1 1 0\n", "sizes above zero"),
        ("label/000017.txt", b"chair 1 2 3 4 0 0 nan 1 1 1 1 0\n", "out of range"),
        ("depth/000017.mat", b"", "empty"),
        ("depth/000017.mat", b"MATLAB 5.0 MAT-file, cut", "MAT file"),
    ],
)
def test_nonsense_is_refused(tmp_path: Path, file: str, data: bytes, said: str) -> None:
    folder = votenet(tmp_path / "v")
    (folder / file).write_bytes(data)
    with pytest.raises(InputError, match=said):
        read_capture("sunrgbd", folder, {"frame": "000017"})


def test_what_is_no_frame_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="not a frame of SUN RGB-D"):
        read_capture("sunrgbd", tmp_path)
    path = index(tmp_path / "m")
    (tmp_path / "m/000017.bin").write_bytes(bytes(25))
    with pytest.raises(InputError, match="no whole points"):
        read_capture("sunrgbd", path)
    folder = raw(tmp_path / "r")
    (folder / "depth_bfx/1.png").write_bytes(b"no png")
    with pytest.raises(InputError, match="cannot read the picture"):
        read_capture("sunrgbd", folder)
