"""What mesh prims say of their subdivision is what is drawn."""

from collections.abc import Callable

import numpy as np
import pytest
from pxr import Sdf, Usd, UsdGeom, Vt
from scipy.interpolate import BSpline

from openrooms_usd.arrays import Array
from openrooms_usd.usd.shapes.gprims import GprimSurface, read_surface
from openrooms_usd.usd.shapes.subdivided import Topologies

# Four squares about the origin, seen from above.
POINTS = [(i, j, 0.0) for j in (-1, 0, 1) for i in (-1, 0, 1)]
FACES = [0, 1, 4, 3, 1, 2, 5, 4, 3, 4, 7, 6, 4, 5, 8, 7]


def surface(change: Callable[[UsdGeom.Mesh], object] = lambda mesh: None) -> GprimSurface:
    stage = Usd.Stage.CreateInMemory()
    mesh = UsdGeom.Mesh.Define(stage, "/mesh")
    mesh.CreatePointsAttr(POINTS)
    mesh.CreateFaceVertexCountsAttr([4, 4, 4, 4])
    mesh.CreateFaceVertexIndicesAttr(FACES)
    change(mesh)
    return read_surface(mesh.GetPrim())


def area(found: GprimSurface) -> Array:
    assert found.mesh is not None
    a, b, c = np.moveaxis(found.mesh.points[found.mesh.triangles], 1, 0)
    return np.asarray(0.5 * np.cross(b - a, c - a).sum(axis=0))


def test_boundaries_are_rounded_kept_or_left_out() -> None:
    def bounded(rule: str) -> Array:
        return area(surface(lambda mesh: mesh.CreateInterpolateBoundaryAttr(rule)))

    assert bounded("edgeAndCorner")[2] == pytest.approx(4.0)
    # The area that a closed cubic B-spline about the square's eight points goes around.
    knots = np.arange(-3.0, 12.0)
    ring = np.array([POINTS[row][:2] for row in (0, 1, 2, 5, 8, 7, 6, 3)], float)
    curve = BSpline(knots, np.vstack([ring, ring[:3]]), 3)
    corner = curve(np.linspace(0.0, 8.0, 33)[:-1])
    after = np.roll(corner, -1, axis=0)
    expected = 0.5 * float((corner[:, 0] * after[:, 1] - corner[:, 1] * after[:, 0]).sum())
    assert bounded("edgeOnly")[2] == pytest.approx(expected, rel=1e-6)
    found = surface(lambda mesh: mesh.CreateInterpolateBoundaryAttr("none"))
    assert found.mesh is None and found.losses[-1] == ("skipped", "no face has an area")


def test_left_handed_faces_are_seen_from_below() -> None:
    def turn(mesh: UsdGeom.Mesh) -> None:
        mesh.CreateOrientationAttr("leftHanded")

    assert area(surface(turn))[2] == pytest.approx(-4.0)
    mesh = surface(turn).mesh
    assert mesh is not None and mesh.normals is not None
    assert np.abs(mesh.normals - [0.0, 0.0, -1.0]).max() < 1e-6


def test_holes_stay_open_and_uniform_values_stay_with_their_face() -> None:
    def change(mesh: UsdGeom.Mesh) -> None:
        mesh.CreateHoleIndicesAttr([1])
        primvars = UsdGeom.PrimvarsAPI(mesh)
        st = primvars.CreatePrimvar("st", Sdf.ValueTypeNames.TexCoord2fArray, "uniform")
        st.Set(Vt.Vec2fArray([(k, 2 * k) for k in range(4)]))

    found = surface(change)
    assert found.mesh is not None
    assert set(found.mesh.faces.tolist()) == {0, 2, 3}
    assert (found.mesh.uvs["st"][..., 0] == found.mesh.faces[:, None]).all()
    assert area(found)[2] == pytest.approx(3.0)


