"""What hangs, and what drives, in both engines."""

import numpy as np
import pytest

from openrooms_usd.geometry.solids import box
from openrooms_usd.physics.world import Body, Contact, Joint, Link, Shape
from openrooms_usd.simulation.driving import Action, act, heading
from openrooms_usd.simulation.robots import rover, triangles

from .conftest import Opener, about_y, at, brick, floor, solid, where

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
