"""Bullet as an engine: it loads the URDF files that the exporter writes."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.engines import (
    DEFAULT_FRICTION,
    DEFAULT_TIMESTEP,
    Energy,
    Friction,
    Pose,
    Touch,
    Velocity,
)
from openrooms_usd.errors import StageError
from openrooms_usd.geometry.quaternions import pose_of, quaternion
from openrooms_usd.physics.world import Body, Drive, Joint, LinkName, World
from openrooms_usd.scratch import scratch_folder
from orusd_urdf.loading import BASE, Loaded, keep_apart, load_file
from orusd_urdf.naming import safe
from orusd_urdf.packages import needed
from orusd_urdf.springs import extra_damping, moved_inertia
from orusd_urdf.urdf import write_bodies

# Iterations until the friction of a stack is Coulomb's; Bullet's own 50 leave books creeping.
_SOLVER_ITERATIONS: Final = 200
_SOLVER_RESIDUAL: Final = 1e-9
# Newtons or newton metres, where nothing limits them.
_UNLIMITED_FORCE: Final = 1e9


class BulletEngine:
    """Opens worlds in Bullet, without a window."""

    def open(
        self,
        world: World,
        *,
        timestep: float = DEFAULT_TIMESTEP,
        friction: Friction = DEFAULT_FRICTION,
    ) -> "BulletSimulation":
        """Write the world as URDF files to a temporary folder and load them.

        Raises:
            MissingPackageError: Bullet is not installed.
            StageError: Bullet refuses a file.
        """
        bullet = needed("pybullet")
        simulation = BulletSimulation(bullet, world, timestep)
        with scratch_folder() as folder:
            simulation.load(folder, friction)
        return simulation


@dataclass(frozen=True, eq=False)
class _Loaded:
    """A body in Bullet.

    Attributes:
        body: As it was given.
        number: Bullet's.
        base_from_inertial: (4, 4) Bullet counts poses of bases in the frame of their inertia.
        joints: Bullet's number of each joint that can move, which is that of its child too.
        links: Bullet's number of each link.
    """

    body: Body
    number: int
    base_from_inertial: Array
    joints: dict[str, int]
    links: dict[str, int]


class BulletSimulation:
    """A world in Bullet.

    Every step starts from an ordered list of contacts, and files are never cached, so that equal
    worlds give equal bits.
    """

    def __init__(self, bullet: Any, world: World, timestep: float) -> None:
        self.timestep = timestep
        self._steps = 0
        self._p = bullet
        self._world = world
        self._client: int = bullet.connect(bullet.DIRECT)
        self._how = {"physicsClientId": self._client}
        self._bodies: dict[str, _Loaded] = {}
        self._names: dict[int, str] = {}
        self._springs: list[tuple[tuple[int, int], Joint, Drive]] = []
        bullet.setGravity(*world.gravity.tolist(), **self._how)
        bullet.setPhysicsEngineParameter(
            fixedTimeStep=timestep,
            numSolverIterations=_SOLVER_ITERATIONS,
            solverResidualThreshold=_SOLVER_RESIDUAL,
            minimumSolverIslandSize=1,
            deterministicOverlappingPairs=1,
            enableFileCaching=0,
            **self._how,
        )

    def load(self, folder: Path, friction: Friction) -> None:
        """Write every body as a file, load it, and leave its joints to themselves.

        Args:
            folder: Empty; the files are not needed afterwards.
            friction: Which coefficient of each surface counts.

        Raises:
            StageError: Bullet refuses a file.
        """
        files = write_bodies(self._world, folder, friction=friction)
        loaded = {body.name: self._load(body, files[body.name]) for body in self._world.bodies}
        pairs = [((a, safe(one)), (b, safe(other))) for (a, one), (b, other) in self._world.apart]
        keep_apart(self._p, loaded, pairs, self._client)
        for loop in self._world.loops:
            for point in loop.points:
                self._pin(loop.links, point)
        for name, one in self._each():
            for joint in one.body.joints:
                self._begin(one, joint)
            if not one.body.fixed and np.any(one.body.velocity):
                self.set_velocity(name, *one.body.velocity)

    def _pin(self, links: tuple[LinkName, LinkName], point: Array) -> None:
        """Keep a point of the world the same in two links, from now on."""
        ends: list[int] = []
        local = []
        for body, link in links:
            one = self._bodies[body]
            index = one.links[link]
            dynamics = self._p.getDynamicsInfo(one.number, index, **self._how)
            ends += [one.number, index]
            centre = self.links(body)[link] @ pose_of(dynamics[3], dynamics[4])
            local.append((centre[:3, :3].T @ (point - centre[:3, 3])).tolist())
        kind = self._p.JOINT_POINT2POINT
        made = self._p.createConstraint(*ends, kind, [0.0] * 3, *local, **self._how)
        self._p.changeConstraint(made, maxForce=_UNLIMITED_FORCE, **self._how)

    def _begin(self, one: _Loaded, joint: Joint) -> None:
        """Give a joint its first speed, and its drive: by forces that follow it, or as a motor.

        Bullet's motors are rigid. One stands in for a spring, or for the damping of a motor with
        little force, that is too stiff for the steps; its sag is below that of a step of gravity.
        """
        if joint.speed:
            index = one.joints[joint.name]
            self._p.resetJointState(one.number, index, 0.0, joint.speed, **self._how)
        drive = joint.drive
        if drive is None:
            return
        where = (one.number, one.joints[joint.name])
        if np.isfinite(drive.force):
            self._p.changeDynamics(*where, jointDamping=0.0, **self._how)
        force = min(drive.force, _UNLIMITED_FORCE)
        if extra_damping(one.body, joint, self.timestep):
            mode, goal = self._p.POSITION_CONTROL, {"targetPosition": drive.target}
            self._p.setJointMotorControl2(*where, mode, force=force, **goal, **self._how)
        elif (
            np.isfinite(drive.force)
            and not drive.stiffness
            and self.timestep * joint.damping > moved_inertia(one.body, joint)
        ):
            self.drive(one.body.name, joint.name, drive.speed, force)
        else:
            self._springs.append((where, joint, drive))

    def _pull(self) -> None:
        """What drives give in this step."""
        for (number, index), joint, drive in self._springs:
            position, speed, *_ = self._p.getJointState(number, index, **self._how)
            force = drive.stiffness * (drive.target - position) + joint.damping * drive.speed
            if np.isfinite(drive.force):
                # The file's damping goes on by itself where nothing limits it.
                force = float(np.clip(force - joint.damping * speed, -drive.force, drive.force))
            mode = self._p.TORQUE_CONTROL
            self._p.setJointMotorControl2(number, index, mode, force=force, **self._how)

    def _load(self, body: Body, file: Path) -> Loaded:
        at = body.world_from_body
        place = at[:3, 3].tolist(), quaternion(at[:3, :3]).tolist()
        moving = {j.name: safe(j.name) for j in body.joints if j.kind != "fixed"}
        rubs = {safe(joint.name): joint.friction for joint in body.joints}
        try:
            loaded = load_file(self._p, file, place, rubs, fixed=body.fixed, client=self._client)
        except self._p.error as error:
            raise StageError(f"Bullet rejects {body.name!r}: {error}", place=body.path) from error
        dynamics = self._p.getDynamicsInfo(loaded.number, BASE, **self._how)
        self._bodies[body.name] = _Loaded(
            body,
            loaded.number,
            pose_of(dynamics[3], dynamics[4]),
            {name: loaded.joints[known] for name, known in moving.items()},
            {link.name: loaded.links[safe(link.name)] for link in body.links},
        )
        self._names[loaded.number] = body.name
        return loaded

    @property
    def time(self) -> float:
        """Seconds since it was opened."""
        return self._steps * self.timestep

    def step(self, seconds: float) -> None:
        """Let time pass: the nearest whole number of steps, at least one."""
        count = max(1, round(seconds / self.timestep))
        for _ in range(count):
            self._pull()
            self._p.stepSimulation(**self._how)
        self._steps += count

    def poses(self) -> dict[str, Pose]:
        """Where every body is."""
        return {name: Pose(self._base(one), self._joints(one)[0]) for name, one in self._each()}

    def links(self, body: str) -> dict[str, Array]:
        """(4, 4) world_from_link of every link of a body."""
        one = self._bodies[body]
        found = {}
        for name, index in one.links.items():
            if index == BASE:
                found[name] = self._base(one)
            else:
                state = self._p.getLinkState(
                    one.number, index, computeForwardKinematics=1, **self._how
                )
                found[name] = pose_of(state[4], state[5])
        return found

    def velocities(self) -> dict[str, Velocity]:
        """How every body moves."""
        found = {}
        for name, one in self._each():
            linear, angular = self._p.getBaseVelocity(one.number, **self._how)
            found[name] = Velocity(np.array(linear), np.array(angular), self._joints(one)[1])
        return found

    def place(self, body: str, world_from_body: Array, joints: Mapping[str, float]) -> None:
        """Put a body elsewhere, fixed or not, and stop it; joints that are not named stay."""
        one = self._bodies[body]
        at = world_from_body @ one.base_from_inertial
        turn = quaternion(at[:3, :3]).tolist()
        self._p.resetBasePositionAndOrientation(one.number, at[:3, 3].tolist(), turn, **self._how)
        self._p.resetBaseVelocity(one.number, [0.0] * 3, [0.0] * 3, **self._how)
        for name, value in {**self._joints(one)[0], **joints}.items():
            self._p.resetJointState(one.number, one.joints[name], value, 0.0, **self._how)

    def set_velocity(self, body: str, linear: Array, angular: Array) -> None:
        """Set how the base of a free body moves; its joints are as they are."""
        number = self._bodies[body].number
        self._p.resetBaseVelocity(number, linear.tolist(), angular.tolist(), **self._how)

    def drive(self, body: str, joint: str, speed: float, effort: float) -> None:
        """Hold a joint at a speed with at most this force or torque, until told otherwise."""
        one = self._bodies[body]
        self._p.setJointMotorControl2(
            one.number,
            one.joints[joint],
            self._p.VELOCITY_CONTROL,
            targetVelocity=speed,
            force=effort,
            **self._how,
        )

    def contacts(self) -> tuple[Touch, ...]:
        """Where different bodies touch."""
        found = self._p.getContactPoints(**self._how)
        return tuple(
            Touch(
                self._names[row[1]],
                self._names[row[2]],
                0.5 * (np.array(row[5]) + np.array(row[6])),
                np.array(row[7]),
                -row[8],
                row[9],
            )
            for row in found
            if row[1] != row[2]
        )

    def energy(self) -> Energy:
        """The energy of all that moves."""
        kinetic = potential = 0.0
        for _, one in self._each():
            for index, (linear, angular, centre) in self._motions(one):
                dynamics = self._p.getDynamicsInfo(one.number, index, **self._how)
                mass, principal = dynamics[0], np.array(dynamics[2])
                # About the axes of inertia, in which they are along the frame of the centre.
                turning = centre[:3, :3].T @ angular
                kinetic += 0.5 * (mass * float(linear @ linear) + float(principal @ turning**2))
                potential -= mass * float(self._world.gravity @ centre[:3, 3])
        return Energy(kinetic, potential)

    def close(self) -> None:
        """Give back what Bullet holds."""
        self._p.disconnect(**self._how)

    def _each(self) -> Iterator[tuple[str, _Loaded]]:
        return iter(self._bodies.items())

    def _base(self, one: _Loaded) -> Array:
        at, turn = self._p.getBasePositionAndOrientation(one.number, **self._how)
        return np.asarray(pose_of(at, turn) @ np.linalg.inv(one.base_from_inertial))

    def _joints(self, one: _Loaded) -> tuple[dict[str, float], dict[str, float]]:
        if not one.joints:
            return {}, {}
        states = self._p.getJointStates(one.number, list(one.joints.values()), **self._how)
        rows = dict(zip(one.joints, states, strict=True))
        return {n: row[0] for n, row in rows.items()}, {n: row[1] for n, row in rows.items()}

    def _motions(self, one: _Loaded) -> Iterator[tuple[int, tuple[Array, Array, Array]]]:
        """Velocity, spin and frame of the centre of mass of every link that moves."""
        if not one.body.fixed:
            linear, angular = self._p.getBaseVelocity(one.number, **self._how)
            at = self._p.getBasePositionAndOrientation(one.number, **self._how)
            yield BASE, (np.array(linear), np.array(angular), pose_of(*at))
        if not one.joints and one.body.fixed:
            return
        for index in one.links.values():
            if index != BASE:
                state = self._p.getLinkState(one.number, index, 1, 1, **self._how)
                yield index, (np.array(state[6]), np.array(state[7]), pose_of(*state[:2]))
