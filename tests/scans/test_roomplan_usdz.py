"""The USDZ exports of RoomPlan: parametric layers and meshes of a room whose JSON is known."""

import json
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely
from pxr import Sdf, Usd

from openrooms_usd.description import parse_room
from openrooms_usd.steps.alignment.step import AlignmentStep
from openrooms_usd.steps.base import StepContext
from openrooms_usd.steps.layout.step import LayoutStep
from tests.scans.roomplan_usdz import (
    HEAD,
    assert_same,
    component,
    cube,
    curve_of,
    curved_front,
    full_room,
    layers_of,
    matrix_text,
    mesh,
    pack,
    read,
)

THICK = 0.16


def boxes_mesh(name: str, matrix: list[float], boxes: list[list[float]]) -> str:
    """A mesh of boxes (x0, x1, y0, y1, z0, z1) whose faces are quads."""
    corners = [(x, y, z) for z in (4, 5) for x, y in ((0, 2), (1, 2), (1, 3), (0, 3))]
    points = [tuple(float(box[i]) for i in corner) for box in boxes for corner in corners]
    quads = [(4, 5, 6, 7), (3, 2, 1, 0), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]
    faces = [[8 * i + k for k in quad] for i in range(len(boxes)) for quad in quads]
    return mesh(name, matrix, points, faces)


def wall_mesh(name: str, row: dict[str, Any], inside: list[dict[str, Any]], block: bool) -> str:
    """A slab behind the wall's plane, in boxes beside, over and under its holes."""
    width, height = 0.5 * row["dimensions"][0], 0.5 * row["dimensions"][1]
    M = np.array(row["transform"]).reshape(4, 4).T
    whole, boxes = shapely.box(-width, -height, width, height), []
    for one in inside:
        center = np.linalg.inv(M) @ np.array(one["transform"]).reshape(4, 4).T[:, 3]
        w, h = 0.5 * one["dimensions"][0], 0.5 * one["dimensions"][1]
        whole -= shapely.box(center[0] - w, center[1] - h, center[0] + w, center[1] + h)
    xs = sorted({x for x, _ in shapely.get_coordinates(whole).tolist()})
    ys = sorted({y for _, y in shapely.get_coordinates(whole).tolist()})
    for x0, x1 in pairwise(xs):
        for y0, y1 in pairwise(ys):
            if whole.contains(shapely.Point(0.5 * (x0 + x1), 0.5 * (y0 + y1))):
                boxes.append([x0, x1, y0, y1, -THICK, 0.0])
    if block:
        boxes.append([width, width + THICK, -height, height, -THICK, 0.0])
    return boxes_mesh(name, row["transform"], boxes)


def floor_mesh(name: str, row: dict[str, Any]) -> str:
    """A slab that reaches under the walls."""
    corners = np.array(row["polygonCorners"])
    ring = shapely.Polygon(corners[:, :2]).buffer(THICK, join_style="mitre", mitre_limit=9)
    upper = shapely.get_coordinates(ring.exterior)[:-1]
    pieces = shapely.constrained_delaunay_triangles(shapely.Polygon(upper)).geoms
    points, faces = [], []
    for piece in pieces:
        three = shapely.get_coordinates(shapely.normalize(piece))[:3]
        for z in (0.0, -THICK):
            faces.append(list(range(len(points), len(points) + 3)))
            points += [(*p, z) for p in three.tolist()]
    return mesh(name, row["transform"], points, faces)


def mesh_layers(data: dict[str, Any]) -> dict[str, str]:
    """A mesh export: passages are holes alone, doors say whether they are open."""
    layers, root = {}, HEAD.format(name="Room") + 'def Xform "Room"\n{\n}\n'
    for i, wall in enumerate(data["walls"]):
        own = [
            row
            for key in ("doors", "windows", "openings")
            for row in data[key]
            if row["parentIdentifier"] == wall["identifier"]
        ]
        folder = f"assets/Mesh/Walls/Wall{i}"
        slab = wall_mesh(f"Wall{i}", wall, own, block=i % 2 == 0)
        layers[f"{folder}/Wall{i}.usda"] = component(f"Wall{i}", "Wall", wall["identifier"], slab)
        for j, row in enumerate(own):
            kind = next(iter(row["category"]))
            if kind == "opening":
                continue
            word = (
                f"Door(Isopen: {row['category']['door']['isOpen']})" if kind == "door" else "Window"
            )
            name = f"{kind.capitalize()}{i}_{j}"
            w, h = 0.5 * row["dimensions"][0], 0.5 * row["dimensions"][1]
            leaf = boxes_mesh(name, row["transform"], [[-w, w, -h, h, -0.08, 0.0]])
            layers[f"{folder}/{name}.usda"] = component(name, word, row["identifier"], leaf)
    for i, row in enumerate(data["floors"]):
        layers["assets/Mesh/Floors/Floor0.usda"] = component(
            f"Floor{i}", "Floor", row["identifier"], floor_mesh(f"Floor{i}", row)
        )
    for i, row in enumerate(data["objects"]):
        kind = next(iter(row["category"])).capitalize()
        layers[f"assets/Mesh/{kind}/{kind}{i}.usda"] = component(
            f"{kind}{i}", kind, row["identifier"], cube(f"{kind}{i}", row, 0.0)
        )
    return {"Room.usda": root, **layers}


