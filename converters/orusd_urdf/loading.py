"""Loads an exported folder into Bullet."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from openrooms_usd.errors import InputError
from orusd_urdf.packages import needed

_BASE: Final = -1


@dataclass(frozen=True)
class Loaded:
    """A body in Bullet.

    Attributes:
        number: Bullet's.
        links: Bullet's number of each link by its name in the file; that of the base is -1.
        joints: Bullet's number of each joint that moves.
    """

    number: int
    links: dict[str, int]
    joints: dict[str, int]


def load_bullet(folder: Path, client: int) -> dict[str, Loaded]:
    """Load every body of a folder that the URDF exporter wrote, where it stands.

    Gravity is that of the room, joints are left to themselves but for their friction, and nothing
    is slowed down by air.

    Args:
        folder: It has ``scene.json``.
        client: What ``pybullet.connect`` gave.

    Returns:
        The bodies by their names in the scene file.

    Raises:
        InputError: The folder has no scene file, or Bullet refuses a file.
        MissingPackageError: Bullet is not installed.
    """
    p = needed("pybullet")
    scene = _scene(folder / "scene.json")
    p.setGravity(*scene["gravity"], physicsClientId=client)
    return {entry["name"]: _load(p, folder, entry, client) for entry in scene["bodies"]}


def _scene(file: Path) -> dict[str, Any]:
    try:
        scene = json.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise InputError(
            f"no readable scene: {error}", place=file, remedy="export again"
        ) from error
    if not isinstance(scene, dict) or scene.get("format") != 1:
        raise InputError("another format", place=file, remedy="export again")
    return scene


def _load(p: Any, folder: Path, entry: dict[str, Any], client: int) -> Loaded:
    # The features of hulls keep them from standing apart by a margin of 1 mm each.
    flags = (
        p.URDF_USE_INERTIA_FROM_FILE
        | p.URDF_INITIALIZE_SAT_FEATURES
        | p.URDF_USE_MATERIAL_COLORS_FROM_MTL
    )
    file = folder / entry["urdf"]
    try:
        number = p.loadURDF(
            str(file),
            entry["position"],
            entry["quaternion_xyzw"],
            useFixedBase=entry["fixed_base"],
            flags=flags,
            physicsClientId=client,
        )
    except p.error as error:
        raise InputError(
            f"Bullet refuses it: {error}", place=file, remedy="export again"
        ) from error
    base = p.getBodyInfo(number, physicsClientId=client)[0].decode()
    loaded = Loaded(number, {base: _BASE}, {})
    for index in range(p.getNumJoints(number, physicsClientId=client)):
        info = p.getJointInfo(number, index, physicsClientId=client)
        loaded.links[info[12].decode()] = index
        if info[2] != p.JOINT_FIXED:
            loaded.joints[info[1].decode()] = index
    for index in loaded.links.values():
        still = {"linearDamping": 0.0, "angularDamping": 0.0}
        p.changeDynamics(number, index, **still, physicsClientId=client)
    for name, index in loaded.joints.items():
        # Dry friction is a motor that holds a joint still as well as it can.
        force = entry["joints"][name]["friction"]
        how = p.VELOCITY_CONTROL
        p.setJointMotorControl2(number, index, how, 0.0, 0.0, force=force, physicsClientId=client)
    return loaded
