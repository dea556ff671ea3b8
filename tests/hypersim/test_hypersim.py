"""Scenes in Hypersim's layout: its documented identities, by code that follows its own pages."""

import csv
import json
import shutil
from pathlib import Path

import h5py
import numpy as np
import pytest

from openrooms_usd.errors import InputError
from openrooms_usd.loading import open_source
from openrooms_usd.rendering import exr
from openrooms_usd.rendering.datasets import DatasetOptions, FinishedRoom
from openrooms_usd.rendering.reading import read_render
from orusd_hypersim import HypersimDataset
from orusd_hypersim.dataset import scene_name
from orusd_hypersim.hdf5 import write_array
from tests.folders import contents

HEIGHT, WIDTH = 18, 24
# Neither in the middle nor with square pixels: both show in the matrices.
K = np.array([[20.0, 0.0, 11.0], [0.0, 23.0, 10.5], [0.0, 0.0, 1.0]])
HALF = 2.0**-10
HALVES = ("base_color", "metallic")


def pose(number: int) -> np.ndarray:
    c, s = np.cos(0.4 + number), np.sin(0.4 + number)
    found = np.eye(4)
    found[:3, :3] = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]) @ [
        [1, 0, 0],
        [0, 0, 1],
        [0, -1, 0],
    ]
    found[:3, 3] = (1.0 + number, -2.0, 1.5)
    return found


def channels(number: int) -> dict[str, np.ndarray]:
    rng = np.random.default_rng(number)
    depth = rng.uniform(0.5, 5.0, (HEIGHT, WIDTH, 1))
    depth[0] = 0.0
    rows, columns = np.mgrid[:HEIGHT, :WIDTH] + 0.5
    points = (
        np.stack([(columns - 11.0) / 20.0, (rows - 10.5) / 23.0, np.ones_like(rows)], -1) * depth
    )
    there = depth > 0
    labels = rng.integers(0, 9, (HEIGHT, WIDTH, 1)) * there
    normal = rng.standard_normal((HEIGHT, WIDTH, 3))
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    found = {
        "radiance": rng.gamma(1.0, 300.0, (HEIGHT, WIDTH, 3)),
        "irradiance": rng.gamma(1.0, 900.0, (HEIGHT, WIDTH, 3)),
        "base_color": rng.random((HEIGHT, WIDTH, 3)),
        "metallic": rng.random((HEIGHT, WIDTH, 1)),
        "depth": depth,
        "distance": np.linalg.norm(points, axis=-1, keepdims=True),
        "position": np.where(there, points @ pose(number)[:3, :3].T + pose(number)[:3, 3], 0),
        "normal": normal * there,
        "normal_geometric": normal * there,
        "instance": labels,
        "semantic_nyu40": labels,
    }
    # Brighter than halves can say.
    found["radiance"][3, 3] = 1e6
    return {name: pixels.astype(np.float32) for name, pixels in found.items()}


def write_render(folder: Path, count: int) -> Path:
    """A render of so many views."""
    views = {}
    for number in range(count):
        name = f"view_{number}"
        (folder / name).mkdir(parents=True)
        found = channels(number)
        exr.write_channels(folder / name / "channels.exr", found)
        views[name] = {
            "resolution": [WIDTH, HEIGHT],
            "K": K.tolist(),
            "world_from_camera": pose(number).tolist(),
        }
    legend = {"instance": {"1": "/World/a", "8": "/World/b"}}
    manifest = {"generator": "openrooms_usd 0.2.0", "views": views, "legend": legend, "lights": []}
    (folder / "manifest.json").write_text(json.dumps(manifest))
    return folder


def write_scene(render: Path, out: Path) -> Path:
    rooms = [FinishedRoom("r", 7, "val", {"main": read_render(render)})]
    summary = HypersimDataset().write_rooms(rooms, out, DatasetOptions())
    assert {*summary.missing} == {"tex_coord"}
    files = [path for path in out.rglob("*") if path.is_file() and path.name[0] != "."]
    assert summary.files == len(files)
    return out


@pytest.fixture(scope="module")
def root(tmp_path_factory: pytest.TempPathFactory) -> Path:
    render = write_render(tmp_path_factory.mktemp("render"), 2)
    return write_scene(render, tmp_path_factory.mktemp("hypersim"))


def test_frames_that_are_none_now_go(tmp_path: Path) -> None:
    """A scene that is written again with fewer views is as if it were written once."""
    write_scene(write_render(tmp_path / "two", 2), tmp_path / "again")
    one = write_render(tmp_path / "one", 1)
    again, once = (write_scene(one, tmp_path / name) for name in ("again", "once"))
    assert contents(again) == contents(once)
    source = open_source(again, form="hypersim")
    assert len(source) == 1


def read(root: Path, frame: int, name: str) -> np.ndarray:
    kind = "final" if name in ("color", "residual") or "diffuse" in name else "geometry"
    folder = root / f"scenes/ai_001_007/images/scene_cam_00_{kind}_hdf5"
    with h5py.File(folder / f"frame.{frame:04d}.{name}.hdf5", "r") as file:
        return file["dataset"][:]


