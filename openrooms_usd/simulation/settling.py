"""Lets a room settle and writes where everything came to rest as a layer."""

from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from openrooms_usd import adapters
from openrooms_usd.arrays import Array
from openrooms_usd.engines import (
    DEFAULT_FRICTION,
    DEFAULT_TIMESTEP,
    Engine,
    Friction,
    Pose,
    Simulation,
)
from openrooms_usd.errors import InputError, StageError
from openrooms_usd.physics.world import Body, Link, World
from openrooms_usd.progress import Progress, silent

if TYPE_CHECKING:
    from openrooms_usd.usd.places.settled import Motion


# How often it is looked whether something has exploded, seconds.
_CHECK_EVERY_S: Final = 0.05

# What falls freely through a storey of 4 m has 9 m/s; nothing in a room is faster by itself.
_MAX_SPEED_M_S: Final = 30.0
_REMEDY: Final = (
    "show the object's colliders (purpose guide): it may overlap another object; or use a "
    "smaller --timestep"
)


@dataclass(frozen=True)
class Moved:
    """How far a body has moved against where the stage shows it.

    Attributes:
        body: Its name.
        path: Its prim.
        millimetres: Of the point of its collision shapes that has moved most, on joints too.
        degrees: By how much it, or the link that turned most, has turned.
        joints: Degrees or millimetres by which its joints have moved.
        speed: Of its base at the end, m/s.
    """

    body: str
    path: str
    millimetres: float
    degrees: float
    joints: dict[str, float]
    speed: float


@dataclass(frozen=True)
class Settled:
    """What became of a room.

    Attributes:
        out: The layer that was written; None when it was not asked for.
        engine: Its name.
        seconds: Simulated.
        timestep: Seconds of one step.
        friction: Which coefficient counted.
        moved: Every body that can move, the farthest first.
        held: Prims that a stronger layer keeps where they were.
    """

    out: Path | None
    engine: str
    seconds: float
    timestep: float
    friction: str
    moved: tuple[Moved, ...]
    held: tuple[str, ...] = ()

    def as_dict(self) -> dict[str, Any]:
        """Plain data, for ``--json``."""
        return {**asdict(self), "out": None if self.out is None else str(self.out)}

    def __repr__(self) -> str:
        first = self.moved[0] if self.moved else None
        most = f", by at most {first.millimetres:.1f} mm: {first.body}" if first else ""
        said = f"{len(self.moved)} movable objects{most}"
        return f"Settled({self.seconds:g} s in {self.engine}, {said}; layer: {self.out})"


def settle(
    path: Path,
    *,
    engine: str = "mujoco",
    seconds: float = 2.0,
    out: Path | None = None,
    timestep: float = DEFAULT_TIMESTEP,
    friction: Friction = DEFAULT_FRICTION,
    look: str | None = None,
    progress: Progress = silent,
) -> Settled:
    """Let a room settle, and write its poses, as `openrooms_usd.api.scenes.simulate` describes.

    The room starts from where its stages and edits have put it: what an earlier run has written to
    the same layer does not count. So a second run writes the same.
    """
    from openrooms_usd.simulation.settledlayer import choose_look, settling
    from openrooms_usd.usd.places.settled import author_motions
    from openrooms_usd.usd.rigid.reading import read_world

    _check(seconds, timestep)
    found: Engine = adapters.load(adapters.ENGINES, engine)
    with settling(path, out) as room:
        if look is not None:
            choose_look(room.stage, look, path)
        world = read_world(room.stage, path)
        if all(body.fixed and not body.joints for body in world.bodies):
            raise StageError(
                "nothing in this stage can move",
                place=path,
                remedy="compose the room with its physics step",
            )
        simulation = found.open(world, timestep=timestep, friction=friction)
        try:
            run(world, simulation, seconds, partial(progress, f"{seconds:g} s in {engine}"))
            moved = sorted(displacements(world, simulation), key=lambda row: -row.millimetres)
            held = author_motions(room.stage, motions(world, simulation))
        finally:
            simulation.close()
        room.save()
    return Settled(room.target, engine, seconds, timestep, friction, tuple(moved), tuple(held))


