"""What things weigh: every category of the library beside products that one can buy."""

from functools import cache

import numpy as np
import pytest
import trimesh
from numpy.typing import NDArray

from openrooms_usd.furniture import CATEGORIES, part_of
from openrooms_usd.furniture.construction import ANY, GENERAL
from openrooms_usd.furniture.registry import records
from openrooms_usd.geometry.triangulation import triangulate
from openrooms_usd.library.assignment.kinds import kind_of
from openrooms_usd.library.construction import (
    construction_of,
    density_of,
    joint_damping_of,
    mass_of_part,
    movable,
)
from openrooms_usd.library.finishes import FINISHES, finishes_of
from openrooms_usd.library.friction.references import SUBSTANCES
from openrooms_usd.physics.mass import MassProperties, combined
from tests.furniture.pieces import piece

Array = NDArray[np.float64]


def mass_range(category: str, style: str | None = None) -> tuple[float, float] | None:
    """What such products weigh, as the record says; None for what nobody weighs."""
    known = CATEGORIES[category]
    return known.mass_range_of(style) if style else known.mass_range


@cache
def meshes(category: str, style: str) -> dict[str, tuple[Array, Array]]:
    parts = piece(category, style).parts
    return {
        name: (mesh.points, mesh.indices[triangulate(mesh.points, mesh.counts, mesh.indices)[0]])
        for name, mesh in parts.items()
    }


@cache
def weighed(category: str, style: str, part: str, finish: str) -> MassProperties:
    substance = FINISHES[finish].substance
    return mass_of_part(category, part, substance, *meshes(category, style)[part])


@cache
def built(category: str, style: str, seed: int) -> MassProperties:
    parts = meshes(category, style)
    kinds = {part_of(name) for name in parts}
    finishes = finishes_of(category, kinds, np.random.default_rng(seed))
    return combined([weighed(category, style, name, finishes[part_of(name)]) for name in parts])


@pytest.mark.one_in(51)
@pytest.mark.parametrize("category", sorted(name for name in CATEGORIES if mass_range(name)))
def test_things_weigh_what_such_things_weigh(category):
    for style in CATEGORIES[category].styles:
        low, high = mass_range(category, style)
        for seed in range(2):
            mass = built(category, style, seed).mass
            assert low <= mass <= high, f"{category}/{style}: {mass:.2f} kg"


@pytest.mark.one_in(3)
@pytest.mark.parametrize("category", sorted(CATEGORIES))
def test_everything_in_the_library_can_be_a_rigid_body(category):
    for style in CATEGORIES[category].styles:
        found = built(category, style, 0).checked(f"{category}/{style}")
        width, depth, height = CATEGORIES[category].styles[style].size or CATEGORIES[category].size
        assert abs(found.centre[0]) < width / 2 and abs(found.centre[1]) < depth / 2
        assert 0 < found.centre[2] < height


def test_lamps_do_not_fall_by_themselves():
    for style in CATEGORIES["floor_lamp"].styles:
        centre = built("floor_lamp", style, 0).centre
        assert centre[2] < 0.6 * CATEGORIES["floor_lamp"].size[2]


def test_a_model_that_names_no_parts_weighs_as_much_as_the_thing():
    for category, substance, size, (low, high) in [
        ("refrigerator", "metal", (0.7, 0.7, 1.8), mass_range("refrigerator")),
        ("washing_machine", "metal", (0.6, 0.6, 0.86), mass_range("washing_machine")),
        ("microwave", "paint", (0.5, 0.4, 0.29), mass_range("microwave")),
        ("wardrobe", "wood", (1.5, 0.6, 2.1), mass_range("wardrobe")),
        ("wardrobe", None, (1.5, 0.6, 2.1), mass_range("wardrobe")),
        ("file_cabinet", "metal", (0.46, 0.6, 1.3), mass_range("file_cabinet")),
        ("chair", "fabric", (0.45, 0.45, 0.45), mass_range("chair")),
        ("office_chair", "leather", (0.5, 0.5, 0.4), mass_range("office_chair")),
        ("anything", "wood", (0.5, 0.5, 0.5), (5, 20)),
        ("anything", "metal", (0.3, 0.3, 0.3), (3, 10)),
    ]:
        box = trimesh.creation.box(size)
        found = mass_of_part(category, "Cube.001", substance, box.vertices, box.faces)
        assert low <= found.mass <= high, f"{category} of {substance}: {found.mass:.1f} kg"