def furnished(scanner: Any) -> dict[str, Any]:
    """A room whose openings know their walls: an open door, a window, a passage at a wall's end."""
    data = full_room(scanner)
    wall = {i: row["identifier"] for i, row in enumerate(data["walls"])}
    data["doors"] = [
        scanner.surface(
            "door",
            [5, 0.5],
            [5, 1.4],
            0.0,
            2.1,
            category={"door": {"isOpen": True}},
            parentIdentifier=wall[1],
        )
    ]
    data["windows"][0]["parentIdentifier"] = wall[0]
    data["openings"] = [
        scanner.surface("opening", [0, 4], [0, 2.5], 0.0, 2.0, parentIdentifier=wall[5])
    ]
    data["objects"] = data["objects"][:1]
    return data


def test_a_mesh_export_gives_what_the_json_gives(scanner, tmp_path: Path) -> None:
    data = furnished(scanner)
    from_json = read(scanner.write(data))
    usdz = read(pack(tmp_path / "Room.usdz", mesh_layers(data)))
    assert usdz.notes == ()
    [passage] = [o for o in usdz.openings if o.kind == "opening"]
    [known] = [o for o in from_json.openings if o.kind == "opening"]
    assert passage.center == pytest.approx(known.center, abs=1e-5)
    assert (passage.width, passage.height) == pytest.approx((1.5, 2.0), abs=1e-5)
    states = {o.id: (o.is_open, o.wall) for o in usdz.openings if o is not passage}
    assert states == {o.id: (o.is_open, o.wall) for o in from_json.openings if o is not known}
    data["openings"][0]["identifier"] = passage.id
    assert_same(usdz, read(scanner.write(data)), 1e-5)


def test_a_wall_that_is_lower_at_one_end_has_no_hole_there(scanner, tmp_path: Path) -> None:
    data = furnished(scanner)
    # A hole that reaches the wall's top.
    data["openings"][0] |= scanner.surface("opening", [0, 4], [0, 2.5], 2.0, 2.45) | {
        "parentIdentifier": data["openings"][0]["parentIdentifier"]
    }
    usdz = read(pack(tmp_path / "Room.usdz", mesh_layers(data)))
    assert sorted(o.kind for o in usdz.openings) == ["door", "window"]
    assert "built up to it as rectangles: 1 wall is sloped, up to 2.45 m" in usdz.notes[0]


def test_a_curved_wall_with_a_thickness_has_the_arc_of_its_front(scanner, tmp_path: Path) -> None:
    data = furnished(scanner) | {"windows": []}
    wall, layers = data["walls"][0], mesh_layers(data)
    # Bulging out of the room, whose inside is at -z of this wall: it is thick towards its centre.
    rows = [curved_front(radius, 5.0) for radius in (4.0, 4.0 - THICK)]
    faces = [
        [k + i for i in face] for k, (_, own) in zip((0, 50), rows, strict=True) for face in own
    ]
    points = np.concatenate([points for points, _ in rows])
    layers["assets/Mesh/Walls/Wall0/Wall0.usda"] = component(
        "Wall0", "Wall", wall["identifier"], mesh("Wall0", wall["transform"], points, faces)
    )
    usdz = read(pack(tmp_path / "Room.usdz", layers))
    wall["curve"] = curve_of(5.0)
    known = read(scanner.write(data))
    assert len(known.floor) > 12
    assert usdz.floor == pytest.approx(known.floor, abs=1e-4)


