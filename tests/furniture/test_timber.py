"""Grain runs along what joiners cut: legs, rails and boards along their length, doors upright."""

import numpy as np
import pytest
from numpy.typing import NDArray

from openrooms_usd.furniture import CATEGORIES, make
from openrooms_usd.geometry.grain import along_grain, charts
from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.geometry.solids import box, rounded_box
from openrooms_usd.geometry.uvquality import uv_quality
from openrooms_usd.library.assets import model_of
from openrooms_usd.library.timber import grained


def grain(mesh: Mesh) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Where t runs on each triangle, by inverting its map from the texture; and its area."""
    corners, _ = mesh.triangles()
    p, st = mesh.points[mesh.indices[corners]], mesh.st[corners].astype(np.float64)  # type: ignore[index]
    edges, flat = p[:, 1:] - p[:, :1], st[:, 1:] - st[:, :1]
    area = 0.5 * np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1)
    kept = np.abs(np.linalg.det(flat)) > 1e-14
    along = np.linalg.solve(flat[kept], edges[kept])[:, 1]
    return along / np.linalg.norm(along, axis=1, keepdims=True), area[kept]


def principal(mesh: Mesh) -> NDArray[np.float64]:
    """The axis along which a mesh is longest, by the spread of its points."""
    return np.linalg.svd(mesh.points - mesh.points.mean(axis=0))[2][0]


def share_along(mesh: Mesh, axis: NDArray[np.float64], within: float = 15.0) -> float:
    """The part of the surface whose grain runs along an axis."""
    along, area = grain(mesh)
    return float(area[np.abs(along @ axis) > np.cos(np.radians(within))].sum() / area.sum())


@pytest.mark.parametrize(
    ("category", "style", "parts"),
    [
        ("table", "four_legs", ("leg", "leg_3", "tabletop")),
        ("chair", "slat", ("leg_0", "rail_0")),
        ("coffee_table", "shelf", ("tabletop", "leg_1")),
        ("bed", "slatted", ("slat_0", "leg_0", "rail_0")),
        ("bench", "slatted", ("slat_0", "leg_0")),
        ("desk", "writing", ("leg_0", "tabletop")),
        ("bookshelf", "case", ("shelf_0",)),
    ],
)
def test_grain_runs_along_the_longest_axis(
    category: str, style: str, parts: tuple[str, ...]
) -> None:
    spec = CATEGORIES[category]
    made = make(category, spec.size, style, np.random.default_rng(0))
    laid = model_of(made).parts
    names = {name for part in parts for name in (part, f"{part}_0") if name in laid}
    assert names
    for name in names:
        assert share_along(laid[name], principal(made.parts[name])) > 0.85, name


def test_doors_are_upright_and_go_on_from_one_to_the_next() -> None:
    made = make("cabinet", CATEGORIES["cabinet"].size, "doors", np.random.default_rng(0))
    laid = grained(made.parts)
    doors = [mesh for name, mesh in sorted(laid.items()) if name.startswith("door")]
    assert len(doors) >= 2
    for mesh in doors:
        assert share_along(mesh, np.array([0.0, 0.0, 1.0])) > 0.85
    seen = []
    for mesh in doors:
        front = mesh.normals[:, 1] < -0.99  # type: ignore[index]
        place, st = mesh.points[mesh.indices[front]][:, [0, 2]], mesh.st[front]  # type: ignore[index]
        seen.append((st - place).mean(axis=0))
    assert np.allclose(seen[0], seen[1], atol=2e-3)


def test_no_two_legs_are_cut_from_the_same_place() -> None:
    made = make("table", CATEGORIES["table"].size, "four_legs", np.random.default_rng(0))
    starts = [
        mesh.st.min(axis=0)  # type: ignore[union-attr]
        for name, mesh in grained(made.parts).items()
        if name.startswith("leg")
    ]
    gaps = [np.abs(a - b).max() for i, a in enumerate(starts) for b in starts[:i]]
    assert min(gaps) > 0.05


def test_cloth_stays_as_it_was_laid() -> None:
    made = make("sofa", CATEGORIES["sofa"].size, "modern", np.random.default_rng(0))
    for name, mesh in grained(made.parts).items():
        if name.startswith("seat_cushion"):
            moved = mesh.st - made.parts[name].st  # type: ignore[operator]
            assert np.ptp(moved, axis=0).max() < 1e-5


def test_the_ends_of_boards_show_shorter_streaks() -> None:
    plank = rounded_box((1.2, 0.3, 0.03))
    cut = along_grain(plank, ends=True)
    end = np.abs(plank.normals[:, 0]) > 0.99  # type: ignore[index]
    lengths = [float(np.ptp(mesh.st[end], axis=0).max()) for mesh in (plank, cut)]  # type: ignore[index]
    assert lengths[1] == pytest.approx(4 * lengths[0], rel=1e-3)
    assert uv_quality(cut).stretch < 1.6


def test_charts_of_a_box_are_told_by_their_texture() -> None:
    plank = box((1.0, 0.3, 0.02))
    assert len(set(charts(plank).tolist())) in (3, 4, 5, 6)
    one = along_grain(plank)
    assert share_along(one, np.array([1.0, 0.0, 0.0])) > 0.9
    assert share_along(plank, np.array([1.0, 0.0, 0.0])) < 0.2  # what is mended