def test_an_open_model_weighs_as_sheets():
    box = trimesh.creation.box((0.5, 0.5, 0.02))
    faces = box.faces[box.face_normals[:, 2] > 0.5]
    for substance in SUBSTANCES:
        mass = mass_of_part("table", "leg", substance, box.vertices, faces).checked().mass
        assert 0.1 < mass < 15


@pytest.mark.parametrize("substance", [*SUBSTANCES, None])
def test_any_part_of_anything_is_made_somehow(substance):
    for category in (*CATEGORIES, "spaceship", ""):
        for part in ("leg", "Leg_12", "engine", "", "部品"):
            made = construction_of(category, part, substance)
            assert made.wall > 0 and (made.density or density_of(substance)) > 0


def test_names_of_other_spelling_are_known():
    assert construction_of("Office Chair", "Seat_Cushion.001", "fabric").density == 150
    assert construction_of("bed", "bed_mattress_2", "fabric").density == 60


def test_a_leg_of_wood_is_solid_and_one_of_steel_is_a_tube():
    leg = trimesh.creation.cylinder(0.02, 0.7)
    wood, steel = (
        mass_of_part("table", "leg_0", what, leg.vertices, leg.faces) for what in ("wood", "metal")
    )
    assert wood.mass == pytest.approx(550 * leg.volume)
    assert steel.mass == pytest.approx(7850 * 0.0015 * np.pi * 0.0385 * 0.7, rel=0.03)


def test_the_rows_are_written_in_our_spelling_and_every_one_can_be_reached():
    tables = {name: told.construction for name, told in records()} | {"anything": GENERAL}
    for category, rows in tables.items():
        assert category == kind_of(category), category
        for row in rows:
            for name in row.parts:
                assert name == ANY or name == kind_of(name), name
            assert row.reason in {"board", "foam", "sheet", "china", "weight", "common"}
            found = {
                id(construction_of(category, part, substance))
                for part in row.parts
                for substance in (*SUBSTANCES, None)
                if not row.substances or substance in row.substances
            }
            assert id(row.construction) in found, (category, row)


def test_what_is_built_in_stays_where_it_is():
    fixed = {name for name, told in records() if told.fixed}
    assert not {name for name in fixed if movable(name)}
    assert fixed & set(CATEGORIES) == {
        "air_conditioner", "backsplash", "bathtub", "ceiling_lamp", "ceiling_rose", "counter",
        "curtain", "data_outlet", "dishwasher", "door", "faucet", "fireplace", "hob", "hood",
        "kitchen_cabinet", "kitchen_unit", "light_switch", "oven", "radiator", "shower",
        "shower_screen", "sink", "smoke_detector", "socket", "stairs", "stove", "thermostat",
        "toilet", "toilet_paper_holder", "towel_rail", "wall_lamp", "wall_shelf", "wall_vent",
        "window", "worktop",
    }  # fmt: skip
    assert movable("chair") and movable("Office Chair", "floor") and movable("bowl", "surface")
    assert not movable("picture", "wall") and not movable("lamp", "ceiling")
    assert movable("clock", "surface") and not movable("clock", "wall")


def test_joints_take_a_hand_and_not_a_crowbar():
    widths = {"door": 0.8, "refrigerator": 0.6, "oven": 0.45, "stove": 0.45, "dishwasher": 0.6}
    for category in CATEGORIES:
        assert joint_damping_of(category, "rail").friction < 22
        # At the handle, one hinge away.
        assert joint_damping_of(category, "hinge").friction / widths.get(category, 0.2) < 22
        assert joint_damping_of(category, "hinge").damping > 0
