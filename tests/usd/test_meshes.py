"""Meshes written and read, against USD's own bounds and transforms and against trimesh."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, Vt

from openrooms_usd.arrays import Array
from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.usd.shapes.meshes import (
    MeshReading,
    PlacedMesh,
    TriangleMesh,
    define_mesh,
    read_meshes,
    world_triangles,
)

QUADS = np.array(
    [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]]
)


def cuboid(size: tuple[float, float, float] = (1.0, 2.0, 3.0)) -> Mesh:
    """A box about the origin with outward faces, flat normals and some texture coordinates."""
    signs = np.array([[x, y, z] for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)], dtype=float)
    normals = np.repeat(np.kron(np.eye(3), [[-1.0], [1.0]]), 4, axis=0)
    st = np.tile([[0.0, 0], [1, 0], [1, 1], [0, 1]], (6, 1)) + np.repeat(np.arange(6), 4)[:, None]
    return Mesh(
        signs * np.array(size) / 2,
        np.full(6, 4, dtype=np.int32),
        QUADS.astype(np.int32).reshape(-1),
        normals.astype(np.float32),
        st.astype(np.float32),
    )


def new_stage(axis: str = "Z", unit: float = 1.0) -> Usd.Stage:
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageUpAxis(stage, axis)
    UsdGeom.SetStageMetersPerUnit(stage, unit)
    UsdGeom.Xform.Define(stage, "/World")
    return stage


def world_volume(placed: PlacedMesh) -> float:
    """Signed volume in the world, by the divergence theorem, its winding as a renderer sees it."""
    a, b, c = np.moveaxis(placed.world_points()[placed.mesh.triangles], 1, 0)
    volume = float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)
    return -volume if placed.mirrored else volume


def only(reading: MeshReading) -> PlacedMesh:
    assert reading.losses == []
    assert len(reading) == 1
    return reading.meshes[0]


# --- authoring ---


def test_what_is_written_is_what_usd_understands() -> None:
    stage = new_stage()
    mesh = cuboid()
    prim = define_mesh(stage, "/World/box", mesh, double_sided=True)
    assert UsdGeom.Mesh.ValidateTopology(
        prim.GetFaceVertexIndicesAttr().Get(), prim.GetFaceVertexCountsAttr().Get(), 8
    )[0]
    computed = UsdGeom.Boundable.ComputeExtentFromPlugins(prim, Usd.TimeCode.Default())
    np.testing.assert_array_equal(prim.GetExtentAttr().Get(), computed)
    assert prim.GetSubdivisionSchemeAttr().Get() == "none"
    assert prim.GetNormalsInterpolation() == "faceVarying"
    assert prim.GetDoubleSidedAttr().Get() is True
    st = UsdGeom.PrimvarsAPI(prim).GetPrimvar("st")
    assert st.GetTypeName() == Sdf.ValueTypeNames.TexCoord2fArray
    assert st.GetInterpolation() == "faceVarying"
    np.testing.assert_array_equal(st.Get(), mesh.st)


def test_extent_bounds_the_rounded_points() -> None:
    stage = new_stage()
    mesh = cuboid((0.1, 0.2, 0.3)).moved((0.1, 1e4 / 3, 7.7))
    prim = define_mesh(stage, "/World/box", mesh)
    low, high = np.array(prim.GetExtentAttr().Get())
    points = np.array(prim.GetPointsAttr().Get())
    assert (points >= low).all()
    assert (points <= high).all()


def test_reading_gives_back_what_was_written() -> None:
    stage = new_stage()
    mesh = cuboid()
    define_mesh(stage, "/World/box", mesh, double_sided=True)
    placed = only(read_meshes(stage))
    corners, faces = mesh.triangles()
    assert placed.path == "/World/box"
    assert placed.double_sided
    assert not placed.mirrored
    np.testing.assert_allclose(placed.mesh.points, mesh.points)
    np.testing.assert_array_equal(placed.mesh.triangles, mesh.indices[corners])
    np.testing.assert_array_equal(placed.mesh.faces, faces)
    assert mesh.normals is not None
    assert mesh.st is not None
    np.testing.assert_allclose(placed.mesh.normals, mesh.normals[corners])
    np.testing.assert_array_equal(placed.mesh.st, mesh.st[corners])
    assert world_volume(placed) == pytest.approx(6.0)


# --- placing ---


@pytest.mark.parametrize("axis", ["Y", "Z"])
@pytest.mark.parametrize("unit", [1.0, 0.01])
def test_places_are_those_of_usds_bounds(axis: str, unit: float) -> None:
    """Through nested transforms, an instance, an instance in it, and a point instancer."""
    stage = new_stage(axis, unit)
    prototypes(stage)
    rng = np.random.default_rng(0)
    for name, target in (("a", "/Assets/pair"), ("b", "/Assets/pair"), ("c", "/Assets/nested")):
        prim = UsdGeom.Xform.Define(stage, f"/World/{name}")
        prim.AddTranslateOp().Set(Gf.Vec3d(*rng.uniform(-5, 5, 3)))
        prim.AddRotateXYZOp().Set(Gf.Vec3f(*rng.uniform(-90, 90, 3)))
        prim.AddScaleOp().Set(Gf.Vec3f(*rng.uniform(0.5, 2, 3)))
        prim.GetPrim().GetReferences().AddInternalReference(target)
        prim.GetPrim().SetInstanceable(True)
    reading = read_meshes(stage)
    assert len(reading) == 2 + 2 + 4
    turn = Gf.Matrix4d(1.0)
    if axis == "Y":
        turn.SetRotate(Gf.Rotation(Gf.Vec3d(1, 0, 0), 90.0))
    turn *= Gf.Matrix4d().SetScale(unit)
    cache = UsdGeom.BBoxCache(Usd.TimeCode.Default(), ["default"])
    for placed in reading:
        bound = cache.ComputeWorldBound(placed.prim)
        corners = [bound.GetRange().GetCorner(k) for k in range(8)]
        expected = [(bound.GetMatrix() * turn).Transform(corner) for corner in corners]
        np.testing.assert_allclose(
            np.sort(placed.world_points(), axis=0), np.sort(expected, axis=0), atol=1e-6
        )
        assert placed.prim.GetPath() == placed.path
        assert placed.prim.IsInstanceProxy()


def prototypes(stage: Usd.Stage) -> None:
    """A pair of boxes, and an asset that holds two instances of it."""
    stage.CreateClassPrim("/Assets")
    UsdGeom.Xform.Define(stage, "/Assets/pair")
    geometry = UsdGeom.Xform.Define(stage, "/Assets/pair/Geometry")
    geometry.AddRotateXYZOp().Set(Gf.Vec3f(20, 40, 60))
    geometry.AddScaleOp().Set(Gf.Vec3f(1, 2, 3))
    define_mesh(stage, "/Assets/pair/Geometry/left", cuboid())
    right = define_mesh(stage, "/Assets/pair/Geometry/right", cuboid((0.3, 0.3, 0.3)))
    right.AddTranslateOp().Set(Gf.Vec3d(2, 0, 0))
    UsdGeom.Xform.Define(stage, "/Assets/nested")
    for k in range(2):
        inner = UsdGeom.Xform.Define(stage, f"/Assets/nested/inner_{k}")
        inner.AddRotateZOp().Set(30.0 * k)
        inner.AddTranslateOp().Set(Gf.Vec3d(0, k, 0))
        inner.GetPrim().GetReferences().AddInternalReference("/Assets/pair")
        inner.GetPrim().SetInstanceable(True)


def test_instances_share_one_object() -> None:
    stage = new_stage()
    prototypes(stage)
    for k in range(20):
        prim = UsdGeom.Xform.Define(stage, f"/World/o{k}").GetPrim()
        prim.GetReferences().AddInternalReference("/Assets/nested" if k % 2 else "/Assets/pair")
        prim.SetInstanceable(True)
    # Another purpose is inherited by the same prototype, but its triangles are the same.
    UsdGeom.Imageable(stage.GetPrimAtPath("/World/o3")).CreatePurposeAttr("render")
    reading = read_meshes(stage)
    assert len(reading) == 10 * 2 + 10 * 4
    assert len({id(placed.mesh) for placed in reading}) == 2


def scattered(stage: Usd.Stage, count: int) -> UsdGeom.PointInstancer:
    instancer = UsdGeom.PointInstancer.Define(stage, "/World/many")
    instancer.AddTranslateOp().Set(Gf.Vec3d(0, 0, 10))
    define_mesh(stage, "/World/many/Prototypes/small", cuboid((0.1, 0.1, 0.1)))
    large = define_mesh(stage, "/World/many/Prototypes/large", cuboid((1, 1, 1)))
    large.AddTranslateOp().Set(Gf.Vec3d(0, 0, 0.5))
    instancer.CreatePrototypesRel().SetTargets(
        ["/World/many/Prototypes/small", "/World/many/Prototypes/large"]
    )
    rng = np.random.default_rng(1)
    instancer.CreateProtoIndicesAttr([k % 2 for k in range(count)])
    instancer.CreatePositionsAttr(Vt.Vec3fArray.FromNumpy(rng.random((count, 3), dtype=np.float32)))
    instancer.CreateScalesAttr(
        Vt.Vec3fArray.FromNumpy(1 + rng.random((count, 3), dtype=np.float32))
    )
    turns = [Gf.Quath(Gf.Rotation(Gf.Vec3d(1, 2, 3), 17.0 * k).GetQuat()) for k in range(count)]
    instancer.CreateOrientationsAttr(Vt.QuathArray(turns))
    return instancer


def test_point_instancers_are_expanded() -> None:
    stage = new_stage()
    instancer = scattered(stage, 6)
    instancer.CreateInvisibleIdsAttr([2])
    instancer.DeactivateId(5)
    reading = read_meshes(stage)
    assert [placed.path for placed in reading] == [f"/World/many[{k}]" for k in (0, 1, 3, 4)]
    assert [str(p.prim.GetName()) for p in reading] == ["small", "large", "large", "small"]
    placed = instancer.ComputeInstanceTransformsAtTime(  # prototype transforms included
        Usd.TimeCode.Default(), Usd.TimeCode.Default(), applyMask=UsdGeom.PointInstancer.ApplyMask
    )
    for mesh, place in zip(reading, placed, strict=True):
        world = place * Gf.Matrix4d().SetTranslate(Gf.Vec3d(0, 0, 10))
        points = [world.Transform(Gf.Vec3d(*point)) for point in mesh.mesh.points.tolist()]
        np.testing.assert_allclose(mesh.world_points(), points, atol=1e-9)


def test_point_instancers_that_fit_nothing_are_reported() -> None:
    stage = new_stage()
    instancer = scattered(stage, 4)
    instancer.GetProtoIndicesAttr().Set([0, 1, 2, 0])
    assert read_meshes(stage).losses[0][:2] == ("/World/many", "skipped")
    instancer.GetProtoIndicesAttr().Set([0, 1, 1])
    assert "do not fit" in read_meshes(stage).losses[0][2]
    instancer.GetProtoIndicesAttr().Set([0, 0, 0, 0])
    instancer.GetPrototypesRel().SetTargets(["/World/many"])
    assert "own instancer" in read_meshes(stage).losses[0][2]
    instancer.GetPrototypesRel().SetTargets(["/nowhere"])
    assert len(read_meshes(stage)) == 0


def test_what_is_invisible_or_has_another_purpose_is_left_out() -> None:
    stage = new_stage()
    for name in ("shown", "hidden", "guide", "proxy", "render", "kept"):
        UsdGeom.Xform.Define(stage, f"/World/{name}")
        define_mesh(stage, f"/World/{name}/mesh", cuboid())
    for name in ("guide", "proxy", "render"):
        UsdGeom.Xform(stage.GetPrimAtPath(f"/World/{name}")).CreatePurposeAttr(name)
    UsdGeom.Imageable(stage.GetPrimAtPath("/World/hidden")).MakeInvisible()
    UsdGeom.Imageable(stage.GetPrimAtPath("/World/kept")).CreatePurposeAttr("guide")
    # An opinion of its own is stronger than the inherited one.
    UsdGeom.Imageable(stage.GetPrimAtPath("/World/kept/mesh")).CreatePurposeAttr("default")
    drawn = {placed.path.split("/")[2] for placed in read_meshes(stage)}
    expected = {
        str(prim.GetPath()).split("/")[2]
        for prim in stage.Traverse()
        if prim.IsA(UsdGeom.Mesh)
        and UsdGeom.Imageable(prim).ComputeVisibility() != "invisible"
        and UsdGeom.Imageable(prim).ComputePurpose() in ("default", "render")
    }
    assert drawn == expected == {"shown", "render", "kept"}
    guides = read_meshes(stage, purposes=("guide",))
    assert [placed.path for placed in guides] == ["/World/guide/mesh"]


def test_an_instance_hands_its_purpose_and_visibility_down() -> None:
    stage = new_stage()
    prototypes(stage)
    for name in ("shown", "hidden", "guide"):
        prim = UsdGeom.Xform.Define(stage, f"/World/{name}").GetPrim()
        prim.GetReferences().AddInternalReference("/Assets/nested")
        prim.SetInstanceable(True)
    UsdGeom.Imageable(stage.GetPrimAtPath("/World/hidden")).MakeInvisible()
    UsdGeom.Imageable(stage.GetPrimAtPath("/World/guide")).CreatePurposeAttr("guide")
    assert {placed.path.split("/")[2] for placed in read_meshes(stage)} == {"shown"}


def test_transform_stacks_can_be_reset() -> None:
    stage = new_stage("Y", 0.01)
    stage.CreateClassPrim("/Assets")
    UsdGeom.Xform.Define(stage, "/Assets/asset")
    UsdGeom.Xform.Define(stage, "/Assets/asset/inner").AddTranslateOp().Set(Gf.Vec3d(7, 7, 7))
    mesh = define_mesh(stage, "/Assets/asset/inner/mesh", cuboid())
    mesh.SetResetXformStack(True)
    mesh.AddTranslateOp().Set(Gf.Vec3d(1, 2, 3))
    instance = UsdGeom.Xform.Define(stage, "/World/instance")
    instance.AddTranslateOp().Set(Gf.Vec3d(100, 100, 100))
    instance.GetPrim().GetReferences().AddInternalReference("/Assets/asset")
    instance.GetPrim().SetInstanceable(True)
    placed = only(read_meshes(stage))
    np.testing.assert_allclose(placed.world_points().mean(axis=0), [0.01, -0.03, 0.02])


def test_time_samples_are_read_at_the_first() -> None:
    stage = new_stage()
    mesh = define_mesh(stage, "/World/mesh", cuboid())
    points = np.array(mesh.GetPointsAttr().Get())
    mesh.GetPointsAttr().Clear()
    for time in (10.0, 20.0):
        mesh.GetPointsAttr().Set(Vt.Vec3fArray.FromNumpy((time * points).astype(np.float32)), time)
    mesh.AddTranslateOp().Set(Gf.Vec3d(5, 0, 0), 10.0)
    placed = only(read_meshes(stage))
    np.testing.assert_allclose(placed.world_points(), 10.0 * points + [5, 0, 0])


def test_mirrored_and_left_handed_surfaces_keep_their_outside() -> None:
    stage = new_stage()
    define_mesh(stage, "/World/mirrored", cuboid()).AddScaleOp().Set(Gf.Vec3f(-1, 1, 1))
    left = define_mesh(stage, "/World/left", cuboid().flipped())
    left.GetOrientationAttr().Set("leftHanded")
    found = list(read_meshes(stage))
    assert {placed.path for placed in found} == {"/World/mirrored", "/World/left"}
    for placed in found:
        assert placed.mirrored == (placed.path == "/World/mirrored")
        assert world_volume(placed) == pytest.approx(6.0)
        assert placed.mesh.normals is not None
        a, b, c = np.moveaxis(placed.mesh.points[placed.mesh.triangles], 1, 0)
        outward = np.cross(b - a, c - a)
        outward /= np.linalg.norm(outward, axis=1, keepdims=True)
        np.testing.assert_allclose(placed.mesh.normals, np.repeat(outward[:, None], 3, axis=1))


def _wrong_normals(mesh: UsdGeom.Mesh, how: str) -> None:
    normals = np.array(mesh.GetNormalsAttr().Get())
    if how == "all":
        normals *= -1.0
    elif how == "some faces":
        normals[4:12] *= -1.0
    elif how == "some corners":
        normals[::4] *= -1.0
    elif how == "left-handed, not turned":
        mesh.GetOrientationAttr().Set("leftHanded")
    mesh.GetNormalsAttr().Set(Vt.Vec3fArray.FromNumpy(normals))


@pytest.mark.parametrize(
    ("how", "told"),
    [
        ("none", None),
        ("all", "of all triangles"),
        ("some faces", "of 4 of 12 triangles"),
        ("some corners", "of all triangles"),
        ("left-handed, not turned", "of all triangles"),
    ],
)
@pytest.mark.parametrize("scale", [(1, 1, 1), (-1, 2, 1)])
def test_normals_against_their_triangle_are_turned_round(
    how: str, told: str | None, scale: tuple[float, float, float]
) -> None:
    """They are the triangle's own, whichever of both was written wrongly."""
    stage = new_stage()
    mesh = define_mesh(stage, "/World/mesh", cuboid())
    mesh.AddScaleOp().Set(Gf.Vec3f(*scale))
    _wrong_normals(mesh, how)
    reading = read_meshes(stage)
    found = reading.meshes[0].mesh
    a, b, c = np.moveaxis(found.points[found.triangles], 1, 0)
    front = np.cross(b - a, c - a)
    front /= np.linalg.norm(front, axis=1, keepdims=True)
    np.testing.assert_allclose(found.normals, np.repeat(front[:, None], 3, axis=1), atol=1e-6)
    assert [told in reason for _, _, reason in reading.losses] == ([True] if told else [])


