"""A point cloud becomes a room: walls, a window, and a table of the user's own in its place.

The cloud is sampled from boxes whose place is known, turned and moved as scans are.
"""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import Usd, UsdGeom
from scipy.spatial.transform import Rotation

from tests.commands import output_of

WIDTH, DEPTH, HEIGHT = 4.2, 3.1, 2.5
# The table: top and legs as boxes (centre, size), its place, its heading and what it is scaled by.
TABLE = [((0, 0, 0.72), (1.2, 0.7, 0.04))] + [
    ((x, y, 0.35), (0.06, 0.06, 0.7)) for x in (-0.55, 0.55) for y in (-0.3, 0.3)
]
AT, HEADING = np.array([2.6, 1.3, 0.0]), np.radians(35.0)
# The window: in the wall y = 0, from x to x, from z to z.
WINDOW = (1.0, 2.4, 0.9, 2.1)
# The scan is turned about Z, leans by two degrees and lies somewhere else.
TURN, LEAN, AWAY = np.radians(20.0), np.radians(2.0), np.array([50.0, -30.0, 7.0])


def rotation(axis: str, angle: float) -> np.ndarray:
    c, s = np.cos(angle), np.sin(angle)
    rows = {"z": [[c, -s, 0], [s, c, 0], [0, 0, 1]], "x": [[1, 0, 0], [0, c, -s], [0, s, c]]}
    return np.array(rows[axis])


SCAN_FROM_ROOM = rotation("x", LEAN) @ rotation("z", TURN)


def sheet(rng: np.random.Generator, origin: Any, u: Any, v: Any, density: float) -> np.ndarray:
    """Points spread over a rectangle."""
    u, v = np.array(u, float), np.array(v, float)
    count = int(np.linalg.norm(u) * np.linalg.norm(v) * density)
    a, b = rng.random((2, count, 1))
    return np.array(origin, float) + a * u + b * v


def box(rng: np.random.Generator, center: Any, size: Any, density: float) -> np.ndarray:
    low, (x, y, z) = np.array(center) - np.array(size) / 2, np.diag(size)
    pairs = [
        (low, x, y),
        (low + z, x, y),
        (low, x, z),
        (low + y, x, z),
        (low, y, z),
        (low + x, y, z),
    ]
    return np.concatenate([sheet(rng, *pair, density) for pair in pairs])


def cloud() -> dict[str, np.ndarray]:
    """Points, NYU40 labels and instances, in the frame of the scan."""
    rng = np.random.default_rng(5)
    x, y, z = np.diag([WIDTH, DEPTH, HEIGHT])
    walls = [
        sheet(rng, (0, 0, 0), x, z, 4000),
        sheet(rng, y, x, z, 4000),
        sheet(rng, (0, 0, 0), y, z, 4000),
        sheet(rng, x, y, z, 4000),
    ]
    left, right, low, high = WINDOW
    front = walls[0]
    pane = (front[:, 0] > left) & (front[:, 0] < right) & (front[:, 2] > low) & (front[:, 2] < high)
    table = np.concatenate([box(rng, *part, 15000) for part in TABLE])
    parts = [
        (np.concatenate(walls), 1, 0),
        (sheet(rng, (0, 0, 0), x, y, 4000), 2, 0),
        (sheet(rng, z, x, y, 4000), 22, 0),
        (table @ rotation("z", HEADING).T + AT, 7, 1),
    ]
    points = np.concatenate([part[0] for part in parts])
    label = np.concatenate([np.full(len(p), n) for p, n, _ in parts])
    label[: len(front)][pane] = 9
    instance = np.concatenate([np.full(len(p), n) for p, _, n in parts])
    points = (points + rng.normal(0, 0.003, points.shape)) @ SCAN_FROM_ROOM.T + AWAY
    return {"points": points, "label": label, "instance": instance}


def write_table(path: Path) -> None:
    """An OBJ with Z up, 10 % too long: the alignment must find its scale."""
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = [row for a, b, c, d in quads for row in ((a, b, c), (a, c, d))]
    lines = []
    for number, (center, size) in enumerate(TABLE):
        corners = np.array([[i, j, k] for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)]) / 2
        placed = (corners * np.array(size) + np.array(center)) * (1.1, 1.0, 1.0)
        lines += ["v {:.6f} {:.6f} {:.6f}".format(*corner) for corner in placed]
        faces = np.array(triangles) + 8 * number + 1
        lines += ["f {} {} {}".format(*face) for face in faces]
    path.write_text("\n".join(lines) + "\n")


