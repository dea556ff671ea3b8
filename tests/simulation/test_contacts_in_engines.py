"""Contacts of both engines against closed forms, through the files that they load."""

import numpy as np
import pytest

from openrooms_usd.geometry.solids import box
from openrooms_usd.physics.pair import friction
from openrooms_usd.physics.world import Body, Contact, Link, Shape
from openrooms_usd.simulation.robots import triangles

from .conftest import Opener, about_y, at, brick, floor, solid, where

G = 9.81
# A box counts as sliding when it is faster than this after one second, m/s.
SLIDING = 5e-3


@pytest.mark.parametrize(("floor_mu", "box_mu"), [(0.3, 0.3), (0.5, 0.8), (0.2, 0.9)])
def test_a_box_slides_from_the_angle_of_friction_on(
    opened: Opener, floor_mu: float, box_mu: float
) -> None:
    """Within 2 % of tan(angle) = the pair's coefficient, on either side."""
    mu = friction(floor_mu, box_mu)
    speeds = []
    for factor in (0.98, 1.02):
        angle = np.arctan(factor * mu)
        gravity = G * np.array([np.sin(angle), 0.0, -np.cos(angle)])
        cube = brick("cube", (0.2, 0.2, 0.1), 1.0, at(0.0, 0.0, 0.05), box_mu)
        simulation = opened(floor(floor_mu), cube, gravity=gravity)
        simulation.step(1.0)
        speeds.append(np.linalg.norm(simulation.velocities()["cube"].linear))
    assert speeds[0] < SLIDING < speeds[1]


@pytest.mark.parametrize("mu", [0.2, 0.6])
def test_a_sliding_box_stops_where_coulomb_says(opened: Opener, mu: float) -> None:
    simulation = opened(floor(mu), brick("cube", (0.3, 0.3, 0.1), 2.0, at(0, 0, 0.05), mu))
    simulation.set_velocity("cube", np.array([1.5, 0.0, 0.0]), np.zeros(3))
    simulation.step(1.5)
    assert where(simulation, "cube")[0, 3] == pytest.approx(1.5**2 / (2 * mu * G), rel=0.02)


def test_a_stack_of_books_stays_and_gains_no_energy(opened: Opener) -> None:
    books = [
        brick(f"book_{n}", (0.16, 0.22, 0.03), 0.5, at(0.004 * n, 0, 0.015 + 0.03 * n), 0.4)
        for n in range(6)
    ]
    simulation = opened(floor(), *books)
    simulation.step(0.5)
    energies, begun = [], {b.name: where(simulation, b.name) for b in books}
    for _ in range(6):
        simulation.step(0.25)
        energies.append(simulation.energy())
    assert max(e.kinetic for e in energies) < 1e-6
    # Soft contacts still give way by a few micrometres.
    assert max(e.total for e in energies) < energies[0].total * (1.0 + 2e-5)
    for book in books:
        assert np.linalg.norm((where(simulation, book.name) - begun[book.name])[:3, 3]) < 1e-3
        assert np.linalg.norm((where(simulation, book.name) - book.world_from_body)[:3, 3]) < 2e-3


def test_a_table_with_one_short_leg_tips_to_the_angle_of_its_feet(opened: Opener) -> None:
    """It turns about the diagonal of the two neighbours of the short leg."""
    side, short, height = 0.8, 0.02, 0.7
    legs = [
        box((0.04, 0.04, height - gap), (x * side / 2, y * side / 2, 0.5 * (height + gap)))
        for x, y, gap in ((1, 1, short), (1, -1, 0.0), (-1, 1, 0.0), (-1, -1, 0.0))
    ]
    top = box((side + 0.04, side + 0.04, 0.03), (0.0, 0.0, height + 0.015))
    contact = Contact(0.6, 0.6)
    shapes = [Shape(f"s{n}", triangles(mesh), contact) for n, mesh in enumerate([*legs, top])]
    mass = solid(10.0, (side, side, 0.03))
    # Its centre lies on the short leg's side, so that it must tip.
    mass = type(mass)(10.0, np.array([0.05, 0.05, height]), mass.inertia)
    link = Link("base", "/table", np.eye(4), mass, tuple(shapes))
    simulation = opened(floor(), Body("table", "/table", np.eye(4), (link,)))
    simulation.step(2.0)
    # The diagonal runs through the feet's outer corners, and so does the way to the short foot.
    corner = side / 2 + 0.02
    expected = np.arctan(short / (np.sqrt(2.0) * corner))
    up = where(simulation, "table")[:3, 2]
    tilt = np.arctan2(np.hypot(up[0], up[1]), up[2])
    assert tilt == pytest.approx(expected, rel=0.05)
    assert up[0] > 0 and up[1] > 0


def test_a_chair_on_the_edge_of_a_carpet_stands_on_it(opened: Opener) -> None:
    carpet = box((1.0, 1.0, 0.012), (-0.5, 0.0, 0.006))
    rug = Link(
        "base", "/rug", np.eye(4), None, (Shape("pile", triangles(carpet), Contact(0.7, 0.5)),)
    )
    feet = [box((0.03, 0.03, 0.45), (x, y, 0.225)) for x in (-0.2, 0.2) for y in (-0.2, 0.2)]
    seat = box((0.45, 0.45, 0.03), (0.0, 0.0, 0.465))
    contact = Contact(0.5, 0.4)
    shapes = [Shape(f"s{n}", triangles(mesh), contact) for n, mesh in enumerate([*feet, seat])]
    mass = solid(5.0, (0.4, 0.4, 0.1))
    mass = type(mass)(5.0, np.array([0.0, 0.0, 0.45]), mass.inertia)
    chair = Body(
        "chair",
        "/chair",
        at(0.0, 0.0, 0.012),
        (Link("b", "/chair", np.eye(4), mass, tuple(shapes)),),
    )
    simulation = opened(floor(), Body("rug", "/rug", np.eye(4), (rug,), (), True), chair)
    simulation.step(2.0)
    pose = where(simulation, "chair")
    tilt = np.arctan2(pose[0, 2], pose[2, 2])
    # Two feet on the pile, two on the floor, and it has not walked.
    assert tilt == pytest.approx(0.012 / 0.4, rel=0.12)
    assert abs(pose[0, 3]) < 0.01 and simulation.energy().kinetic < 1e-5


@pytest.mark.parametrize(
    ("size", "mass"), [((1e-3,) * 3, 1e-6), ((0.02,) * 3, 1e-3), ((10.0, 4.0, 0.5), 5e3)]
)
def test_parts_of_all_sizes_rest(
    opened: Opener, size: tuple[float, float, float], mass: float
) -> None:
    """1 mm, 1 g, and 10 m of 5 t."""
    thing = brick("thing", size, mass, at(0.0, 0.0, 0.5 * size[2]))
    simulation = opened(floor(size=(30.0, 30.0, 1.0)), thing)
    simulation.step(1.0)
    moved = where(simulation, "thing") - thing.world_from_body
    assert np.linalg.norm(moved[:3, 3]) < 1e-3
    assert np.abs(moved[:3, :3]).max() < 0.02


def test_a_fall_is_the_parabola(opened: Opener) -> None:
    simulation = opened(brick("cube", (0.1,) * 3, 1.0, at(0, 0, 5.0, about_y(0.3))), timestep=0.001)
    before = simulation.energy().total
    simulation.step(0.5)
    assert where(simulation, "cube")[2, 3] == pytest.approx(5.0 - 0.5 * G * 0.25, abs=5e-3)
    assert simulation.energy().total == pytest.approx(before, rel=1e-3)
