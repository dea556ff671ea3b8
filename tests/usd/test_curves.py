"""Curves, patches, points and tetrahedra against closed forms and other people's splines."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest
import trimesh
from pxr import Gf, Usd, UsdGeom
from scipy.interpolate import BSpline, CubicHermiteSpline

from openrooms_usd.arrays import Array
from openrooms_usd.usd.shapes.gprims import GprimSurface, read_surface
from openrooms_usd.usd.shapes.meshes import TriangleMesh, read_meshes

# So thick that the least number of lines is enough.
THICK = 20.0
BENT = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 1), (0, 2, 1), (1, 3, 0), (2, 3, 0)]


def surface(
    kind: str, interpolations: Mapping[str, str] | None = None, **said: Any
) -> GprimSurface:
    stage = Usd.Stage.CreateInMemory()
    prim = stage.DefinePrim("/prim", kind)
    for name, value in said.items():
        prim.GetAttribute(name).Set(value)
    for name, interpolation in (interpolations or {}).items():
        prim.GetAttribute(name).SetMetadata("interpolation", interpolation)
    return read_surface(prim)


def curves(points: Any, kind: str = "BasisCurves", width: float = 0.1, **said: Any) -> GprimSurface:
    counts = said.pop("counts", [len(points)])
    return surface(
        kind,
        {"widths": "constant"},
        points=[Gf.Vec3f(*map(float, p)) for p in points],
        curveVertexCounts=counts,
        widths=[width],
        **said,
    )


def axis(found: GprimSurface, sides: int = 12) -> Array:
    """(S, 3) the middles of a tube's sections."""
    assert found.mesh is not None, found.losses
    return np.asarray(found.mesh.points.reshape(-1, sides, 3).mean(axis=1))


def volume(found: GprimSurface) -> float:
    assert found.mesh is not None, found.losses
    a, b, c = np.moveaxis(found.mesh.points[found.mesh.triangles], 1, 0)
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)


def test_a_straight_line_is_a_cylinder() -> None:
    found = curves([(0, 0, 0), (0, 0, 2)], type="linear", width=0.2)
    assert volume(found) == pytest.approx(np.pi * 0.1**2 * 2.0)
    assert found.mesh is not None and found.mesh.normals is not None
    at, normals = found.mesh.points[found.mesh.triangles], found.mesh.normals
    sides = np.abs(normals[..., 2]) < 0.5
    out = at[sides] * [1.0, 1.0, 0.0]
    out /= np.linalg.norm(out, axis=1, keepdims=True)
    assert np.abs(normals[sides] - out).max() < 1e-6
    assert set(normals[~sides][:, 2].round(6)) == {-1.0, 1.0}


def test_bezier_curves_are_those_of_de_casteljau() -> None:
    found = axis(curves(BENT, type="cubic", basis="bezier", width=THICK))
    expected = []
    for first in (0, 3):
        for t in np.arange(6) / 6.0:
            row = np.array(BENT[first : first + 4], float)
            while len(row) > 1:
                row = (1.0 - t) * row[:-1] + t * row[1:]
            expected.append(row[0])
    assert np.abs(found - [*expected, BENT[-1]]).max() < 1e-6


def test_b_splines_are_scipys() -> None:
    found = axis(curves(BENT, type="cubic", basis="bspline", width=THICK))
    curve = BSpline(np.arange(-3.0, 8.0), np.array(BENT, float), 3)
    assert np.abs(found - curve(np.arange(25) / 6.0)).max() < 1e-6


@pytest.mark.parametrize("basis", ["bspline", "catmullRom"])
def test_pinned_curves_begin_and_end_at_their_points(basis: str) -> None:
    found = axis(curves(BENT, type="cubic", basis=basis, wrap="pinned", width=THICK))
    assert len(found) == 6 * 6 + 1
    assert np.abs(found[[0, -1]] - np.array(BENT, float)[[0, -1]]).max() < 1e-6
    if basis == "catmullRom":
        assert np.abs(found[::6] - BENT).max() < 1e-6


@pytest.mark.parametrize(("basis", "pieces"), [("bezier", 2), ("bspline", 6), ("catmullRom", 6)])
def test_periodic_curves_are_rings(basis: str, pieces: int) -> None:
    ring = [(np.cos(t), np.sin(t), 0.4 * np.cos(2 * t + 1)) for t in np.arange(6) * np.pi / 3.0]
    found = curves(ring, type="cubic", basis=basis, wrap="periodic")
    middle = axis(found)
    assert len(middle) > 6 * pieces
    # Pappus: a ring holds its section times the way of its middle, but for the corners.
    way = np.linalg.norm(middle - np.roll(middle, 1, axis=0), axis=1).sum()
    rough = 0.06 if basis == "bezier" else 0.02
    assert volume(found) == pytest.approx(np.pi * 0.05**2 * way, rel=rough)
    # No section is turned against the next, where the ring closes neither.
    assert found.mesh is not None
    at = found.mesh.points.reshape(-1, 12, 3) - middle[:, None]
    against = (at * np.roll(at, 1, axis=0)).sum(axis=2) / 0.05**2
    assert against.mean(axis=1).min() > (0.7 if basis == "bezier" else 0.9)


