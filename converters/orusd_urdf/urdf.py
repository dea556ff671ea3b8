"""A world as URDF: a file for every body, and a file that says where each one stands."""

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import Any, Final
from xml.etree import ElementTree

import numpy as np

from openrooms_usd import atomic, claims, names
from openrooms_usd.engines import DEFAULT_FRICTION, Friction
from openrooms_usd.geometry.quaternions import quaternion
from openrooms_usd.physics.world import Body, World
from orusd_urdf.assets import Assets
from orusd_urdf.checking import check_world, started
from orusd_urdf.looks import Loss, RobotMaterial
from orusd_urdf.naming import Names, safe
from orusd_urdf.robot import robot_element
from orusd_urdf.tree import joined

SCENE: Final = "scene.json"
_OBJECTS: Final = PurePosixPath("objects")
_ROOM: Final = "room"


def write_urdf(
    world: World,
    folder: Path,
    *,
    looks: Mapping[str, RobotMaterial],
    friction: Friction = DEFAULT_FRICTION,
    package: str | None = None,
) -> list[Loss]:
    """Write a world as URDF files and ``scene.json``, all or nothing.

    Args:
        world: What to write.
        folder: It receives ``room``, ``objects``, ``meshes`` and ``textures``.
        looks: What materials look like, by the paths of their prims.
        friction: Which coefficient of each surface counts.
        package: The name of the ROS package that the folder will be; None for relative paths.

    Returns:
        What was lost.

    Raises:
        StageError: The world is impossible.
        OutputError: A file cannot be written.
    """
    check_world(world)
    with claims.refilling(folder, ".orusd.urdf.sha256") as refill:
        writer = _Writer(Assets(refill.folder), looks, friction, package)
        files = writer.write(world)
        scene = {
            "format": 1,
            "gravity": world.gravity.tolist(),
            "friction": friction,
            "bodies": [_entry(body, files[body.name]) for body in world.bodies],
            "apart": [[(body, safe(link)) for body, link in ends] for ends in world.apart],
        }
        atomic.write_text(
            refill.folder / SCENE, json.dumps(scene, indent=1, ensure_ascii=False) + "\n"
        )
    return [*writer.assets.losses, *_find_losses(world)]


def _find_losses(world: World) -> Iterator[Loss]:
    """What URDF has no word for."""
    for loop in world.loops:
        yield loop.path, "skipped", "it closes a loop: URDF supports only trees"
    for path in started(world):
        yield path, "approximated", "its initial velocity is lost"
    for body in world.bodies:
        for joints in joined(body):
            child = next(link for link in body.links if link.name == joints[-1].child)
            if len(joints) > 1:
                what = f"URDF has one direction a joint: {len(joints)} with light links between"
                yield child.path, "approximated", what
            if any(joint.drive for joint in joints):
                yield child.path, "approximated", "its drive is lost except for the damping"


def write_bodies(
    world: World, folder: Path, *, friction: Friction = DEFAULT_FRICTION
) -> dict[str, Path]:
    """Write a world as URDF files without anything to look at.

    Args:
        world: What to write.
        folder: Where.
        friction: Which coefficient of each surface counts.

    Returns:
        The file of each body, by its name in the world.

    Raises:
        StageError: The world is impossible.
        OutputError: A file cannot be written.
    """
    check_world(world)
    files = _Writer(Assets(folder), None, friction, None).write(world)
    return {name: folder / file for name, file in files.items()}


@dataclass
class _Writer:
    assets: Assets
    looks: Mapping[str, RobotMaterial] | None
    friction: Friction
    package: str | None

    def write(self, world: World) -> dict[str, PurePosixPath]:
        """Write every body, and say where its file lies in the folder."""
        folders = Names()
        files = {}
        for body in world.bodies:
            if body.path == names.ROOM:
                file = PurePosixPath(_ROOM, f"{_ROOM}.urdf")
            else:
                name = folders.unique(body.name)
                file = _OBJECTS / name / f"{name}.urdf"
            self._write(body, file)
            files[body.name] = file
        return files

    def _write(self, body: Body, file: PurePosixPath) -> None:
        up = "../" * (len(file.parts) - 1)
        prefix = f"package://{self.package}/" if self.package else up
        element = robot_element(body, self.assets, self.looks, self.friction, prefix)
        ElementTree.indent(element)
        content = ElementTree.tostring(element, encoding="unicode")
        declaration = '<?xml version="1.0" encoding="utf-8"?>'
        atomic.write_text(self.assets.folder / file, f"{declaration}\n{content}\n")


def _entry(body: Body, file: PurePosixPath) -> dict[str, Any]:
    moving = [joint for joint in body.joints if joint.kind != "fixed"]
    return {
        "name": body.name,
        "prim": body.path,
        "category": body.category,
        "urdf": str(file),
        "position": (np.round(body.world_from_body[:3, 3], 12) + 0.0).tolist(),
        "quaternion_xyzw": (np.round(quaternion(body.world_from_body[:3, :3]), 15) + 0.0).tolist(),
        "fixed_base": body.fixed,
        "links": {safe(link.name): link.path for link in body.links},
        "joints": {
            safe(joint.name): {"position": 0.0, "friction": joint.friction} for joint in moving
        },
    }
