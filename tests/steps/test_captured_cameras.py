"""Cameras of photographs: a point that the photograph shows in a pixel is there in our view."""

import json
from pathlib import Path

import numpy as np
import pytest
from pxr import Usd, UsdGeom

from openrooms_usd.composing import compose_room
from openrooms_usd.description import parse_room
from openrooms_usd.errors import DescriptionError, InputError
from openrooms_usd.geometry.raycast import RayCaster
from openrooms_usd.usd.cameras import photograph, read_camera
from openrooms_usd.usd.shapes.meshes import read_meshes, world_triangles
from tests.scans.posedforms import picture

K = np.array([[610.0, 0, 345.5], [0, 610.0, 221.25], [0, 0, 1]])
SIZE = (720, 480)


def looking(eye, target) -> np.ndarray:
    """A pose from first principles: z forward, x right, y down."""
    forward = np.subtract(target, eye) / np.linalg.norm(np.subtract(target, eye))
    right = np.cross(forward, [0, 0, 1])
    right /= np.linalg.norm(right)
    M = np.eye(4)
    M[:3, :3] = np.column_stack([right, np.cross(forward, right), forward])
    M[:3, 3] = eye
    return M


# In the source's frame, whose unit is a centimetre and whose floor lies at 40.
EYES = [(60.0, 60.0, 190.0), (440.0, 80.0, 160.0), (80.0, 340.0, 200.0), (420.0, 330.0, 170.0)]
POSES = [looking(eye, (250.0, 200.0, 90.0)) for eye in EYES]
ON_FLOOR = np.array([250.0, 360.0, 40.0])


def capture(folder: Path, **more: object) -> Path:
    frames = [
        {
            "id": f"{10 * i}",
            "world_from_camera": pose.tolist(),
            "K": K.tolist(),
            "resolution": SIZE,
            "picture": f"color/{10 * i}.jpg",
        }
        for i, pose in enumerate(POSES)
    ]
    data = {
        "unit": "cm",
        "level": 40,
        "height": 260,
        "floor": [[0, 0], [500, 0], [500, 400], [0, 400]],
        "objects": [{"id": "b", "label": "box", "center": [250, 200, 75], "size": [80, 60, 70]}],
        "frames": frames,
    }
    path = folder / "boxes.json"
    path.write_text(json.dumps(data | more))
    return path


def compose(folder: Path, cameras: str) -> Usd.Stage:
    (folder / "room.yaml").write_text(
        "layout: {from: boxes, file: boxes.json}\n"
        "furniture: {from: boxes, file: boxes.json}\n"
        f"cameras: {cameras}\n"
    )
    compose_room(folder / "room.yaml", folder / "out", flatten=False)
    stage = Usd.Stage.Open(str(folder / "out/scene.usda"))
    stage.Reload()  # layers of an earlier composition may still be open
    return stage


def cameras_of(stage: Usd.Stage) -> dict[str, Usd.Prim]:
    return {prim.GetName(): prim for prim in stage.GetPrimAtPath("/World/Cameras").GetChildren()}