@pytest.mark.parametrize("interpolation", ["vertex", "varying", "faceVarying"])
@pytest.mark.parametrize("scheme", ["catmullClark", "bilinear"])
def test_coordinates_that_follow_the_points_follow_the_surface(
    interpolation: str, scheme: str
) -> None:
    """Coordinates that are the points' own x and y stay so, but for the linear ones."""

    def change(mesh: UsdGeom.Mesh) -> None:
        mesh.CreateSubdivisionSchemeAttr(scheme)
        primvars = UsdGeom.PrimvarsAPI(mesh)
        st = primvars.CreatePrimvar("st", Sdf.ValueTypeNames.TexCoord2fArray, interpolation)
        rows = FACES if interpolation == "faceVarying" else range(9)
        st.Set(Vt.Vec2fArray([POINTS[row][:2] for row in rows]))

    mesh = surface(change).mesh
    assert mesh is not None
    assert np.abs(mesh.uvs["st"] - mesh.points[mesh.triangles][..., :2]).max() < 1e-6


def test_creases_of_two_lengths_are_those_of_their_edges() -> None:
    """A crease along the middle lifts up: what is sharp stays where it is."""

    def lifted(sharpness: list[float]) -> float:
        def change(mesh: UsdGeom.Mesh) -> None:
            mesh.GetPointsAttr().Set([(x, y, 1.0 - abs(y)) for x, y, _ in POINTS])
            mesh.CreateCreaseIndicesAttr([3, 4, 5])
            mesh.CreateCreaseLengthsAttr([3])
            mesh.CreateCreaseSharpnessesAttr(sharpness)

        mesh = surface(change).mesh
        assert mesh is not None
        return float(mesh.points[:, 2].max())

    assert lifted([10.0]) == lifted([10.0, 10.0]) == pytest.approx(1.0)
    # One for each edge, of which one is smooth; and a number of them that fits nothing.
    assert lifted([0.0, 0.0]) == lifted([1.0, 2.0, 3.0]) < 1.0


def test_what_loop_cannot_refine_is_drawn_as_it_is() -> None:
    found = surface(lambda mesh: mesh.CreateSubdivisionSchemeAttr("loop"))
    assert found.mesh is not None and len(found.mesh.faces) == 8
    assert "loop refines only triangles" in found.losses[0][1]


def test_equal_topologies_are_refined_once_and_give_the_same() -> None:
    stage = Usd.Stage.CreateInMemory()
    prims = []
    for number in range(3):
        mesh = UsdGeom.Mesh.Define(stage, f"/m{number}")
        points = np.random.default_rng(number).uniform(-1.0, 1.0, (8, 3))
        mesh.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(points.astype(np.float32)))
        mesh.CreateFaceVertexCountsAttr([4] * 6)
        mesh.CreateFaceVertexIndicesAttr(
            [0, 1, 3, 2, 2, 3, 5, 4, 4, 5, 7, 6, 6, 7, 1, 0, 1, 7, 5, 3, 6, 0, 2, 4]
        )
        if number == 2:
            # Another surface of the same faces.
            mesh.CreateCornerIndicesAttr([0])
            mesh.CreateCornerSharpnessesAttr([10.0])
        prims.append(mesh.GetPrim())
    known = Topologies()
    shared = [read_surface(prim, topologies=known).mesh for prim in prims]
    alone = [read_surface(prim).mesh for prim in prims]
    assert len(known._known) == 2
    for one, other in zip(shared, alone, strict=True):
        assert one is not None and other is not None
        assert np.array_equal(one.points, other.points)
        assert np.array_equal(one.normals, other.normals)


def test_a_bilinear_cube_has_flat_sides() -> None:
    stage = Usd.Stage.CreateInMemory()
    mesh = UsdGeom.Mesh.Define(stage, "/cube")
    points = [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]
    mesh.CreatePointsAttr(points)
    mesh.CreateFaceVertexCountsAttr([4] * 6)
    mesh.CreateFaceVertexIndicesAttr(
        [0, 1, 3, 2, 4, 6, 7, 5, 0, 4, 5, 1, 2, 3, 7, 6, 0, 2, 6, 4, 1, 5, 7, 3]
    )
    mesh.CreateSubdivisionSchemeAttr("bilinear")
    found = read_surface(mesh.GetPrim()).mesh
    assert found is not None and found.normals is None
    corners = found.points[found.triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert np.sort(np.abs(normals), axis=1)[:, :2].max() < 1e-12