def test_smooth_normals_a_little_below_their_triangle_stay() -> None:
    stage = new_stage()
    mesh = define_mesh(stage, "/World/mesh", cuboid())
    normals = np.array(mesh.GetNormalsAttr().Get())
    normals[0] = (0.3, 0.95, 0.0)  # of the face that looks along -X
    normals[0] /= np.linalg.norm(normals[0])
    mesh.GetNormalsAttr().Set(Vt.Vec3fArray.FromNumpy(normals))
    found = only(read_meshes(stage)).mesh
    assert found.normals is not None
    np.testing.assert_allclose(found.normals[0, 0], normals[0], atol=1e-6)


def test_flattened_transforms_are_skipped_with_a_reason() -> None:
    stage = new_stage()
    define_mesh(stage, "/World/flat", cuboid()).AddScaleOp().Set(Gf.Vec3f(1, 0, 1))
    reading = read_meshes(stage)
    assert (len(reading), reading.losses) == (
        0,
        [("/World/flat", "skipped", "its transform is singular")],
    )


def test_all_triangles_come_in_one_soup() -> None:
    stage = new_stage()
    define_mesh(stage, "/World/a", cuboid())
    define_mesh(stage, "/World/b", cuboid()).AddTranslateOp().Set(Gf.Vec3d(10, 0, 0))
    points, triangles, owners = world_triangles(read_meshes(stage))
    assert owners.tolist() == [0] * 12 + [1] * 12
    np.testing.assert_allclose(points[triangles[12:]].mean(axis=(0, 1)), [10, 0, 0], atol=1e-9)
    empty = world_triangles([])
    assert [part.shape for part in empty] == [(0, 3), (0, 3), (0,)]