def run(
    world: World,
    simulation: Simulation,
    seconds: float,
    progress: Callable[[float], None] = lambda fraction: None,
) -> None:
    """Let time pass, and stop as soon as something explodes.

    Args:
        world: What is simulated.
        simulation: Of it.
        seconds: How long.
        progress: Called with the finished fraction.

    Raises:
        StageError: The place names the prim.
    """
    guard = guard_of(world)
    begun = simulation.time
    while (left := begun + seconds - simulation.time) > 0.5 * simulation.timestep:
        simulation.step(min(_CHECK_EVERY_S, left))
        guard.check(simulation)
        progress(min(1.0, 1.0 - (left - _CHECK_EVERY_S) / seconds))


def displacements(world: World, simulation: Simulation) -> Iterator[Moved]:
    """How far every body that can move has moved since the stage."""
    poses, velocities = simulation.poses(), simulation.velocities()
    for body in world.bodies:
        if body.fixed and not body.joints:
            continue
        pose = poses[body.name]
        bases = {body.links[0].name: pose.world_from_body}
        placed = simulation.links(body.name) if body.joints else bases
        far = turned = 0.0
        for link in body.links:
            if link.between:
                continue
            motion = placed[link.name] @ np.linalg.inv(body.world_from_body @ link.body_from_link)
            points = _points(body, link)
            shift = points @ motion[:3, :3].T + motion[:3, 3] - points
            far = max(far, 1e3 * float(np.linalg.norm(shift, axis=1).max()))
            turned = max(turned, _degrees(motion))
        speed = float(np.linalg.norm(velocities[body.name].linear))
        yield Moved(body.name, body.path, far, turned, dict(_joint_ways(body, pose)), speed)


def _joint_ways(body: Body, pose: Pose) -> Iterator[tuple[str, float]]:
    for joint in body.joints:
        if joint.name in pose.joints:
            value = pose.joints[joint.name]
            yield joint.name, float(np.degrees(value) if joint.kind == "hinge" else 1e3 * value)


def _degrees(motion: Array) -> float:
    # By the sine: the cosine of a small angle says nothing.
    R = motion[:3, :3]
    sine = 0.5 * np.linalg.norm([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    return float(np.degrees(np.arctan2(sine, 0.5 * (np.trace(R) - 1.0))))


def motions(world: World, simulation: Simulation) -> "Iterator[Motion]":
    """The motion of every root, and of every link that moves against it; robots have no prims."""
    from openrooms_usd.usd.places.settled import Motion

    poses = simulation.poses()
    for body in world.bodies:
        if not body.path or (body.fixed and not body.joints):
            continue
        base = poses[body.name].world_from_body
        yield Motion(body.path, base @ np.linalg.inv(body.world_from_body), "before")
        links = simulation.links(body.name) if body.joints else {}
        for link in body.links[1:]:
            was = body.world_from_body @ link.body_from_link
            if link.path and link.path != body.path:
                yield Motion(link.path, links[link.name] @ np.linalg.inv(was), "after")


def _check(seconds: float, timestep: float) -> None:
    if not (0.0 < seconds < 3600.0):
        raise InputError(f"{seconds:g} seconds cannot be simulated", remedy="give 0 < S < 3600")
    if not (0.0 < timestep <= 0.02):
        raise InputError(
            f"a time step of {timestep:g} s", remedy="give 0 < S <= 0.02; 0.002 is usual"
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
        """Reject values that are not finite, impossible speeds, and bodies outside the world.

        Raises:
            StageError: Something has exploded; the place names its prim.
        """
        velocities = simulation.velocities()
        for name, pose in simulation.poses().items():
            speed = float(np.linalg.norm(velocities[name].linear))
            where = pose.world_from_body[:3, 3]
            if not (np.isfinite(pose.world_from_body).all() and np.isfinite(speed)):
                self._refuse(name, "its pose is not finite", simulation.time)
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
    """(N, 3) the corners of a body's shapes and its links' origins, in the world."""
    return np.concatenate([_points(body, link) for link in body.links])


def _points(body: Body, link: Link) -> Array:
    M = body.world_from_body @ link.body_from_link
    points = np.concatenate([np.zeros((1, 3)), *(shape.mesh.points for shape in link.shapes)])
    return np.asarray(points @ M[:3, :3].T + M[:3, 3])
