"""A writer of RoomPlan's USDZ by hand, of rooms whose JSON is known, and how both compare."""

import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from openrooms_usd.adapters import IMPORTERS, load
from openrooms_usd.capture import Capture

CORNERS = np.array([[0, 0], [5, 0], [5, 2.5], [3, 2.5], [2, 4], [0, 4]], dtype=float)
HEAD = '#usda 1.0\n(\n    defaultPrim = "{name}"\n    metersPerUnit = 1\n    upAxis = "Y"\n)\n'


def read(path: Path, room: str | None = None) -> Capture:
    options = {} if room is None else {"room": room}
    capture: Capture = load(IMPORTERS, "roomplan").read(path, options)
    return capture


def matrix_text(columns: list[float]) -> str:
    rows = [columns[i : i + 4] for i in range(0, 16, 4)]
    return "( " + ", ".join("(" + ", ".join(map(repr, row)) + ")" for row in rows) + " )"


def component(name: str, category: str, uuid: str, geometry: str) -> str:
    return HEAD.format(name=name) + (
        f'def Xform "{name}" (\n    customData = {{\n        string Category = "{category}"\n'
        f'        string UUID = "{uuid}"\n    }}\n    kind = "component"\n)\n{{\n{geometry}}}\n'
    )


def cube(name: str, row: dict[str, Any], thickness: float) -> str:
    scale = [*row["dimensions"][:2], row["dimensions"][2] or thickness]
    return (
        f'    def Cube "{name}"\n    {{\n        double size = 1\n'
        f"        double3 xformOp:scale = ({', '.join(map(repr, scale))})\n"
        f"        matrix4d xformOp:transform = {matrix_text(row['transform'])}\n"
        '        uniform token[] xformOpOrder = ["xformOp:transform", "xformOp:scale"]\n    }\n'
    )


def mesh(name: str, matrix: list[float], points: Any, faces: Any) -> str:
    """A mesh in its own frame."""
    return (
        f'    def Mesh "{name}"\n    {{\n'
        f"        int[] faceVertexCounts = {[len(face) for face in faces]}\n"
        f"        int[] faceVertexIndices = {[i for face in faces for i in face]}\n"
        f"        point3f[] points = {[tuple(map(float, p)) for p in points]}\n"
        f"        matrix4d xformOp:transform = {matrix_text(matrix)}\n"
        '        uniform token[] xformOpOrder = ["xformOp:transform"]\n    }\n'
    )


def curved_front(radius: float, width: float, bulge: float = 4.0) -> tuple[Any, Any]:
    """(50, 3) points of a curved wall's face, its lower edge first, and its quads."""
    half = np.arcsin(0.5 * width / bulge)
    angles = np.linspace(0.5 * np.pi + half, 0.5 * np.pi - half, 25)
    x, z = radius * np.cos(angles), radius * np.sin(angles) - bulge * np.cos(half)
    y = 0.5 * 2.45
    rows = [np.column_stack([x, np.full(25, side), z]) for side in (-y, y)]
    return np.concatenate(rows), [[i, i + 1, i + 26, i + 25] for i in range(24)]


def curve_of(width: float, bulge: float = 4.0) -> dict[str, Any]:
    """What the JSON says of the same wall."""
    half = np.arcsin(0.5 * width / bulge)
    return {
        "radius": bulge,
        "center": [0, -bulge * np.cos(half)],
        "startAngle": 0.5 * np.pi + half,
        "endAngle": 0.5 * np.pi - half,
    }


def fan(name: str, row: dict[str, Any], depth: float = 1e-4) -> str:
    """A slab: a fan above (this floor is seen whole from its first corner), one below, sides."""
    upper = np.array(row["polygonCorners"], dtype=float)
    n = len(upper)
    points = np.concatenate([upper, upper - [0, 0, depth]])
    faces = [[0, i, i + 1] for i in range(1, n - 1)]
    faces += [[n, n + i + 1, n + i] for i in range(1, n - 1)]
    faces += [[i, (i + 1) % n, n + (i + 1) % n, n + i] for i in range(n)]
    return mesh(name, row["transform"], points, faces)


def layers_of(data: dict[str, Any]) -> dict[str, str]:
    """The layers of a parametric export; the root refers to several from one prim."""
    layers, references = {}, []
    for key in ("walls", "doors", "windows", "openings", "floors", "objects"):
        for i, row in enumerate(data[key]):
            category = next(iter(row["category"]))
            category = category[0].upper() + category[1:]
            name = f"{category}{i}"
            geometry = fan(name, row) if key == "floors" else cube(name, row, 5e-4)
            path = f"assets/Parametric/{key}/{name}.usda"
            layers[path] = component(name, category, row["identifier"], geometry)
            references.append(f"@./{path}@")
    sections = "".join(
        f'        def Xform "{row["label"]}{i}"\n        {{\n'
        "            matrix4d xformOp:transform = "
        f"{matrix_text([*np.eye(4).ravel()[:12].tolist(), *row['center'], 1.0])}\n"
        '            uniform token[] xformOpOrder = ["xformOp:transform"]\n        }\n'
        for i, row in enumerate(data.get("sections", []))
    )
    root = HEAD.format(name="Room") + (
        f'def Xform "Room"\n{{\n    def Xform "Section_grp"\n    {{\n{sections}    }}\n'
        f'    def Xform "Wall_0_grp" (\n        prepend references = [{", ".join(references)}]\n'
        "    )\n    {\n    }\n}\n"
    )
    return {"Room.usda": root, **layers}


def pack(path: Path, layers: dict[str, str | bytes], **how: Any) -> Path:
    with zipfile.ZipFile(path, "w", **how) as archive:
        for name, text in layers.items():
            archive.writestr(name, text)
    return path


def full_room(scanner) -> dict[str, Any]:
    data = scanner.room(CORNERS, 2.45)
    data["doors"] = [scanner.surface("door", [5, 0.5], [5, 1.4], 0.0, 2.1)]
    data["windows"] = [scanner.surface("window", [3, 0], [1, 0], 0.8, 2.2)]
    data["openings"] = [scanner.surface("opening", [0, 3], [0, 2], 0.0, 2.0)]
    data["objects"] = [
        scanner.box("chair", [1, 2, 0.45], [0.5, 0.6, 0.9], 30),
        scanner.box("washerDryer", [4, 1, 0.45], [0.6, 0.65, 0.9], 200),
    ]
    data["sections"] = [{"label": "kitchen", "center": scanner.source([1, 1, 1]).tolist()}]
    return data


def assert_same(a: Capture, b: Capture, tolerance: float) -> None:
    """Two captures, matched by the identifiers of the source."""
    assert a.floor == pytest.approx(b.floor, abs=tolerance)
    assert a.height == pytest.approx(b.height, abs=tolerance)
    assert a.source_from_world == pytest.approx(b.source_from_world, abs=tolerance)
    boxes, openings = {box.id: box for box in b.boxes}, {o.id: o for o in b.openings}
    assert {box.id for box in a.boxes} == set(boxes)
    assert {o.id for o in a.openings} == set(openings)
    for box in a.boxes:
        other = boxes[box.id]
        assert box.label == other.label
        for key in ("center", "size", "rotation"):
            assert getattr(box, key) == pytest.approx(getattr(other, key), abs=tolerance)
    for opening in a.openings:
        other = openings[opening.id]
        assert opening.kind == other.kind
        for key in ("center", "direction", "width", "height"):
            assert getattr(opening, key) == pytest.approx(getattr(other, key), abs=tolerance)
