"""The COLMAP model and the cameras of ``transforms.json``, by our reading and others'."""

import json
import os
import shutil
import subprocess
from pathlib import Path

import numpy as np
import OpenImageIO
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from openrooms_usd.errors import InputError
from openrooms_usd.rendering import color
from openrooms_usd.rendering.datasets import DatasetOptions, DatasetSummary
from openrooms_usd.rendering.reading import RenderedScene, read_render
from orusd_nerf import NerfDataset, cameras
from tests.folders import contents
from tests.openrooms.synthetic import make_render, write_exr

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


def write(render: RenderedScene, root: Path, **options: object) -> DatasetSummary:
    return NerfDataset().write([render], root, DatasetOptions(**options))


def changed(folder: Path, name: str, change) -> RenderedScene:
    """A render whose manifest says otherwise of one view."""
    make_render(folder, views=2)
    manifest = json.loads((folder / "manifest.json").read_text())
    change(manifest["views"][name])
    (folder / "manifest.json").write_text(json.dumps(manifest))
    return read_render(folder)


def test_the_same_render_gives_the_same_bytes(render: RenderedScene, tmp_path: Path) -> None:
    for name in "ab":
        assert write(render, tmp_path / name).files == 13
    write(render, tmp_path / "a")
    assert contents(tmp_path / "a") == contents(tmp_path / "b")


def test_all_images_have_one_exposure(render: RenderedScene, dataset: Path) -> None:
    fitted = [color.fitted_exposure(view.pixels["radiance"]) for view in render.views.values()]
    assert max(fitted) > 1.001 * min(fitted)
    common = np.exp(np.mean(np.log(fitted)))
    for name, view in render.views.items():
        image = OpenImageIO.ImageBuf(str(dataset / f"images/{name}.png")).get_pixels("uint8")
        linear = color.film(view.pixels["radiance"] * common)
        expected = 255 * np.where(
            linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055
        )
        assert abs(image - expected).max() < 0.51


def test_what_a_render_lacks_is_told(tmp_path: Path) -> None:
    make_render(tmp_path / "day", views=1)
    write_exr(tmp_path / "day/view_0/channels.exr", {"roughness": np.ones((48, 64, 1))})
    summary = write(read_render(tmp_path / "day"), tmp_path / "data")
    assert set(summary.missing) == {"images", "depths", "points"}
    frame = json.loads((tmp_path / "data/transforms.json").read_text())["frames"][0]
    assert "depth_file_path" not in frame
    assert (tmp_path / "data/sparse/0/images.txt").read_text().endswith("view_0.png\n\n")


def test_what_is_too_far_away_has_no_depth_and_is_counted(tmp_path: Path) -> None:
    make_render(tmp_path / "day", views=1)
    depth = np.full((48, 64, 1), 2.0)
    depth[:2, :5] = 66.0
    write_exr(tmp_path / "day/view_0/channels.exr", {"depth": depth})
    summary = write(read_render(tmp_path / "day"), tmp_path / "data")
    assert any(note.startswith("10 pixels lie farther") for note in summary.notes)
    found = OpenImageIO.ImageBuf(str(tmp_path / "data/depths/view_0.png")).get_pixels("uint16")
    np.testing.assert_array_equal(found, np.where(depth > 60, 0, 2000))


def test_files_of_views_that_are_gone_go_too(render: RenderedScene, tmp_path: Path) -> None:
    write(render, tmp_path / "data")
    (tmp_path / "data/images/own.png").write_bytes(b"mine")
    write(make_render(tmp_path / "one", views=1), tmp_path / "data")
    names = sorted(path.name for path in (tmp_path / "data/images").iterdir())
    assert names == ["own.png", "view_0.png"]


def test_nothing_appears_when_something_fails(render: RenderedScene, tmp_path: Path) -> None:
    shutil.copytree(render.folder, tmp_path / "day")
    (tmp_path / "day/view_1/channels.exr").write_bytes(b"damaged")
    with pytest.raises(InputError):
        write(read_render(tmp_path / "day"), tmp_path / "data")
    assert not (tmp_path / "data").exists()


def test_several_renders_and_options_of_another_dataset_are_refused(
    render: RenderedScene, tmp_path: Path
) -> None:
    with pytest.raises(InputError, match="2 renders"):
        NerfDataset().write([render, render], tmp_path / "data", DatasetOptions())
    with pytest.raises(InputError, match="belong to OpenRooms"):
        write(render, tmp_path / "data", first=0)


def test_cameras_that_these_files_cannot_say_are_refused(tmp_path: Path) -> None:
    def skewed(view: dict) -> None:
        view["K"][0][1] = 0.5

    with pytest.raises(InputError, match="skewed"):
        write(changed(tmp_path / "day", "view_1", skewed), tmp_path / "data")


Array = np.ndarray


def depth_of(path: Path) -> Array:
    source = OpenImageIO.ImageInput.open(str(path))
    pixels = source.read_image(OpenImageIO.UINT16)
    source.close()
    return pixels[..., 0]


