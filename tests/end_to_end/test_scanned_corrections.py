"""Corrections of measured poses in a composed stage: seen, exact, and switched off.

A scan in millimetres shows a table that leans and reaches into a wall, and a box above it.
"""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import Sdf, Usd, UsdGeom, Vt
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from openrooms_usd.usd.places.frames import matrix
from openrooms_usd.usd.shapes.meshes import read_meshes
from tests.commands import output_of
from tests.end_to_end.test_scanned_room import (
    AWAY,
    DEPTH,
    HEIGHT,
    SCAN_FROM_ROOM,
    TABLE,
    WIDTH,
    box,
    rotation,
    sheet,
    write_table,
)

pytestmark = pytest.mark.slow

BOX = [((0, 0, 0.15), (0.4, 0.3, 0.3))]
# 3 cm in the wall y = 0, turned by 3 degrees; the box on it, 5 cm too high.
AT, TURN = np.array([2.0, 0.34, 0.0]), np.radians(3.0)
ABOVE = np.array([2.1, 0.4, 0.79])


def cloud() -> dict[str, np.ndarray]:
    rng = np.random.default_rng(6)
    x, y, z = np.diag([WIDTH, DEPTH, HEIGHT])
    walls = [
        sheet(rng, (0, 0, 0), x, z, 3000),
        sheet(rng, y, x, z, 3000),
        sheet(rng, (0, 0, 0), y, z, 3000),
        sheet(rng, x, y, z, 3000),
    ]
    table = np.concatenate([box(rng, *part, 15000) for part in TABLE]) @ rotation("z", TURN).T + AT
    crate = np.concatenate([box(rng, *part, 15000) for part in BOX]) + ABOVE
    parts = [
        (np.concatenate(walls), 1, 0),
        (sheet(rng, (0, 0, 0), x, y, 3000), 2, 0),
        (sheet(rng, z, x, y, 3000), 22, 0),
        (table, 7, 1),
        (crate, 29, 2),
    ]
    points = np.concatenate([part[0] for part in parts])
    points = (points + rng.normal(0, 0.003, points.shape)) @ SCAN_FROM_ROOM.T + AWAY
    label, instance = (np.concatenate([np.full(len(p[0]), p[k]) for p in parts]) for k in (1, 2))
    return {"points": 1000.0 * points, "label": label, "instance": instance}


@pytest.fixture(scope="module")
def out(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("corrections")
    np.savez(folder / "scan.npz", **cloud())
    (folder / "cad").mkdir()
    write_table(folder / "cad" / "desk_b.obj")
    write_box(folder / "cad" / "crate.obj")
    index = {
        "desk_b": {"category": "table", "up": "Z", "symmetry": "2"},
        "crate": {"category": "box", "up": "Z", "symmetry": "2"},
    }
    (folder / "cad" / "index.json").write_text(json.dumps(index))
    (folder / "room.yaml").write_text(
        "layout: {from: scan, scan: scan.npz, unit: mm}\n"
        "furniture:\n  from: scan\n  cad: ./cad\n  objects:\n"
        "    - {instance: 1, category: table, cad: desk_b, support: floor}\n"
        "    - {instance: 2, category: box, cad: crate, support: 1}\n"
    )
    compose(folder)
    return folder / "out"


def write_box(path: Path) -> None:
    ((center, size),) = BOX
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    corners = np.array([[i, j, k] for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)]) / 2
    lines = ["v {} {} {}".format(*c) for c in corners * size + np.array(center)]
    path.write_text("\n".join([*lines, *("f {} {} {} {}".format(*np.add(q, 1)) for q in quads)]))


def compose(folder: Path) -> None:
    call = ["compose", str(folder / "room.yaml"), "-o", str(folder / "out")]
    output_of(*call)


@pytest.fixture(scope="module")
def objects(out: Path) -> dict[int, Any]:
    report = json.loads((out / "report.json").read_text())["alignment"]
    assert report["unresolved"] == []
    return {thing["instance"]: thing for thing in report["objects"]}


PARTS = {1: ("table", TABLE, (1.1, 1.0, 1.0)), 2: ("box", BOX, (1.0, 1.0, 1.0))}


def reported(thing: Any, which: str) -> np.ndarray:
    """Corners of the CAD in the scan, metres, by the report alone: p = R diag(scale) p_cad + t."""
    _, boxes, stretch = PARTS[thing["instance"]]
    unit = np.array([[i, j, k] for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)]) / 2
    corners = np.concatenate([(unit * s + np.array(c)) * stretch for c, s in boxes])
    pose = thing["placed"] if which == "placed" else thing
    turn = Rotation.from_quat(pose["rotation_wxyz"], scalar_first=True)
    return turn.apply(corners * thing["scale"]) + pose["translation"]


