"""The USDZ export: layers written here, by hand, of a room whose JSON is known."""

from pathlib import Path

import pytest
from pxr import Sdf, Usd

from openrooms_usd.description import parse_room
from openrooms_usd.stages.alignment.stage import AlignmentStage
from openrooms_usd.stages.base import StageContext
from openrooms_usd.stages.layout.stage import LayoutStage
from tests.scans.roomplan_usdz import (
    assert_same,
    component,
    curve_of,
    curved_front,
    full_room,
    layers_of,
    mesh,
    pack,
    read,
)


def test_layers_give_what_the_json_gives(scanner, tmp_path: Path) -> None:
    data = full_room(scanner)
    usdz = read(pack(tmp_path / "Room.usdz", layers_of(data)))
    assert_same(usdz, read(scanner.write(data)), 1e-6)
    assert usdz.boxes[0].confidence is None
    assert any("which doors stand open" in note for note in usdz.notes)


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
        room = parse_room(f"layout: {section}\nalignment: {section}")
        stage = Usd.Stage.CreateInMemory()
        context = StageContext(room, path.parent, stage, tmp_path / path.suffix[1:])
        LayoutStage().author(context)
        AlignmentStage().author(context)
        stages.append({str(prim.GetPath()) for prim in stage.Traverse()})
    assert stages[0] == stages[1]
    assert len([path for path in stages[0] if path.startswith("/World/Furniture/")]) == 2
