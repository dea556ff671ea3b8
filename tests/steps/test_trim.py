"""What the layout step fixes along walls and below the ceiling."""

from pathlib import Path

import numpy as np
import pytest
import shapely
from pxr import Usd, UsdGeom

from openrooms_usd.building.mouldings import section
from openrooms_usd.composing import compose_room
from openrooms_usd.description import parse_room
from openrooms_usd.errors import DescriptionError
from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.steps.base import StepContext
from openrooms_usd.steps.layout.step import LayoutStep
from openrooms_usd.usd.files.layers import apply_metadata
from openrooms_usd.usd.semantics import read_label, read_number
from openrooms_usd.usd.shading.materials import bound_material

ROOM = """
layout:
  polygon: [[0, 0], [5, 0], [5, 2], [2, 2], [2, 4], [0, 4]]
  openings:
    - {kind: window, wall: 0, at: 1.0}
    - {kind: window, wall: 0, at: 4.0, sill: 0.0, height: 2.2, width: 1.0}
    - {kind: door, wall: 1, at: 60 cm}
    - {kind: opening, wall: 4, at: 0.8, width: 70 cm, height: 2.1}
"""
TRIM = """\
  trim:
    skirting: {height: 0.1, depth: 0.012, profile: square}
    casing: 8 cm
    cornice: true
"""


def author(text: str) -> Usd.Stage:
    stage = Usd.Stage.CreateInMemory()
    apply_metadata(stage.GetRootLayer())
    LayoutStep().author(StepContext(parse_room(text), Path(), stage, Path("layout")))
    return stage


def points(stage: Usd.Stage, path: str) -> np.ndarray:
    return np.array(UsdGeom.Mesh(stage.GetPrimAtPath(path)).GetPointsAttr().Get(), dtype=float)


def test_nothing_is_there_of_which_nothing_is_said() -> None:
    stage = author(ROOM)
    assert not stage.GetPrimAtPath("/World/Room/Trim")
    assert not stage.GetPrimAtPath("/World/Room/Openings/window_0/Casing")


@pytest.mark.parametrize("mirrored", [False, True])
def test_skirting_is_as_long_as_the_walls_without_openings(mirrored: bool) -> None:
    text = ROOM + TRIM
    if mirrored:
        corners = "[[0, 0], [-5, 0], [-5, 2], [-2, 2], [-2, 4], [0, 4]]"
        text = text.replace("[[0, 0], [5, 0], [5, 2], [2, 2], [2, 4], [0, 4]]", corners)
    stage = author(text)
    mesh = UsdGeom.Mesh(stage.GetPrimAtPath("/World/Room/Trim/Skirting"))
    found = Mesh(
        np.array(mesh.GetPointsAttr().Get(), dtype=float),
        np.array(mesh.GetFaceVertexCountsAttr().Get()),
        np.array(mesh.GetFaceVertexIndicesAttr().Get()),
    )
    ring = shapely.Polygon(section("square", 0.012, 0.1))
    length = 18.0 - (1.0 + 0.9 + 0.7 + 3 * 2 * 0.079)
    # At each of five convex corners the path of the centroid is shorter, at the concave one longer.
    assert found.volume() / ring.area == pytest.approx(length - 8 * ring.centroid.x, rel=1e-4)
    assert found.points[:, 2].max() == pytest.approx(0.1)


def test_trim_is_labelled_and_stays_below_the_ceiling() -> None:
    stage = author(ROOM + TRIM + "  ceiling: coffers\n  cladding: [{top: 1.2}]\n")
    trim = stage.GetPrimAtPath("/World/Room/Trim")
    kinds = {prim.GetName(): read_label(prim, "category") for prim in trim.GetChildren()}
    assert kinds == {
        "Skirting": "skirting",
        "Cornice": "cornice",
        "Beams": "beam",
        "cladding_0": None,
    }
    assert read_number([trim.GetChild("Skirting")], "openrooms45") == 43
    assert read_number([trim.GetChild("Beams")], "nyu40") == 38
    tiles = trim.GetChild("cladding_0").GetChildren()
    assert [prim.GetName() for prim in tiles] == [f"wall_{i}" for i in range(6)]
    assert {read_label(prim, "category") for prim in tiles} == {"cladding"}
    for prim in (prim for prim in Usd.PrimRange(trim) if prim.IsA(UsdGeom.Mesh)):
        assert points(stage, str(prim.GetPath()))[:, 2].min() >= -0.003
        assert points(stage, str(prim.GetPath()))[:, 2].max() <= 2.6 + 0.003
    casing = points(stage, "/World/Room/Openings/door_0/Casing")
    assert casing[:, 0].min() == pytest.approx(-0.45 - 0.079, abs=1e-5)
    assert casing[:, 1].min() == pytest.approx(-0.015, abs=1e-6)
    assert casing[:, 1].max() == pytest.approx(0.215, abs=1e-6)


def test_materials_reach_walls_trim_and_cladding(tmp_path: Path) -> None:
    (tmp_path / "room.yaml").write_text(
        ROOM + TRIM + "  cladding: [{name: tiles, walls: [2], top: 1}]\n"
        "materials:\n"
        "  walls: {color: [0.5, 0.5, 0.5]}\n"
        "  accents: {wall_3: {color: [0.1, 0.2, 0.3]}}\n"
        "  trim: {color: [0.3, 0.2, 0.1]}\n"
        "  cladding: {tiles: {color: [0.2, 0.6, 0.6]}}\n"
    )
    for part in ("layout", "alignment", "materials"):
        scene = compose_room(tmp_path / "room.yaml", tmp_path / "out", only=part).scene
    stage = Usd.Stage.Open(str(scene))
    worn = {
        path: bound_material(stage.GetPrimAtPath(f"/World/Room/{path}")).GetPath().name
        for path in (
            "Walls/wall_0",
            "Walls/wall_1",
            "Walls/wall_3",
            "Trim/Skirting",
            "Trim/Cornice",
            "Trim/tiles/wall_2",
        )
    }
    assert worn["Walls/wall_0"] == worn["Walls/wall_1"]
    assert worn["Trim/Skirting"] == worn["Trim/Cornice"]
    assert len(set(worn.values())) == 4


@pytest.mark.parametrize("said", ["accents: {wall_9: paint}", "cladding: {tyles: paint}"])
def test_materials_of_walls_that_are_not_there_are_refused(said: str, tmp_path: Path) -> None:
    text = ROOM + "  cladding: [{name: tiles, walls: [2], top: 1}]\n" + f"materials: {{{said}}}\n"
    (tmp_path / "room.yaml").write_text(text)
    with pytest.raises(DescriptionError, match="there is no"):
        compose_room(tmp_path / "room.yaml", tmp_path / "out")
