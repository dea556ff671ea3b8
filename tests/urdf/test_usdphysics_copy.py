"""The flat copy for Isaac and Newton: the same bodies, in one file, with what PhysX must know."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from pxr import Sdf, Usd, UsdGeom, UsdPhysics, UsdShade, UsdUtils

from openrooms_usd import names
from openrooms_usd.exporters import Report
from openrooms_usd.usd.files.layers import open_stage
from openrooms_usd.usd.rigid.reading import read_world
from openrooms_usd.validation.model import Rule, Subject
from openrooms_usd.validation.physx_rules import PHYSX_RULES
from openrooms_usd.validation.stage_rules import articulations, nested_bodies
from orusd_urdf import UsdPhysicsExporter
from tests.folders import contents
from tests.validators import nvidia_issues

EXPORT = """
import sys
from pathlib import Path
from openrooms_usd.usd.files.layers import open_stage
from orusd_urdf import UsdPhysicsExporter
UsdPhysicsExporter().convert(open_stage(Path(sys.argv[1])), Path(sys.argv[2]), {})
"""


@pytest.fixture(scope="module")
def copied(composed_bodies: Path, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Report]:
    folder = tmp_path_factory.mktemp("usdphysics")
    report = UsdPhysicsExporter().convert(open_stage(composed_bodies), folder, {})
    return folder, report


@pytest.mark.slow
def test_the_copy_says_the_same_of_every_body(
    composed_bodies: Path, copied: tuple[Path, Report]
) -> None:
    before = {body.path: body for body in read_world(open_stage(composed_bodies)).bodies}
    after = {body.path: body for body in read_world(open_stage(copied[0] / "scene.usdc")).bodies}
    assert list(before) == list(after)
    for path, body in before.items():
        other = after[path]
        assert body.fixed == other.fixed
        np.testing.assert_allclose(body.world_from_body, other.world_from_body, atol=1e-9)
        assert [joint.name for joint in body.joints] == [joint.name for joint in other.joints]
        for link, twin in zip(body.links, other.links, strict=True):
            assert len(link.shapes) == len(twin.shapes)
            assert (link.mass is None) == (twin.mass is None)
            if link.mass is not None and twin.mass is not None:
                assert link.mass.mass == twin.mass.mass
                np.testing.assert_array_equal(link.mass.inertia, twin.mass.inertia)
            for shape, same in zip(link.shapes, twin.shapes, strict=True):
                given, root = shape.contact, same.contact
                assert root.static_friction**2 == pytest.approx(given.static_friction, rel=1e-6)
                assert root.dynamic_friction**2 == pytest.approx(given.dynamic_friction, rel=1e-6)


def test_the_parser_of_usd_finds_everything(copied: tuple[Path, Report]) -> None:
    stage = Usd.Stage.Open(str(copied[0] / "scene.usdc"))
    parse = (
        getattr(UsdPhysics, "UsdPhysicsLoadStageFromPrimRange", None)
        or UsdPhysics.LoadUsdPhysicsFromRange
    )
    found = parse(stage, [Sdf.Path.absoluteRootPath])
    kinds = UsdPhysics.ObjectType
    assert len(found[kinds.Scene][0]) == 1
    assert found[kinds.RigidBody][0]
    paths, shapes = (
        found[kinds.ConvexMeshShape]
        if hasattr(kinds, "ConvexMeshShape")
        else (found[kinds.MeshShape])
    )
    assert paths
    assert all(shape.materials for shape in shapes)


def test_both_surfaces_ask_to_be_multiplied(copied: tuple[Path, Report]) -> None:
    stage = Usd.Stage.Open(str(copied[0] / "scene.usdc"))
    prims = Usd.PrimRange.Stage(stage, Usd.PrimAllPrimsPredicate)
    materials = [prim for prim in prims if prim.HasAPI(UsdPhysics.MaterialAPI)]
    assert materials
    for prim in materials:
        assert "PhysxMaterialAPI" in prim.GetMetadata("apiSchemas").GetAddedOrExplicitItems()
        assert prim.GetAttribute("physxMaterial:frictionCombineMode").Get() == "multiply"
        assert prim.GetAttribute("physxMaterial:restitutionCombineMode").Get() == "multiply"


def test_dry_friction_of_joints_is_in_the_word_of_newton_and_physx(
    copied: tuple[Path, Report],
) -> None:
    stage = Usd.Stage.Open(str(copied[0] / "scene.usdc"))
    joints = [prim for prim in stage.Traverse() if prim.IsA(UsdPhysics.Joint)]
    said = [prim for prim in joints if prim.GetAttribute(names.JOINT_FRICTION).Get()]
    assert said
    for prim in said:
        assert "NewtonJointAPI" in prim.GetMetadata("apiSchemas").GetAddedOrExplicitItems()
        friction = prim.GetAttribute("newton:friction").Get()
        assert friction == prim.GetAttribute(names.JOINT_FRICTION).Get() > 0.0


def test_no_validator_and_no_rule_of_physx_finds_anything(copied: tuple[Path, Report]) -> None:
    assert nvidia_issues(copied[0] / "scene.usdc") == []
    subject = Subject(open_stage(copied[0] / "scene.usdc"))
    rules = (*PHYSX_RULES, Rule("", nested_bodies, ""), Rule("", articulations, ""))
    assert [complaint for rule in rules for complaint in rule.check(subject)] == []


def test_one_file_in_metres_that_needs_nothing_from_elsewhere(
    composed_bodies: Path, copied: tuple[Path, Report]
) -> None:
    folder, _ = copied
    stage = Usd.Stage.Open(str(folder / "scene.usdc"))
    assert UsdGeom.GetStageMetersPerUnit(stage) == 1.0
    assert UsdPhysics.GetStageKilogramsPerUnit(stage) == 1.0
    assert UsdGeom.GetStageUpAxis(stage) == "Z"
    layers, files, missing = UsdUtils.ComputeAllDependencies(str(folder / "scene.usdc"))
    assert len(layers) == 1 and not missing and files
    assert all(Path(file).is_relative_to(folder) for file in files)
    text = stage.GetRootLayer().ExportToString()
    assert str(composed_bodies.parent) not in text and str(folder) not in text


def test_nothing_moves_or_collides_inside_an_instance(
    composed_bodies: Path, copied: tuple[Path, Report]
) -> None:
    stage = Usd.Stage.Open(str(copied[0] / "scene.usdc"))
    composed = open_stage(composed_bodies)
    assert any(prim.IsInstance() for prim in composed.Traverse())
    prims = list(stage.Traverse(Usd.TraverseInstanceProxies()))
    apis = (UsdPhysics.RigidBodyAPI, UsdPhysics.CollisionAPI)
    assert [p for p in prims if p.IsInstanceProxy() and any(map(p.HasAPI, apis))] == []
    colliders = [prim for prim in prims if prim.HasAPI(UsdPhysics.CollisionAPI)]
    assert colliders
    for prim in colliders:
        assert UsdGeom.Imageable(prim).ComputePurpose() == "guide"
        api = UsdShade.MaterialBindingAPI(prim)
        material = api.ComputeBoundMaterial("physics")[0]
        assert material.GetPrim().HasAPI(UsdPhysics.MaterialAPI)


@pytest.mark.slow
def test_another_process_writes_the_same_bytes(
    composed_bodies: Path, copied: tuple[Path, Report], tmp_path: Path
) -> None:
    command = [sys.executable, "-c", EXPORT, str(composed_bodies), str(tmp_path)]
    subprocess.run(command, check=True, capture_output=True)
    assert contents(copied[0]) and contents(tmp_path) == contents(copied[0])


@pytest.mark.slow
def test_coefficients_stay_on_request(composed_bodies: Path, tmp_path: Path) -> None:
    stage = open_stage(composed_bodies)
    UsdPhysicsExporter().convert(stage, tmp_path, {"roots": False})
    before = [s.contact for b in read_world(stage).bodies for k in b.links for s in k.shapes]
    again = read_world(open_stage(tmp_path / "scene.usdc"))
    assert [s.contact for b in again.bodies for k in b.links for s in k.shapes] == before


def test_a_body_inside_an_instance_is_taken_out(tmp_path: Path) -> None:
    from orusd_urdf.usdphysics import flattened

    stage = Usd.Stage.CreateInMemory()
    UsdGeom.Xform.Define(stage, "/Source")
    UsdPhysics.RigidBodyAPI.Apply(UsdGeom.Cube.Define(stage, "/Source/Cube").GetPrim())
    for name in ("A", "B"):
        prim = UsdGeom.Xform.Define(stage, f"/World/{name}").GetPrim()
        prim.GetReferences().AddInternalReference("/Source")
        prim.SetInstanceable(True)
    flat = Usd.Stage.Open(flattened(stage))
    assert not flat.GetPrimAtPath("/World/A/Cube").IsInstanceProxy()
    assert flat.GetPrimAtPath("/World/B/Cube").HasAPI(UsdPhysics.RigidBodyAPI)
    assert stage.GetPrimAtPath("/World/A/Cube").IsInstanceProxy()
