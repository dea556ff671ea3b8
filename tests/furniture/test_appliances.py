"""Appliances and sanitary ware are hollow where they should be, and closed where not."""

import numpy as np
import pytest

from openrooms_usd.furniture import CATEGORIES, Furniture, part_of
from openrooms_usd.furniture.categories.toilet import egg
from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.geometry.raycast import RayCaster
from tests.furniture.pieces import caster, made


def _fixed(furniture: Furniture) -> RayCaster:
    """What stays where it is when doors, lids and drawers are taken away."""
    moving = {mesh for joint in furniture.joints for mesh in joint.meshes}
    return caster(*[mesh for name, mesh in furniture.parts.items() if name not in moving])


CAVITIES = [
    (name, style)
    for name in ("stove", "oven", "microwave", "refrigerator", "dishwasher", "washing_machine")
    for style in CATEGORIES[name].styles
    if (name, style) not in {("dishwasher", "drawers"), ("washing_machine", "top_loader")}
]


@pytest.mark.parametrize(("name", "style"), CAVITIES)
def test_there_is_an_inside_behind_every_door(name: str, style: str) -> None:
    furniture = made(name, style)
    rest = _fixed(furniture)
    doors = [joint for joint in furniture.joints if part_of(joint.name) == "door"]
    assert doors
    for joint in doors:
        low, high = furniture.parts[joint.meshes[0]].extent
        u = np.random.default_rng(0).uniform(0.25, 0.75, size=(200, 2))
        origins = np.stack(
            [
                low[0] + u[:, 0] * (high[0] - low[0]),
                np.full(200, low[1] - 0.1),
                low[2] + u[:, 1] * (high[2] - low[2]),
            ],
            axis=1,
        )
        reach = rest.first_hit(origins, np.tile([0.0, 1.0, 0.0], (200, 1))).distance - 0.1
        # Shelves and racks are in the way of some, the body's back stops all.
        assert np.isfinite(reach).all()
        assert np.median(reach) > 0.2
        assert np.quantile(reach, 0.9) > 0.24


def test_washing_machines_turn_their_laundry_in_a_drum() -> None:
    for style in CATEGORIES["washing_machine"].styles:
        furniture = made("washing_machine", style)
        drums = [mesh for name, mesh in furniture.parts.items() if part_of(name) == "drum"]
        assert drums
        for drum in drums:
            sides = drum.extent[1] - drum.extent[0]
            # A thin cup: far less material than what it encloses.
            assert 0 < drum.volume() < 0.15 * np.pi / 4 * np.prod(sides)


BASINS = [("sink", "basin", 0.07), ("bathtub", "container", 0.3), ("toilet", "base", 0.12)]


@pytest.mark.parametrize(("name", "part", "deep"), BASINS)
def test_basins_are_hollow(name: str, part: str, deep: float) -> None:
    for style in CATEGORIES[name].styles:
        for seed in range(3):
            furniture = made(name, style, seed)
            own = "bowl" if f"bowl_{0}" in furniture.parts else part
            for mesh in (m for n, m in furniture.parts.items() if part_of(n) == own):
                low, high = mesh.extent
                middle = _lowest_inside(mesh)
                assert high[2] - middle[2] > deep, (style, seed)
                assert middle[2] > low[2] + 0.002, (style, seed)


def _lowest_inside(mesh: Mesh) -> np.ndarray:
    """(3,) the lowest point that is seen from straight above."""
    low, high = mesh.extent
    u = (np.arange(24) + 0.5) / 24
    x, y = np.meshgrid(low[0] + u * (high[0] - low[0]), low[1] + u * (high[1] - low[1]))
    # Only the middle half: outside, one sees past the rim.
    x, y = x[8:16, 8:16].ravel(), y[8:16, 8:16].ravel()
    origins = np.stack([x, y, np.full(len(x), high[2] + 0.1)], axis=1)
    distance = caster(*[mesh]).first_hit(origins, np.tile([0.0, 0, -1], (len(x), 1))).distance
    lowest = int(np.argmax(np.where(np.isfinite(distance), distance, -1)))
    return origins[lowest] + [0, 0, -distance[lowest]]


@pytest.mark.parametrize("style", sorted(set(CATEGORIES["sink"].styles) - {"kitchen", "inset"}))
def test_water_would_fall_into_the_basin(style: str) -> None:
    for seed in range(3):
        furniture = made("sink", style, seed)
        spout = furniture.parts["spout_0"]
        tip = spout.points[spout.points[:, 1] < spout.extent[0, 1] + 0.03]
        outlet = np.array([*tip[:, :2].mean(axis=0), tip[:, 2].min() - 1e-4])
        basin = furniture.parts["basin_0"]
        hit = caster(*[basin]).first_hit(outlet[None], np.array([[0.0, 0.0, -1.0]]))
        assert hit.hit[0]
        rim = basin.extent[1, 2]
        assert outlet[2] - hit.distance[0] < rim - 0.03, seed


def test_lids_lie_on_seats_that_lie_on_the_bowl() -> None:
    for style in CATEGORIES["toilet"].styles:
        parts = made("toilet", style).parts
        base, seat, lid = (parts[f"{name}_0"].extent for name in ("base", "seat", "lid"))
        assert 0 < seat[0, 2] - base[1, 2] < 0.01
        assert 0 <= lid[0, 2] - seat[1, 2] < 0.01
        np.testing.assert_allclose(seat[:, 0], lid[:, 0], atol=1e-6)


def test_toilet_seats_have_a_hole() -> None:
    seat = made("toilet", "close_coupled").parts["seat_0"]
    middle = seat.extent.mean(axis=0)
    hit = caster(*[seat]).first_hit([[middle[0], middle[1], 2.0]], [[0.0, 0.0, -1.0]])
    assert not hit.hit[0]


def test_an_egg_is_an_ellipse_in_front() -> None:
    points = egg(0.36, 0.28, 0.2, 3.0)
    np.testing.assert_allclose(np.abs(points).max(axis=0), [0.18, 0.28])
    assert points[:, 1].max() == pytest.approx(0.2)
    front = points[points[:, 1] < -1e-9]
    shares = np.abs(front / [0.18, 0.28]) ** 2.1
    np.testing.assert_allclose(shares.sum(axis=1), 1.0)


@pytest.mark.parametrize("style", ["gas", "wide"])
def test_pots_stand_on_the_grates(style: str) -> None:
    furniture = made("stove", style)
    tops = [m.extent[1, 2] for n, m in furniture.parts.items() if part_of(n) == "grate"]
    caps = [m.extent[1, 2] for n, m in furniture.parts.items() if part_of(n) == "burner"]
    height = CATEGORIES["stove"].styles[style].size or CATEGORIES["stove"].size
    assert tops == pytest.approx([height[2]] * len(tops), abs=1e-6)
    assert max(caps) < height[2] - 0.01