@pytest.fixture(scope="module")
def out(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("scan")
    np.savez(folder / "scan.npz", **cloud())
    (folder / "cad").mkdir()
    write_table(folder / "cad" / "desk_b.obj")
    (folder / "cad" / "index.json").write_text(
        json.dumps({"desk_b": {"category": "table", "up": "Z", "symmetry": "2"}})
    )
    (folder / "room.yaml").write_text(
        "layout: {from: scan, scan: scan.npz}\n"
        "furniture:\n  from: scan\n  cad: ./cad\n"
        "  objects: [{instance: 1, category: table}]\n"
        "  further: [{category: ceiling_lamp, at: [0, 0]}]\n"
    )
    call = ["compose", str(folder / "room.yaml"), "-o", str(folder / "out")]
    output_of(*call)
    return folder / "out"


@pytest.fixture(scope="module")
def report(out: Path) -> dict[str, Any]:
    found: dict[str, Any] = json.loads((out / "report.json").read_text())
    return found


def in_room(points: Any) -> np.ndarray:
    return (np.array(points) - AWAY) @ SCAN_FROM_ROOM


@pytest.mark.slow
def test_the_report_has_the_walls_in_the_frame_of_the_scan(report: Any) -> None:
    (room,) = report["layout"]["rooms"]
    corners = in_room(room["corners"])
    true = np.array([[0, 0, 0], [WIDTH, 0, 0], [WIDTH, DEPTH, 0], [0, DEPTH, 0]])
    nearest = np.linalg.norm(corners[:, None] - true, axis=2)
    assert len(corners) == 4
    assert sorted(nearest.argmin(axis=1)) == [0, 1, 2, 3]
    assert nearest.min(axis=1).max() < 0.02
    assert room["ceiling_height"] == pytest.approx(HEIGHT, abs=0.02)
    assert SCAN_FROM_ROOM.T @ room["floor"]["normal"] == pytest.approx([0, 0, 1], abs=3e-3)
    assert room["guessed_walls"] == []
    # Counter-clockwise from above.
    x, y = corners[:, :2].T
    assert x @ np.roll(y, -1) - y @ np.roll(x, -1) > 0


@pytest.mark.slow
def test_the_window_has_its_corners_from_bottom_left(report: Any) -> None:
    (window,) = report["layout"]["rooms"][0]["openings"]
    left, right, low, high = WINDOW
    assert window["type"] == "window"
    # From inside one looks along -Y: left is where x is large.
    true = [[right, 0, low], [left, 0, low], [left, 0, high], [right, 0, high]]
    np.testing.assert_allclose(in_room(window["corners"]), true, atol=0.06)


@pytest.mark.slow
def test_the_table_is_found_with_its_scale(report: Any) -> None:
    (table,) = report["alignment"]["objects"]
    assert (table["instance"], table["category"], table["cad"]) == (1, "table", "desk_b")
    np.testing.assert_allclose(in_room(table["translation"])[:2], AT[:2], atol=0.03)
    np.testing.assert_allclose(table["scale"], [1 / 1.1, 1.0, 1.0], atol=0.04)
    w, x, y, z = table["rotation_wxyz"]
    turned = SCAN_FROM_ROOM.T @ [1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)]
    heading = np.arctan2(turned[1], turned[0])
    assert abs((heading - HEADING + np.pi / 2) % np.pi - np.pi / 2) < np.radians(2.0)
    assert table["residual"] < 0.02
    assert 0.5 < table["coverage"] <= 1.0