@pytest.mark.slow
def test_a_point_is_seen_in_the_pixel_of_the_photograph(tmp_path: Path) -> None:
    capture(tmp_path)
    stage = compose(tmp_path, "{from: capture}")
    size = stage.GetPrimAtPath("/Render/Settings").GetAttribute("resolution").Get()
    assert tuple(size) == SIZE
    caster = RayCaster(*world_triangles(read_meshes(stage).meshes)[:2])
    found = cameras_of(stage)
    assert len(found) == len(POSES)
    for name, prim in found.items():
        pose = POSES[int(name.removeprefix("frame_")) // 10]
        local = np.linalg.inv(pose) @ [*ON_FLOOR, 1.0]  # in the photograph's own frame and unit
        u, v, _ = K @ (local[:3] / local[2])
        camera = read_camera(prim, *SIZE)
        assert pytest.approx(K, abs=1e-3) == camera.K
        ray = camera.world_from_camera[:3, :3] @ np.linalg.solve(camera.K, [u, v, 1.0])
        eye = camera.world_from_camera[:3, 3]
        hits = caster.first_hit(eye[None], ray[None])
        point = eye + float(hits.distance[0]) * ray / np.linalg.norm(ray)
        assert point == pytest.approx((ON_FLOOR - [0, 0, 40]) / 100.0, abs=1e-4)


@pytest.mark.slow
def test_names_sources_and_every(tmp_path: Path) -> None:
    capture(tmp_path)
    views = "[{from: capture, every: 3}, {from: select, count: 1}]"
    stage = compose(tmp_path, f"{{views: {views}}}")
    found = cameras_of(stage)
    assert list(found) == ["frame_0", "frame_30", "view_0"]
    assert photograph(found["frame_30"]) == {"file": "color/30.jpg", "id": "30"}
    assert photograph(found["view_0"]) is None
    # 640 wide instead of 720: everything shrinks alike, the middle of the rows stays.
    small = read_camera(found["frame_0"], 640, 480).K
    scale = 640 / 720
    below = 240 - (240 - 221.25) * scale
    expected = np.array([[610 * scale, 0, 345.5 * scale], [0, 610 * scale, below], [0, 0, 1]])
    assert small == pytest.approx(expected, abs=1e-3)
    assert UsdGeom.Camera(found["view_0"]).GetHorizontalApertureOffsetAttr().Get() == 0.0


def test_a_room_from_no_capture_has_no_photographs(tmp_path: Path) -> None:
    for cameras in ("{from: capture}", "{views: [{from: capture}]}"):
        with pytest.raises(DescriptionError, match="not come from a capture"):
            parse_room(f"cameras: {cameras}")
    capture(tmp_path, frames=[])
    with pytest.raises(InputError, match="no cameras of photographs"):
        compose(tmp_path, "{from: capture, every: 33}")


@pytest.mark.slow
def test_a_changed_pose_runs_the_step_again(tmp_path: Path) -> None:
    capture(tmp_path)
    eyes = []
    for shift in (0.0, 50.0):
        data = json.loads((tmp_path / "boxes.json").read_text())
        data["frames"][0]["world_from_camera"][0][3] += shift
        (tmp_path / "boxes.json").write_text(json.dumps(data))
        stage = compose(tmp_path, "{from: capture}")
        eyes.append(read_camera(cameras_of(stage)["frame_0"], *SIZE).world_from_camera[:3, 3])
    assert eyes[1] - eyes[0] == pytest.approx([0.5, 0, 0])


def test_photographs_are_copied_as_back_plates_where_that_is_asked(tmp_path: Path) -> None:
    capture(tmp_path)
    (tmp_path / "color").mkdir()
    for i in range(0, 40, 20):
        picture(tmp_path / f"color/{i}.jpg", i)
    stage = compose(tmp_path, "{from: capture, resolution: [360, 180], plates: true}")
    folder = tmp_path / "out/layers"
    for name, prim in cameras_of(stage).items():
        number = int(name.removeprefix("frame_"))
        assert prim.HasAPI(UsdGeom.BackPlateAPI) == (number in (0, 20))
        if number in (0, 20):
            plate = UsdGeom.BackPlateAPI(prim, "photograph")
            asset = plate.GetImageAttr().Get()
            shown = Path(asset.resolvedPath)
            assert shown.parent == folder / "cameras"
            assert shown.read_bytes() == (tmp_path / f"color/{number}.jpg").read_bytes()
            # A third of its rows is above and below what this camera sees.
            assert plate.GetScaleTweakAttr().Get()[1] == pytest.approx(4 / 3)
    assert len(list((folder / "cameras").glob("*.jpg"))) == 2
    picture(tmp_path / "color/20.jpg", 200)
    compose(tmp_path, "{from: capture, resolution: [360, 180], plates: true}")
    shown = sorted(path.read_bytes() for path in (folder / "cameras").glob("*.jpg"))
    assert shown == sorted((tmp_path / f"color/{i}.jpg").read_bytes() for i in (0, 20))
    plain = compose(tmp_path, "{from: capture}")
    assert not any(p.HasAPI(UsdGeom.BackPlateAPI) for p in cameras_of(plain).values())
    assert not list((folder / "cameras").glob("*.jpg"))
