"""Instances of one mesh, placed together: each stands where USD says, whatever its transform."""

import numpy as np
import pytest
from pxr import Gf, Usd, UsdGeom, Vt

from openrooms_usd.rendering.scene import instances as module
from openrooms_usd.rendering.scene.instances import joined
from openrooms_usd.rendering.scene.translate import translate
from openrooms_usd.rendering.scene.triangles import Triangles

CORNERS = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
FACES = [(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)]


def instances(normals: str, count: int = 40) -> Usd.Stage:
    """Tetrahedra of one prototype under any affine transform, every second one mirrored."""
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    prototype = stage.CreateClassPrim("/Prototype")
    mesh = UsdGeom.Mesh.Define(stage, "/Prototype/mesh")
    mesh.CreatePointsAttr(CORNERS)
    mesh.CreateFaceVertexCountsAttr([3] * 4)
    mesh.CreateFaceVertexIndicesAttr([index for face in FACES for index in face])
    mesh.CreateSubdivisionSchemeAttr("none")
    if normals:
        rng = np.random.default_rng(1)
        given = rng.normal(size=(12 if normals == "faceVarying" else 4, 3)).astype(np.float32)
        mesh.CreateNormalsAttr(Vt.Vec3fArray.FromNumpy(given))
        mesh.SetNormalsInterpolation(normals)
    rng = np.random.default_rng(2)
    for number in range(count):
        prim = stage.DefinePrim(f"/World/instance_{number}", "Xform")
        prim.SetInstanceable(True)
        prim.GetReferences().AddInternalReference(prototype.GetPath())
        matrix = np.eye(4)
        matrix[:3, :3] = rng.normal(size=(3, 3))
        matrix[0, :3] *= np.sign(np.linalg.det(matrix[:3, :3])) * (-1) ** number
        matrix[3, :3] = rng.normal(size=3)
        UsdGeom.Xformable(prim).AddTransformOp().Set(Gf.Matrix4d(matrix.tolist()))
    return stage


@pytest.mark.parametrize("normals", ["", "vertex", "faceVarying"])
@pytest.mark.parametrize("at_once", [1, 12, 1 << 18])
def test_instances_stand_where_usd_says(
    normals: str, at_once: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "_MOST_TRIANGLES", at_once)
    stage = instances(normals)
    found = translate(stage).triangles
    rows = iter(range(len(found)))
    cache = UsdGeom.XformCache()
    for prim in Usd.PrimRange(stage.GetPseudoRoot(), Usd.TraverseInstanceProxies()):
        if not prim.IsA(UsdGeom.Mesh):
            continue
        matrix = cache.GetLocalToWorldTransform(prim)
        given = UsdGeom.Mesh(prim).GetNormalsAttr().Get()
        mirrored = matrix.GetDeterminant() < 0.0
        for number, face in enumerate(FACES):
            row, corners = next(rows), [matrix.Transform(Gf.Vec3d(*CORNERS[i])) for i in face]
            if not given:
                flat = Gf.Cross(corners[1] - corners[0], corners[2] - corners[0]).GetNormalized()
                expected = [flat * (-1.0 if mirrored else 1.0)] * 3
            else:
                places = face if normals == "vertex" else range(3 * number, 3 * number + 3)
                # Normals go by the inverse transpose.
                turned = matrix.GetInverse().GetTranspose()
                expected = [turned.TransformDir(Gf.Vec3d(given[i])).GetNormalized() for i in places]
                # They are random: those against their triangle are turned round.
                order = [
                    int(np.abs(np.array(corners) - corner).sum(axis=1).argmin())
                    for corner in found.corners[row]
                ]
                for place, normal in zip(order, found.normals[row].tolist(), strict=True):
                    expected[place] *= 1.0 if expected[place] * Gf.Vec3d(*normal) > 0.0 else -1.0
            # The winding of what is mirrored is turned round, from whichever corner.
            order = [
                int(np.abs(np.array(corners) - corner).sum(axis=1).argmin())
                for corner in found.corners[row]
            ]
            assert sorted(order) == [0, 1, 2]
            assert (
                Gf.Cross(
                    Gf.Vec3d(*map(float, np.eye(3)[order[0]])),
                    Gf.Vec3d(*map(float, np.eye(3)[order[1]])),
                )
                * Gf.Vec3d(*map(float, np.eye(3)[order[2]]))
                < 0.0
            ) == mirrored
            assert np.allclose(found.corners[row], np.array(corners)[order], atol=1e-6)
            assert np.allclose(found.normals[row], np.array(expected)[order], atol=1e-5)
    assert next(rows, None) is None


def test_what_was_split_is_joined_without_a_copy() -> None:
    rng = np.random.default_rng(3)
    whole = Triangles(
        rng.normal(size=(9, 3, 3)),
        rng.normal(size=(9, 3, 3)).astype(np.float32),
        rng.normal(size=(9, 3, 2)).astype(np.float32),
        np.arange(9, dtype=np.int32),
    )
    parts = whole.split([2, 0, 4, 3])
    assert [len(part) for part in parts] == [2, 0, 4, 3]
    again = joined(parts)
    assert np.shares_memory(again.corners, whole.corners)
    assert np.array_equal(again.pieces, np.arange(9))
    # Any others, and another order of these, are copied.
    turned = joined([parts[2], parts[0], parts[3]])
    assert turned.pieces.tolist() == [2, 3, 4, 5, 0, 1, 6, 7, 8]
    assert np.array_equal(turned.corners, whole.corners[turned.pieces])
    gap = joined([parts[0], parts[3]])
    assert gap.pieces.tolist() == [0, 1, 6, 7, 8]
    assert len(joined([])) == 0
