"""Furniture fills its box exactly, keeps real thicknesses, and lets its light out."""

from itertools import pairwise

import numpy as np
import pytest

from openrooms_usd.arrays import Array
from openrooms_usd.errors import InputError
from openrooms_usd.furniture import (
    CATEGORIES,
    Furniture,
    Parts,
    Size,
    category,
    make,
    part_of,
    styles,
)
from openrooms_usd.furniture.joinery.pieces import fitted
from openrooms_usd.geometry.mesh import joined
from openrooms_usd.geometry.solids import box
from openrooms_usd.geometry.topology import is_closed
from tests.furniture.pieces import STYLES, caster, piece, planned, usual

LAMPS = [(name, style) for name, style in STYLES if category(name).emits]
# The shell of a chair is cut in two along a seam: seat and back are open there.
OPEN = {("chair", "shell", "seat"), ("chair", "shell", "back")}


def _rng(seed: int = 0) -> np.random.Generator:
    return np.random.default_rng(seed)


def _extent(parts: Parts) -> np.ndarray:
    return joined(list(parts.values())).extent


@pytest.mark.one_in(2, rest="long")
@pytest.mark.parametrize(("name", "style"), STYLES)
@pytest.mark.parametrize(
    "factor",
    [
        pytest.param((1, 1, 1), marks=pytest.mark.long),
        (1.3, 0.8, 1.1),
        pytest.param((0.02, 9, 3), marks=pytest.mark.long),
    ],
)
def test_fills_the_box_exactly(name: str, style: str, factor: Size) -> None:
    size = np.array(usual(name, style)) * factor
    width, depth, height = np.clip(size, 0.02, 20.0).tolist()
    extent = _extent(make(name, (width, depth, height), style, _rng()).parts)
    expected = [[-0.5 * width, -0.5 * depth, 0.0], [0.5 * width, 0.5 * depth, height]]
    np.testing.assert_allclose(extent, expected, atol=1e-9)


@pytest.mark.one_in(3, rest="long")
@pytest.mark.parametrize(("name", "style"), STYLES)
def test_is_planned_for_its_box(name: str, style: str) -> None:
    # What the last stretch corrects is small, so boards and legs keep their thickness.
    size, made = usual(name, style), planned(name, style)
    if (name, style) == ("table", "disc"):
        size = (0.5, 0.5, 0.5)
        made = Furniture(category(name).styles[style].build(size, _rng()))
    extent = _extent(made.parts)
    assert np.abs(np.array(size) / (extent[1] - extent[0]) - 1).max() < 0.04


@pytest.mark.parametrize(("name", "style"), STYLES)
@pytest.mark.parametrize(
    "seed", [0, *(pytest.param(seed, marks=pytest.mark.long) for seed in (1, 2))]
)
def test_meshes_are_sound(name: str, style: str, seed: int) -> None:
    size = usual(name, style)
    made = make(name, size, style, _rng(seed)) if seed else piece(name, style)
    parts, triangles = made.parts, 0
    for part, mesh in parts.items():
        triangles += int((mesh.counts - 2).sum())
        assert mesh.areas().min() > 0
        assert np.abs(np.linalg.norm(mesh.normals, axis=1) - 1).max() < 1e-5
        assert np.isfinite(mesh.st).all()
        if (name, style, part) not in OPEN:
            assert is_closed(mesh), part
            assert mesh.volume() > 0, part
    assert 40 < triangles < 12_000


@pytest.mark.one_in(8, rest="long")
@pytest.mark.parametrize(("name", "style"), STYLES)
def test_follows_from_its_seed(name: str, style: str) -> None:
    first, second = (make(name, usual(name, style), style, _rng(7)).parts for _ in range(2))
    assert first.keys() == second.keys()
    for part, mesh in first.items():
        assert mesh.points.tobytes() == second[part].points.tobytes()
        assert mesh.st.tobytes() == second[part].st.tobytes()


def test_what_was_built_elsewhere_is_brought_to_the_origin() -> None:
    parts = fitted(
        {"seat": box((1, 1, 1), (5, 6, 7)), "leg": box((1, 1, 1), (5, 6, 6))}, (2, 3, 4)
    ).parts
    np.testing.assert_allclose(_extent(parts), [[-1, -1.5, 0], [1, 1.5, 4]])
    assert parts["leg"].extent[1, 2] == pytest.approx(2)


def test_chairs_are_sat_on_at_45_cm() -> None:
    for height in (0.75, 0.9, 1.1):
        seat = make("chair", (0.45, 0.5, height), "slat", _rng()).parts["seat"]
        assert seat.extent[1, 2] == pytest.approx(0.45, abs=0.005)


def test_legs_keep_their_thickness() -> None:
    def leg(size: Size) -> np.ndarray:
        mesh = make("table", size, "four_legs", _rng()).parts["leg_0"]
        return (mesh.extent[1] - mesh.extent[0])[:2]

    np.testing.assert_allclose(leg((1.4, 0.6, 0.7)), leg((1.4, 1.2, 0.8)), atol=5e-4)


def test_wide_cabinets_get_more_doors() -> None:
    def doors(width: float) -> int:
        parts = make("cabinet", (width, 0.4, 0.8), "doors", _rng()).parts
        return sum(part_of(name) == "door" for name in parts)

    assert doors(0.45) == 1
    assert doors(0.9) == 2
    assert doors(2.7) == 6


