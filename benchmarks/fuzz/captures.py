"""Sound captures of a small room as objects: RoomPlan, Scan2CAD and lists of boxes."""

import json
import zipfile
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.fuzz.frames import SCENE, write_frames
from benchmarks.fuzz.kinds import Kind

CORNERS = [[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [0.0, 3.0]]
_HEAD = '#usda 1.0\n(\n    defaultPrim = "{0}"\n    metersPerUnit = 1\n    upAxis = "Y"\n)\n'
COMPOSED = "name: c\nroom: office\nmaterials: {{resolution: 16}}\n{0}"


def _transform(center: Any, axes: Any) -> list[float]:
    """16 numbers, column by column; the room is Z up, the source Y up."""
    turn = np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])
    M = np.eye(4)
    M[:3, :3] = turn @ np.array(axes, dtype=float).T
    M[:3, 3] = turn @ np.asarray(center, dtype=float)
    return [float(x) for x in M.T.ravel()]


def _surface(kind: str, a: list[float], b: list[float], low: float, high: float) -> dict[str, Any]:
    start, end = np.asarray(a), np.asarray(b)
    along = (end - start) / np.linalg.norm(end - start)
    axes = [[*along, 0], [0, 0, 1], [along[1], -along[0], 0]]
    return {
        "identifier": f"{kind}-{a}", "category": {kind: {}}, "confidence": {"high": {}},
        "dimensions": [float(np.linalg.norm(end - start)), high - low, 0],
        "transform": _transform([*(0.5 * (start + end)), 0.5 * (low + high)], axes),
        "parentIdentifier": None, "completedEdges": [], "curve": None, "polygonCorners": [],
        "story": 0,
    }  # fmt: skip


def _box(category: str, center: list[float], size: list[float]) -> dict[str, Any]:
    width, depth, height = size
    return {
        "identifier": f"{category}-1", "category": {category: {}}, "confidence": {"medium": {}},
        "dimensions": [width, height, depth], "attributes": {},
        "transform": _transform(center, [[1, 0, 0], [0, 0, 1], [0, -1, 0]]),
    }  # fmt: skip


def roomplan() -> dict[str, Any]:
    """A CapturedRoom with a floor, a door, a window and two objects."""
    ring = [*CORNERS, CORNERS[0]]
    local = [[x - 2, y - 1.5, 0] for x, y in CORNERS]
    floor = {
        "identifier": "floor", "category": {"floor": {}}, "confidence": {"high": {}},
        "dimensions": [4, 3, 0], "polygonCorners": local,
        "transform": _transform([2, 1.5, 0], [[1, 0, 0], [0, 1, 0], [0, 0, 1]]),
    }  # fmt: skip
    return {
        "version": 2, "story": 0, "coreModel": "A" * 40,
        "sections": [{"label": "kitchen", "center": [1.0, 1.0, -1.0], "story": 0}],
        "walls": [_surface("wall", a, b, 0, 2.5) for a, b in pairwise(ring)],
        "floors": [floor],
        "doors": [_surface("door", [4, 0.5], [4, 1.4], 0, 2.1)],
        "windows": [_surface("window", [3, 0], [1, 0], 0.8, 2.2)],
        "openings": [_surface("opening", [0, 2], [0, 1], 0, 2)],
        "objects": [
            _box("chair", [1, 2, 0.45], [0.5, 0.6, 0.9]),
            _box("table", [2, 1, 0.4], [1.2, 0.7, 0.8]),
        ],
    }  # fmt: skip


def _plant_roomplan(folder: Path) -> None:
    inner = folder / "in"
    inner.mkdir()
    (inner / "Room.json").write_text(json.dumps(roomplan()))
    sections = "layout: {from: roomplan, file: Room.json}\n"
    sections += "alignment: {from: roomplan, file: Room.json}\n"
    (inner / "room.yaml").write_text(COMPOSED.format(sections))


def _geometry(name: str, row: dict[str, Any], mesh: bool) -> str:
    turned = ", ".join(
        "(" + ", ".join(map(repr, row["transform"][i : i + 4])) + ")" for i in range(0, 16, 4)
    )
    pose = f"        matrix4d xformOp:transform = ( {turned} )\n"
    if not mesh:
        scale = [*row["dimensions"][:2], row["dimensions"][2] or 5e-4]
        return (
            f'    def Cube "{name}"\n    {{\n        double size = 1\n{pose}'
            f"        double3 xformOp:scale = ({', '.join(map(repr, scale))})\n"
            "        uniform token[] xformOpOrder = "
            '["xformOp:transform", "xformOp:scale"]\n    }\n'
        )
    points = [*row["polygonCorners"], *([x, y, -1e-4] for x, y, _ in row["polygonCorners"])]
    n = len(points) // 2
    faces = [[0, i, i + 1] for i in range(1, n - 1)]
    faces += [[n, n + i + 1, n + i] for i in range(1, n - 1)]
    faces += [[i, (i + 1) % n, n + (i + 1) % n, n + i] for i in range(n)]
    return (
        f'    def Mesh "{name}"\n    {{\n'
        f"        int[] faceVertexCounts = {[len(face) for face in faces]}\n"
        f"        int[] faceVertexIndices = {[i for face in faces for i in face]}\n"
        f"        point3f[] points = {[tuple(map(float, p)) for p in points]}\n{pose}"
        '        uniform token[] xformOpOrder = ["xformOp:transform"]\n    }\n'
    )