# --- topology ---


def broken(change: Callable[[UsdGeom.Mesh], object]) -> MeshReading:
    stage = new_stage()
    mesh = define_mesh(stage, "/World/mesh", cuboid())
    change(mesh)
    return read_meshes(stage)


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (lambda mesh: mesh.GetPointsAttr().Clear(), "no points"),
        (lambda mesh: mesh.GetFaceVertexCountsAttr().Set([]), "no faces"),
        (lambda mesh: mesh.GetFaceVertexCountsAttr().Set([4] * 5), "add up"),
        (lambda mesh: mesh.GetFaceVertexCountsAttr().Set([28, -4]), "add up"),
        (lambda mesh: mesh.GetFaceVertexIndicesAttr().Set([8] * 24), "do not exist"),
        (lambda mesh: mesh.GetFaceVertexIndicesAttr().Set([-1] * 24), "do not exist"),
        (lambda mesh: mesh.GetPointsAttr().Set([(np.nan, 0, 0)] * 8), "NaN"),
        (lambda mesh: mesh.GetPointsAttr().Set([(0, 0, np.inf)] * 8), "NaN or infinity"),
        (lambda mesh: mesh.GetPointsAttr().Set([(1, 1, 1)] * 8), "area"),
        (lambda mesh: mesh.CreateHoleIndicesAttr(list(range(6))), "area"),
    ],
)
def test_impossible_meshes_are_skipped_with_a_reason(
    change: Callable[[UsdGeom.Mesh], object], reason: str
) -> None:
    reading = broken(change)
    assert len(reading) == 0
    [(path, outcome, said)] = reading.losses
    assert (path, outcome) == ("/World/mesh", "skipped")
    assert reason in said