def test_doors_and_drawers_have_gaps_between_them() -> None:
    parts = make("cabinet", (0.9, 0.42, 0.9), "drawers", _rng()).parts
    fronts = sorted(
        (mesh.extent[:, 2] for name, mesh in parts.items() if part_of(name) == "drawer_front"),
        key=lambda span: span[0],
    )
    gaps = [above[0] - below[1] for below, above in pairwise(fronts)]
    assert gaps == pytest.approx([0.003] * len(gaps), abs=1e-6)


def freed(parts: Parts) -> Array:
    """(3,) the share of a bulb's light that passes all other parts: downwards, level, upwards."""
    parts = dict(parts)
    bulb = parts.pop("light_bulb")
    a, b, c = np.moveaxis(bulb.points[bulb.indices[bulb.triangles()[0]]], 1, 0)
    normal = np.cross(b - a, c - a)
    area = np.linalg.norm(normal, axis=1)
    rng = _rng(1)
    face = rng.choice(len(area), size=1500, p=area / area.sum())
    u = rng.dirichlet((1, 1, 1), size=len(face))
    origins = u[:, :1] * a[face] + u[:, 1:2] * b[face] + u[:, 2:] * c[face]
    normal = normal[face] / area[face][:, None]
    # Lambertian: normal plus a point on the unit sphere.
    sphere = rng.normal(size=normal.shape)
    ways = normal + sphere / np.linalg.norm(sphere, axis=1, keepdims=True)
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    # Past itself too: bulbs are convex, so only other parts block.
    free = np.isinf(caster(*parts.values()).first_hit(origins + 1e-4 * normal, ways).distance)
    # Within 60 degrees of the vertical, and else.
    bands = [ways[:, 2] < -0.5, np.abs(ways[:, 2]) <= 0.5, ways[:, 2] > 0.5]
    return np.array([free[band].mean() for band in bands])


# At least and at most, of what is sent downwards, level and upwards.
OPEN_ROUND = ((0.6, 0.8, 0.6), (1.0, 1.0, 1.0))
OPEN_ENDS = ((0.08, 0.0, 0.65), (1.0, 0.4, 1.0))
OPEN_BELOW = ((0.65, 0.0, 0.0), (1.0, 0.7, 0.02))
OPEN_ABOVE = ((0.0, 0.0, 0.65), (0.02, 0.4, 1.0))
LEAVES = {
    **dict.fromkeys(("globe", "chandelier", "cluster"), OPEN_ROUND),
    **dict.fromkeys(("drum", "tripod", "urn", "stick", "sconce", "swing"), OPEN_ENDS),
    **dict.fromkeys(("pendant", "flush", "spots", "arc", "task"), OPEN_BELOW),
    "uplight": OPEN_ABOVE,
}


@pytest.mark.parametrize(("name", "style"), LAMPS)
def test_light_leaves_the_lamp_where_its_style_is_open(name: str, style: str) -> None:
    """Shades that are closed, and bulbs that stand out of them, are seen at once."""
    found = freed(make(name, usual(name, style), style, _rng()).parts)
    least, most = LEAVES[style]
    assert (found >= least).all() and (found <= most).all(), found


def test_every_category_has_styles_that_suit_their_own_size() -> None:
    for name, spec in CATEGORIES.items():
        assert spec.styles, name
        assert any(style.suits(spec.size) for style in spec.styles.values()), name
        # A style without a size of its own may be for larger or smaller boxes alone.
        for title, style in spec.styles.items():
            assert style.size is None or style.suits(style.size), (name, title)
        assert (spec.lumen > 0) == spec.emits


def test_styles_suit_the_size() -> None:
    assert styles("chair", (0.8, 0.8, 0.8)) == ("armchair",)
    assert "armchair" not in styles("chair", (0.45, 0.5, 0.8))
    assert styles("sofa", (2.6, 1.6, 0.8)) == ("chaise",)


@pytest.mark.parametrize(
    ("name", "style", "size", "said"),
    [
        ("chiar", "slat", (1, 1, 1), "did you mean 'chair'"),
        ("chair", "slats", (1, 1, 1), "did you mean 'slat'"),
        ("chair", "slat", (1e9, 1, 1), "between 0.004 m and 20 m"),
        ("chair", "slat", (float("nan"), 1, 1), "between 0.004 m and 20 m"),
    ],
)
def test_refuses_what_it_cannot_build(name: str, style: str, size: Size, said: str) -> None:
    with pytest.raises(InputError) as caught:
        make(name, size, style, _rng())
    assert said in str(caught.value)


@pytest.mark.parametrize("seed", range(4))
def test_cords_of_a_cluster_leave_the_rose_on_the_side_of_their_globe(seed: int) -> None:
    parts = make("ceiling_lamp", (0.9, 0.9, 0.9), "cluster", _rng(seed)).parts
    for cord in np.split(parts["lamp_pole"].points, 3):
        above = cord[cord[:, 2] > cord[:, 2].max() - 0.005, :2].mean(axis=0)
        below = cord[cord[:, 2] < cord[:, 2].min() + 0.005, :2].mean(axis=0)
        assert (above * below >= -1e-6).all()