def nerfstudio_rays(meta: dict, frame: dict) -> tuple[Array, Array]:
    """Origins and directions of nerfstudio's ``Cameras.generate_rays``, before it normalises them.

    Image coordinates are pixels + 0.5, directions (x, -y, -1) in the camera; planar depth counts
    along these, for it is multiplied by the norm of the direction that was normalised.
    """
    lens = meta | frame
    x, y = np.meshgrid(np.arange(lens["w"]) + 0.5, np.arange(lens["h"]) + 0.5)
    rays = np.stack(
        [(x - lens["cx"]) / lens["fl_x"], -(y - lens["cy"]) / lens["fl_y"], -np.ones_like(x)], -1
    )
    matrix = np.array(frame["transform_matrix"])
    return matrix[:3, 3], rays @ matrix[:3, :3].T


def ngp_rays(meta: dict, frame: dict) -> tuple[Array, Array]:
    """The same by instant-ngp: its matrices have y and z turned around, and axes permuted.

    ``nerf_matrix_to_ngp``, then ``uv_to_ray`` of a perspective lens: the principal point is over
    the resolution, and uv = (pixel + 0.5) / resolution.
    """
    lens = meta | frame
    size = np.array([lens["w"], lens["h"]])
    matrix = np.array(frame["transform_matrix"])[:3] * [1, -1, -1, 1]
    low, high = np.array(meta["aabb"])
    scale = 1.0 / (high - low).max()
    matrix[:, 3] = matrix[:, 3] * scale + 0.5 - 0.5 * (low + high) * scale
    matrix = matrix[[1, 2, 0]]
    x, y = np.meshgrid(np.arange(lens["w"]) + 0.5, np.arange(lens["h"]) + 0.5)
    uv = np.stack([x, y], -1) / size
    middle = np.array([lens["cx"], lens["cy"]]) / size
    focal = np.array([lens["fl_x"], lens["fl_y"]])
    rays = np.concatenate([(uv - middle) * size / focal, np.ones((*uv.shape[:2], 1))], -1)
    origin, rays = matrix[:, 3], rays @ matrix[:, :3].T
    # Back from its unit cube to our metres.
    inverse = [2, 0, 1]
    return (origin[inverse] - 0.5 + 0.5 * (low + high) * scale) / scale, rays[..., inverse]


def check(root: Path, rule=nerfstudio_rays) -> None:
    meta = json.loads((root / "transforms.json").read_text())
    assert meta["frames"]
    for frame in meta["frames"]:
        steps = depth_of(root / frame["depth_file_path"])
        assert frame["depth_path"] == frame["depth_file_path"]
        metres = steps * 1e-3
        assert meta["integer_depth_scale"] == 1e-3
        origin, rays = rule(meta, frame)
        points = (origin + metres[..., None] * rays)[steps > 0]
        assert len(points) > 0.5 * steps.size
        away = np.minimum(abs(points[:, 2]), abs(points[:, 1] - 4.0))
        # Half a step of depth, along rays of at most a length of 1.5.
        assert away.max() < 1e-3


@pytest.mark.parametrize("rule", [nerfstudio_rays, ngp_rays])
def test_depth_lies_on_the_surfaces(rule, dataset: Path) -> None:
    check(dataset, rule)


@pytest.mark.parametrize("turn", [(1, 1, 1), (-1, -1, 1), (1, -1, 1), (1, 1, -1)])
def test_a_flipped_axis_is_noticed(
    turn: tuple, render: RenderedScene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(cameras, "_OPENCV_FROM_OPENGL", np.diag([*turn, 1.0]))
    NerfDataset().write([render], tmp_path, DatasetOptions())
    with pytest.raises(AssertionError):
        check(tmp_path)


def test_cameras_that_differ_stand_in_their_frames(tmp_path: Path) -> None:
    render = make_render(tmp_path / "day", views=2)
    other = make_render(tmp_path / "wide", size=(80, 48), views=1)
    (tmp_path / "wide/view_0").rename(tmp_path / "day/wide")
    manifest = json.loads((tmp_path / "day/manifest.json").read_text())
    manifest["views"]["wide"] = json.loads((other.folder / "manifest.json").read_text())["views"][
        "view_0"
    ]
    (tmp_path / "day/manifest.json").write_text(json.dumps(manifest))
    from openrooms_usd.rendering.reading import read_render

    NerfDataset().write([read_render(render.folder)], tmp_path / "data", DatasetOptions())
    meta = json.loads((tmp_path / "data/transforms.json").read_text())
    assert not {"w", "h", "fl_x", "cx"} & set(meta)
    assert [frame["w"] for frame in meta["frames"]] == [64, 64, 80]
    check(tmp_path / "data")


def test_matrices_are_those_of_the_render(render: RenderedScene, dataset: Path) -> None:
    found = json.loads((dataset / "cameras.json").read_text())["cameras"]
    arrays = np.load(dataset / "cameras.npz")
    assert list(found) == list(render.views) == arrays["name"].tolist()
    for number, (name, view) in enumerate(render.views.items()):
        assert found[name]["K"] == view.K.tolist()
        assert (found[name]["width"], found[name]["height"]) == (64, 48)
        for stored in (found[name]["world_from_camera"], arrays["world_from_camera"][number]):
            np.testing.assert_allclose(stored, view.world_from_camera, atol=1e-12)
        both = arrays["camera_from_world"][number] @ view.world_from_camera
        np.testing.assert_allclose(both, np.eye(4), atol=1e-12)
