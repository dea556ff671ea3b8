"""Mouldings are closed, as large as they must be, and end where something is in their way."""

import numpy as np
import pytest
import shapely

from openrooms_usd.building.ceilings import bars
from openrooms_usd.building.claddings import cladding
from openrooms_usd.building.mouldings import EMBED_M, PROFILES, moulding, panelling, section
from openrooms_usd.building.shell import Hole
from openrooms_usd.building.wallruns import free_rings, runs
from openrooms_usd.building.walls import walls_of
from openrooms_usd.geometry.topology import is_closed

L_SHAPE = np.array([[0, 0], [5, 0], [5, 2], [2, 2], [2, 4], [0, 4.0]])


@pytest.mark.parametrize("name", PROFILES)
def test_a_moulding_is_its_section_times_the_path_of_its_centroid(name: str) -> None:
    """Pappus: at a mitre the centroid's path is the room's outline moved in by its distance."""
    ring = shapely.Polygon(section(name, 0.06, 0.1))
    assert ring.is_valid
    away = ring.centroid.x
    around = shapely.Polygon(L_SHAPE).buffer(-away, join_style="mitre").length
    closed = moulding(L_SHAPE, np.array(ring.exterior.coords)[:-1], closed=True)
    assert is_closed(closed)
    assert closed.volume() == pytest.approx(ring.area * around, rel=1e-9)
    straight = moulding(np.array([[1, 1], [1, 3.0]]), section(name, 0.06, 0.1))
    assert is_closed(straight)
    assert straight.volume() == pytest.approx(2.0 * ring.area, rel=1e-9)


def test_normals_look_out_of_a_moulding() -> None:
    mesh = moulding(L_SHAPE, section("ogee", 0.014, 0.09), closed=True)
    corners, _ = mesh.triangles()
    a, b, c = np.moveaxis(mesh.points[mesh.indices[corners]], 1, 0)
    assert mesh.normals is not None
    assert (np.einsum("ij,ij->i", np.cross(b - a, c - a), mesh.normals[corners[:, 0]]) > 0).all()


def test_texture_runs_in_metres_along_a_moulding() -> None:
    mesh = moulding(L_SHAPE, section("square", 0.014, 0.09), closed=True)
    assert mesh.st is not None
    ends = mesh.counts.cumsum()
    for stop in ends:
        rows = slice(stop - 4, stop)
        p, st = mesh.points[mesh.indices[rows]], mesh.st[rows].astype(float)
        for i in range(4):
            there = np.linalg.norm(p[i] - p[i - 1])
            assert np.linalg.norm(st[i] - st[i - 1]) == pytest.approx(there, abs=1e-5)


def test_runs_are_the_outline_without_its_gaps() -> None:
    whole = runs([L_SHAPE], [], 0.014)
    assert [run.closed for run in whole] == [True]
    assert whole[0].length == pytest.approx(18.0)
    gaps = [(np.array([1.0, 0]), np.array([1.9, 0])), (np.array([2.0, 3.9]), np.array([2.0, 2.8]))]
    found = runs([L_SHAPE], gaps, 0.014)
    # What is left of the second wall's end is too short to hold a board's mitre.
    assert not any(run.closed for run in found)
    assert sum(run.length for run in found) == pytest.approx(18.0 - 0.9 - 1.1)
    other_face = [(np.array([1.0, 0.1]), np.array([1.9, 0.1]))]
    assert sum(run.length for run in runs([L_SHAPE], other_face, 0.014)) == pytest.approx(18.0)


def test_runs_go_around_walls_that_stand_free() -> None:
    corners = np.array([[0, 0], [4, 0], [4, 3], [0, 3.0]])
    inside = np.array([[1, 1], [2, 1], [2, 1.1], [1, 1.1]])
    joined = np.array([[3, 0], [3.1, 0], [3.1, 1], [3, 1.0]])
    found = runs(free_rings(corners, [inside, joined]), [], 0.014)
    # The wall that stands by itself adds its outline, the other its two sides less its foot.
    lengths = sorted(run.length for run in found)
    assert lengths == pytest.approx([2.2, 14.0 + 2.0], abs=2e-3)
    assert all(run.closed for run in found)


@pytest.mark.parametrize("crossed", [False, True])
def test_beams_fill_what_they_cover(crossed: bool) -> None:
    mesh = bars(L_SHAPE, 2.5, spacing=1.0, width=0.1, depth=0.2, along="y", crossed=crossed)
    assert mesh is not None
    # At x = 1 (4 m long) and at 2 to 4; one at x = 2 is half in the wall beside it.
    strips = [shapely.box(x - 0.05, 0, x + 0.05, 4) for x in (1, 2, 3, 4)]
    if crossed:
        strips += [shapely.box(0, y - 0.05, 5, y + 0.05) for y in (1, 2, 3)]
    area = shapely.union_all(strips).intersection(shapely.Polygon(L_SHAPE)).area
    assert mesh.volume() == pytest.approx(area * (0.2 + EMBED_M), rel=1e-6)
    assert mesh.extent[0, 2] == pytest.approx(2.3)
    assert mesh.extent[1, 2] == pytest.approx(2.5 + EMBED_M)
    assert bars(L_SHAPE, 2.5, spacing=9, width=0.1, depth=0.2, along="y", crossed=True) is None


def test_cladding_leaves_holes_and_meets_at_corners() -> None:
    walls = walls_of(L_SHAPE, np.arange(6), 0.2)
    hole = Hole(1.0, 1.8, 0.9, 2.0)
    pieces = cladding(walls[0], (0.0, 5.0), (0.0, 2.4), 0.01, [hole], (1.0, 1.0))
    assert all(is_closed(piece) for piece in pieces)
    area = 5.0 * 2.4 - 0.8 * 1.1
    # Both mitres take a triangle of the depth squared off the front, and add one behind.
    depth, back = 0.01, EMBED_M
    mitres = 2.4 * (depth + back) * depth
    volume = sum(piece.volume() for piece in pieces)
    assert volume == pytest.approx(area * (depth + back) - mitres, rel=1e-6)
    points = np.concatenate([piece.points for piece in pieces])
    assert points[:, 1].max() == pytest.approx(depth)
    tops = sorted({round(float(z), 6) for z in points[:, 2]})
    assert tops == [0.0, 0.9, 2.0, 2.4]


def test_panels_stay_on_their_wall() -> None:
    run = runs([L_SHAPE], [], 0.012)[0]
    mesh = panelling(run, 0.9, 0.012)
    inner = shapely.Polygon(L_SHAPE).buffer(-0.015, join_style="mitre")
    outer = shapely.Polygon(L_SHAPE).buffer(0.003, join_style="mitre")
    places = shapely.points(mesh.points[:, :2])
    assert not shapely.contains_properly(inner, places).any()
    assert shapely.contains(outer, places).all()
    assert mesh.extent[:, 2] == pytest.approx([0.0, 0.9])
