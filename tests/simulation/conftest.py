"""Small worlds in closed form, for every engine."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager

import numpy as np
import pytest

from openrooms_usd import adapters
from openrooms_usd.arrays import Array
from openrooms_usd.engines import Simulation
from openrooms_usd.geometry.solids import box
from openrooms_usd.physics.mass import MassProperties
from openrooms_usd.physics.world import Body, Contact, Link, Shape, World
from openrooms_usd.simulation.robots import triangles
from tests.engines import ENGINES

Opener = Callable[..., Simulation]


@pytest.fixture(params=ENGINES)
def engine(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture
def opened(engine: str) -> Iterator[Opener]:
    """Open bodies in an engine; what was opened is closed."""
    simulations: list[Simulation] = []

    def open_(*bodies: Body, gravity: Array | None = None, **how: object) -> Simulation:
        world = World(bodies) if gravity is None else World(bodies, gravity)
        simulations.append(adapters.load(adapters.ENGINES, engine).open(world, **how))
        return simulations[-1]

    yield open_
    for simulation in simulations:
        simulation.close()


def at(x: float, y: float, z: float, R: Array | None = None) -> Array:
    M = np.eye(4)
    M[:3, 3] = x, y, z
    if R is not None:
        M[:3, :3] = R
    return M


def about_y(angle: float) -> Array:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])


def solid(mass: float, size: tuple[float, float, float]) -> MassProperties:
    x, y, z = np.square(size) * (mass / 12.0)
    return MassProperties(mass, np.zeros(3), np.diag([y + z, x + z, x + y]))


def brick(
    name: str, size: tuple[float, float, float], mass: float, pose: Array, mu: float = 0.5
) -> Body:
    """A solid box about its own origin."""
    shape = Shape("box", triangles(box(size)), Contact(mu, mu))
    return Body(
        name, f"/{name}", pose, (Link("base", f"/{name}", np.eye(4), solid(mass, size), (shape,)),)
    )


def floor(mu: float = 0.5, size: tuple[float, float, float] = (6.0, 6.0, 0.2)) -> Body:
    """Its top is z = 0."""
    shape = Shape("slab", triangles(box(size)), Contact(mu, mu))
    link = Link("base", "/floor", np.eye(4), None, (shape,))
    return Body("floor", "/floor", at(0.0, 0.0, -0.5 * size[2]), (link,), (), True)


@contextmanager
def running(engine: str, world: World, **how: object) -> Iterator[Simulation]:
    simulation = adapters.load(adapters.ENGINES, engine).open(world, **how)
    try:
        yield simulation
    finally:
        simulation.close()


def where(simulation: Simulation, body: str) -> Array:
    return simulation.poses()[body].world_from_body
