"""Directions, lobes and elements against sums over the hemisphere and their own definitions."""

import numpy as np
import pytest

from openrooms_usd.appearance.authoring import material_names, panorama_of
from openrooms_usd.appearance.curve import Curve
from openrooms_usd.appearance.directions import (
    ELEVATIONS,
    between_elevations,
    frames_about,
    lobe_values,
    smith_ratio,
    visible_normals,
)
from openrooms_usd.appearance.elements import Elements, Lookup, opened
from openrooms_usd.appearance.places import strata
from openrooms_usd.appearance.straight import slab

UP = np.array([[0.0, 0.0, 1.0]])
VIEWS = [(0.0, 0.0, 1.0), (0.6, 0.0, 0.8), (0.54, 0.72, 0.4358899)]


def hemisphere(rings: int = 400, turns: int = 800) -> tuple[np.ndarray, float]:
    """Directions that cover equal areas of the disc below the hemisphere, and that area over pi."""
    radius = np.sqrt((np.arange(rings) + 0.5) / rings)
    angle = 2.0 * np.pi * (np.arange(turns) + 0.5) / turns
    r, a = (grid.ravel() for grid in np.meshgrid(radius, angle))
    return np.stack([r * np.cos(a), r * np.sin(a), np.sqrt(1.0 - r * r)], axis=-1), 1.0 / len(r)


def sphere(count: int) -> np.ndarray:
    found = np.random.default_rng(1).normal(size=(count, 3))
    return found / np.linalg.norm(found, axis=1, keepdims=True)


def test_frames_are_right_handed_about_their_normals() -> None:
    normal = np.concatenate([sphere(50), UP, -UP])
    frames = frames_about(normal)
    assert np.allclose(frames @ frames.transpose(0, 2, 1), np.eye(3), atol=1e-12)
    assert np.allclose(np.linalg.det(frames), 1.0)
    assert np.array_equal(frames[..., 2], normal)


@pytest.mark.parametrize("view", VIEWS)
@pytest.mark.parametrize("alpha", [0.1, 0.3, 0.7])
def test_visible_normals_have_their_density(view: tuple[float, ...], alpha: float) -> None:
    """Mean half vectors against the integral of G1 max(v.h, 0) D / cos (Heitz, 2018)."""
    u = strata(np.random.default_rng(0), 1, 20000)
    drawn = visible_normals(np.tile(view, (len(u), 1)), alpha, u).mean(axis=0)
    # Slopes of normals, by alpha, are those of a sphere's: D cos is even over the disc below it.
    s, angle = np.meshgrid((np.arange(800) + 0.5) / 800, 2.0 * np.pi * np.arange(200) / 200)
    area, up, r = 2.0 * s.ravel() / s.size, s.ravel(), np.sqrt(1.0 - s.ravel() ** 2)
    half = np.stack([alpha * r * np.cos(angle.ravel()), alpha * r * np.sin(angle.ravel()), up], -1)
    half /= np.linalg.norm(half, axis=1, keepdims=True)
    weight = np.maximum(half @ view, 0.0) / half[:, 2] * area
    tangent2 = 1.0 / view[2] ** 2 - 1.0
    projected = view[2] * (1.0 + np.sqrt(1.0 + alpha**2 * tangent2)) / 2.0
    assert weight.sum() == pytest.approx(projected, rel=2e-3)
    assert drawn == pytest.approx((weight[:, None] * half).sum(axis=0) / weight.sum(), abs=4e-3)


@pytest.mark.parametrize("view", VIEWS)
@pytest.mark.parametrize("alpha", [0.1225, 0.25, 0.5625])
def test_both_ways_to_gather_a_lobe_agree_and_lose_light(
    view: tuple[float, ...], alpha: float
) -> None:
    """A white furnace: points of lights against rays by visible normals."""
    ahead, area = hemisphere()
    first, rest = lobe_values(UP, np.array([view]), ahead[None], alpha)
    by_points = np.array([first.sum(), rest.sum()]) * area
    seen = np.tile(view, (40000, 1))
    half = visible_normals(seen, alpha, strata(np.random.default_rng(2), 1, len(seen)))
    cosine = np.einsum("ni,ni->n", seen, half)
    light = 2.0 * cosine[:, None] * half - seen
    weight = np.where(light[:, 2] > 0.0, smith_ratio(seen[:, 2], light[:, 2], alpha), 0.0)
    schlick = (1.0 - cosine) ** 5
    by_rays = np.array([(weight * (1.0 - schlick)).mean(), (weight * schlick).mean()])
    assert by_points == pytest.approx(by_rays, abs=5e-3)
    assert 0.6 < by_rays.sum() <= 1.0
    if alpha < 0.2:
        assert by_rays.sum() > 0.94