@pytest.mark.parametrize("name", ["points", "faceVertexCounts", "faceVertexIndices", "normals"])
@pytest.mark.parametrize(
    ("kind", "value"),
    [
        ("Point3f", (1.0, 2.0, 3.0)),
        ("Int", 7),
        ("String", "x"),
        ("StringArray", ["x"]),
        ("Asset", "x.png"),
        ("Float2Array", [(0.0, 1.0)] * 8),
        ("Matrix4dArray", [Gf.Matrix4d()] * 8),
    ],
)
def test_values_of_other_types_are_none(name: str, kind: str, value: Any) -> None:
    """The asset working group's own test has such points."""
    stage = new_stage()
    define_mesh(stage, "/World/mesh", cuboid())
    stage.GetPrimAtPath("/World/mesh").RemoveProperty(name)
    layer = stage.GetRootLayer()
    said = Sdf.AttributeSpec(
        layer.GetPrimAtPath("/World/mesh"), name, getattr(Sdf.ValueTypeNames, kind)
    )
    said.default = value
    reading = read_meshes(stage)
    assert len(reading) == (name == "normals")
    assert name == "normals" or reading.losses[0][1] == "skipped"


def test_holes_are_left_open() -> None:
    reading = broken(lambda mesh: mesh.CreateHoleIndicesAttr([0, 3]))
    assert sorted(set(only(reading).mesh.faces.tolist())) == [1, 2, 4, 5]


