"""Contacts, what hangs, what drives and what is pushed, in both engines, in closed form."""

import numpy as np
import pytest

from openrooms_usd import adapters
from openrooms_usd.geometry.solids import box
from openrooms_usd.physics.pair import friction
from openrooms_usd.physics.world import Body, Contact, Joint, Link, Shape
from openrooms_usd.simulation import pushing
from openrooms_usd.simulation.driving import Action, act, heading
from openrooms_usd.simulation.pushing import CARPET, STRONG, WAX, WEAK, Push, predicted, simulated
from openrooms_usd.simulation.robots import rover, triangles
from tests.engines import ENGINES

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


ROD = 0.6
SHADE = (0.2, 0.2, 0.1)


def pendant(angle: float, damping: float) -> Body:
    """A shade of 1 kg on a rod without weight, which turns about Y below a hook at 2 m."""
    shade = Shape("shade", triangles(box(SHADE, (0.0, 0.0, -ROD))), Contact(0.5, 0.4))
    mass = solid(1.0, SHADE)
    hanging = type(mass)(1.0, np.array([0.0, 0.0, -ROD]), mass.inertia)
    hook = Link("hook", "/lamp", np.eye(4), None)
    lamp = Link("lamp", "/lamp/lamp", at(0.0, 0.0, 0.0, about_y(angle)), hanging, (shade,))
    axis = np.array([0.0, 1.0, 0.0])
    joint = Joint("swing", "hinge", "hook", "lamp", axis, (-3.0, 3.0), damping)
    return Body("lamp", "/lamp", at(0.0, 0.0, 2.0), (hook, lamp), (joint,), True)


def test_a_pendant_lamp_comes_to_rest_below_its_hook(opened: Opener) -> None:
    simulation = opened(floor(), pendant(0.5, 0.8))
    simulation.step(8.0)
    # From the pose of the stage: it hangs straight when it has turned back.
    assert simulation.poses()["lamp"].joints["swing"] == pytest.approx(-0.5, abs=2e-3)
    link = simulation.links("lamp")["lamp"]
    assert link @ [0.0, 0.0, -ROD, 1.0] == pytest.approx([0.0, 0.0, 2.0 - ROD, 1.0], abs=2e-3)
    assert simulation.energy().kinetic < 1e-8


def test_an_undamped_pendant_swings_in_the_time_of_a_pendulum(opened: Opener) -> None:
    """2 pi sqrt(I / (m g l)), 0.2 % more for an amplitude of 0.17 rad."""
    angle = 0.17
    simulation = opened(pendant(angle, 0.0), timestep=0.001)
    inertia = ROD**2 + (SHADE[0] ** 2 + SHADE[2] ** 2) / 12.0
    period = 2.0 * np.pi * np.sqrt(inertia / (9.81 * ROD)) * (1.0 + angle**2 / 16.0)
    simulation.step(0.25 * period)
    assert simulation.poses()["lamp"].joints["swing"] == pytest.approx(-angle, abs=4e-3)
    simulation.step(0.25 * period)
    assert simulation.poses()["lamp"].joints["swing"] == pytest.approx(-2.0 * angle, abs=4e-3)


def test_a_lamp_that_is_fixed_stays_at_the_ceiling(opened: Opener) -> None:
    shape = Shape("shade", triangles(box(SHADE)), Contact(0.5, 0.4))
    pose = at(0.3, 0.2, 2.0, about_y(0.2))
    link = Link("lamp", "/fixed", np.eye(4), solid(1.0, SHADE), (shape,))
    simulation = opened(floor(), Body("fixed", "/fixed", pose, (link,), (), True))
    simulation.step(1.0)
    assert where(simulation, "fixed") == pytest.approx(pose, abs=1e-6)


@pytest.mark.one_in(4)
def test_a_rover_drives_among_many_things(opened: Opener) -> None:
    """With so many degrees of freedom some engines take other solvers."""
    crowd = [
        brick(f"b{n}", (0.1,) * 3, 0.5, at(0.3 * (n % 6) - 1.0, 1.2 + 0.3 * (n // 6), 0.05))
        for n in range(12)
    ]
    simulation = opened(floor(), *crowd, rover((-0.5, 0.0)))
    simulation.step(0.2)
    act(simulation, "rover", Action(forward=0.8))
    pose = where(simulation, "rover")
    assert pose[:3, 3] == pytest.approx([0.3, 0.0, 0.0], abs=0.02)
    assert pose[2, 2] > 0.9999
    act(simulation, "rover", Action(left=1.0))
    pose = where(simulation, "rover")
    assert heading(pose) == pytest.approx(1.0, abs=0.1)
    assert pose[2, 2] > 0.9999
    for thing in crowd:
        assert np.linalg.norm((where(simulation, thing.name) - thing.world_from_body)[:3, 3]) < 2e-3


def integrated(push: Push, step: float = 1e-6) -> float:
    """The same by Newton's second law in tiny steps, without knowing the phases."""
    drag = push.coefficient * pushing.GRAVITY
    way = speed = time = 0.0
    while time < pushing.PUSH + pushing.WAIT:
        pushed = time < pushing.PUSH and speed < pushing.SPEED
        if pushed:
            force = push.effort - drag * pushing.CABINET_MASS
            speed += step * force / (pushing.ROBOT_MASS + pushing.CABINET_MASS)
        elif time >= pushing.PUSH:
            speed = max(0.0, speed - step * drag)
            if speed == 0.0:
                break
        way += step * speed
        time += step
    return way


@pytest.mark.parametrize(
    "push", [Push(CARPET, WEAK), Push(WAX, STRONG), Push(CARPET, 400.0)], ids=str
)
def test_the_prediction_is_newtons_law(push: Push) -> None:
    assert predicted(push) == pytest.approx(integrated(push), rel=1e-3)


def test_a_motor_weaker_than_friction_moves_nothing() -> None:
    assert predicted(Push(CARPET, 14.0)) == 0.0


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("floor", [CARPET, WAX])
@pytest.mark.parametrize("effort", [WEAK, STRONG])
def test_engines_agree_with_it_within_five_percent(
    engine: str, floor: float, effort: float
) -> None:
    push = Push(floor, effort)
    found = simulated(push, adapters.load(adapters.ENGINES, engine), 0.002)
    assert found == pytest.approx(predicted(push), rel=0.05)


@pytest.mark.parametrize("engine", ENGINES)
def test_a_smaller_step_errs_less(engine: str) -> None:
    loaded = adapters.load(adapters.ENGINES, engine)
    push = Push(CARPET, STRONG)
    errors = [abs(simulated(push, loaded, step) - predicted(push)) for step in (0.004, 0.001)]
    assert errors[1] < 0.5 * errors[0]


def test_wax_lets_it_go_further() -> None:
    ways = np.array([predicted(Push(floor, STRONG)) for floor in (CARPET, WAX)])
    assert ways[1] > ways[0]
    # As the paper's own offsets, which are nothing that we fit.
    assert pushing.PAPER[WAX] > pushing.PAPER[CARPET]