def test_elevations_are_told_apart_linearly() -> None:
    ways = np.concatenate([sphere(500), UP, -UP])
    low, upper = between_elevations(ways)
    steps = np.array(ELEVATIONS)
    told = (1.0 - upper) * steps[low] + upper * steps[low + 1]
    assert told == pytest.approx(np.degrees(np.arcsin(ways[:, 2])), abs=1e-9)
    assert ((upper >= 0.0) & (upper <= 1.0)).all()


def test_the_panorama_shows_what_directions_were_told() -> None:
    sky = np.random.default_rng(0).uniform(10.0, 900.0, (len(ELEVATIONS), 3))
    rows = panorama_of(sky)[:, 0]
    elevation = np.radians(90.0 - 180.0 * (np.arange(len(rows)) + 0.5) / len(rows))
    ways = np.stack([np.cos(elevation), np.zeros(len(rows)), np.sin(elevation)], axis=-1)
    low, upper = between_elevations(ways)
    told = (1.0 - upper)[:, None] * sky[low] + upper[:, None] * sky[low + 1]
    assert rows == pytest.approx(told, rel=1e-5)


def test_a_pane_lets_through_what_its_reflections_leave() -> None:
    cosine = np.array([1.0, 0.7, 0.2])
    reflected = 0.04 + 0.96 * (1.0 - cosine) ** 5
    bounces = (1.0 - reflected) ** 2 * sum(reflected ** (2 * n) for n in range(60))
    assert slab(cosine) == pytest.approx(bounces, rel=1e-6)


@pytest.mark.parametrize("rays", [1, 20, 35, 64, 140])
def test_random_numbers_fill_every_stratum_once(rays: int) -> None:
    u = strata(np.random.default_rng(0), 3, rays).reshape(3, rays, 2)
    shapes = [(n, rays // n) for n in range(1, rays + 1) if rays % n == 0]
    filled = [
        all(len(set(map(tuple, np.floor(one * shape).astype(int)))) == rays for one in u)
        for shape in shapes
    ]
    assert any(filled)
    assert ((u >= 0.0) & (u < 1.0)).all()


@pytest.mark.parametrize("strength", [-0.2, 0.0, 0.35, 1.0])
def test_a_curve_is_undone_and_has_its_slopes(strength: float) -> None:
    curve, x, step = Curve(strength), np.linspace(0.01, 0.99, 50), 1e-6
    assert curve.linear(curve.values(x)) == pytest.approx(x, abs=2e-5)
    slope = (curve.values(x + step) - curve.values(x - step)) / (2 * step)
    assert curve.slope(x) == pytest.approx(slope, rel=1e-4)
    more = (Curve(strength + step).values(x) - curve.values(x)) / step
    assert curve.by_strength(x) == pytest.approx(more, abs=1e-5)


def points_of(part: int, low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    at = np.random.default_rng(part).uniform(low, high, (400, 3))
    return np.full(len(at), part), at


def test_elements_are_small_and_face_one_way() -> None:
    low, high = np.array([[0, 0, 0], [4, 4, 0]]), np.array([[3, 0.2, 2], [4.2, 4.3, 0.1]])
    corners = np.stack([low, high, 0.5 * (low + high)], axis=1)
    elements = Elements(np.array([0, 1]), corners)
    seen = [points_of(*one) for one in zip((0, 1), low, high, strict=True)]
    part, at = (np.concatenate(both) for both in zip(*seen, strict=True))
    normal = sphere(len(at))
    key = elements.key(part, at, normal)
    assert np.array_equal(opened(key)[0], part)
    for one in np.unique(key):
        here = key == one
        side = np.ptp(at[here], axis=0).max()
        assert side <= (0.3 if part[here][0] == 0 else 0.06) + 1e-9
        axis = np.abs(normal[here]).argmax(axis=1)
        assert len(set(axis)) == 1
        assert len(set(normal[here][:, axis[0]] > 0.0)) == 1
    lookup = Lookup(np.unique(key[::2]))
    assert np.array_equal(lookup.part[lookup(key)], part)  # also of those that are unknown
    assert np.array_equal(np.unique(key[::2])[lookup(key[::2])], key[::2])


def test_materials_of_parts_have_names_of_their_own() -> None:
    """Paths that differ by where a slash stands do not share a material."""
    paths = ["/World/a/b_c", "/World/a_b/c", "/World/a_b_c", "/Only"]
    named = material_names(paths)
    assert len(set(named.values())) == len(paths) and named["/Only"] == "Only"
    assert named == material_names(reversed(paths))
