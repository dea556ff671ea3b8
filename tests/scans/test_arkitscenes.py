"""A scan of ARKitScenes that we write ourselves: a wall, a path along it, boxes."""

import json
from pathlib import Path

import numpy as np
import OpenImageIO
import pytest
from scipy.spatial.transform import Rotation

from openrooms_usd.capture import read_capture
from openrooms_usd.errors import InputError

ID = "40000001"
WIDTH, HEIGHT = 64, 48
# Turned boxes: rows are their axes, the second one is up.
AXES = Rotation.from_euler("z", 25, degrees=True).as_matrix().T[[0, 2, 1]] * [[1], [1], [-1]]


def pose(time: float) -> np.ndarray:
    """world_from_camera: it walks along x and turns about z by 4 degrees a second."""
    start = np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])
    M = np.eye(4)
    M[:3, :3] = Rotation.from_euler("z", 4 * time, degrees=True).as_matrix() @ start
    M[:3, 3] = [0.3 * time, 0.0, 1.4]
    return M


def png(path: Path, values: np.ndarray) -> None:
    path.parent.mkdir(exist_ok=True)
    image = OpenImageIO.ImageBuf(OpenImageIO.ImageSpec(WIDTH, HEIGHT, 1, str(values.dtype)))
    image.set_pixels(OpenImageIO.ROI(), values.reshape(HEIGHT, WIDTH, 1))
    image.write(str(path))


def scan(
    folder: Path, frames: str = f"{ID}_frames", moments: int = 11, points: np.ndarray | None = None
) -> Path:
    """Depth at 10 Hz between the poses at 5 Hz of a wall at y = 2 m; pixels of 0 are unsure."""
    inner = folder / frames if frames else folder
    (inner / "lowres_wide_intrinsics").mkdir(parents=True)
    lines = []
    for i in range(6):
        M = np.linalg.inv(pose(i / 5))
        numbers = [100 + i / 5, *Rotation.from_matrix(M[:3, :3]).as_rotvec(), *M[:3, 3]]
        lines.append(" ".join(f"{n:.9f}" for n in numbers))
    (inner / "lowres_wide.traj").write_text("\n".join(lines) + "\n")
    for i in range(moments):
        name = f"{ID}_{100 + i / 10:.3f}"
        (inner / f"lowres_wide_intrinsics/{name}.pincam").write_text("64 48 50 50 32 24\n")
        v, u = np.mgrid[:HEIGHT, :WIDTH] + 0.5
        rays = (
            np.stack([(u - 32) / 50, (v - 24) / 50, np.ones_like(u)], -1) @ pose(i / 10)[:3, :3].T
        )
        depth = np.round(2000.0 / rays[..., 1]).astype(np.uint16)
        sure = np.full((HEIGHT, WIDTH), 2, np.uint8)
        sure[:, :10], depth[:, :10] = 0, 500
        png(inner / f"lowres_depth/{name}.png", depth)
        png(inner / f"confidence/{name}.png", sure)
    if points is None:
        points = np.random.default_rng(0).uniform(0, 1, (200, 3))
    head = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(points)}\n"
    head += "".join(f"property float {a}\n" for a in "xyz") + "end_header\n"
    (folder / f"{ID}_3dod_mesh.ply").write_bytes(head.encode() + points.astype("<f4").tobytes())
    drawn = {"centroid": [1, 2, 0.5], "axesLengths": [0.6, 1.0, 0.4]}
    box = {"uid": "u1", "label": "chair"}
    box["segments"] = {"obbAligned": drawn | {"normalizedAxes": AXES.ravel().tolist()}}
    (folder / f"{ID}_3dod_annotation.json").write_text(json.dumps({"data": [box]}))
    return folder


