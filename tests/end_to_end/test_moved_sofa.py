"""A sofa is moved in the edits: in the next pictures its lamp, light and shadow are elsewhere."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import Sdf, Usd, UsdGeom

from openrooms_usd.composing import compose_room

ROOM = """\
seed: 5
layout: {polygon: [[0, 0], [6, 0], [6, 5], [0, 5]]}
furniture:
  objects:
    - {name: sofa, category: sofa, at: [1.8, 3.1]}
    - {name: side, category: table, size: [0.5, 0.5, 0.5], at: [1.4, 0], relative_to: sofa}
    - {name: lamp, category: table_lamp, at: [1.4, 0], relative_to: sofa, on: side}
materials: {resolution: 16}
lights: {environment: {from: constant, illuminance: 0}, lamps: {lamp: {lumen: 800}}}
cameras:
  resolution: [64, 48]
  views:
    - {name: above, from: pose, fov: 90,
       world_from_camera: [[1, 0, 0, 3], [0, -1, 0, 2.5], [0, 0, -1, 2.55]]}
    - {from: select, name: best, count: 2}
"""
SHIFT = np.array([0.0, -1.2, 0.0])
CHANNELS = ["instance", "position", "radiance", "base_color"]


def cameras(scene: Path) -> dict[str, np.ndarray]:
    stage = Usd.Stage.Open(str(scene))
    stage.Reload()
    prims = stage.GetPrimAtPath("/World/Cameras").GetChildren()
    time = Usd.TimeCode.EarliestTime()
    return {
        prim.GetName(): np.array(UsdGeom.Xformable(prim).ComputeLocalToWorldTransform(time))
        for prim in prims
    }


@pytest.mark.parametrize("pinned", [pytest.param(False, marks=pytest.mark.slow), True])
def test_the_next_pictures_show_it(tmp_path: Path, show: Any, fastest: str, pinned: bool) -> None:
    (tmp_path / "room.yaml").write_text(ROOM)
    scene = compose_room(tmp_path / "room.yaml", tmp_path / "out").scene
    chosen = cameras(scene)
    how = {
        "options": {"variant": fastest},
        "samples": 128,
        "channels": CHANNELS,
        "cameras": ["above"],
        "resolution": (96, 72),
    }
    before = None if pinned else show(scene, "before", **how)
    stage = Usd.Stage.Open(str(scene))
    stage.SetEditTarget(Sdf.Layer.FindOrOpen(str(tmp_path / "out/layers/edits.usda")))
    sofa = stage.GetPrimAtPath("/World/Furniture/sofa")
    UsdGeom.XformCommonAPI(sofa).SetTranslate(tuple(np.array([1.8, 3.1, 0.0]) + SHIFT))
    if pinned:
        camera = UsdGeom.Xformable(stage.GetPrimAtPath("/World/Cameras/best_0"))
        matrix = camera.ComputeLocalToWorldTransform(0)
        camera.MakeMatrixXform().Set(matrix)
    stage.GetEditTarget().GetLayer().Save()
    del stage, sofa
    compose_room(tmp_path / "room.yaml", tmp_path / "out")
    again = cameras(scene)
    if pinned:
        np.testing.assert_allclose(again["best_0"], chosen["best_0"], atol=1e-9)
        return
    assert set(again) == set(chosen)
    assert (again["above"] == chosen["above"]).all()
    assert any(not np.allclose(again[name], chosen[name]) for name in ("best_0", "best_1"))
    after = show(scene, "after", **how)
    for name in ("sofa", "side", "lamp"):
        middle = [_middle(shown, f"/World/Furniture/{name}") for shown in (before, after)]
        np.testing.assert_allclose((middle[1] - middle[0])[:2], SHIFT[:2], atol=0.12)
    # The light around the lamp, with the shadows of sofa and table in it, went along.
    start = np.array([3.2, 3.1])
    lights = [
        _floor_light(shown, at)
        for shown, at in ((before, start), (after, start + SHIFT[:2]), (after, start))
    ]
    along, stayed = (_alikeness(lights[0], other) for other in lights[1:])
    assert along > 0.8
    assert stayed < along - 0.3


def _middle(shown: Any, path: str) -> np.ndarray:
    """Middle of the box of all points that the picture shows of an object."""
    points = shown["above"]["position"][shown.names("above", "instance") == path]
    assert len(points) > 5
    return 0.5 * (points.min(axis=0) + points.max(axis=0))


def _floor_light(shown: Any, middle: np.ndarray) -> dict[tuple[int, int], float]:
    """Median radiance of the floor over its colour, on a grid of 30 cm around a place."""
    floor = shown.names("above", "instance") == "/World/Room/Floor"
    cells = np.round((shown["above"]["position"][floor][:, :2] - middle) / 0.3).astype(int)
    # Without the floor's own pattern.
    colors = shown["above"]["base_color"][floor].astype(float)
    light = (shown["above"]["radiance"][floor] / colors).mean(axis=-1)
    near = np.linalg.norm(cells, axis=1) < 5
    keys = {tuple(cell) for cell in cells[near].tolist()}
    return {key: float(np.median(light[(cells == key).all(axis=1)])) for key in keys}


def _alikeness(one: dict[tuple[int, int], float], other: dict[tuple[int, int], float]) -> float:
    """Correlation over the cells that both show."""
    both = sorted(one.keys() & other.keys())
    assert len(both) > 20
    values = [[light[cell] for cell in both] for light in (one, other)]
    return float(np.corrcoef(np.log(values))[0, 1])