@pytest.mark.slow
def test_the_stage_has_the_room_level_and_the_table_on_its_floor(out: Path, report: Any) -> None:
    stage = Usd.Stage.Open(str(out / "scene.usda"))
    room = stage.GetPrimAtPath("/World/Room")
    assert room.GetAttribute("openrooms:room:height").Get() == pytest.approx(HEIGHT, abs=0.02)
    floor = np.array(room.GetAttribute("openrooms:room:floor").Get())
    sides = np.sort(np.linalg.norm(np.roll(floor, -1, axis=0) - floor, axis=1))
    assert sides == pytest.approx([DEPTH, DEPTH, WIDTH, WIDTH], abs=0.02)
    furniture = stage.GetPrimAtPath("/World/Furniture").GetChildren()
    (table,) = [prim for prim in furniture if prim.GetName().startswith("table_")]
    bounds = UsdGeom.BBoxCache(Usd.TimeCode.Default(), ["default"])
    low = bounds.ComputeWorldBound(table).ComputeAlignedRange().GetMin()[2]
    assert low == pytest.approx(0.0, abs=0.01)
    assert stage.GetPrimAtPath("/World/Furniture/ceiling_lamp_0")
    order = [op.GetOpName() for op in UsdGeom.Xformable(table).GetOrderedXformOps()]
    measured = [name for name in order if not name.endswith(":placed")]
    assert measured == ["xformOp:translate", "xformOp:rotateXYZ", "xformOp:scale"]
    placed, before = (report["alignment"]["objects"][0][k] for k in ("placed", "translation"))
    moved = np.subtract(placed["translation"], before)
    assert ("xformOp:translate:placed" in order) == bool(np.abs(moved).max() > 1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("up", ["Y", "Z"])
def test_a_cad_that_says_nothing_of_its_vertical_is_put_upright(tmp_path: Path, up: str) -> None:
    """OBJ files stand either way, and an index need not tell; a box does not either."""
    np.savez(tmp_path / "scan.npz", **cloud())
    (tmp_path / "cad").mkdir()
    file = tmp_path / "cad" / "desk_b.obj"
    write_table(file)
    upright = np.eye(3)
    if up == "Y":
        upright = rotation("x", np.pi / 2)
        rows = [line.split() for line in file.read_text().splitlines()]
        lines = [
            " ".join([w[0], w[1], w[3], str(-float(w[2]))] if w[0] == "v" else w) for w in rows
        ]
        file.write_text("\n".join(lines) + "\n")
    turn = Rotation.from_matrix(SCAN_FROM_ROOM @ rotation("z", HEADING + np.pi / 2))
    center = SCAN_FROM_ROOM @ np.add(AT, [0.03, -0.04, 0.39]) + AWAY
    box = {"center": center.tolist(), "size": [0.72, 1.15, 0.76]}
    box["rotation_wxyz"] = turn.as_quat(scalar_first=True).tolist()
    hint = {"instance": 1, "category": "table", "cad": "desk_b", "box": box}
    furniture = {"from": "scan", "cad": "cad", "objects": [hint]}
    room = {"layout": {"from": "scan", "scan": "scan.npz"}, "furniture": furniture}
    (tmp_path / "room.yaml").write_text(json.dumps(room))
    call = ["compose", str(tmp_path / "room.yaml"), "-o", str(tmp_path / "out")]
    output_of(*call)
    (table,) = json.loads((tmp_path / "out/report.json").read_text())["alignment"]["objects"]
    matrix = Rotation.from_quat(table["rotation_wxyz"], scalar_first=True).as_matrix()
    vertical = SCAN_FROM_ROOM.T @ matrix @ upright.T @ [0.0, 0.0, 1.0]
    assert vertical[2] == pytest.approx(1.0, abs=1e-3)
    np.testing.assert_allclose(in_room(table["translation"]), AT, atol=0.03)
    expected = np.abs(upright.T @ [1 / 1.1, 1.0, 1.0])
    np.testing.assert_allclose(table["scale"], expected, atol=0.04)


@pytest.mark.slow
def test_a_scan_in_millimetres_and_far_away_is_reported_where_it_lies(tmp_path: Path) -> None:
    """Poses in and out are in metres, in the axes of the scan, here those of a country's map."""
    away = np.array([1.2e6, -2.4e6, 310.0])
    arrays = cloud()
    arrays["points"] = (arrays["points"] - AWAY + away) * 1000.0
    np.savez(tmp_path / "scan.npz", **arrays)
    (tmp_path / "cad").mkdir()
    write_table(tmp_path / "cad" / "desk_b.obj")
    turn = Rotation.from_matrix(SCAN_FROM_ROOM @ rotation("z", HEADING))
    pose = {"translation": (SCAN_FROM_ROOM @ AT + away + 0.03).tolist(), "scale": [0.95, 1, 1]}
    pose["rotation_wxyz"] = turn.as_quat(scalar_first=True).tolist()
    hint = {"instance": 1, "category": "Round table", "cad": "desk_b", "pose": pose}
    layout = {"from": "scan", "scan": "scan.npz", "unit": "mm", "up": [0.05, 0.03, 1.0]}
    furniture = {"from": "scan", "cad": "cad", "objects": [hint]}
    (tmp_path / "room.yaml").write_text(json.dumps({"layout": layout, "furniture": furniture}))
    call = ["compose", str(tmp_path / "room.yaml"), "-o", str(tmp_path / "out")]
    output_of(*call)
    report = json.loads((tmp_path / "out/report.json").read_text())
    corners = (np.array(report["layout"]["rooms"][0]["corners"]) - away) @ SCAN_FROM_ROOM
    true = np.array([[0, 0, 0], [WIDTH, 0, 0], [WIDTH, DEPTH, 0], [0, DEPTH, 0]])
    assert np.linalg.norm(corners[:, None] - true, axis=2).min(axis=1).max() < 0.02
    (table,) = report["alignment"]["objects"]
    for found in (table, table["placed"]):
        np.testing.assert_allclose((found["translation"] - away) @ SCAN_FROM_ROOM, AT, atol=0.02)
    # Any words will do for what an object is.
    assert table["category"] == "Round table"
    stage = Usd.Stage.Open(str(tmp_path / "out/scene.usda"))
    names = [prim.GetName() for prim in stage.GetPrimAtPath("/World/Furniture").GetChildren()]
    assert [name.startswith("round_table_") for name in names] == [True]
