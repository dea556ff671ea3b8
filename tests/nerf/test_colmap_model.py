"""The COLMAP model: points fall where images see them, by our reading and by pycolmap's.

pycolmap runs where `.ci/install-colmap` has been, or where ORUSD_COLMAP_PYTHON names a Python that
has it.
"""

import json
import os
import subprocess
from pathlib import Path

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from openrooms_usd.render.datasets import DatasetOptions
from openrooms_usd.render.reading import RenderedScene
from orusd_nerf import NerfDataset, cameras

ROOT = Path(__file__).parents[2]
PYTHON = os.environ.get("ORUSD_COLMAP_PYTHON", str(ROOT / ".venv-colmap/bin/python"))
APART_PX = 1e-3
# As COLMAP's documents have it.
READ = """
import json, sys
import numpy as np, pycolmap

model = pycolmap.Reconstruction(sys.argv[1])
worst, count, poses = 0.0, 0, {}
for image in model.images.values():
    camera, pose = image.camera, image.cam_from_world
    pose = pose() if callable(pose) else pose
    assert camera.model.name == "PINHOLE", camera.model
    poses[image.name] = pose.matrix().tolist()
    for mark in image.points2D:
        assert mark.has_point3D()
        seen = camera.img_from_cam(pose * model.points3D[mark.point3D_id].xyz)
        worst, count = max(worst, float(np.abs(seen - mark.xy).max())), count + 1
for point in model.points3D.values():
    for element in point.track.elements:
        assert model.images[element.image_id].points2D[element.point2D_idx].has_point3D()
print(json.dumps({"worst": worst, "count": count, "poses": poses, "points": len(model.points3D)}))
"""


def lines(path: Path) -> list[list[str]]:
    text = path.read_text().splitlines()
    return [line.split() for line in text if not line.startswith("#")]


def worst_error(model: Path) -> float:
    """The farthest, pixels, that a point falls from where an image says that it sees it."""
    (_, kind, _, _, fx, fy, cx, cy), *others = lines(model / "cameras.txt")
    assert kind == "PINHOLE" and not others
    points = {row[0]: row for row in lines(model / "points3D.txt")}
    rows, worst = lines(model / "images.txt"), 0.0
    tracks: dict[str, set[tuple[str, str]]] = {}
    for head, marks in zip(rows[::2], rows[1::2], strict=True):
        w, x, y, z, *shift = map(float, head[1:8])
        R = Rotation.from_quat([x, y, z, w])
        seen = np.array(marks).reshape(-1, 3)
        placed = R.apply([list(map(float, points[row[2]][1:4])) for row in seen]) + shift
        assert (placed[:, 2] > 0).all()
        pixels = placed[:, :2] / placed[:, 2:] * [float(fx), float(fy)] + [float(cx), float(cy)]
        worst = max(worst, abs(pixels - seen[:, :2].astype(float)).max())
        for index, row in enumerate(seen):
            tracks.setdefault(row[2], set()).add((head[0], str(index)))
    for number, row in points.items():
        assert set(zip(row[8::2], row[9::2], strict=True)) == tracks[number]
    return worst


def test_points_fall_where_images_see_them(dataset: Path) -> None:
    assert worst_error(dataset / "sparse/0") < APART_PX


def test_points_lie_on_the_surfaces_and_most_are_seen_twice(dataset: Path) -> None:
    rows = lines(dataset / "sparse/0/points3D.txt")
    points = np.array([row[1:4] for row in rows], float)
    assert np.minimum(abs(points[:, 2]), abs(points[:, 1] - 4.0)).max() < 1e-6
    # Nobody sees a point in the window, which is a hole.
    hole = (abs(points[:, 0] + 0.8) < 0.6) & (abs(points[:, 2] - 1.5) < 0.7) & (points[:, 1] > 3.9)
    assert not hole.any()
    assert np.mean([len(row) > 10 for row in rows]) > 0.8


def test_images_with_their_poses_turned_around_are_noticed(
    render: RenderedScene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(cameras, "quaternion", lambda R: Rotation.from_matrix(R.T).as_quat())
    NerfDataset().write([render], tmp_path, DatasetOptions())
    with pytest.raises(AssertionError):
        assert worst_error(tmp_path / "sparse/0") < APART_PX


def test_the_cloud_has_the_points_and_colours_of_the_model(dataset: Path) -> None:
    rows = np.array([row[1:7] for row in lines(dataset / "sparse/0/points3D.txt")], float)
    cloud = trimesh.load(dataset / "points3D.ply")
    np.testing.assert_allclose(cloud.vertices, rows[:, :3], atol=1e-6)
    np.testing.assert_array_equal(cloud.colors[:, :3], rows[:, 3:])


@pytest.mark.slow
@pytest.mark.skipif(
    not Path(PYTHON).exists(),
    reason=f"no COLMAP: {PYTHON} is missing (.ci/install-colmap, ORUSD_COLMAP_PYTHON)",
)
def test_pycolmap_reads_the_model(render: RenderedScene, dataset: Path) -> None:
    words = [PYTHON, "-c", READ, str(dataset / "sparse/0")]
    done = subprocess.run(words, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr[-3000:]
    found = json.loads(done.stdout.splitlines()[-1])
    assert found["worst"] < APART_PX
    assert found["points"] == len(lines(dataset / "sparse/0/points3D.txt"))
    assert found["count"] > 2 * found["points"]
    for name, view in render.views.items():
        pose = np.linalg.inv(view.world_from_camera)[:3]
        np.testing.assert_allclose(found["poses"][f"{name}.png"], pose, atol=1e-9)
