"""The contract of physics engines: a world goes in, time passes, poses come out.

An engine is an entry point ``openrooms_usd.engines``. It simulates the files that the exporter of
its own format writes, so that what was simulated here is what others load. Everything is in metres,
kilograms, seconds, radians and newtons, in the frame of the world (Z up). Bodies, links and joints
go by their names in the `World`.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, Literal, Protocol

from openrooms_usd.arrays import Array
from openrooms_usd.physics.world import World

Friction = Literal["static", "dynamic"]
"""Which of a surface's two coefficients an engine that has one of them uses."""

DEFAULT_TIMESTEP: Final = 0.002
DEFAULT_FRICTION: Final[Friction] = "static"


@dataclass(frozen=True, eq=False)
class Pose:
    """Where a body is.

    Attributes:
        world_from_body: (4, 4) rigid; the frame of its base.
        joints: Angle or way of every joint that can move, from the pose of the stage.
    """

    world_from_body: Array
    joints: Mapping[str, float]


@dataclass(frozen=True, eq=False)
class Velocity:
    """How a body moves.

    Attributes:
        linear: (3,) of its base's centre of mass, m/s.
        angular: (3,) about the world's axes, rad/s.
        joints: Speed of every joint that can move, rad/s or m/s.
    """

    linear: Array
    angular: Array
    joints: Mapping[str, float]


@dataclass(frozen=True, eq=False)
class Touch:
    """One point in which two bodies touch.

    Attributes:
        a: The name of a body.
        b: The name of another one.
        point: (3,) in the world.
        normal: (3,) unit, from b to a.
        depth: By how much they overlap there, metres; negative where there is still a gap.
        force: Along the normal, newtons.
    """

    a: str
    b: str
    point: Array
    normal: Array
    depth: float
    force: float


@dataclass(frozen=True)
class Energy:
    """Energy of all that moves, joules; the potential counts from the world's origin."""

    kinetic: float
    potential: float

    @property
    def total(self) -> float:
        """What friction, damping and inelastic contacts can only make less."""
        return self.kinetic + self.potential


class Simulation(Protocol):
    """A world in an engine, at some time."""

    timestep: float
    """Seconds of one step."""

    time: float
    """Seconds since it was opened."""

    def step(self, seconds: float) -> None:
        """Let time pass: the nearest whole number of steps, at least one."""
        ...

    def poses(self) -> Mapping[str, Pose]:
        """Where every body is."""
        ...

    def links(self, body: str) -> Mapping[str, Array]:
        """(4, 4) world_from_link of every link of a body."""
        ...

    def velocities(self) -> Mapping[str, Velocity]:
        """How every body moves."""
        ...

    def place(self, body: str, world_from_body: Array, joints: Mapping[str, float]) -> None:
        """Put a body elsewhere, fixed or not, and stop it; joints that are not named stay."""
        ...

    def set_velocity(self, body: str, linear: Array, angular: Array) -> None:
        """Set how the base of a free body moves; its joints are as they are."""
        ...

    def drive(self, body: str, joint: str, speed: float, effort: float) -> None:
        """Hold a joint at a speed with at most this force or torque, until told otherwise."""
        ...

    def contacts(self) -> tuple[Touch, ...]:
        """Where different bodies touch."""
        ...

    def energy(self) -> Energy:
        """The energy of all that moves."""
        ...

    def close(self) -> None:
        """Give back what the engine holds; nothing else may be called afterwards."""
        ...


class Engine(Protocol):
    """Opens worlds; registered as an entry point ``openrooms_usd.engines``."""

    def open(
        self,
        world: World,
        *,
        timestep: float = DEFAULT_TIMESTEP,
        friction: Friction = DEFAULT_FRICTION,
    ) -> Simulation:
        """Load a world.

        Args:
            world: What to simulate.
            timestep: Seconds of one step.
            friction: Which coefficient of each surface counts.

        Raises:
            StageError: The engine cannot hold this world.
        """
        ...
