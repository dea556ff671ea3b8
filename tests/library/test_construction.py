"""What things weigh: every category of the library beside products that one can buy."""

from functools import cache

import numpy as np
import pytest
import trimesh

from openrooms_usd.arrays import Array
from openrooms_usd.furniture import CATEGORIES, make, part_of
from openrooms_usd.furniture.construction import ANY, GENERAL
from openrooms_usd.furniture.registry import records
from openrooms_usd.geometry.grain import along_grain, charts
from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.geometry.solids import box, rounded_box
from openrooms_usd.geometry.triangulation import triangulate
from openrooms_usd.geometry.uvquality import uv_quality
from openrooms_usd.library.assets import model_of
from openrooms_usd.library.construction import (
    construction_of,
    density_of,
    joint_damping_of,
    mass_of_part,
    movable,
)
from openrooms_usd.library.friction.references import SUBSTANCES
from openrooms_usd.library.styles.assignment.kinds import kind_of
from openrooms_usd.library.styles.finishes import FINISHES, finishes_of
from openrooms_usd.library.timber import grained
from openrooms_usd.physics.mass import MassProperties, combined
from tests.furniture.pieces import piece


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


@pytest.mark.one_in(51, rest="long")
@pytest.mark.parametrize("category", sorted(name for name in CATEGORIES if mass_range(name)))
def test_things_weigh_what_such_things_weigh(category):
    for style in CATEGORIES[category].styles:
        low, high = mass_range(category, style)
        for seed in range(2):
            mass = built(category, style, seed).mass
            assert low <= mass <= high, f"{category}/{style}: {mass:.2f} kg"


@pytest.mark.one_in(3, rest="long")
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
    assert fixed & set(CATEGORIES) == set(
        """
        air_conditioner backsplash bathtub ceiling_lamp ceiling_rose counter curtain
        data_outlet dishwasher door faucet fireplace hob hood kitchen_cabinet kitchen_unit
        light_switch oven radiator shower shower_screen sink smoke_detector socket stairs stove
        thermostat toilet toilet_paper_holder towel_rail wall_lamp wall_shelf wall_vent window
        worktop
        """.split()
    )
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


def grain(mesh: Mesh) -> tuple[Array, Array]:
    """Where t runs on each triangle, by inverting its map from the texture; and its area."""
    corners, _ = mesh.triangles()
    p, st = mesh.points[mesh.indices[corners]], mesh.st[corners].astype(np.float64)  # type: ignore[index]
    edges, flat = p[:, 1:] - p[:, :1], st[:, 1:] - st[:, :1]
    area = 0.5 * np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1)
    kept = np.abs(np.linalg.det(flat)) > 1e-14
    along = np.linalg.solve(flat[kept], edges[kept])[:, 1]
    return along / np.linalg.norm(along, axis=1, keepdims=True), area[kept]


def principal(mesh: Mesh) -> Array:
    """The axis along which a mesh is longest, by the spread of its points."""
    return np.linalg.svd(mesh.points - mesh.points.mean(axis=0))[2][0]


def share_along(mesh: Mesh, axis: Array, within: float = 15.0) -> float:
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
