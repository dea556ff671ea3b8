"""``orusd simulate``: a result, JSON, and mistakes in words."""

import json
from pathlib import Path

import numpy as np
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
    how = ("--engine", engine, "--duration", 1, "-o", out, "--json")
    data = json.loads(output_of("simulate", stage, *how))
    (row,) = data["moved"]
    assert row["path"] == "/World/crate"
    assert row["millimetres"] == pytest.approx(50.0, abs=1.0)
    assert data["out"] == str(out) and "xformOp:translate:settled" in out.read_text()


def test_people_read_what_moved(stage: Path, tmp_path: Path) -> None:
    told = output_of("simulate", stage, "--duration", 0.5, "-o", tmp_path / "rest.usda")
    assert "1 movable object; the largest motion in 0.5 s was 50." in told and "wrote" in told
    assert "warning: these moved by more than 1 cm: crate" in told


def test_a_layer_elsewhere_starts_from_the_room_as_described(tmp_path: Path) -> None:
    """And not from where things came to rest before."""
    (tmp_path / "layers").mkdir()
    (tmp_path / "layers/layout.usda").write_text(STAGE)
    metadata = STAGE[STAGE.index("    defaultPrim") : STAGE.index(")")]
    below = "    subLayers = [@layers/settled.usda@, @layers/layout.usda@]\n"
    room = tmp_path / "scene.usda"
    room.write_text(f"#usda 1.0\n(\n{metadata}{below})\n")
    own = tmp_path / "layers/settled.usda"
    own.write_text("#usda 1.0\n")
    how = ("--duration", 0.5, "--json", "-o")
    first = json.loads(output_of("simulate", room, *how, tmp_path / "first.usda"))
    own.write_bytes((tmp_path / "first.usda").read_bytes())
    again = json.loads(output_of("simulate", room, *how, tmp_path / "again.usda"))
    assert again["moved"] == first["moved"]
    assert first["moved"][0]["millimetres"] == pytest.approx(50.0, abs=1.0)


FLAP = """\
    def PhysicsRevoluteJoint "hinge"
    {
        rel physics:body1 = </World/crate>
        point3f physics:localPos0 = (-0.1, 0, 0.55)
        point3f physics:localPos1 = (-0.1, 0, 0)
        uniform token physics:axis = "Y"
    }
}
"""


def test_what_turns_on_a_joint_counts(stage: Path, tmp_path: Path) -> None:
    """A crate of 20 cm whose edge hangs from the world swings down by a quarter and more."""
    lifted = STAGE.replace("(0, 0, 0.15)", "(0, 0, 0.55)")
    stage.write_text(lifted.rstrip().removesuffix("}") + FLAP)
    how = ("--duration", 0.3, "-o", tmp_path / "rest.usda")
    (row,) = json.loads(output_of("simulate", stage, *how, "--json"))["moved"]
    (angle,) = row["joints"].values()
    assert row["degrees"] == pytest.approx(abs(angle), abs=0.1) and row["degrees"] > 30.0
    # The far edge is 20 cm from the hinge and 10 cm above and below it.
    reach = 2.0 * (0.2**2 + 0.1**2) ** 0.5 * np.sin(np.radians(row["degrees"]) / 2.0)
    assert row["millimetres"] == pytest.approx(1e3 * reach, rel=0.01)
    told = output_of("simulate", stage, *how)
    assert f"the largest turn {row['degrees']:.1f} degrees" in told


def test_a_stage_that_is_no_room_needs_a_place(stage: Path) -> None:
    result = run("simulate", stage)
    assert "not a composed room" in str(result.exception)


def test_an_explosion_leaves_no_layer(stage: Path, tmp_path: Path) -> None:
    stage.write_text(STAGE.replace("(0, 0, 0.15)", "(3, 0, 0.15)"))
    out = tmp_path / "rest.usda"
    with pytest.raises(StageError, match="left the world") as caught:
        output_of("simulate", stage, "-o", out, "--duration", 5)
    assert caught.value.place == "/World/crate"
    assert not out.exists()


def test_a_missing_engine_names_the_extra() -> None:
    with pytest.raises(MissingPackageError) as caught:
        needed("an_engine_that_nobody_has")
    assert caught.value.remedy == 'pip install "openrooms-usd[physics]"'