def test_subdivision_surfaces_are_refined_and_reported() -> None:
    reading = broken(lambda mesh: mesh.GetSubdivisionSchemeAttr().Set("catmullClark"))
    assert len(reading) == 1
    [(path, outcome, reason)] = reading.losses
    assert (path, outcome) == ("/World/mesh", "approximated")
    assert "catmullClark" in reason
    assert np.bincount(reading.meshes[0].mesh.faces).tolist() == [32] * 6


def test_other_geometry_is_reported_once_however_often_it_is_used() -> None:
    stage = new_stage()
    stage.CreateClassPrim("/Assets")
    UsdGeom.Xform.Define(stage, "/Assets/asset")
    stage.DefinePrim("/Assets/asset/smoke", "Volume")
    UsdGeom.Points.Define(stage, "/Assets/asset/points")
    for k in range(3):
        prim = UsdGeom.Xform.Define(stage, f"/World/o{k}").GetPrim()
        prim.GetReferences().AddInternalReference("/Assets/asset")
        prim.SetInstanceable(True)
    losses = read_meshes(stage).losses
    assert [(path, outcome) for path, outcome, _ in losses] == [
        ("/World/o0/smoke", "skipped"),
        ("/World/o0/points", "skipped"),
    ]
    assert "Volume" in losses[0][2]


