"""Photographs of real rooms, where they are there: what projects onto what."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from openrooms_usd.appearance.photographs import distorted, read_posed
from openrooms_usd.capture import CapturedFrame
from openrooms_usd.geometry.pinhole import pixel_directions
from openrooms_usd.geometry.rotations import inverse
from orusd_scans.formats.depthpicture import read_sixteen_bits

Real = Callable[[str], Path]
_LAMP_ROOM = "photographs/colmap_lamp_room"


def pixels_of(points: np.ndarray, frame: CapturedFrame) -> np.ndarray:
    """(N, 2) where a photograph shows points of the world, its lens included."""
    camera_from_world = inverse(frame.world_from_camera)
    local = points @ camera_from_world[:3, :3].T + camera_from_world[:3, 3]
    return distorted(local[:, :2] / local[:, 2:], frame) @ frame.K[:2, :2].T + frame.K[:2, 2]


def observations(text: Path) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Points in the world and where they were found, by picture, as COLMAP's texts say it."""
    rows = [line.split() for line in (text / "points3D.txt").read_text().splitlines()]
    places = {row[0]: [float(v) for v in row[1:4]] for row in rows if row[0] != "#"}
    lines = [line for line in (text / "images.txt").read_text().splitlines() if line[:1] != "#"]
    found = {}
    for head, points in zip(lines[::2], lines[1::2], strict=True):
        trios = np.array(points.split()).reshape(-1, 3)
        kept = [trio for trio in trios if trio[2] in places]
        at = np.array([[float(u), float(v)] for u, v, _ in kept])
        found[head.split()[-1]] = np.array([places[trio[2]] for trio in kept]), at
    return found


def test_points_of_a_model_project_to_where_they_were_found(real: Real) -> None:
    root = real(_LAMP_ROOM)
    seen = observations(root / "text")
    frames = read_posed(root / "sparse/0").frames
    straight, transposed = [], []
    errors = []
    for frame in frames:
        points, at = seen[frame.picture]
        errors.append(np.linalg.norm(pixels_of(points, frame) - at, axis=1))
        bare = CapturedFrame(frame.id, frame.world_from_camera, frame.K, frame.resolution)
        straight.append(np.linalg.norm(pixels_of(points, bare) - at, axis=1))
        turned = frame.world_from_camera.copy()
        turned[:3, :3] = turned[:3, :3].T
        wrong = CapturedFrame(frame.id, turned, frame.K, frame.resolution)
        transposed.append(np.linalg.norm(pixels_of(points, wrong) - at, axis=1))
    middle, mean = np.median(np.concatenate(errors)), np.mean(np.concatenate(errors))
    # COLMAP says 1.17 pixels itself.
    assert middle < 1.0
    assert mean == pytest.approx(1.17, abs=0.05)
    assert np.mean(np.concatenate(straight)) > mean
    assert np.median(np.concatenate(transposed)) > 100.0


def test_the_texts_of_a_model_say_what_its_binary_files_say(real: Real) -> None:
    root = real(_LAMP_ROOM)
    binary, text = read_posed(root / "sparse/0").frames, read_posed(root / "text").frames
    assert len(binary) == 35
    for one, other in zip(binary, text, strict=True):
        assert one.id == other.id
        assert one.world_from_camera == pytest.approx(other.world_from_camera, abs=1e-9)
        assert one.distortion == pytest.approx(other.distortion, abs=1e-12)


def test_transforms_of_a_model_are_its_cameras_up_to_a_similarity(real: Real) -> None:
    root = real(_LAMP_ROOM)
    model = {frame.id: frame for frame in read_posed(root, "colmap").frames}
    listed = read_posed(root / "transforms.json").frames
    assert {frame.id for frame in listed} == set(model)
    turns, ratios = [], []
    first, last = listed[0], listed[-1]
    for frame in listed:
        own = model[frame.id].world_from_camera
        turns.append(frame.world_from_camera[:3, :3] @ own[:3, :3].T)
        for other in (first, last):
            if other.id != frame.id:
                step = frame.world_from_camera[:3, 3] - other.world_from_camera[:3, 3]
                apart = own[:3, 3] - model[other.id].world_from_camera[:3, 3]
                ratios.append(np.linalg.norm(step) / np.linalg.norm(apart))
                along = turns[0] @ apart / np.linalg.norm(apart)
                assert step / np.linalg.norm(step) == pytest.approx(along, abs=1e-3)
    assert np.ptp(turns, axis=0).max() < 1e-4
    assert np.ptp(ratios) < 1e-3 * np.mean(ratios)


def test_depth_of_one_frame_agrees_with_that_of_another(real: Real) -> None:
    found = read_posed(real("photographs/sevenscenes_kitchen"))
    gaps, transposed = [], []
    for one, other in zip(found.frames[:-2:6], found.frames[2::6], strict=True):
        a, b = (read_sixteen_bits(found.depth_file(frame)) for frame in (one, other))
        for wrong, differences in ((False, gaps), (True, transposed)):
            pose = one.world_from_camera.copy()
            if wrong:
                pose[:3, :3] = pose[:3, :3].T
            differences.append(_gap(a * one.depth_unit, pose, one.K, b * other.depth_unit, other))
    middle = np.median(np.concatenate(gaps))
    assert 0.003 < middle < 0.02
    assert np.median(np.concatenate(transposed)) > 5.0 * middle


def _gap(
    depth: np.ndarray, pose: np.ndarray, K: np.ndarray, other: np.ndarray, camera: CapturedFrame
) -> np.ndarray:
    """Metres between depth seen from another camera and the depth that it has there."""
    height, width = depth.shape
    some = slice(None, None, 4)
    known = (depth > 0.0) & (depth < 65.0)
    local = pixel_directions(K, width, height) * depth[..., None]
    local = local[some, some][known[some, some]]
    points = local @ pose[:3, :3].T + pose[:3, 3]
    back = inverse(camera.world_from_camera)
    there = points @ back[:3, :3].T + back[:3, 3]
    there = there[there[:, 2] > 0.2]
    u, v = np.floor(((there / there[:, 2:]) @ camera.K.T)[:, :2]).astype(int).T
    inside = (u >= 0) & (u < width) & (v >= 0) & (v < height)
    measured = other[v[inside], u[inside]]
    valid = (measured > 0.0) & (measured < 65.0)
    return np.abs(measured[valid] - there[inside, 2][valid])


def test_lists_and_frames_of_scans_are_read(real: Real) -> None:
    for name, form, count in (
        ("photographs/simulated/dev/room_1_simple", "frames", 16),
        ("real_dev/data/arkit_lounge", "frames", 16),
        ("sunrgbd_sample/sunrgbd_000017_infos.pkl", "sunrgbd", 1),
    ):
        found = read_posed(real(name))
        assert (found.form, len(found.frames)) == (form, count)
        assert all(found.file(frame) is not None for frame in found.frames)