def test_furniture_models_stand_in_their_boxes(scanner, tmp_path: Path) -> None:
    """A model export: the object refers to a model in another unit, which a scale fits."""
    data = furnished(scanner)
    row, layers = data["objects"][0], mesh_layers(data)
    [name] = [name for name in layers if "Chair" in name]
    width, height, depth = row["dimensions"]
    scale = np.diag([width / 50, height / 100, depth / 60, 1.0])
    scale[3, :3] = [0.0, -0.5 * height, 0.0]
    inner = (
        '    def Xform "Chair0"\n    {\n'
        f"        matrix4d xformOp:transform = {matrix_text(row['transform'])}\n"
        '        uniform token[] xformOpOrder = ["xformOp:transform"]\n'
        '        def Xform "model" (\n            prepend references = @./{}@\n        )\n'
        "        {{\n"
        f"            matrix4d xformOp:transform = {matrix_text(scale.ravel().tolist())}\n"
        '            uniform token[] xformOpOrder = ["xformOp:transform"]\n        }}\n    }}\n'
    )
    head, rest = inner.split("        def Xform", 1)
    rest = "        def Xform" + rest
    for file, expected in (("SwivelChair_wBack.rooms.usda", 1), ("missing.usda", 0)):
        layers[name] = component("Chair0", "Chair", row["identifier"], head + rest.format(file))
        unit = HEAD.format(name="chair").replace("metersPerUnit = 1", "metersPerUnit = 0.01")
        model = boxes_mesh("m", np.eye(4).ravel().tolist(), [[-25, 25, 0, 100, -30, 30]])
        layers["assets/Mesh/Chair/SwivelChair_wBack.rooms.usda"] = (
            unit + f'def Xform "chair"\n{{\n{model}}}\n'
        )
        usdz = read(pack(tmp_path / "Room.usdz", layers))
        assert len(usdz.boxes) == expected
        if expected:
            [known] = read(scanner.write(data)).boxes
            assert usdz.boxes[0].size == pytest.approx(known.size, abs=1e-5)
            assert usdz.boxes[0].center == pytest.approx(known.center, abs=1e-5)
            assert usdz.boxes[0].attributes == {"ChairType": "swivel"}
        else:
            assert any("Chair0: the file has no shape of it" in note for note in usdz.notes)


@pytest.mark.parametrize(
    "name", ["roomplan_libroom", "real_dev/data/roomplan_library", "real_dev/data/roomplan_kitchen"]
)
def test_a_real_export_says_the_same_in_both_formats(real, scanner, name: str) -> None:
    folder = real(name)
    usdz, known = read(folder / "Room.usdz"), read(folder / "Room.json")
    states = {(o.is_open, o.wall, o.kind) for o in usdz.openings}
    assert states == {(o.is_open, o.wall, o.kind) for o in known.openings}
    assert usdz.notes == known.notes
    # Passages of mesh exports are holes, which have no identifier of their own.
    data = json.loads((folder / "Room.json").read_text())
    for row in data["openings"]:
        where = [o.id for o in usdz.openings if o.id.startswith(f"{row['parentIdentifier']} ")]
        row["identifier"] = where[0] if where else row["identifier"]
    assert_same(usdz, read(scanner.write(data)), 1e-5)


def test_layers_give_what_the_json_gives(scanner, tmp_path: Path) -> None:
    data = full_room(scanner)
    usdz = read(pack(tmp_path / "Room.usdz", layers_of(data)))
    assert_same(usdz, read(scanner.write(data)), 1e-6)
    assert usdz.boxes[0].confidence is None
    assert any("which doors are open" in note for note in usdz.notes)


def test_layers_may_be_crates(scanner, tmp_path: Path) -> None:
    data = full_room(scanner)
    crates: dict[str, str | bytes] = {}
    for name, text in layers_of(data).items():
        layer = Sdf.Layer.CreateAnonymous(".usda")
        layer.ImportFromString(text)
        file = tmp_path / "one.usdc"
        layer.Export(str(file))
        crates[name.replace(".usda", ".usdc")] = file.read_bytes()
    assert_same(read(pack(tmp_path / "Room.usdz", crates)), read(scanner.write(data)), 1e-6)


def test_a_curved_wall_is_found_in_its_mesh(scanner, tmp_path: Path) -> None:
    data = full_room(scanner) | {"windows": []}
    layers = layers_of(data)
    # Over the edge from (0, 0) to (5, 0): local z looks out of the room.
    wall = data["walls"][0]
    front = mesh("Wall0", wall["transform"], *curved_front(4.0, 5.0))
    layers["assets/Parametric/walls/Wall0.usda"] = component(
        "Wall0", "Wall", wall["identifier"], front
    )
    from_usdz = read(pack(tmp_path / "Room.usdz", layers))
    wall["curve"] = curve_of(5.0)
    from_json = read(scanner.write(data))
    assert len(from_json.floor) > 12
    assert from_usdz.floor == pytest.approx(from_json.floor, abs=1e-5)


def test_sections_name_the_rooms(scanner, tmp_path: Path) -> None:
    data = full_room(scanner)
    path = pack(tmp_path / "Room.usdz", layers_of(data))
    assert read(path, "kitchen").floor == pytest.approx(read(path).floor)


def test_both_formats_give_the_same_prims(scanner, tmp_path: Path) -> None:
    data = full_room(scanner)
    stages = []
    for path in (scanner.write(data), pack(tmp_path / "Room.usdz", layers_of(data))):
        section = f"{{from: roomplan, file: {path.name}}}"
        room = parse_room(f"layout: {section}\nfurniture: {section}")
        stage = Usd.Stage.CreateInMemory()
        context = StepContext(room, path.parent, stage, tmp_path / path.suffix[1:])
        LayoutStep().author(context)
        AlignmentStep().author(context)
        stages.append({str(prim.GetPath()) for prim in stage.Traverse()})
    assert stages[0] == stages[1]
    assert len([path for path in stages[0] if path.startswith("/World/Furniture/")]) == 2
