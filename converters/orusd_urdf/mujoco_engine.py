"""MuJoCo as an engine: it loads the MJCF file that the exporter writes.

All but one thing: MuJoCo takes the larger coefficient of two surfaces, and the file so names a pair
for each two that differ, millions in a furnished room. The engine gives each contact its own
coefficient when it arises instead, so that it needs no pairs and none is left out.
"""

from collections.abc import Mapping
from dataclasses import dataclass
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
from openrooms_usd.physics import pair
from openrooms_usd.physics.world import Body, Joint, World
from openrooms_usd.scratch import scratch_folder
from orusd_urdf.packages import needed

# Time constant of contacts, seconds: at least two steps (MuJoCo wants that). Stiffer ones make what
# is pushed hop, since MuJoCo's friction is convex: what slides is lifted by mu times its speed.
_CONTACT_TIME_S: Final = 0.01
_STEPS_OF_CONTACT: Final = 2.0
# How much of the wanted acceleration a contact gives: the less is left, the less things sink in.
_SOLVER_IMPEDANCE: Final = (0.95, 0.99, 0.001, 0.5, 2.0)
# Friction that is firmer than the normal force, and swept again until nothing creeps.
_IMPRATIO: Final = 10.0
_NOSLIP_ITERATIONS: Final = 5
# What drives a joint: its name after that of the joint, and its inertia, kg or kg m2.
_MOTOR: Final = ".motor"
_UNLIMITED_FORCE: Final = 1e9
# The least coefficient that MuJoCo's round cones can have.
_MIN_FRICTION: Final = 1e-5


class MujocoEngine:
    """Opens worlds in MuJoCo."""

    def open(
        self,
        world: World,
        *,
        timestep: float = DEFAULT_TIMESTEP,
        friction: Friction = DEFAULT_FRICTION,
    ) -> "MujocoSimulation":
        """Write the world as one MJCF file to a temporary folder and compile it.

        Raises:
            MissingPackageError: MuJoCo is not installed.
            StageError: MuJoCo refuses the file.
        """
        from orusd_urdf.mjcf import write_model

        mujoco = needed("mujoco")
        with scratch_folder() as folder:
            file = write_model(world, folder, friction=friction, pairs="none", timestep=timestep)
            try:
                spec = mujoco.MjSpec.from_file(str(file))
                _add_motors(mujoco, spec)
                model = spec.compile()
            except ValueError as error:
                raise StageError(f"MuJoCo rejects the model: {error}") from error
        _tune(mujoco, model, timestep)
        return MujocoSimulation(mujoco, model, world)


def _add_motors(mujoco: Any, spec: Any) -> None:
    """Give every hinge and rail a motor, which is off.

    An actuator overshoots where its force is limited: a step's impulse may be more than is needed.
    So a motor is dry friction against a carrier that nothing can stop: it has exactly the force
    that holds the joint at the carrier's speed, and never more than its effort.
    """
    for joint in list(spec.joints):
        if joint.type in (mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE):
            name = f"{joint.name}{_MOTOR}"
            carrier = spec.worldbody.add_body(name=name, gravcomp=1.0)
            carrier.mass, carrier.inertia, carrier.explicitinertial = 1.0, [1.0] * 3, True
            carrier.add_joint(name=name, type=joint.type, armature=_UNLIMITED_FORCE)
            clutch = spec.add_tendon(name=name)
            clutch.wrap_joint(joint.name, 1.0)
            clutch.wrap_joint(name, -1.0)


def _tune(mujoco: Any, model: Any, timestep: float) -> None:
    """Make contacts rigid and dry: stiff, inelastic, with Coulomb's round cone of friction."""
    option = model.opt
    option.timestep = timestep
    option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    # Newton's method with sparse matrices, which MuJoCo takes from 60 degrees of freedom on, blows
    # up where wheels are driven over round cones of friction.
    option.jacobian = mujoco.mjtJacobian.mjJAC_DENSE
    option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    option.impratio = _IMPRATIO
    option.noslip_iterations = _NOSLIP_ITERATIONS
    option.tolerance = 1e-10
    stiff = (max(_CONTACT_TIME_S, _STEPS_OF_CONTACT * timestep), 1.0)
    model.geom_solref[:], model.geom_solimp[:] = stiff, _SOLVER_IMPEDANCE
    model.pair_solref[:], model.pair_solimp[:] = stiff, _SOLVER_IMPEDANCE
    model.tendon_solref_fri[:], model.tendon_solimp_fri[:] = stiff, _SOLVER_IMPEDANCE


