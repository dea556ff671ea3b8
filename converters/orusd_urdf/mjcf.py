"""A world as MJCF: one scene that MuJoCo compiles, with its meshes and pictures beside it."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Final
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

from openrooms_usd import atomic
from openrooms_usd.engines import DEFAULT_FRICTION, DEFAULT_TIMESTEP, Friction
from openrooms_usd.physics.world import World
from orusd_urdf.assets import Assets
from orusd_urdf.checking import check_world
from orusd_urdf.frames import text
from orusd_urdf.looks import Look, Loss
from orusd_urdf.pairs import MAX_PAIRS, Choice, Which, chosen, contact_element
from orusd_urdf.tree import Tree, joint_name, link_name

__all__ = ["joint_name", "link_name", "write_mjcf", "write_model"]

SCENE: Final = "scene.xml"
NAMES: Final = "names.json"

# Coulomb's round cone, and friction that is firmer than the normal force and swept again: nothing
# creeps at rest.
_OPTIONS: Final = {
    "timestep": text(DEFAULT_TIMESTEP),
    "integrator": "implicitfast",
    "cone": "elliptic",
    "impratio": "10",
    "noslip_iterations": "5",
    # Its sparse Newton blows up where wheels are driven over round cones.
    "jacobian": "dense",
}
# What a furnished room's contacts may take, far more than MuJoCo guesses: the sweeps against slip
# hold a square matrix of them. Nothing is taken before it is needed.
_MEMORY: Final = "2G"
# Contacts without bounce, as stiff as the step allows: things sink in by micrometres.
_RIGID: Final = {
    "solref": text([2.0 * DEFAULT_TIMESTEP, 1.0]),
    "solimp": text([0.95, 0.99, 0.001, 0.5, 2.0]),
}


def write_mjcf(
    world: World,
    folder: Path,
    *,
    looks: Mapping[str, Look],
    friction: Friction = DEFAULT_FRICTION,
    pairs: Choice = "auto",
) -> list[Loss]:
    """Write a world as ``scene.xml``, all or nothing.

    ``names.json`` beside it says which prim each body, joint and geom is.

    Args:
        world: What to write.
        folder: It receives the scene, ``meshes`` and ``textures``.
        looks: What materials look like, by the paths of their prims.
        friction: Which coefficient of each surface counts.
        pairs: Which unequal surfaces get the coefficient that they have together
            (`pairs.chosen`).

    Returns:
        What was lost.

    Raises:
        StageError: The world is impossible.
        OutputError: A file cannot be written.
    """
    check_world(world)
    with atomic.filling(folder) as beside:
        tree = Tree(Assets(beside), looks, friction)
        which = _write_scene(world, tree, beside, pairs=pairs)
        found = json.dumps(tree.prims, indent=1, ensure_ascii=False)
        atomic.write_text(beside / NAMES, f"{found}\n")
    losses = [*tree.assets.losses, *tree.losses, *_restitution(world)]
    return [*losses, *_left_out(which, pairs)]


def write_model(
    world: World, folder: Path, *, friction: Friction = DEFAULT_FRICTION, pairs: Choice = "auto"
) -> Path:
    """Write a world without anything to look at.

    Args:
        world: What to write.
        folder: Where.
        friction: Which coefficient of each surface counts.
        pairs: As for `write_mjcf`.

    Returns:
        The scene's file.

    Raises:
        StageError: The world is impossible.
        OutputError: A file cannot be written.
    """
    check_world(world)
    _write_scene(world, Tree(Assets(folder), None, friction), folder, pairs=pairs)
    return folder / SCENE


def _write_scene(world: World, tree: Tree, folder: Path, *, pairs: Choice) -> Which:
    root = Element("mujoco", model="room")
    SubElement(root, "compiler", angle="radian", autolimits="true")
    SubElement(root, "option", {"gravity": text(world.gravity), **_OPTIONS})
    SubElement(root, "size", memory=_MEMORY)
    root.append(_defaults())
    bodies = Element("worldbody")
    bodies.extend(tree.body(body) for body in world.bodies)
    which = chosen(tree.surfaces, pairs)
    root.extend([tree.asset(), bodies, contact_element(world, tree.surfaces, which)])
    ElementTree.indent(root)
    atomic.write_text(folder / SCENE, ElementTree.tostring(root, encoding="unicode") + "\n")
    return which


def _defaults() -> Element:
    """What is seen does not collide, what collides is not seen; no geom gives mass."""
    element = Element("default")
    visual = SubElement(element, "default", {"class": "visual"})
    SubElement(visual, "geom", type="mesh", contype="0", conaffinity="0", group="2", mass="0")
    collision = SubElement(element, "default", {"class": "collision"})
    SubElement(collision, "geom", {"condim": "3", "group": "3", "mass": "0", **_RIGID})
    SubElement(element, "pair", {"condim": "3", **_RIGID})
    return element


def _left_out(which: Which, asked: Choice) -> list[Loss]:
    """What is said of pairs that are not written."""
    if which == "all":
        return []
    what = {
        "near": "unequal surfaces that are apart",
        "close": "unequal surfaces that do not touch at first",
        "none": "unequal surfaces",
    }[which]
    why = f": all pairs would be more than {MAX_PAIRS:,} (pairs=all)" if asked == "auto" else ""
    return [("/", "approximated", f"{what} have the larger coefficient{why}")]


def _restitution(world: World) -> list[Loss]:
    contacts = (s.contact for body in world.bodies for link in body.links for s in link.shapes)
    if not any(contact.restitution > 0.0 for contact in contacts):
        return []
    return [("/", "approximated", "MuJoCo knows no restitution: nothing bounces")]
