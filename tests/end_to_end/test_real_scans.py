"""The real captures become rooms without a hand-written polygon, where they are there."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely
from pxr import Usd, UsdGeom
from scipy.spatial.transform import Rotation

from tests.commands import output_of

FRAME = "frame_000017"
Real = Callable[[str], Path]


def composed(folder: Path, kind: str, source: Path, *options: object) -> dict[str, Any]:
    """Import, compose, validate; the report."""
    output_of("import", kind, source, "-o", folder, *options)
    output_of("compose", folder / "room.yaml", "-o", folder / "out")
    # Smaller overlaps of real things are kept and warned of; nothing else may be found.
    found = json.loads(output_of("validate", "--json", folder / "out/scene.usda"))["findings"]
    assert {(one["severity"], one["code"]) for one in found} <= {("warning", "overlap")}
    assert (folder / "out/overlay.png").stat().st_size > 1000
    report: dict[str, Any] = json.loads((folder / "out/report.json").read_text())
    return report


def matrix(trs: Any) -> np.ndarray:
    w, x, y, z = trs["rotation"]
    M = np.eye(4)
    M[:3, :3] = Rotation.from_quat([x, y, z, w]).as_matrix() @ np.diag(trs["scale"])
    M[:3, 3] = trs["translation"]
    return M


@pytest.mark.slow
def test_a_scene_of_scannet_with_its_annotated_cads(tmp_path: Path, real: Real) -> None:
    root = real("scan2cad_scene0470_00")
    folder = root / "Assets/scannet-sample/scene0470_00"
    annotation = root / "Routines/Script/example_annotation.json"
    options = ("--annotation", annotation, "--models", root / "Assets/shapenet-sample")
    report = composed(tmp_path, "scannet", folder, *options)
    (room,) = report["layout"]["rooms"]
    x, y = np.array(room["corners"])[:, :2].T
    area = 0.5 * (x @ np.roll(y, -1) - y @ np.roll(x, -1))
    # What the points cover, less what hangs through the walls.
    assert area == pytest.approx(8.3, abs=0.5)
    assert room["ceiling_height"] is None
    (entry,) = json.loads(annotation.read_text())
    found = report["alignment"]["objects"]
    assert len(found) == len(entry["aligned_models"])
    for thing, model in zip(found, entry["aligned_models"], strict=True):
        M = np.linalg.inv(matrix(entry["trs"])) @ matrix(model["trs"])
        assert thing["cad"] == model["id_cad"]
        # The rule of Scan2CAD, without what is symmetric.
        assert np.linalg.norm(thing["translation"] - M[:3, 3]) < 0.2
        scale = np.linalg.norm(M[:3, :3], axis=0)
        assert abs(np.mean(thing["scale"] / scale) - 1.0) < 0.2
        turn = Rotation.from_quat(thing["rotation_wxyz"], scalar_first=True).as_matrix()
        angle = np.degrees(Rotation.from_matrix(turn @ (M[:3, :3] / scale).T).magnitude())
        assert angle < 20.0 or model["sym"] != "__SYM_NONE"


@pytest.mark.slow
def test_a_single_view_stands_where_its_camera_stood(tmp_path: Path, real: Real) -> None:
    source = real("sunrgbd_sample/sunrgbd_000017_infos.pkl")
    report = composed(tmp_path, "sunrgbd", source)
    assert {one["category"] for one in report["alignment"]["objects"]} == {"bed", "night_stand"}
    (room,) = report["layout"]["rooms"]
    assert room["guessed_walls"]
    assert shapely.Polygon(np.array(room["corners"])[:, :2]).contains(shapely.Point(0.0, 0.0))
    stage = Usd.Stage.Open(str(tmp_path / "out/scene.usda"))
    source_from_world = np.array(
        stage.GetPrimAtPath("/World/Room").GetAttribute("openrooms:source:fromWorld").Get()
    ).T
    camera = UsdGeom.Xformable(stage.GetPrimAtPath(f"/World/Cameras/{FRAME}"))
    world_from_camera = np.array(camera.ComputeLocalToWorldTransform(0)).T
    # Upright depth has its origin in the camera.
    np.testing.assert_allclose((source_from_world @ world_from_camera)[:3, 3], 0.0, atol=1e-4)
    up = Rotation.from_matrix(source_from_world[:3, :3]).apply([0.0, 0.0, 1.0])
    assert np.degrees(np.arccos(up[2])) < 3.0


@pytest.mark.slow
def test_a_sweep_of_a_laser_scanner(tmp_path: Path, real: Real) -> None:
    source = real("pcl_room_scan/room_scan1.pcd")
    report = composed(tmp_path, "scan", source, "--unit", "auto")
    room = report["layout"]["rooms"][0]
    assert len(room["corners"]) >= 4
    # What the scanner stood in the middle of.
    assert shapely.Polygon(np.array(room["corners"])[:, :2]).contains(shapely.Point(0.0, 0.0))