@dataclass(frozen=True, eq=False)
class _Loaded:
    """A body in MuJoCo: the numbers of its links and joints, and where its base stands.

    Balls have their three hinges, by MuJoCo's number.
    """

    body: Body
    links: Mapping[str, int]
    joints: Mapping[str, int]
    balls: Mapping[int, tuple[Joint, ...]]
    free: int | None

    @property
    def base(self) -> int:
        """MuJoCo's number of the base."""
        return self.links[self.body.links[0].name]


class MujocoSimulation:
    """A world in MuJoCo."""

    def __init__(self, mujoco: Any, model: Any, world: World) -> None:
        self._m = mujoco
        self._model = model
        self._data = mujoco.MjData(model)
        self._gravity = world.gravity
        self._bodies = {body.name: self._loaded(body) for body in world.bodies}
        self._names = {
            number: name for name, one in self._bodies.items() for number in one.links.values()
        }
        self._speeds: dict[int, float] = {}
        self._factors = np.array([pair.factor(own) for own in model.geom_friction[:, 0]])
        self._steps = 0
        self._forward()
        self._start()

    def _start(self) -> None:
        """Give bodies and joints their first velocities."""
        for name, one in self._bodies.items():
            for joint in one.body.joints:
                if joint.speed and joint.name in one.joints:
                    self._data.qvel[self._model.jnt_dofadr[one.joints[joint.name]]] = joint.speed
            for number, hinges in one.balls.items():
                at = self._model.jnt_dofadr[number]
                self._data.qvel[at : at + 3] = sum(each.speed * each.axis for each in hinges)
            if one.free is not None and np.any(one.body.velocity):
                self.set_velocity(name, *one.body.velocity)
        self._forward()

    def _loaded(self, body: Body) -> _Loaded:
        from orusd_urdf.tree import ball_name, is_ball, joined, joint_name, link_name, written

        there = [link for link in body.links if not link.between]
        links = {link.name: self._model.body(link_name(body, link)).id for link in there}
        joints, balls = dict[str, int](), dict[int, tuple[Joint, ...]]()
        for steps in joined(body):
            for joint in written(steps):
                # A ball has no angle that could be one number.
                if is_ball(steps, joint):
                    first = steps.index(joint)
                    balls[self._model.joint(ball_name(body, joint)).id] = steps[first : first + 3]
                else:
                    joints[joint.name] = self._model.joint(joint_name(body, joint)).id
        base = links[body.links[0].name]
        free = None if body.fixed else int(self._model.body_jntadr[base])
        return _Loaded(body, links, joints, balls, free)

    @property
    def timestep(self) -> float:
        """Seconds of one step."""
        return float(self._model.opt.timestep)

    @property
    def time(self) -> float:
        """Seconds since it was opened."""
        return self._steps * self.timestep

    def step(self, seconds: float) -> None:
        """Let time pass: the nearest whole number of steps, at least one."""
        count = max(1, round(seconds / self.timestep))
        carriers, speeds = list(self._speeds), list(self._speeds.values())
        for _ in range(count):
            self._data.qvel[carriers] = speeds
            self._m.mj_step1(self._model, self._data)
            self._rub()
            self._m.mj_step2(self._model, self._data)
        self._steps += count
        # What a step leaves of poses and contacts is of its beginning.
        self._forward()

    def _forward(self) -> None:
        """Everything that follows from poses and speeds, without a step."""
        self._m.mj_forward(self._model, self._data)
        self._rub()
        self._m.mj_fwdConstraint(self._model, self._data)

    def _rub(self) -> None:
        """Give every contact the coefficient of its pair, and the constraints that follow."""
        contacts = self._data.contact
        if not len(contacts.geom):
            return
        found = self._factors[contacts.geom].prod(axis=1, keepdims=True)
        contacts.friction[:, :2] = np.maximum(found, _MIN_FRICTION)
        for prepare in ("makeConstraint", "island", "projectConstraint", "referenceConstraint"):
            getattr(self._m, f"mj_{prepare}")(self._model, self._data)

    def poses(self) -> dict[str, Pose]:
        """Where every body is."""
        return {
            name: Pose(self._pose(one.base), self._values(one, self._data.qpos, "qposadr"))
            for name, one in self._bodies.items()
        }

    def links(self, body: str) -> dict[str, Array]:
        """(4, 4) world_from_link of every link of a body."""
        return {name: self._pose(number) for name, number in self._bodies[body].links.items()}

    def velocities(self) -> dict[str, Velocity]:
        """How every body moves."""
        found = {}
        for name, one in self._bodies.items():
            spin = self._velocity(one.base, local=False)
            joints = self._values(one, self._data.qvel, "dofadr")
            found[name] = Velocity(spin[3:].copy(), spin[:3].copy(), joints)
        return found

    def place(self, body: str, world_from_body: Array, joints: Mapping[str, float]) -> None:
        """Put a body elsewhere, fixed or not, and stop it; joints that are not named stay."""
        one, model, data = self._bodies[body], self._model, self._data
        turn = np.roll(quaternion(world_from_body[:3, :3]), 1)
        if one.free is None:
            model.body_pos[one.base], model.body_quat[one.base] = world_from_body[:3, 3], turn
        else:
            at, speed = model.jnt_qposadr[one.free], model.jnt_dofadr[one.free]
            data.qpos[at : at + 7] = np.concatenate([world_from_body[:3, 3], turn])
            data.qvel[speed : speed + 6] = 0.0
        for name, number in one.joints.items():
            data.qvel[model.jnt_dofadr[number]] = 0.0
            if name in joints:
                data.qpos[model.jnt_qposadr[number]] = joints[name]
        for number in one.balls:
            data.qvel[model.jnt_dofadr[number] :][:3] = 0.0
        self._forward()

    def set_velocity(self, body: str, linear: Array, angular: Array) -> None:
        """Set how the base of a free body moves; its joints are as they are."""
        one, data = self._bodies[body], self._data
        assert one.free is not None, f"{body} is fixed"
        at = self._model.jnt_dofadr[one.free]
        pose = self._pose(one.base)
        arm = pose[:3, 3] - data.xipos[one.base]
        # MuJoCo counts the velocity of the body's origin, and spins in its own frame.
        data.qvel[at : at + 3] = linear + np.cross(angular, arm)
        data.qvel[at + 3 : at + 6] = pose[:3, :3].T @ angular
        self._forward()

    def drive(self, body: str, joint: str, speed: float, effort: float) -> None:
        """Hold a joint at a speed with at most this force or torque, until told otherwise."""
        name = f"{self._model.joint(self._bodies[body].joints[joint]).name}{_MOTOR}"
        self._model.tendon_frictionloss[self._model.tendon(name).id] = effort
        self._speeds[int(self._model.joint(name).dofadr[0])] = speed

    def contacts(self) -> tuple[Touch, ...]:
        """Where different bodies touch."""
        found = []
        for index in range(self._data.ncon):
            contact = self._data.contact[index]
            a, b = (self._names.get(self._model.geom_bodyid[geom]) for geom in contact.geom)
            if a is None or b is None or a == b:
                continue
            force = np.zeros(6)
            self._m.mj_contactForce(self._model, self._data, index, force)
            # MuJoCo's normal points from the first to the second.
            normal = -contact.frame[:3].copy()
            found.append(Touch(a, b, contact.pos.copy(), normal, -contact.dist, float(force[0])))
        return tuple(found)

    def energy(self) -> Energy:
        """The energy of all that moves."""
        kinetic = potential = 0.0
        for one in self._bodies.values():
            for number in one.links.values() if one.joints or not one.body.fixed else ():
                mass, moments = self._model.body_mass[number], self._model.body_inertia[number]
                spin = self._velocity(number, local=True)
                kinetic += 0.5 * float(mass * spin[3:] @ spin[3:] + moments @ spin[:3] ** 2)
                potential -= float(mass * self._gravity @ self._data.xipos[number])
        return Energy(kinetic, potential)

    def close(self) -> None:
        """Give back the model."""
        del self._data, self._model

    def _pose(self, number: int) -> Array:
        x, y, z = self._data.xpos[number]
        w, *xyz = self._data.xquat[number]
        return pose_of((x, y, z), (*xyz, w))

    def _velocity(self, number: int, *, local: bool) -> Array:
        """(6,) spin, then velocity of the centre of mass, in the world's or the inertia's axes."""
        found = np.zeros(6)
        kind = self._m.mjtObj.mjOBJ_BODY
        self._m.mj_objectVelocity(self._model, self._data, kind, number, found, int(local))
        return found

    def _values(self, one: _Loaded, values: Array, address: str) -> dict[str, float]:
        places = getattr(self._model, f"jnt_{address}")
        return {name: float(values[places[number]]) for name, number in one.joints.items()}
