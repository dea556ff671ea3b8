"""Skinned meshes against linear blend skinning and blend shapes, computed here by numpy."""

import numpy as np
import pytest
from numpy.typing import NDArray
from pxr import Gf, Usd, UsdGeom, UsdSkel

from openrooms_usd.usd.meshes import read_meshes
from openrooms_usd.usd.moments import hold

Array = NDArray[np.float64]

POINTS = np.array([[0, 0, 0], [1, 0, 0], [1, 0, 1], [0, 0, 1], [1, 0, 2], [0, 0, 2.0]])
WEIGHTS = np.array([[1, 0], [1, 0], [0.5, 0.5], [0.5, 0.5], [0, 1], [0, 1.0]])
SMILE = np.array([[0, 0, 0], [0, 0, 0], [0, -1, 0], [0, -1, 0], [0, 0, 3], [0, 0, 3.0]])
# Row vectors, as USD has them: the second joint stands at the height 1.
BIND = np.array([np.eye(4), np.eye(4)])
BIND[1, 3, 2] = 1.0


def puppet(path: str = "/World/Puppet") -> Usd.Stage:
    """Two joints: the root rises, the other one bends by a right angle within ten time codes."""
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageUpAxis(stage, "Z")
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    root = UsdSkel.Root.Define(stage, path)
    skeleton = UsdSkel.Skeleton.Define(stage, f"{path}/Skeleton")
    skeleton.CreateJointsAttr(["a", "a/b"])
    matrices = [Gf.Matrix4d(one) for one in BIND]
    skeleton.CreateBindTransformsAttr(matrices)
    skeleton.CreateRestTransformsAttr(matrices)
    animation = UsdSkel.Animation.Define(stage, f"{path}/Animation")
    animation.CreateJointsAttr(["a", "a/b"])
    animation.CreateScalesAttr([Gf.Vec3h(1)] * 2)
    animation.CreateBlendShapesAttr(["smile"])
    bent = Gf.Quatf(Gf.Rotation(Gf.Vec3d(1, 0, 0), 90).GetQuat())
    for at, height, turn in ((0.0, 0.0, Gf.Quatf(1)), (10.0, 4.0, bent)):
        animation.CreateTranslationsAttr().Set([(0, 0, height), (0, 0, 1)], at)
        animation.CreateRotationsAttr().Set([Gf.Quatf(1), turn], at)
        animation.CreateBlendShapeWeightsAttr().Set([at / 10.0], at)
    binding = UsdSkel.BindingAPI.Apply(skeleton.GetPrim())
    binding.CreateAnimationSourceRel().SetTargets([animation.GetPath()])
    mesh = UsdGeom.Mesh.Define(stage, f"{path}/Mesh")
    mesh.CreatePointsAttr(POINTS.astype(np.float32))
    mesh.CreateFaceVertexCountsAttr([4, 4])
    mesh.CreateFaceVertexIndicesAttr([0, 1, 2, 3, 3, 2, 4, 5])
    mesh.CreateSubdivisionSchemeAttr("none")
    binding = UsdSkel.BindingAPI.Apply(mesh.GetPrim())
    binding.CreateSkeletonRel().SetTargets([skeleton.GetPath()])
    binding.CreateJointIndicesPrimvar(False, 2).Set([0, 1] * len(POINTS))
    binding.CreateJointWeightsPrimvar(False, 2).Set(WEIGHTS.reshape(-1).tolist())
    shape = UsdSkel.BlendShape.Define(stage, f"{path}/Mesh/Smile")
    shape.CreateOffsetsAttr(SMILE.astype(np.float32))
    binding.CreateBlendShapesAttr(["smile"])
    binding.CreateBlendShapeTargetsRel().SetTargets([shape.GetPath()])
    UsdGeom.Xformable(root).AddTranslateOp().Set((7, 0, 0))
    return stage


def expected(done: float) -> Array:
    """Blend shapes, then every point by the mean of its joints' motions since they were bound."""
    angle = np.radians(90.0 * done)
    c, s = np.cos(angle), np.sin(angle)
    first = np.eye(4)
    first[3, 2] = 4.0 * done
    second = np.array([[1, 0, 0, 0], [0, c, s, 0], [0, -s, c, 0], [0, 0, 1, 1]]) @ first
    motions = np.linalg.inv(BIND) @ np.array([first, second])
    shaped = np.column_stack([POINTS + done * SMILE, np.ones(len(POINTS))])
    moved = np.einsum("pj,pr,jrc->pc", WEIGHTS, shaped, motions)[:, :3]
    return np.add(moved, (7.0, 0.0, 0.0))


def only(stage: Usd.Stage) -> Array:
    (mesh,) = read_meshes(stage)
    return mesh.world_points()


@pytest.mark.parametrize("time_code", [None, 0.0, 5.0, 10.0])
def test_a_pose_is_what_linear_blend_skinning_gives(time_code: float | None) -> None:
    stage = puppet()
    assert hold(stage, time_code) == {}
    assert np.allclose(only(stage), expected((time_code or 0.0) / 10.0), atol=1e-5)


def test_instances_of_what_is_skinned() -> None:
    stage = puppet("/Puppets/Puppet")
    stage.GetPrimAtPath("/Puppets").SetActive(True)
    for number in range(2):
        prim = stage.DefinePrim(f"/World/puppet_{number}", "Xform")
        prim.GetReferences().AddInternalReference("/Puppets")
        prim.SetInstanceable(True)
    hold(stage, 5.0)
    found = [mesh.world_points() for mesh in read_meshes(stage)]
    assert len(found) == 3
    assert all(np.allclose(one, expected(0.5), atol=1e-5) for one in found)


def test_skinning_that_does_not_fit_is_told() -> None:
    stage = puppet()
    primvar = UsdSkel.BindingAPI(stage.GetPrimAtPath("/World/Puppet/Mesh")).GetJointIndicesPrimvar()
    primvar.Set([0, 7] * len(POINTS))
    lost = hold(stage, 5.0)
    assert list(lost) == ["/World/Puppet/Mesh"]
    assert "rest pose" in lost["/World/Puppet/Mesh"]
    assert np.isfinite(only(stage)).all()