def _plant_roomplan_usdz(folder: Path) -> None:
    (folder / "in").mkdir()
    layers, links = {}, []
    data = roomplan()
    for key in ("walls", "doors", "windows", "openings", "floors", "objects"):
        for i, row in enumerate(data[key]):
            category = next(iter(row["category"])).capitalize()
            name = f"{category}{i}"
            path = f"assets/Parametric/{key}/{name}.usda"
            layers[path] = _HEAD.format(name) + (
                f'def Xform "{name}" (\n    customData = {{\n'
                f'        string Category = "{category}"\n'
                f'        string UUID = "{row["identifier"]}"\n    }}\n    kind = "component"\n)\n'
                f"{{\n{_geometry(name, row, key == 'floors')}}}\n"
            )
            links.append(f"@./{path}@")
    root = _HEAD.format("Room") + (
        'def Xform "Room"\n{\n    def Xform "Wall_0_grp" (\n'
        f"        prepend references = [{', '.join(links)}]\n    )\n    {{\n    }}\n}}\n"
    )
    with zipfile.ZipFile(folder / "in/Room.usdz", "w") as archive:
        for name, text in {"Room.usda": root, **layers}.items():
            archive.writestr(name, text)


def _trs(translation: list[float]) -> dict[str, Any]:
    return {"translation": translation, "rotation": [1.0, 0.0, 0.0, 0.0], "scale": [1.0, 1.0, 1.0]}


def scan2cad_annotation() -> list[dict[str, Any]]:
    models = [
        {
            "trs": _trs([1.0 + i, 0.4, -1.0]), "bbox": [0.3, 0.4, 0.25],
            "center": [0.01, 0.02, -0.03], "sym": "__SYM_ROTATE_UP_2", "catid_cad": catid,
            "id_cad": f"cad{i}",
        }
        for i, catid in enumerate(("03001627", "04379243"))
    ]  # fmt: skip
    half = 0.5**0.5
    scan = {"translation": [0, 0, 0], "rotation": [half, -half, 0, 0], "scale": [1, 1, 1]}
    return [{"id_scan": SCENE, "trs": scan, "aligned_models": models}]


def _plant_scan2cad(folder: Path) -> None:
    inner = folder / "in"
    inner.mkdir()
    (inner / "full_annotations.json").write_text(json.dumps(scan2cad_annotation()))
    door = {"kind": "door", "center": [2, 0, 1.05], "width": 0.9, "height": 2.0, "open": True}
    floor = {"floor": CORNERS, "level": 0.0, "height": 2.5, "openings": [door]}
    (inner / "floor.json").write_text(json.dumps(floor))
    (inner / "floor.csv").write_text("x,y\n" + "".join(f"{x},{y}\n" for x, y in CORNERS))
    models = inner / "models/03001627/cad0/models"
    models.mkdir(parents=True)
    (models / "model_normalized.obj").write_text(
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 0 1\nf 1 2 3\nf 1 3 4\nf 2 3 4\n"
    )


def _plant_boxes(folder: Path) -> None:
    inner = folder / "in"
    inner.mkdir()
    (inner / "boxes.csv").write_text(
        "id,label,x,y,z,width,depth,height,yaw\na,chair,1,2,0,0.5,0.6,0.9,30\n"
        "b,desk,3,1,0,1.6,0.8,0.75,\n"
    )
    boxes = [
        {"id": "a", "label": "chair", "center": [1, 2, 0.45], "size": [0.5, 0.6, 0.9], "yaw": 30},
        {"id": "b", "label": "desk", "center": [3, 1, 0.375], "size": [1.6, 0.8, 0.75]},
    ]
    (inner / "boxes.json").write_text(json.dumps({"objects": boxes, "floor": CORNERS}))
    (inner / "floor.csv").write_text("x,y\n" + "".join(f"{x},{y}\n" for x, y in CORNERS))
    (inner / "floor.json").write_text(json.dumps({"floor": CORNERS, "height": 2.5}))
    write_frames(inner / "frames.json")


_CAD = "import scan2cad {in}/full_annotations.json -o {out} --polygon {in}/floor"
KINDS = (
    Kind(
        "capture.roomplan", _plant_roomplan,
        ((30, "import roomplan {in}/Room.json -o {out}"), (1, "compose {in}/room.yaml -o {out}")),
        ("in/Room.json",), share=4,
    ),
    Kind(
        "capture.roomplan-usdz", _plant_roomplan_usdz,
        ((1, "import roomplan {in}/Room.usdz -o {out}"),), share=4,
    ),
    Kind(
        "capture.scan2cad", _plant_scan2cad,
        (
            (2, f"{_CAD}.json"), (1, f"{_CAD}.csv"),
            (2, f"{_CAD}.json --models {{in}}/models"),
        ),
        share=3,
    ),
    Kind(
        "capture.boxes-csv", _plant_boxes,
        (
            (2, "import boxes {in}/boxes.csv -o {out}"),
            (2, "import boxes {in}/boxes.csv -o {out} --polygon {in}/floor.csv"),
        ),
        ("in/*.csv",), share=3,
    ),
    Kind(
        "capture.boxes-json", _plant_boxes,
        (
            (2, "import boxes {in}/boxes.json -o {out} --frames {in}/frames.json"),
            (2, "import boxes {in}/boxes.json -o {out} --polygon {in}/floor.json"),
        ),
        ("in/*.json",), share=3,
    ),
)  # fmt: skip