# --- primvars ---


def expected_corners(placed: TriangleMesh, interpolation: str, values: Array) -> Array:
    """The definition of each interpolation, corner by corner, for a mesh of quads cut in fans."""
    rows = []
    for number, triangle in enumerate(placed.triangles.tolist()):
        face = int(placed.faces[number])
        for point in triangle:
            corner = 4 * face + QUADS[face].tolist().index(point)
            rows.append(
                {
                    "constant": 0,
                    "uniform": face,
                    "vertex": point,
                    "varying": point,
                    "faceVarying": corner,
                }[interpolation]
            )
    return values[rows].reshape(-1, 3, values.shape[1])


SIZES = {"constant": 1, "uniform": 6, "vertex": 8, "varying": 8, "faceVarying": 24}


@pytest.mark.parametrize("interpolation", SIZES)
@pytest.mark.parametrize("indexed", [False, True])
@pytest.mark.parametrize("handed", ["rightHanded", "leftHanded"])
def test_primvars_reach_their_corners(interpolation: str, indexed: bool, handed: str) -> None:
    rng = np.random.default_rng(5)
    stage = new_stage()
    mesh = define_mesh(stage, "/World/mesh", cuboid())
    mesh.GetOrientationAttr().Set(handed)
    api = UsdGeom.PrimvarsAPI(mesh)
    size = SIZES[interpolation]
    values = {
        name: rng.normal(size=(size, width)).astype(np.float32)
        for name, width in (("normals", 3), ("map1", 2), ("st", 2))
    }
    values["normals"] /= np.linalg.norm(values["normals"], axis=1, keepdims=True)
    order = rng.permutation(size) if indexed else np.arange(size)
    for name, array in values.items():
        kind = (
            Sdf.ValueTypeNames.Normal3fArray
            if name == "normals"
            else (Sdf.ValueTypeNames.Float2Array if name == "map1" else None)
        )
        vt = (Vt.Vec3fArray if name == "normals" else Vt.Vec2fArray).FromNumpy(
            np.ascontiguousarray(array[np.argsort(order)])
        )
        primvar = api.CreatePrimvar(name, kind or Sdf.ValueTypeNames.TexCoord2fArray, interpolation)
        primvar.Set(vt)
        if indexed:
            primvar.SetIndices(Vt.IntArray.FromNumpy(order.astype(np.int32)))
    placed = read_meshes(stage).meshes[0].mesh
    assert list(placed.uvs) == ["st", "map1"]  # the usual one first
    for name, found in (("normals", placed.normals), *placed.uvs.items()):
        assert found is not None
        expected = expected_corners(placed, interpolation, values[name])
        if name == "normals":  # random ones: half of them stand against their triangle
            expected *= np.sign(np.sum(expected * found, axis=2, keepdims=True))
        np.testing.assert_allclose(found, expected, atol=1e-6)


