"""Intrinsic shapes against closed forms, USD's own extents, and trimesh."""

import numpy as np
import pytest
import trimesh
from numpy.typing import NDArray
from pxr import Usd, UsdGeom

from openrooms_usd.usd.meshes import TriangleMesh, read_meshes

SHAPES: dict[str, tuple[dict[str, float], float, float]] = {
    # attributes, volume, area
    "Cube": ({"size": 3.0}, 27.0, 54.0),
    "Sphere": ({"radius": 2.0}, 4 / 3 * np.pi * 8, 4 * np.pi * 4),
    "Cylinder": ({"radius": 1.5, "height": 4.0}, np.pi * 2.25 * 4, 2 * np.pi * 1.5 * 5.5),
    "Cone": ({"radius": 1.5, "height": 2.0}, np.pi * 1.5, np.pi * 1.5 * (1.5 + 2.5)),
    "Capsule": (
        {"radius": 0.5, "height": 2.0},
        np.pi * 0.25 * 2 + 4 / 3 * np.pi * 0.125,
        2 * np.pi * 0.5 * 2 + 4 * np.pi * 0.25,
    ),
    "Cylinder_1": (
        {"radiusBottom": 2.0, "radiusTop": 1.0, "height": 3.0},
        np.pi * 3.0 / 3 * (4 + 2 + 1),
        np.pi * (4 + 1 + 3 * np.hypot(3, 1)),
    ),
}


def new_stage() -> Usd.Stage:
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageUpAxis(stage, "Z")
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    return stage


def shape(kind: str, **values: object) -> tuple[TriangleMesh, NDArray[np.float64]]:
    """The triangles of a shape, and the extent that USD computes for it."""
    stage = new_stage()
    prim = stage.DefinePrim("/World/shape", kind)
    for name, value in values.items():
        prim.GetAttribute(name).Set(value)
    reading = read_meshes(stage)
    assert reading.losses == []
    extent = UsdGeom.Boundable.ComputeExtentFromPlugins(
        UsdGeom.Boundable(prim), Usd.TimeCode.Default()
    )
    return reading.meshes[0].mesh, np.array(extent, dtype=np.float64)


@pytest.mark.parametrize("kind", SHAPES)
@pytest.mark.parametrize("axis", ["X", "Y", "Z"])
def test_shapes_are_closed_and_have_their_size(kind: str, axis: str) -> None:
    values, volume, area = SHAPES[kind]
    has_axis = kind not in ("Cube", "Sphere")
    mesh, extent = shape(kind, **values, **({"axis": axis} if has_axis else {}))
    found = trimesh.Trimesh(mesh.points, mesh.triangles, process=False)
    assert found.is_watertight
    assert found.is_winding_consistent
    # Inscribed, so a little smaller; (2 pi / 48)^2 / 6 is 0.3 %.
    assert 0.99 * volume <= found.volume <= volume * (1 + 1e-9)
    assert 0.99 * area <= found.area <= area * (1 + 1e-9)
    np.testing.assert_allclose(found.bounds, extent, atol=1e-6)
    assert mesh.normals is not None
    facing = np.einsum("mij,mj->mi", mesh.normals, found.face_normals)
    assert facing.min() > np.cos(np.radians(10.0))


def test_a_sphere_has_the_sphere_as_normals() -> None:
    mesh, _extent = shape("Sphere", radius=2.0)
    corners = mesh.points[mesh.triangles]
    np.testing.assert_allclose(mesh.normals, corners / 2.0, atol=1e-6)


def test_a_capsule_is_everywhere_at_its_radius_from_its_axis() -> None:
    mesh, _extent = shape("Capsule", radius=0.5, height=2.0, axis="Y")
    points = mesh.points
    nearest = np.zeros_like(points)
    nearest[:, 1] = np.clip(points[:, 1], -1.0, 1.0)
    np.testing.assert_allclose(np.linalg.norm(points - nearest, axis=1), 0.5)


@pytest.mark.parametrize(
    ("axis", "normal", "size"),
    [("X", [1, 0, 0], [0, 4, 2]), ("Y", [0, 1, 0], [2, 0, 4]), ("Z", [0, 0, 1], [2, 4, 0])],
)
def test_planes_lie_as_the_schema_says(axis: str, normal: list[int], size: list[int]) -> None:
    mesh, extent = shape("Plane", width=2.0, length=4.0, axis=axis)
    a, b, c = np.moveaxis(mesh.points[mesh.triangles], 1, 0)
    wound = np.cross(b - a, c - a)
    np.testing.assert_allclose(wound / np.linalg.norm(wound, axis=1)[:, None], [normal] * 2)
    np.testing.assert_allclose(np.ptp(mesh.points, axis=0), size)
    np.testing.assert_allclose(np.ptp(extent, axis=0), size)


def test_left_handed_shapes_are_turned_inside_out() -> None:
    mesh, _extent = shape("Cube", orientation="leftHanded")
    assert trimesh.Trimesh(mesh.points, mesh.triangles).volume == pytest.approx(-8.0)


@pytest.mark.parametrize(
    ("kind", "values"),
    [
        ("Cube", {"size": 0.0}),
        ("Sphere", {"radius": -1.0}),
        ("Sphere", {"radius": np.nan}),
        ("Cylinder", {"height": 0.0}),
        ("Cone", {"radius": 0.0}),
        ("Plane", {"width": 0.0}),
        ("Capsule", {"radius": 0.0}),
    ],
)
def test_shapes_without_size_are_skipped(kind: str, values: dict[str, float]) -> None:
    stage = new_stage()
    prim = stage.DefinePrim("/World/shape", kind)
    for name, value in values.items():
        prim.GetAttribute(name).Set(value)
    reading = read_meshes(stage)
    assert len(reading) == 0
    assert reading.losses[0][1] == "skipped"