def camera(root: Path, name: str) -> np.ndarray:
    path = root / f"scenes/ai_001_007/_detail/cam_00/camera_keyframe_{name}.hdf5"
    with h5py.File(path, "r") as file:
        return file["dataset"][:]


def matrix(root: Path, name: str, size: int) -> np.ndarray:
    with (root / "metadata_camera_parameters.csv").open() as file:
        row = next(csv.DictReader(file))
    assert row["scene_name"] == "ai_001_007"
    return np.array([[float(row[f"{name}_{i}{j}"]) for j in range(size)] for i in range(size)])


@pytest.mark.parametrize("frame", [0, 1])
def test_color_is_reflectance_times_illumination_and_residual(root: Path, frame: int) -> None:
    color, reflectance, illumination, residual = (
        read(root, frame, name)
        for name in ("color", "diffuse_reflectance", "diffuse_illumination", "residual")
    )
    assert color.dtype == np.float16 and np.isfinite(color).all()
    found = reflectance.astype(np.float64) * illumination + residual
    off = np.abs(found - color) - HALF * np.abs(residual.astype(np.float64))
    assert off.max() <= 1e-3
    truth = channels(frame)
    # Renders have these two in halves.
    albedo, metallic = (truth[name].astype(np.float16).astype(float) for name in HALVES)
    lambertian = albedo * (1 - metallic) * truth["irradiance"] / np.pi
    np.testing.assert_allclose(
        reflectance.astype(np.float64) * illumination, lambertian, rtol=3 * HALF, atol=1e-3
    )


@pytest.mark.parametrize("frame", [0, 1])
def test_positions_project_to_the_pixels_that_show_them(root: Path, frame: int) -> None:
    """As the notebook of the dataset's camera parameters does it, with pixels' true centres."""
    world, turn, place = (
        read(root, frame, "position"),
        camera(root, "orientations"),
        camera(root, "positions"),
    )
    there = np.isfinite(world).all(axis=-1)
    assert not there[0].any() and there[1:].all()
    points = (world[there] - place[frame]) @ turn[frame]
    assert (points[:, 2] < 0).all()
    clip = np.c_[points, np.ones(len(points))] @ matrix(root, "M_proj", 4).T
    x, y = (clip[:, :2] / clip[:, 3:]).T
    rows, columns = np.nonzero(there)
    np.testing.assert_allclose((x + 1) / 2 * WIDTH, columns + 0.5, atol=1e-3)
    np.testing.assert_allclose((1 - y) / 2 * HEIGHT, rows + 0.5, atol=1e-3)


@pytest.mark.parametrize("frame", [0, 1])
def test_rays_of_the_lens_meet_the_positions_at_the_depth(root: Path, frame: int) -> None:
    """Depth is the distance to the camera's centre, in metres."""
    depth, world = read(root, frame, "depth_meters"), read(root, frame, "position")
    u = np.linspace(-1 + 1 / WIDTH, 1 - 1 / WIDTH, WIDTH)
    v = np.linspace(-1 + 1 / HEIGHT, 1 - 1 / HEIGHT, HEIGHT)[::-1]
    uv = np.stack([*np.meshgrid(u, v), np.ones((HEIGHT, WIDTH))], axis=-1)
    rays = uv @ matrix(root, "M_cam_from_uv", 3).T @ camera(root, "orientations")[frame].T
    rays /= np.linalg.norm(rays, axis=-1, keepdims=True)
    found = camera(root, "positions")[frame] + rays * depth[..., None]
    np.testing.assert_allclose(found[1:], world[1:], atol=1e-5)
    assert np.isnan(depth[0]).all()


def test_normals_are_those_of_the_world_in_the_camera(root: Path) -> None:
    for kind in ("normal", "normal_bump"):
        world, seen = (read(root, 1, f"{kind}_{frame}")[1:] for frame in ("world", "cam"))
        turned = world.astype(np.float64) @ camera(root, "orientations")[1]
        np.testing.assert_allclose(seen, turned, atol=2 * HALF)
        np.testing.assert_allclose(world, channels(1)["normal"][1:], atol=HALF)


