"""What things weigh: every category of the library beside products that one can buy."""

from functools import cache

import numpy as np
import pytest
import trimesh
from numpy.typing import NDArray

from openrooms_usd.geometry.triangulation import triangulate
from openrooms_usd.library.assignment.kinds import kind_of
from openrooms_usd.library.construction import (
    FIXED,
    construction_of,
    density_of,
    losses,
    mass_of_part,
    movable,
)
from openrooms_usd.library.finishes import FINISHES, finishes_of
from openrooms_usd.library.friction.references import SUBSTANCES
from openrooms_usd.library.furniture import CATEGORIES, make, part_of
from openrooms_usd.library.makes import ANY, ROWS
from openrooms_usd.physics.mass import MassProperties, combined

Array = NDArray[np.float64]

# Kilograms of products of such sizes, lightest and heaviest, as their makers ship them; a style
# after the slash where it is another kind of thing. Chairs are of wood or with thin cushions, a
# wing chair has a beech frame; a bed is with its mattress (30 to 40 kg) and bedding, shelves are
# with their books (a metre of books has 20 to 25 kg); storage of 16 mm boards has 10 to 13 kg for
# each square metre of front; a cabinet of files is of sheet steel; an oven has 25 to 40 kg for each
# cavity; a slate bed alone is 200 kg; a pot is with soil.
RANGES = {
    "armchair": (7, 35), "basket": (0.4, 3), "bathtub": (20, 60), "bed": (55, 150),
    "bench": (4, 35), "bookshelf": (40, 140), "bottle": (0.15, 0.9), "bowl": (0.3, 3),
    "box": (1, 10), "cabinet": (20, 60), "ceiling_lamp": (0.7, 8), "chair": (2.3, 10),
    "clock": (0.3, 3.5), "coffee_table": (9, 50), "curtain": (1.2, 12), "desk": (14, 75),
    "dishwasher": (30, 55), "dresser": (35, 95), "faucet": (0.5, 3), "file_cabinet": (15, 60),
    "floor_lamp": (2.5, 9), "floor_lamp/arc": (12, 35), "jar": (0.2, 2), "keyboard": (0.2, 1.2),
    "kitchen_cabinet": (12, 35), "laptop": (1, 3.5), "microwave": (9, 25), "monitor": (3, 8),
    "monitor/tube": (12, 32), "office_chair": (8, 22), "oven": (22, 45), "oven/double": (40, 75),
    "picture": (0.8, 5), "pillow": (0.3, 1.5), "plant_pot": (0.5, 60), "pool_table": (280, 450),
    "printer": (4, 18), "printer/copier": (35, 90), "refrigerator": (50, 130),
    "refrigerator/single": (20, 60), "rug": (3, 12), "side_table": (1.5, 16), "sofa": (30, 90),
    "speaker": (3, 10), "speaker/tower": (12, 35), "speaker/bar": (1.2, 5),
    "speaker/wrapped": (0.3, 5), "stool": (2, 9), "stove": (40, 100), "table": (11, 50),
    "table_lamp": (1, 6), "telephone": (0.15, 1.5), "television": (8, 25),
    "television/tube": (25, 60), "toilet": (25, 50), "trash_bin": (0.2, 6), "wall_lamp": (0.3, 3),
    "wardrobe": (70, 190), "washing_machine": (55, 90), "washing_machine/stacked": (80, 140),
    "whiteboard": (8, 35),
}  # fmt: skip


@cache
def meshes(category: str, style: str) -> dict[str, tuple[Array, Array]]:
    spec, rng = CATEGORIES[category], np.random.default_rng(1)
    parts = make(category, spec.styles[style].size or spec.size, style, rng).parts
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


@pytest.mark.parametrize("category", sorted({name.split("/")[0] for name in RANGES}))
def test_things_weigh_what_such_things_weigh(category):
    for style in CATEGORIES[category].styles:
        low, high = RANGES.get(f"{category}/{style}", RANGES[category])
        for seed in range(2):
            mass = built(category, style, seed).mass
            assert low <= mass <= high, f"{category}/{style}: {mass:.2f} kg"


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
        ("refrigerator", "metal", (0.7, 0.7, 1.8), RANGES["refrigerator"]),
        ("washing_machine", "metal", (0.6, 0.6, 0.86), RANGES["washing_machine"]),
        ("microwave", "paint", (0.5, 0.4, 0.29), RANGES["microwave"]),
        ("wardrobe", "wood", (1.5, 0.6, 2.1), RANGES["wardrobe"]),
        ("wardrobe", None, (1.5, 0.6, 2.1), RANGES["wardrobe"]),
        ("file_cabinet", "metal", (0.46, 0.6, 1.3), RANGES["file_cabinet"]),
        ("chair", "fabric", (0.45, 0.45, 0.45), RANGES["chair"]),
        ("office_chair", "leather", (0.5, 0.5, 0.4), RANGES["office_chair"]),
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


def test_the_table_is_written_in_our_spelling_and_every_row_can_be_reached():
    for row in ROWS:
        for name in (*row.categories, *row.parts):
            assert name == ANY or name == kind_of(name), name
        assert row.reason in {"board", "foam", "sheet", "china", "weight", "common"}
        found = {
            id(construction_of(category, part, substance))
            for category in row.categories
            for part in row.parts
            for substance in (*SUBSTANCES, None)
            if not row.substances or substance in row.substances
        }
        assert id(row.construction) in found, row


def test_what_is_built_in_stays_where_it_is():
    assert not {name for name in FIXED if movable(name)}
    assert FIXED & set(CATEGORIES) == {
        "bathtub", "ceiling_lamp", "counter", "curtain", "dishwasher", "door", "faucet",
        "fireplace", "kitchen_cabinet", "oven", "sink", "stairs", "stove", "toilet", "wall_lamp",
        "window",
    }  # fmt: skip
    assert movable("chair") and movable("Office Chair", "floor") and movable("bowl", "surface")
    assert not movable("picture", "wall") and not movable("lamp", "ceiling")
    assert movable("clock", "surface") and not movable("clock", "wall")


def test_joints_take_a_hand_and_not_a_crowbar():
    widths = {"door": 0.8, "refrigerator": 0.6, "oven": 0.45, "stove": 0.45, "dishwasher": 0.6}
    for category in CATEGORIES:
        assert losses(category, "rail").friction < 22
        # At the handle, one hinge away.
        assert losses(category, "hinge").friction / widths.get(category, 0.2) < 22
        assert losses(category, "hinge").damping > 0
