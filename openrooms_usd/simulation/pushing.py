"""The push of the OpenRooms paper: a robot shoves a cabinet over a floor and stops.

The set-up is complete, where the paper's table is not. The robot (0.27 kg) stands still and touches
the cabinet (2 kg). From then on its motor wants `SPEED` and gives at most ``effort``; after `PUSH`
seconds it wants to stand still, for `WAIT` seconds. Rails carry it, so that it loses nothing to the
floor, and the face that pushes is smooth and inelastic. Gravity is 9.8 m/s2, as in the paper. What
remains is Coulomb's friction of the cabinet on the floor, so that the way has a closed form.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import inf
from typing import Final

import numpy as np

from openrooms_usd.engines import Engine, Simulation
from openrooms_usd.geometry.solids import box
from openrooms_usd.physics.mass import MassProperties
from openrooms_usd.physics.pair import friction as pair_friction
from openrooms_usd.physics.world import Body, Contact, Link, Shape, Visual, World
from openrooms_usd.simulation.robots import ALONG, BLUE, PUSHER_SIZE, pusher, triangles

GRAVITY: Final = 9.8
ROBOT_MASS: Final = 0.27
CABINET_MASS: Final = 2.0
CABINET_FRICTION: Final = 0.76
CARPET: Final = 0.76
WAX: Final = 0.31
SPEED: Final = 2.4
PUSH: Final = 0.08
WAIT: Final = 1.67

# What the paper's table says of carpet and wax; nothing here is fitted to it.
PAPER: Final = {CARPET: 0.12, WAX: 0.23}

# Greatest force of the robot's motor, newtons. The paper gives none: these are round numbers.
WEAK: Final = 30.0
STRONG: Final = 60.0

# Pushed at the height of its centre of mass, and so low that it neither rocks nor tips over while
# friction brakes it: half its height times 0.76 is well within half its depth.
_SIZE: Final = (0.6, 0.5, 0.3)
_BUMPER: Final = (0.1, 0.2)


@dataclass(frozen=True)
class Push:
    """One push.

    Attributes:
        floor: The floor's own coefficient; `pair.friction` says what it is against the cabinet.
        effort: Greatest force of the motor, newtons.
    """

    floor: float
    effort: float = STRONG

    @property
    def coefficient(self) -> float:
        """Of cabinet and floor."""
        return pair_friction(CABINET_FRICTION, self.floor)


def predicted(push: Push) -> float:
    """How far Coulomb's friction lets the cabinet go, metres.

    The motor accelerates both masses with ``effort - mu M g`` up to the wanted speed; when it
    stops, the cabinet leaves it and slides v² / (2 mu g).
    """
    drag = push.coefficient * GRAVITY
    spare = push.effort - drag * CABINET_MASS
    if spare <= 0.0:
        return 0.0
    acceleration = spare / (ROBOT_MASS + CABINET_MASS)
    rising = min(PUSH, SPEED / acceleration)
    speed = acceleration * rising
    pushed = 0.5 * speed * rising + speed * (PUSH - rising)
    slide = speed**2 / (2.0 * drag) if drag else inf
    return pushed + min(slide, speed * WAIT)


def simulated(push: Push, engine: Engine, timestep: float) -> float:
    """How far the cabinet goes in an engine, metres."""
    simulation = engine.open(world_of(push), timestep=timestep)
    try:
        for _ in moments(push, simulation):
            pass
        return way(simulation)
    finally:
        simulation.close()


def moments(push: Push, simulation: Simulation) -> Iterator[str]:
    """Let the push happen, and stop before it, when the motor stops, and at the end."""
    yield "before"
    simulation.drive("pusher", ALONG, SPEED, push.effort)
    simulation.step(PUSH)
    yield "pushed"
    simulation.drive("pusher", ALONG, 0.0, push.effort)
    simulation.step(WAIT)
    yield "after"


def way(simulation: Simulation) -> float:
    """How far the cabinet has gone, metres."""
    return float(simulation.poses()["cabinet"].world_from_body[0, 3])


def world_of(push: Push) -> World:
    """A floor, a cabinet in the origin, and the robot behind it."""
    contact = Contact(push.floor, push.floor, name="floor")
    ground = triangles(box((8.0, 4.0, 0.2), (2.0, 0.0, -0.1)))
    floor = Link("floor", "", np.eye(4), None, (Shape("slab", ground, contact),))
    robot = pusher((-0.5 * (_SIZE[0] + PUSHER_SIZE), 0.0), mass=ROBOT_MASS, bumper=_BUMPER)
    bodies = (Body("floor", "", np.eye(4), (floor,), (), True), cabinet((0.0, 0.0)), robot)
    return World(bodies, np.array([0.0, 0.0, -GRAVITY]))


def cabinet(position: tuple[float, float]) -> Body:
    """The cabinet: a box of 2 kg, 0.6 m along X, 0.5 m along Y and 0.3 m high.

    Args:
        position: Its middle on the floor, metres.
    """
    x, y, z = _SIZE
    solid = triangles(box(_SIZE, (0.0, 0.0, 0.5 * z)))
    moments = np.diag([y * y + z * z, x * x + z * z, x * x + y * y]) * (CABINET_MASS / 12.0)
    mass = MassProperties(CABINET_MASS, np.array([0.0, 0.0, 0.5 * z]), moments)
    shape = Shape("box", solid, Contact(CABINET_FRICTION, CABINET_FRICTION, name="cabinet"))
    link = Link("cabinet", "", np.eye(4), mass, (shape,), (Visual("box", solid, BLUE),))
    place = np.eye(4)
    place[:2, 3] = position
    return Body("cabinet", "", place, (link,))