def test_labels_begin_at_one_and_nothing_is_minus_one(root: Path) -> None:
    truth = channels(0)["instance"][..., 0]
    for name in ("semantic", "semantic_instance", "render_entity_id"):
        found = read(root, 0, name)
        assert found.dtype == np.int16
        np.testing.assert_array_equal(found, np.where(truth > 0, truth, -1))
    with (root / "scenes/ai_001_007/_detail/metadata_nodes.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [int(row["node_id"]) for row in rows] == [*range(1, 9)]
    assert (rows[7]["object_name"], rows[1]["object_name"]) == ("/World/b", "_NULL_OBJECT")


def test_tables_say_the_split_and_the_unit(root: Path) -> None:
    with (root / "analysis/metadata_images_split_scene_v1.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [(r["scene_name"], r["camera_name"], r["frame_id"]) for r in rows] == [
        ("ai_001_007", "cam_00", "0"),
        ("ai_001_007", "cam_00", "1"),
    ]
    assert {row["split_partition_name"] for row in rows} == {"val"}
    scene = root / "scenes/ai_001_007/_detail/metadata_scene.csv"
    assert scene.read_text() == "parameter_name,parameter_value\nmeters_per_asset_unit,1.0\n"


def test_names_count_rooms_and_variants() -> None:
    assert scene_name(12, "main") == "ai_001_012"
    assert scene_name(3456, "mainDiffLight") == "ai_204_456"
    with pytest.raises(InputError, match="no room"):
        scene_name(100_000, "main")


def test_a_frame_has_its_channels_and_its_camera(root: Path) -> None:
    source = open_source(root, form="hypersim", split="val")
    assert len(source) == 2
    names = ["depth", "distance", "position", "normal", "irradiance", "instance", "valid"]
    found, truth = source.read(1, names), channels(1)
    np.testing.assert_allclose(found.K, K, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(found.world_from_camera, pose(1), atol=1e-12)
    assert found.size == (WIDTH, HEIGHT)
    for name in ("depth", "distance", "position"):
        np.testing.assert_allclose(found.images[name], truth[name], rtol=1e-6, atol=1e-5)
    for name in ("normal", "irradiance"):
        np.testing.assert_allclose(found.images[name], truth[name], rtol=HALF, atol=HALF)
    assert (found.images["instance"] == truth["instance"]).all()
    assert (found.images["valid"] == (truth["depth"] > 0)).all()
    assert found.about == {"room": "ai_001_007", "variant": "cam_00", "split": "val"}


def test_colour_is_diffuse_and_residual(root: Path) -> None:
    found = open_source(root, form="hypersim").read(0, ["radiance", "diffuse", "residual"]).images
    off = np.abs(found["diffuse"] + found["residual"] - found["radiance"])
    assert (off <= 1e-3 + HALF * np.abs(found["residual"])).all()


def test_what_is_not_there_is_told(root: Path, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="there is no view"):
        open_source(root, form="hypersim", split="train")
    source = open_source(root, form="hypersim")
    with pytest.raises(InputError, match="do not have 'base_color'"):
        source.read(0, ["base_color"])


@pytest.mark.parametrize(
    ("file", "old", "new"),
    [
        ("metadata_camera_parameters.csv", "M_cam_from_uv_00", "another"),
        ("metadata_camera_parameters.csv", f"{HEIGHT},{WIDTH}", f"{HEIGHT},wide"),
        ("metadata_camera_parameters.csv", f"{HEIGHT},{WIDTH}", f"{HEIGHT},inf"),
        ("metadata_camera_parameters.csv", f"{HEIGHT},{WIDTH}", f"{HEIGHT},0"),
        ("metadata_camera_parameters.csv", "scene_name", "scene"),
        ("scenes/ai_001_007/_detail/metadata_scene.csv", "meters_per_asset_unit", "unit"),
        ("analysis/metadata_images_split_scene_v1.csv", "frame_id", "frame"),
    ],
)
def test_a_table_that_is_none_is_named(
    file: str, old: str, new: str, root: Path, tmp_path: Path
) -> None:
    copy = tmp_path / "copy"
    shutil.copytree(root, copy)
    text = (copy / file).read_text()
    assert old in text
    (copy / file).write_text(text.replace(old, new))
    with pytest.raises(InputError, match=Path(file).name):
        open_source(copy, form="hypersim").read(0, ["depth"])


def test_arrays_that_are_no_pictures_or_cameras_are_refused(root: Path, tmp_path: Path) -> None:
    copy = tmp_path / "copy"
    shutil.copytree(root, copy)
    scene = copy / "scenes/ai_001_007"
    depth = scene / "images/scene_cam_00_geometry_hdf5/frame.0000.depth_meters.hdf5"
    write_array(depth, np.ones((HEIGHT, WIDTH, 3)))
    source = open_source(copy, form="hypersim")
    with pytest.raises(InputError, match=r"depth_meters\.hdf5: 'distance' has the shape"):
        source.read(0, ["depth"])
    write_array(scene / "_detail/cam_00/camera_keyframe_positions.hdf5", np.ones((2, 1)))
    with pytest.raises(InputError, match=r"cam_00: its arrays are not cameras"):
        open_source(copy, form="hypersim").read(1, ["depth"])


@pytest.mark.parametrize("kind", ["text", "group", "outside", "words"])
def test_foreign_files_stay_data(kind: str, tmp_path: Path) -> None:
    from orusd_hypersim.hdf5 import read_array

    path = tmp_path / "a.hdf5"
    if kind == "text":
        path.write_text("no HDF5")
    else:
        with h5py.File(path, "w") as file:
            if kind == "group":
                file.create_group("dataset")
            elif kind == "outside":
                file["dataset"] = h5py.ExternalLink("other.hdf5", "/dataset")
            else:
                file["dataset"] = "words"
    with pytest.raises(InputError):
        read_array(path)
