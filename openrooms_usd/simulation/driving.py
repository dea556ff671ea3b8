"""Driving a robot on two wheels by the actions of the OpenRooms paper."""

from dataclasses import dataclass
from math import atan2, hypot, pi
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.engines import Simulation
from openrooms_usd.errors import InputError
from openrooms_usd.simulation.robots import LEFT, RIGHT, WHEEL_DISTANCE, WHEEL_RADIUS

# Radians a second that wheels turn at most and at least, and how fast what is left of a turn is
# taken up, 1/s.
_MAX_WHEEL_RAD_S: Final = 8.0
_MIN_WHEEL_RAD_S: Final = 0.2
_TURN_GAIN_PER_S: Final = 3.0
# Newton metres of each motor, and radians a second that a wheel may gain in one: a gentle start, in
# which wheels do not slip.
_MOTOR_NM: Final = 1.0
_MOTOR_GAIN: Final = 20.0
_CONTROL_S: Final = 0.02
_ARRIVED_M: Final = 0.01
_MAX_SECONDS: Final = 15.0


@dataclass(frozen=True)
class Action:
    """One action: first the turns, then the ways.

    Attributes:
        forward: Metres, not negative.
        backward: Metres, not negative.
        left: Radians counter-clockwise, from -pi to pi.
        right: Radians clockwise, from -pi to pi.
    """

    forward: float = 0.0
    backward: float = 0.0
    left: float = 0.0
    right: float = 0.0

    def __post_init__(self) -> None:
        """Reject invalid actions.

        Raises:
            InputError: A distance is negative, an angle is beyond pi, or a value is not a number.
        """
        ways_fit = self.forward >= 0.0 and self.backward >= 0.0
        turns_fit = abs(self.left) <= pi and abs(self.right) <= pi
        if not (ways_fit and turns_fit and np.isfinite([self.forward, self.backward]).all()):
            raise InputError(
                f"no action: {self}",
                remedy="give distances of at least 0, and angles within [-pi, pi]",
            )


def act(simulation: Simulation, body: str, action: Action) -> None:
    """Carry out an action: turn on the spot, then drive straight on; each ends at rest.

    Wheels are turned by the angles that roll the way. Nothing looks whether the robot got there: it
    may slip, or push something.

    Args:
        simulation: With a robot such as `robots.rover`.
        body: The robot's name.
        action: What to do.
    """
    turn = (action.left - action.right) * 0.5 * WHEEL_DISTANCE / WHEEL_RADIUS
    way = (action.forward - action.backward) / WHEEL_RADIUS
    for left, right in ((-turn, turn), (way, way)):
        _roll(simulation, body, {LEFT: left, RIGHT: right})


def _roll(simulation: Simulation, body: str, angles: dict[str, float]) -> None:
    """Turn wheels by angles, fast at first, and then slower the less is left."""
    if not any(angles.values()):
        return
    start = simulation.poses()[body].joints
    until = simulation.time + _MAX_SECONDS
    fastest = 0.0
    while simulation.time < until:
        joints = simulation.poses()[body].joints
        left = {name: start[name] + angle - joints[name] for name, angle in angles.items()}
        if max(map(abs, left.values())) < _ARRIVED_M:
            break
        fastest = min(fastest + _MOTOR_GAIN * _CONTROL_S, _MAX_WHEEL_RAD_S)
        for name, rest in left.items():
            speed = float(
                np.clip(abs(_TURN_GAIN_PER_S * rest), _MIN_WHEEL_RAD_S, fastest) * np.sign(rest)
            )
            simulation.drive(body, name, speed, _MOTOR_NM)
        simulation.step(_CONTROL_S)
    for name in angles:
        simulation.drive(body, name, 0.0, _MOTOR_NM)
    simulation.step(0.1)


def towards(simulation: Simulation, body: str, point: tuple[float, float]) -> Action:
    """The action that would bring a robot to a point of the floor."""
    pose = simulation.poses()[body].world_from_body
    x, y = point[0] - pose[0, 3], point[1] - pose[1, 3]
    angle = atan2(y, x) - heading(pose)
    return Action(forward=hypot(x, y), left=(angle + pi) % (2.0 * pi) - pi)


def heading(pose: Array) -> float:
    """Where a body's +X points to, radians counter-clockwise from the world's."""
    return atan2(pose[1, 0], pose[0, 0])