def test_hermite_curves_are_scipys() -> None:
    tangents = [Gf.Vec3f(*map(float, p)) for p in np.roll(BENT, 2, axis=0)]
    found = axis(curves(BENT, "HermiteCurves", tangents=tangents, width=THICK))
    curve = CubicHermiteSpline(np.arange(7), np.array(BENT, float), np.roll(BENT, 2, axis=0))
    assert np.abs(found - curve(np.arange(37) / 6.0)).max() < 1e-6


def test_a_nurbs_curve_with_weights_is_a_circle() -> None:
    found = axis(
        curves(
            [(1, 0, 0), (1, 1, 0), (0, 1, 0)],
            "NurbsCurves",
            width=THICK,
            order=[3],
            knots=[0.0, 0, 0, 1, 1, 1],
            pointWeights=[1.0, np.sqrt(0.5), 1.0],
        )
    )
    assert np.abs(np.linalg.norm(found, axis=1) - 1.0).max() < 1e-6
    assert len(found) == 7


EXACT: dict[str, dict[str, Any]] = {
    "bezier": {"type": "cubic", "basis": "bezier"},
    "bspline": {"type": "cubic", "basis": "bspline"},
    "catmullRom": {"type": "cubic", "basis": "catmullRom", "wrap": "pinned"},
    "closed": {"type": "cubic", "basis": "bspline", "wrap": "periodic"},
    "nurbs": {"kind": "NurbsCurves", "order": [4], "knots": list(map(float, range(11)))},
    "hermite": {"kind": "HermiteCurves", "tangents": [Gf.Vec3f(0, 4, 0)] * 7},
}


@pytest.mark.parametrize("name", EXACT)
@pytest.mark.parametrize("radius", [0.2, 0.02])
def test_chords_are_no_farther_off_than_a_twentieth_of_the_radius(name: str, radius: float) -> None:
    """Against the same curve as a thread, which has as many lines as there may be."""
    thread, found = (
        axis(curves(BENT, width=width, **EXACT[name])) for width in (1e-6, 2.0 * radius)
    )
    if name == "closed":
        found = np.append(found, found[:1], axis=0)
    starts, ways = found[:-1], np.diff(found, axis=0)
    to = thread[:, None] - starts
    along = np.clip((to * ways).sum(axis=2) / (ways * ways).sum(axis=1), 0.0, 1.0)
    off = np.linalg.norm(to - along[..., None] * ways, axis=2).min(axis=1).max()
    assert off < 0.05 * radius + 1e-4
    assert len(found) < 0.8 * len(thread)


def test_hair_that_ends_in_a_point_has_no_more_lines_for_that() -> None:
    tapered = surface(
        "BasisCurves",
        {"widths": "varying"},
        points=[Gf.Vec3f(*map(float, p)) for p in BENT],
        curveVertexCounts=[7],
        widths=[2 * THICK, THICK, 0.0],
        type="cubic",
        basis="bezier",
    )
    assert len(axis(tapered)) == 13


def test_two_nurbs_curves_have_their_own_knots_and_ranges() -> None:
    found = axis(
        curves(
            [(0, 0, 0), (1, 0, 0), (5, 0, 0), (6, 1, 0), (7, 0, 0)],
            "NurbsCurves",
            counts=[2, 3],
            order=[2, 3],
            knots=[0.0, 0, 1, 1, 0, 0, 0, 2, 2, 2],
            ranges=[Gf.Vec2d(0, 0.5), Gf.Vec2d(0, 2)],
        )
    )
    assert np.abs(found[:2] - [[0, 0, 0], [0.5, 0, 0]]).max() < 1e-6
    assert np.abs(found[[2, 5, 8]] - [[5, 0, 0], [6, 0.5, 0], [7, 0, 0]]).max() < 1e-6