@pytest.mark.parametrize("frames", [f"{ID}_frames", ""])
def test_a_scan(tmp_path: Path, frames: str) -> None:
    capture = read_capture("arkitscenes", scan(tmp_path / ID, frames))
    assert len(capture.cloud) == 200
    assert len(capture.frames) == 11
    for i, frame in enumerate(capture.frames):
        assert frame.world_from_camera == pytest.approx(pose(i / 10), abs=1e-6)
        assert (frame.resolution, frame.K[0, 0], frame.K[0, 2]) == ((64, 48), 50, 32)
    assert capture.cloud.sensor_origins[3] == pytest.approx([0.09, 0, 1.4], abs=1e-6)
    (box,) = capture.boxes
    assert (box.id, box.label) == ("u1", "chair")
    assert box.size == pytest.approx([0.6, 0.4, 1.0])
    assert box.rotation[:, 2] == pytest.approx([0, 0, 1])
    assert np.abs(box.rotation[:, 0] @ AXES[0]) == pytest.approx(1.0)
    assert np.linalg.det(box.rotation) == pytest.approx(1.0)


def test_depth_is_fused_where_it_is_sure(tmp_path: Path) -> None:
    folder = scan(tmp_path / ID)
    cloud = read_capture("arkitscenes", folder, {"fuse": "1"}).cloud
    assert cloud.points[:, 1] == pytest.approx(np.full(len(cloud), 2.0), abs=2e-3)
    (folder / f"{ID}_3dod_mesh.ply").unlink()
    assert len(read_capture("arkitscenes", folder).cloud) > 300


def test_moments_off_the_path_have_no_pose(tmp_path: Path) -> None:
    folder = scan(tmp_path / ID)
    camera = folder / f"{ID}_frames/lowres_wide_intrinsics/{ID}_109.000.pincam"
    camera.write_text("64 48 50 50 32 24\n")
    capture = read_capture("arkitscenes", folder)
    assert len(capture.frames) == 11
    assert capture.notes == ("1 of 12 photographs have no pose: they were left out",)


@pytest.mark.parametrize(
    ("file", "text", "said"),
    [
        (f"{ID}_frames/lowres_wide.traj", "1 2 3\n", "7 numbers expected"),
        (f"{ID}_frames/lowres_wide.traj", "\n", "no poses"),
        (f"{ID}_frames/lowres_wide.traj", "1 2 3 4 5 6 x\n", "line 1"),
        (f"{ID}_frames/lowres_wide_intrinsics/{ID}_100.000.pincam", "64 48 0 50 32 24", "focal"),
        (f"{ID}_frames/lowres_wide_intrinsics/{ID}_100.000.pincam", "", "six numbers"),
        (f"{ID}_frames/lowres_depth/{ID}_100.000.png", "no png", "cannot read the picture"),
        (f"{ID}_3dod_annotation.json", '{"data": [{"uid": "a"}]}', "'segments' is missing"),
        (f"{ID}_3dod_annotation.json", "[]", "an object expected"),
        (f"{ID}_3dod_mesh.ply", "", "empty"),
    ],
)
def test_nonsense_is_refused(tmp_path: Path, file: str, text: str, said: str) -> None:
    folder = scan(tmp_path / ID)
    (folder / file).write_text(text)
    options = {"fuse": "1"} if "depth" in file else {}
    with pytest.raises(InputError, match=said):
        read_capture("arkitscenes", folder, options)


def test_boxes_that_are_none_are_refused(tmp_path: Path) -> None:
    folder = scan(tmp_path / ID)
    path = folder / f"{ID}_3dod_annotation.json"
    good = json.loads(path.read_text())
    drawn = good["data"][0]["segments"]["obbAligned"]
    for key, value, said in (
        ("axesLengths", [1, 1, 0], "not positive"),
        ("normalizedAxes", [1, 0, 0, 1, 0, 0, 0, 0, 1], "right angles"),
    ):
        path.write_text(
            json.dumps(
                {"data": [{**good["data"][0], "segments": {"obbAligned": drawn | {key: value}}}]}
            )
        )
        with pytest.raises(InputError, match=said):
            read_capture("arkitscenes", folder)
    path.write_text(json.dumps({"data": good["data"] * 2}))
    with pytest.raises(InputError, match="exists already"):
        read_capture("arkitscenes", folder)


def test_what_is_no_scan_is_refused(tmp_path: Path) -> None:
    for path in (tmp_path, tmp_path / "nothing"):
        with pytest.raises(InputError, match="neither a mesh"):
            read_capture("arkitscenes", path)