def test_primvar_normals_win_over_the_attribute() -> None:
    def change(mesh: UsdGeom.Mesh) -> None:
        primvar = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar(
            "normals", Sdf.ValueTypeNames.Normal3fArray, "constant"
        )
        primvar.Set([(0, 0, 2)])

    normals = broken(change).meshes[0].mesh.normals
    assert normals is not None  # those of the lower face are turned round
    np.testing.assert_allclose(np.abs(normals), np.broadcast_to([0.0, 0, 1], (12, 3, 3)))


def test_normals_that_point_nowhere_become_those_of_the_face() -> None:
    def change(mesh: UsdGeom.Mesh) -> None:
        values = np.array(mesh.GetNormalsAttr().Get())
        values[::3], values[1::3] = 0.0, np.nan
        mesh.GetNormalsAttr().Set(Vt.Vec3fArray.FromNumpy(values))

    mesh = cuboid()
    corners, _ = mesh.triangles()
    assert mesh.normals is not None
    np.testing.assert_allclose(only(broken(change)).mesh.normals, mesh.normals[corners])


def test_primvars_that_do_not_fit_are_left_out_with_a_reason() -> None:
    def change(mesh: UsdGeom.Mesh) -> None:
        mesh.GetNormalsAttr().Set([(0, 0, 1)] * 5)
        UsdGeom.PrimvarsAPI(mesh).GetPrimvar("st").Set([(np.nan, 0)] * 24)

    reading = broken(change)
    mesh = reading.meshes[0].mesh
    assert mesh.normals is None
    assert mesh.st is None
    assert [outcome for _, outcome, _ in reading.losses] == ["approximated"] * 2


# --- a stage from somewhere else ---


def test_a_phone_capture_fills_the_bounds_that_usd_computes(real: Callable[[str], Path]) -> None:
    stage = Usd.Stage.Open(str(real("roomplan_libroom/Room.usdz")))
    reading = read_meshes(stage)
    assert len(reading) > 10
    cache = UsdGeom.BBoxCache(
        Usd.TimeCode.EarliestTime(), ["default", "render"], useExtentsHint=False
    )
    bound = cache.ComputeWorldBound(stage.GetPseudoRoot()).ComputeAlignedRange()
    points, triangles, _ = world_triangles(reading)
    used = points[np.unique(triangles)]
    metres = UsdGeom.GetStageMetersPerUnit(stage)
    # Bounds of rotated boxes are a little larger than those of what is in them.
    x, y, z = np.stack([bound.GetMin(), bound.GetMax()]).T * metres
    low, high = np.array([x[0], -z[1], y[0]]), np.array([x[1], -z[0], y[1]])
    size = high - low
    assert (used.min(axis=0) >= low - 1e-4).all()
    assert (used.max(axis=0) <= high + 1e-4).all()
    assert (used.min(axis=0) <= low + 0.1 * size).all()
    assert (used.max(axis=0) >= high - 0.1 * size).all()
