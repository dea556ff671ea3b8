"""``orusd simulate``: a result, JSON, and mistakes in words."""

import json
from pathlib import Path

import pytest

from openrooms_usd.errors import MissingPackageError, StageError
from orusd_urdf.packages import needed
from tests.commands import output_of, run
from tests.engines import ENGINES

STAGE = """\
#usda 1.0
(
    defaultPrim = "World"
    metersPerUnit = 1
    kilogramsPerUnit = 1
    upAxis = "Z"
)
def Xform "World"
{
    def PhysicsScene "Scene"
    {
        vector3f physics:gravityDirection = (0, 0, -1)
        float physics:gravityMagnitude = 9.81
    }
    def Cube "floor" (prepend apiSchemas = ["PhysicsCollisionAPI"])
    {
        double size = 2
        double3 xformOp:translate = (0, 0, -1)
        uniform token[] xformOpOrder = ["xformOp:translate"]
    }
    def Cube "crate" (
        prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsCollisionAPI", "PhysicsMassAPI"]
    )
    {
        double size = 0.2
        float physics:mass = 1
        double3 xformOp:translate = (0, 0, 0.15)
        uniform token[] xformOpOrder = ["xformOp:translate"]
    }
}
"""


@pytest.fixture
def stage(tmp_path: Path) -> Path:
    path = tmp_path / "crate.usda"
    path.write_text(STAGE)
    return path


@pytest.mark.parametrize("engine", ENGINES)
def test_a_foreign_stage_settles(stage: Path, tmp_path: Path, engine: str) -> None:
    out = tmp_path / "rest.usda"
    how = ("--engine", engine, "--seconds", 1, "-o", out, "--json")
    data = json.loads(output_of("simulate", stage, *how))
    (row,) = data["moved"]
    assert row["path"] == "/World/crate"
    assert row["millimetres"] == pytest.approx(50.0, abs=1.0)
    assert data["out"] == str(out) and "xformOp:translate:settled" in out.read_text()


def test_people_read_what_moved(stage: Path, tmp_path: Path) -> None:
    told = output_of("simulate", stage, "--seconds", 0.5, "-o", tmp_path / "rest.usda")
    assert "1 things that can move, by at most 50." in told and "wrote" in told


def test_a_stage_that_is_no_room_needs_a_place(stage: Path) -> None:
    result = run("simulate", stage)
    assert "no composed room" in str(result.exception)


def test_an_explosion_leaves_no_layer(stage: Path, tmp_path: Path) -> None:
    stage.write_text(STAGE.replace("(0, 0, 0.15)", "(3, 0, 0.15)"))
    out = tmp_path / "rest.usda"
    with pytest.raises(StageError, match="left the world") as caught:
        output_of("simulate", stage, "-o", out, "--seconds", 5)
    assert caught.value.place == "/World/crate"
    assert not out.exists()


def test_a_missing_engine_names_the_extra() -> None:
    with pytest.raises(MissingPackageError) as caught:
        needed("an_engine_that_nobody_has")
    assert caught.value.remedy == 'pip install "openrooms-usd[physics]"'
