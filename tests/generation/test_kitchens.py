"""Kitchens are built: equal heights, one worktop line, what is let in hangs in its hole."""

from functools import cache
from itertools import pairwise

import numpy as np
import pytest
import shapely

from openrooms_usd.errors import InputError
from openrooms_usd.furniture import CATEGORIES, FitOptions, make
from openrooms_usd.furniture.categories.worktop import plate
from openrooms_usd.furniture.registry import records
from openrooms_usd.generation import generate
from openrooms_usd.generation.groups.kitchen import BASE_M, LEVEL_M, WALL_LOW_M
from openrooms_usd.generation.items import Item
from openrooms_usd.geometry.topology import is_closed
from openrooms_usd.library.styles.finishes import finishes_of, suite_of

SEEDS = range(8)
RNG = np.random.default_rng


@cache
def kitchen(seed: int) -> dict[str, Item]:
    groups = generate("kitchen", seed).furnishing.groups
    return {item.key: item for title, items in groups if title == "kitchen" for item in items}


def of(seed: int, *names: str) -> list[Item]:
    return [item for item in kitchen(seed).values() if item.category in names]


def along(items: list[Item]) -> list[tuple[float, float]]:
    """Where items of one leg begin and end along it, in order."""
    yaw = np.radians(items[0].yaw)
    middles = [item.x * np.cos(yaw) + item.y * np.sin(yaw) for item in items]
    return sorted(
        (x - 0.5 * item.size[0], x + 0.5 * item.size[0])
        for x, item in zip(middles, items, strict=True)
    )


@pytest.mark.parametrize("seed", SEEDS)
def test_all_units_are_of_one_height_below_one_level_worktop(seed: int) -> None:
    tops = of(seed, "worktop")
    assert tops
    for top in tops:
        assert top.z == BASE_M and top.z + top.size[2] == pytest.approx(LEVEL_M)
    assert len({top.size[1] for top in tops}) == 1
    low = [item for item in of(seed, "kitchen_unit", "dishwasher") if item.size[2] < 1.2]
    ovens = {oven.on for oven in of(seed, "oven")}
    assert {item.size[2] for item in low if item.key not in ovens} == {BASE_M}
    for oven in of(seed, "oven"):
        assert oven.z + oven.size[2] == pytest.approx(BASE_M)


@pytest.mark.parametrize("seed", SEEDS)
def test_fronts_and_edges_are_alike_throughout(seed: int) -> None:
    fronts = {item.order.fronts for item in kitchen(seed).values() if item.order.fronts}
    assert len(fronts) == 1
    cabinets = of(seed, "kitchen_cabinet")
    assert len({round(item.z + item.size[2], 3) for item in cabinets}) <= 1
    over_hoods = {round(hood.z + hood.size[2] + 0.001, 3) for hood in of(seed, "hood")}
    assert {item.z for item in cabinets} <= {WALL_LOW_M, *over_hoods}


@pytest.mark.parametrize("seed", SEEDS)
def test_units_of_a_leg_stand_seam_to_seam(seed: int) -> None:
    floor = [item for item in kitchen(seed).values() if item.on == "floor"]
    for yaw in {item.yaw for item in floor}:
        spans = along([item for item in floor if item.yaw == yaw])
        gaps = [b - a for (_, a), (b, _) in pairwise(spans)]
        assert all(-1e-6 <= gap <= 0.013 for gap in gaps), gaps


@pytest.mark.parametrize("seed", SEEDS)
def test_what_is_let_in_hangs_in_its_hole_by_its_rim(seed: int) -> None:
    things = of(seed, "sink", "hob")
    assert things
    for thing in things:
        top = kitchen(seed)[thing.on]
        x, y = (thing.x - top.x, thing.y - top.y)
        c, s = np.cos(np.radians(top.yaw)), np.sin(np.radians(top.yaw))
        middle = np.array([c * x + s * y, c * y - s * x])
        holes = np.array(top.order.cutouts)
        hole = holes[np.argmin(np.abs(holes[:, :2] - middle).sum(axis=1))]
        assert middle == pytest.approx(hole[:2], abs=2e-3)
        parts = make(thing.category, thing.size, thing.style, RNG(0)).parts
        points = np.concatenate([mesh.points for mesh in parts.values()])
        level = top.z + top.size[2] - thing.z
        below = np.abs(points[points[:, 2] < level - 1e-4, :2])
        assert (below <= 0.5 * hole[2:] - 0.002).all(), "it goes through the slab"
        rim = np.abs(points[np.abs(points[:, 2] - level) < 1e-3, :2]).max(axis=0)
        assert (rim >= 0.5 * hole[2:] + 0.01).all(), "it falls through the hole"
        assert (np.abs(hole[:2]) + 0.5 * hole[2:] < 0.5 * np.array(top.size[:2]) - 0.02).all()


def test_a_slab_with_holes_is_closed_and_has_the_area_that_is_left() -> None:
    holes = [(-0.5, 0.02, 0.5, 0.4), (0.6, -0.01, 0.55, 0.48)]
    mesh = plate((2.4, 0.63, 0.038), holes)
    left = shapely.box(-1.2, -0.315, 1.2, 0.315)
    for x, y, w, d in holes:
        left -= shapely.box(x - w / 2, y - d / 2, x + w / 2, y + d / 2)
    assert is_closed(mesh)
    # The bevels take a triangle of 2 mm along the outer edge.
    assert mesh.volume() == pytest.approx(left.area * 0.038 - 0.5 * 0.002**2 * 6.06, rel=1e-3)
    corners, _ = mesh.triangles()
    plan = mesh.points[mesh.indices[corners]].mean(axis=1)
    assert all(left.buffer(1e-9).covers(shapely.Point(*at)) for at in plan[:, :2])


def test_orders_are_refused_where_there_is_nothing_to_choose() -> None:
    with pytest.raises(InputError, match="a chair of the style slat has no fronts to choose"):
        make("chair", (0.45, 0.5, 0.9), "slat", RNG(0), FitOptions(fronts="slab"))
    with pytest.raises(InputError, match="no cutouts to choose"):
        make(
            "kitchen_unit",
            (0.6, 0.6, 0.87),
            "doors",
            RNG(0),
            FitOptions(cutouts=((0, 0, 0.1, 0.1),)),
        )


def test_a_suite_has_one_finish_on_the_fronts_of_all_its_categories() -> None:
    members = ("kitchen_unit", "kitchen_cabinet", "dishwasher", "refrigerator")
    parts = ("door", "handle", "kickboard")
    assert {suite_of(name, parts) for name in members} == {"kitchen"}
    assert suite_of("refrigerator", ("door", "handle")) == ""
    for seed in range(12):
        worn = {tuple(finishes_of(name, parts, RNG(seed)).items()) for name in members}
        assert len(worn) == 1
    suites = {scheme.suite for _, known in records() for scheme in known.schemes}
    assert suites >= {"", "kitchen"}


@pytest.mark.parametrize("fronts", ["slab", "shaker", "handleless"])
def test_what_is_ordered_is_built(fronts: str) -> None:
    for name in ("kitchen_unit", "kitchen_cabinet", "dishwasher", "refrigerator"):
        for style, made in CATEGORIES[name].styles.items():
            if "fronts" in made.takes:
                size = made.size or CATEGORIES[name].size
                parts = make(name, size, style, RNG(3), FitOptions(fronts=fronts)).parts
                handles = [part for part in parts if part.startswith("handle")]
                assert bool(handles) == (fronts != "handleless"), (name, style)
