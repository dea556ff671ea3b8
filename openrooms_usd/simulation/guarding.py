"""Noticing at once when a simulation is no longer one of this world."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.errors import StageError
from openrooms_usd.physics.world import Body, World
from openrooms_usd.simulate import Simulation

Array = NDArray[np.float64]

# What falls freely through a storey of 4 m has 9 m/s; nothing in a room is faster by itself.
_MAX_SPEED_M_S: Final = 30.0
_REMEDY: Final = (
    "look at the object with its colliders shown (purpose guide): it may overlap another one; or "
    "take a smaller --timestep"
)


@dataclass(frozen=True, eq=False)
class Guard:
    """Bounds that no body of a world may leave.

    Attributes:
        lower: (3,) least corner, metres.
        upper: (3,) greatest corner.
        paths: The prim of each body.
    """

    lower: Array
    upper: Array
    paths: dict[str, str]

    def check(self, simulation: Simulation) -> None:
        """Refuse numbers that are none, speeds that nothing has, and what has left the world.

        Raises:
            StageError: Something has exploded; the place names its prim.
        """
        velocities = simulation.velocities()
        for name, pose in simulation.poses().items():
            speed = float(np.linalg.norm(velocities[name].linear))
            where = pose.world_from_body[:3, 3]
            if not (np.isfinite(pose.world_from_body).all() and np.isfinite(speed)):
                self._refuse(name, "its pose is no number", simulation.time)
            if speed > _MAX_SPEED_M_S:
                self._refuse(name, f"it moves at {speed:.0f} m/s", simulation.time)
            if (where < self.lower).any() or (where > self.upper).any():
                at = ", ".join(f"{value:.1f}" for value in where)
                self._refuse(name, f"it has left the world: ({at})", simulation.time)

    def _refuse(self, name: str, what: str, time: float) -> None:
        message = f"the simulation fails after {time:.2f} s at {name!r}: {what}"
        raise StageError(message, place=self.paths.get(name, name), remedy=_REMEDY)


def guard_of(world: World) -> Guard:
    """Bounds that are the world's own, wider by half its diagonal on every side."""
    points = [corners(body) for body in world.bodies]
    everything = np.concatenate([*points, np.zeros((1, 3))])
    lower, upper = everything.min(axis=0), everything.max(axis=0)
    room = 0.5 * float(np.linalg.norm(upper - lower)) + 1.0
    return Guard(lower - room, upper + room, {body.name: body.path for body in world.bodies})


def corners(body: Body) -> Array:
    """(N, 3) the corners of a body's shapes and its own origin, in the world."""
    origins = [np.zeros((1, 3))]
    for link in body.links:
        M = link.body_from_link
        origins += [shape.mesh.points @ M[:3, :3].T + M[:3, 3] for shape in link.shapes]
    M = body.world_from_body
    return np.asarray(np.concatenate(origins) @ M[:3, :3].T + M[:3, 3])
