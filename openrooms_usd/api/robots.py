"""Robots in composed rooms: worlds, engines, robots, their cameras and what they do.

A *world* is what a scene's physics says, `load_world`; robots are put into it (`with_robot`). An
*engine* opens it as a simulation. `RobotCameras` render what is seen of it (docs/howto/robots.md).
"""

from typing import TYPE_CHECKING

from openrooms_usd.api.given import AnyPath, usd_file
from openrooms_usd.lazy import homes, loader

if TYPE_CHECKING:
    from openrooms_usd.engines import Engine as Engine
    from openrooms_usd.engines import Simulation as Simulation
    from openrooms_usd.geometry.pinhole import look_at as look_at
    from openrooms_usd.physics.world import World as World
    from openrooms_usd.simulation import pushing as pushing
    from openrooms_usd.simulation.driving import Action as Action
    from openrooms_usd.simulation.driving import act as act
    from openrooms_usd.simulation.driving import towards as towards
    from openrooms_usd.simulation.floors import mean_friction as mean_friction
    from openrooms_usd.simulation.floors import with_friction as with_friction
    from openrooms_usd.simulation.pushing import cabinet as cabinet
    from openrooms_usd.simulation.robot_cameras import RobotCameras as RobotCameras
    from openrooms_usd.simulation.robot_cameras import robot_camera as robot_camera
    from openrooms_usd.simulation.robots import pusher as pusher
    from openrooms_usd.simulation.robots import rover as rover
    from openrooms_usd.simulation.robots import with_robot as with_robot
    from openrooms_usd.simulation.strips import row as row
    from openrooms_usd.simulation.strips import write_strip as write_strip

_OFFERED = {
    "geometry.pinhole": ("look_at",),
    "physics.world": ("World",),
    "engines": ("Engine", "Simulation"),
    "simulation": ("pushing",),
    "simulation.driving": ("Action", "act", "towards"),
    "simulation.floors": ("mean_friction", "with_friction"),
    "simulation.pushing": ("cabinet",),
    "simulation.robot_cameras": ("RobotCameras", "robot_camera"),
    "simulation.robots": ("pusher", "rover", "with_robot"),
    "simulation.strips": ("row", "write_strip"),
}
_HOME = homes("openrooms_usd", _OFFERED)

__all__ = sorted([*_HOME, "load_engine", "load_world"])

if not TYPE_CHECKING:  # To type checkers there is nothing but the names above.
    __getattr__ = loader(__name__, _HOME)


def __dir__() -> list[str]:
    """What people are offered."""
    return __all__


def load_world(scene: AnyPath) -> "World":
    """What the physics of a scene says: bodies, links, joints and contacts.

    Args:
        scene: A composed room with physics, or any USD file with it.

    Raises:
        InputError: The file is missing or no readable USD.
        StageError: Its physics is not what UsdPhysics allows.
    """
    from openrooms_usd.usd.files.diagnostics import quiet
    from openrooms_usd.usd.files.layers import open_stage
    from openrooms_usd.usd.rigid.reading import read_world as read

    with quiet():
        return read(open_stage(usd_file(scene)))


def load_engine(name: str) -> "Engine":
    """An engine by its name; its ``open(world)`` starts a simulation.

    Args:
        name: ``pybullet``, ``mujoco``, or another that is installed.

    Raises:
        InputError: No engine has that name.
        MissingPackageError: The engine is not installed.
    """
    from openrooms_usd import adapters

    engine: Engine = adapters.load(adapters.ENGINES, name)
    return engine
