"""Loads what the URDF exporter wrote into Bullet."""

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any, Final

from openrooms_usd.errors import InputError
from orusd_urdf.packages import needed

BASE: Final = -1


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

    def pieces(self, link: str) -> list[int]:
        """A link and the massless ones that carry its other surfaces, as `robot` writes them."""
        return [at for name, at in self.links.items() if name.split(".")[0] == link]


def load_bullet(folder: str | Path, client: Any) -> dict[str, Loaded]:
    """Load every body of a folder that the URDF exporter wrote, where it stands.

    Gravity is that of the room, joints are left to themselves but for their friction, nothing is
    slowed down by air, and what shall not collide does not.

    Args:
        folder: It has ``scene.json``.
        client: What ``pybullet.connect`` gave, or a ``BulletClient`` of ``pybullet_utils``.

    Returns:
        The bodies by their names in the scene file.

    Raises:
        InputError: The folder has no scene file, or Bullet refuses a file.
        MissingPackageError: Bullet is not installed.
    """
    p = needed("pybullet")
    # A BulletClient disconnects when it is garbage collected: it stays in its own variable.
    folder, number = Path(folder), getattr(client, "_client", client)
    scene = _scene(folder / "scene.json")
    p.setGravity(*scene["gravity"], physicsClientId=number)
    bodies = {entry["name"]: _load(p, folder, entry, number) for entry in scene["bodies"]}
    keep_apart(p, bodies, scene.get("apart", ()), number)
    return bodies


def _scene(file: Path) -> dict[str, Any]:
    try:
        scene = json.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise InputError(
            f"not a readable scene: {error}", place=file, remedy="export again"
        ) from error
    if not isinstance(scene, dict) or scene.get("format") != 1:
        raise InputError("another format", place=file, remedy="export again")
    return scene


def _load(p: Any, folder: Path, entry: dict[str, Any], client: int) -> Loaded:
    file = folder / entry["urdf"]
    place = entry["position"], entry["quaternion_xyzw"]
    rubs = {name: joint["friction"] for name, joint in entry["joints"].items()}
    try:
        return load_file(p, file, place, rubs, fixed=entry["fixed_base"], client=client)
    except p.error as error:
        raise InputError(
            f"Bullet rejects it: {error}", place=file, remedy="export again"
        ) from error


def load_file(
    p: Any,
    file: Path,
    place: tuple[list[float], list[float]],
    frictions: Mapping[str, float],
    *,
    fixed: bool,
    client: int,
) -> Loaded:
    """Load one body.

    Args:
        p: Bullet.
        file: The URDF file.
        place: Position, and orientation (xyzw).
        frictions: The dry friction of joints, by their names in the file, N or N m.
        fixed: Whether the base never moves.
        client: What ``pybullet.connect`` gave.

    Raises:
        pybullet.error: Bullet refuses the file.
    """
    # The features of hulls keep them from standing apart by a margin of 1 mm each.
    flags = (
        p.URDF_USE_INERTIA_FROM_FILE
        | p.URDF_INITIALIZE_SAT_FEATURES
        | p.URDF_USE_MATERIAL_COLORS_FROM_MTL
    )
    how = {"physicsClientId": client}
    number = p.loadURDF(str(file), *place, useFixedBase=fixed, flags=flags, **how)
    loaded = Loaded(number, {p.getBodyInfo(number, **how)[0].decode(): BASE}, {})
    for index in range(p.getNumJoints(number, **how)):
        info = p.getJointInfo(number, index, **how)
        loaded.links[info[12].decode()] = index
        if info[2] != p.JOINT_FIXED:
            loaded.joints[info[1].decode()] = index
    for index in loaded.links.values():
        p.changeDynamics(number, index, linearDamping=0.0, angularDamping=0.0, **how)
    for name, index in loaded.joints.items():
        # Bullet drives every joint by default. Dry friction is a motor
        # that holds a joint still as well as it can.
        mode, force = p.VELOCITY_CONTROL, frictions[name]
        p.setJointMotorControl2(number, index, mode, 0.0, 0.0, force=force, **how)
    return loaded


def keep_apart(
    p: Any,
    bodies: Mapping[str, Loaded],
    pairs: Iterable[tuple[tuple[str, str], tuple[str, str]]],
    client: int,
) -> None:
    """Let links pass through each other.

    Args:
        p: Bullet.
        bodies: By their names.
        pairs: (body, link) and (body, link), the links by their names in the files.
        client: What ``pybullet.connect`` gave.
    """
    for (one, link), (other, another) in pairs:
        a, b = bodies[one], bodies[other]
        for here, there in product(a.pieces(link), b.pieces(another)):
            p.setCollisionFilterPair(a.number, b.number, here, there, 0, physicsClientId=client)