def test_widths_follow_their_interpolation() -> None:
    def wide(interpolation: str, widths: list[float]) -> Array:
        found = surface(
            "BasisCurves",
            {"widths": interpolation},
            type="cubic",
            basis="bspline",
            points=[Gf.Vec3f(float(k % 5), float(k // 5), 0) for k in range(10)],
            curveVertexCounts=[5, 5],
            widths=widths,
        )
        assert found.mesh is not None, found.losses
        at = found.mesh.points.reshape(2, 13, 12, 3)
        reach = np.linalg.norm(at - at.mean(axis=2, keepdims=True), axis=3).mean(axis=2)
        return np.asarray(2.0 * reach / reach[0, 0])

    assert np.abs(wide("uniform", [2.0, 4.0]) - [[2.0], [4.0]]).max() < 1e-6
    # Two pieces have three ends.
    expected = np.interp(np.arange(13) / 6.0, [0, 1, 2], [2.0, 3.0, 1.0])
    assert np.abs(wide("varying", [2.0, 3.0, 1.0] * 2) - expected).max() < 1e-6
    curve = BSpline(np.arange(-3.0, 6.0), np.array([1.0, 2.0, 3.0, 9.0, 1.0]), 3)
    vertex = curve(np.arange(13) / 6.0)
    found = wide("vertex", [1.0, 2.0, 3.0, 9.0, 1.0] * 2)
    assert np.abs(found[0] / 2.0 - vertex / vertex[0]).max() < 1e-6


def test_curves_with_normals_are_ribbons() -> None:
    found = surface(
        "BasisCurves",
        {"widths": "constant", "normals": "vertex"},
        type="linear",
        points=[Gf.Vec3f(0, 0, 0), Gf.Vec3f(2, 0, 0)],
        curveVertexCounts=[2],
        widths=[0.5],
        normals=[Gf.Vec3f(0, 0, 1)] * 2,
    )
    assert found.mesh is not None and found.double_sided
    a, b, c = np.moveaxis(found.mesh.points[found.mesh.triangles], 1, 0)
    assert 0.5 * np.cross(b - a, c - a).sum(axis=0) == pytest.approx([0.0, 0.0, 1.0])
    assert found.mesh.normals is not None
    assert np.abs(found.mesh.normals - [0, 0, 1]).max() < 1e-6


def test_a_helix_does_not_twist() -> None:
    """Along a helix the section turns about its own axis by no more than it has to."""
    turn = np.linspace(0.0, 6.0 * np.pi, 200)
    found = curves(np.stack([np.cos(turn), np.sin(turn), 0.1 * turn], axis=1), type="linear")
    assert found.mesh is not None
    at = found.mesh.points.reshape(-1, 12, 3)
    rays = at[:, 0] - at.mean(axis=1)
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    tangents = np.gradient(at.mean(axis=1), axis=0)
    tangents /= np.linalg.norm(tangents, axis=1, keepdims=True)
    assert np.abs((rays * tangents).sum(axis=1)).max() < 1e-6
    spin = (np.cross(rays[:-1], rays[1:]) * tangents[:-1]).sum(axis=1)
    assert np.abs(spin[1:-1]).max() < 3e-3


def test_many_curves_have_few_sides_and_no_widths_are_told() -> None:
    points = [Gf.Vec3f(float(k), 0, float(z)) for k in range(600) for z in range(2)]
    found = surface("BasisCurves", points=points, curveVertexCounts=[2] * 600, type="linear")
    assert found.mesh is not None and len(found.mesh.points) == 600 * 2 * 4
    assert ("approximated", "it has no widths: 1 is used") in found.losses


def test_a_patch_with_weights_is_a_cylinder_that_faces_outwards() -> None:
    arc = [(1, 0), (1, 1), (0, 1)]
    found = surface(
        "NurbsPatch",
        uVertexCount=3,
        vVertexCount=2,
        uOrder=3,
        vOrder=2,
        uKnots=[0.0, 0, 0, 1, 1, 1],
        vKnots=[0.0, 0, 1, 1],
        points=[Gf.Vec3f(float(x), float(y), float(z)) for z in (0, 2) for x, y in arc],
        pointWeights=[1.0, np.sqrt(0.5), 1.0] * 2,
    )
    mesh = found.mesh
    assert mesh is not None and mesh.normals is not None
    assert np.abs(np.linalg.norm(mesh.points[:, :2], axis=1) - 1.0).max() < 1e-6
    a, b, c = np.moveaxis(mesh.points[mesh.triangles], 1, 0)
    flat = np.cross(b - a, c - a)
    assert (np.einsum("ij,ij->i", flat, a * [1, 1, 0]) > 0.0).all()
    assert np.linalg.norm(flat, axis=1).sum() / 2.0 == pytest.approx(np.pi, rel=0.01)
    assert np.einsum("ijk,ik->ij", mesh.normals, flat).min() > 0.0
    assert mesh.uvs["st"].min() == 0.0 and mesh.uvs["st"].max() == 1.0


@pytest.mark.parametrize("count", [3, 6000])
def test_points_are_balls_of_their_widths(count: int) -> None:
    widths = np.linspace(0.1, 0.3, count)
    points = [Gf.Vec3f(float(k), 0, 0) for k in range(count)]
    found = surface("Points", {"widths": "vertex"}, points=points, widths=widths.tolist())
    expected = np.pi / 6.0 * (widths**3).sum()
    assert volume(found) == pytest.approx(expected, rel=1e-4)
    assert found.mesh is not None
    assert len(found.mesh.faces) == count * (80 if count < 5000 else 20)


@pytest.mark.parametrize("said", [True, False])
def test_tetrahedra_show_their_outside(said: bool) -> None:
    more = (
        {
            "surfaceFaceVertexIndices": [
                Gf.Vec3i(*row)
                for row in ((0, 2, 1), (0, 1, 3), (0, 3, 4), (0, 4, 2), (1, 2, 3), (2, 4, 3))
            ]
        }
        if said
        else {}
    )
    found = surface(
        "TetMesh",
        points=[Gf.Vec3f(*p) for p in ((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (-1, 0, 0))],
        tetVertexIndices=[Gf.Vec4i(0, 1, 2, 3), Gf.Vec4i(0, 2, 4, 3)],
        **more,
    )
    assert volume(found) == pytest.approx(2.0 / 6.0)
    assert found.mesh is not None and len(found.mesh.faces) == 6


def test_left_handed_shapes_are_turned() -> None:
    found = curves([(0, 0, 0), (0, 0, 2)], type="linear", width=0.2, orientation="leftHanded")
    assert volume(found) == pytest.approx(-np.pi * 0.1**2 * 2.0)


@pytest.mark.parametrize(
    ("said", "reason"),
    [
        ({"points": [], "counts": []}, "do not add up"),
        ({"counts": [3, 3]}, "do not add up"),
        ({"basis": "bezier", "counts": [3, 2, 2]}, "no curve has as many points"),
        ({"basis": "hermite"}, "the basis hermite is not known"),
        ({"kind": "NurbsCurves", "order": [4], "knots": [0.0] * 11}, "range of its knots is empty"),
        ({"kind": "HermiteCurves", "tangents": []}, "tangents"),
        ({"points": [*BENT[:-1], (np.nan, 0, 0)]}, "NaN"),
    ],
)
def test_what_does_not_fit_is_skipped_with_a_reason(said: dict[str, Any], reason: str) -> None:
    if "kind" not in said:
        said = {"type": "cubic", "basis": "bspline"} | said
    found = curves(said.pop("points", BENT), said.pop("kind", "BasisCurves"), **said)
    assert found.mesh is None
    assert found.losses[0][0] == "skipped" and reason in found.losses[0][1]


def test_what_of_a_curve_is_no_whole_piece_is_cut() -> None:
    """Of five points of a Bezier curve four make a piece; two points make none."""
    found = curves(BENT, basis="bezier", counts=[5, 2])
    whole = curves(BENT[:4], basis="bezier")
    assert found.mesh is not None and whole.mesh is not None
    assert np.abs(found.mesh.points - whole.mesh.points).max() < 1e-12
    assert "surplus points are dropped" in found.losses[0][1]


def test_nurbs_without_knots_go_straight_through_their_points() -> None:
    found = curves(BENT, "NurbsCurves", order=[4], knots=[0.0] * 5)
    straight = curves(BENT, type="linear")
    assert found.mesh is not None and straight.mesh is not None
    assert np.abs(found.mesh.points - straight.mesh.points).max() < 1e-12
    assert "straight through its points" in found.losses[0][1]


def test_one_width_is_that_of_all_and_others_that_do_not_fit_their_mean() -> None:
    line: dict[str, Any] = {
        "points": [Gf.Vec3f(0, 0, 0), Gf.Vec3f(0, 0, 2)],
        "type": "linear",
        "curveVertexCounts": [2],
    }
    one = surface("BasisCurves", {"widths": "vertex"}, widths=[0.2], **line)
    assert volume(one) == pytest.approx(np.pi * 0.1**2 * 2.0)
    three = surface("BasisCurves", {"widths": "vertex"}, widths=[0.1, 0.2, 0.3], **line)
    assert volume(three) == pytest.approx(np.pi * 0.1**2 * 2.0)
    assert "their mean is used" in three.losses[0][1]


@pytest.mark.parametrize("kind", ["linear", "cubic"])
def test_a_curve_of_one_point_leaves_the_others(kind: str) -> None:
    said = {"type": kind, "basis": "bspline", "wrap": "pinned"}
    found = curves([*BENT[:4], (9, 9, 9)], counts=[4, 1], **said)
    whole = curves(BENT[:4], **said)
    assert found.mesh is not None and whole.mesh is not None
    assert np.abs(found.mesh.points - whole.mesh.points).max() < 1e-12


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


def shape(kind: str, **values: object) -> tuple[TriangleMesh, Array]:
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