def composed(out: Path, number: int) -> np.ndarray:
    """Corners of the same object in the composed stage, taken back to the scan, metres."""
    stage = Usd.Stage.Open(str(out / "scene.usda"))
    prim = prim_of(stage, number)
    source = stage.GetPrimAtPath("/World/Room").GetAttribute("openrooms:source:fromWorld").Get()
    back = matrix(source)
    meshes = [m for m in read_meshes(stage).meshes if m.path.startswith(f"{prim.GetPath()}/")]
    points = np.concatenate([mesh.world_points() for mesh in meshes])
    return (points @ back[:3, :3].T + back[:3, 3]) / 1000.0


def prim_of(stage: Usd.Stage, number: int) -> Usd.Prim:
    (prim,) = [
        prim
        for prim in stage.GetPrimAtPath("/World/Furniture").GetChildren()
        if prim.GetName().startswith(PARTS[number][0])
    ]
    return prim


def apart(a: np.ndarray, b: np.ndarray) -> float:
    return float(max(cKDTree(a).query(b)[0].max(), cKDTree(b).query(a)[0].max()))


@pytest.mark.parametrize("number", PARTS)
def test_the_stage_has_what_the_report_calls_placed(
    out: Path, objects: dict[int, Any], number: int
) -> None:
    assert apart(composed(out, number), reported(objects[number], "placed")) < 5e-6
    # And it is something else than what was measured.
    assert apart(composed(out, number), reported(objects[number], "measured")) > 0.005


def test_the_motion_is_operations_of_its_own(out: Path) -> None:
    stage = Usd.Stage.Open(str(out / "scene.usda"))
    table = UsdGeom.Xformable(prim_of(stage, 1))
    names = [op.GetOpName() for op in table.GetOrderedXformOps()]
    assert (
        names
        == (
            "xformOp:translate:placed xformOp:translate xformOp:orient:placed xformOp:rotateXYZ "
            "xformOp:scale"
        ).split()
    )
    _, _, turn, *_ = (op.Get() for op in table.GetOrderedXformOps())
    # Along the wall y = 0.
    angle = 2.0 * np.degrees(np.arccos(min(1.0, turn.GetReal())))
    assert angle == pytest.approx(3.0, abs=1.0)
    # The box was but shifted, 5 cm down.
    crate = UsdGeom.Xformable(prim_of(stage, 2)).GetOrderedXformOps()
    assert [op.GetOpName() for op in crate][:2] == ["xformOp:translate:placed", "xformOp:translate"]
    assert len(crate) == 4
    assert crate[0].Get()[2] == pytest.approx(-0.05, abs=0.005)


def test_prims_say_how_well_they_were_found(out: Path, objects: dict[int, Any]) -> None:
    stage = Usd.Stage.Open(str(out / "scene.usda"))
    for number, support in ((1, "floor"), (2, "object")):
        prim, thing = prim_of(stage, number), objects[number]
        assert "OpenRoomsAlignmentAPI" in prim.GetPrimTypeInfo().GetAppliedAPISchemas()
        found = {
            key: prim.GetAttribute(f"openrooms:alignment:{key}").Get()
            for key in ("residual", "coverage", "symmetry", "support")
        }
        assert found["residual"] == pytest.approx(thing["residual"], abs=1e-6)
        assert found["coverage"] == pytest.approx(thing["coverage"], abs=1e-6)
        assert (found["symmetry"], found["support"]) == (thing["symmetry"], support)
    carrier = prim_of(stage, 2).GetRelationship("openrooms:alignment:carrier")
    assert carrier.GetTargets() == [prim_of(stage, 1).GetPath()]
    assert (objects[1]["support"], objects[2]["support"]) == ("floor", "1")


@pytest.mark.slow
def test_the_measured_pose_comes_back_and_stays(out: Path, objects: dict[int, Any]) -> None:
    stage = Usd.Stage.Open(str(out / "scene.usda"))
    path = prim_of(stage, 1).GetPath()
    edits = Sdf.Layer.FindOrOpen(str(out / "layers" / "edits.usda"))
    spec = Sdf.CreatePrimInLayer(edits, path)
    order = Sdf.AttributeSpec(
        spec, "xformOpOrder", Sdf.ValueTypeNames.TokenArray, Sdf.VariabilityUniform
    )
    order.default = Vt.TokenArray(["xformOp:translate", "xformOp:rotateXYZ", "xformOp:scale"])
    edits.Save()
    del stage
    assert apart(composed(out, 1), reported(objects[1], "measured")) < 5e-6
    compose(out.parent)
    assert apart(composed(out, 1), reported(objects[1], "measured")) < 5e-6
