"""A world as MJCF: one scene that MuJoCo compiles, with its meshes and pictures beside it."""

import json
from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations, islice
from pathlib import Path
from typing import Final, Literal
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

import numpy as np
from numpy.typing import NDArray

from openrooms_usd import atomic, claims
from openrooms_usd.arrays import Array, Mask
from openrooms_usd.engines import DEFAULT_FRICTION, DEFAULT_TIMESTEP, Friction
from openrooms_usd.physics import pair
from openrooms_usd.physics.world import World
from orusd_urdf.assets import Assets
from orusd_urdf.checking import check_world, started
from orusd_urdf.frames import place, text
from orusd_urdf.looks import Loss, RobotMaterial
from orusd_urdf.tree import ContactSurface, Tree, joint_name, link_name

Which = Literal["all", "near", "close", "none"]
Choice = Literal["auto", "all", "near", "close", "none"]

# So many pairs MuJoCo still looks at in every step; a library has hundreds of millions.
MAX_PAIRS: Final = 100_000

# Coefficients that differ by less are taken as one: a pair of them is off by half of it.
_EQUAL_FRICTION: Final = 0.01
# Metres between what can meet, and whether everything can meet the room; each needs fewer pairs.
_REACH: Final[dict[Which, tuple[float, bool]]] = {
    "all": (np.inf, True),
    "near": (0.5, True),
    "close": (0.1, False),
}


def contact_element(world: World, surfaces: Sequence[ContactSurface], which: Which) -> Element:
    """Explicit pairs for unequal surfaces, and no contacts where the world wants none.

    Args:
        world: Its bodies.
        surfaces: The geoms of its shapes.
        which: As `chosen` has it.
    """
    element = Element("contact")
    apart = excluded(world)
    for one, other in apart:
        SubElement(element, "exclude", body1=one, body2=other)
    passing = {frozenset(both) for both in apart}
    for a, b in unequal_pairs(surfaces, which):
        # An explicit pair would collide in spite of what is excluded.
        if frozenset((a.link, b.link)) not in passing:
            coefficient = text(pair.friction(a.friction, b.friction))
            both = {"geom1": a.geom, "geom2": b.geom, "friction": f"{coefficient} {coefficient}"}
            SubElement(element, "pair", both)
    return element


def chosen(surfaces: Sequence[ContactSurface], which: Choice) -> Which:
    """Which unequal surfaces get explicit pairs.

    The number of pairs grows with the square of that of shapes, and MuJoCo looks at each of them in
    every step.

    Args:
        surfaces: The geoms of all shapes.
        which: ``all`` that can meet; those that are ``near`` at first or of the room; those that
            are ``close``; or ``none``. Others have the larger coefficient. ``auto`` takes the first
            of these that has at most 100,000, and at least what is close.
    """
    if which != "auto":
        return which
    for choice in _REACH:
        if next(islice(unequal_pairs(surfaces, choice), MAX_PAIRS, None), None) is None:
            return choice
    return "close"


def excluded(world: World) -> list[tuple[str, str]]:
    """The elements of links that never collide: those of one body, and what the world says."""
    found = [
        (link_name(body, one), link_name(body, other))
        for body in world.bodies
        for one, other in combinations([link for link in body.links if not link.between], 2)
    ]
    names_of = {
        (body.name, link.name): link_name(body, link)
        for body in world.bodies
        for link in body.links
    }
    return [*found, *((names_of[one], names_of[other]) for one, other in world.apart)]


def unequal_pairs(
    surfaces: Sequence[ContactSurface], which: Which = "all"
) -> Iterator[tuple[ContactSurface, ContactSurface]]:
    """Pairs of different bodies that can meet and whose coefficients differ.

    Args:
        surfaces: The geoms of all shapes.
        which: As `chosen` gives it.
    """
    if which == "none" or not surfaces:
        return
    reach, rooms = _REACH[which]
    moves = np.array([surface.moves for surface in surfaces])
    rubs = np.array([surface.friction for surface in surfaces])
    everywhere = rooms & np.array([surface.room for surface in surfaces])
    bounds = np.stack([surface.bounds for surface in surfaces])
    others = {}
    for row, surface in enumerate(surfaces):
        if surface.body not in others:
            others[surface.body] = _others(surfaces, bounds, everywhere, surface.body, reach)
        found = others[surface.body]
        rest = found[np.searchsorted(found, row + 1) :]
        larger, smaller = np.maximum(rubs[row], rubs[rest]), np.minimum(rubs[row], rubs[rest])
        fits = (moves[rest] | moves[row]) & (larger - smaller > _EQUAL_FRICTION * larger)
        fits &= (_gaps(bounds[row], bounds[rest]) < reach) | everywhere[row] | everywhere[rest]
        for number in rest[fits].tolist():
            yield surface, surfaces[number]


def _others(
    surfaces: Sequence[ContactSurface], bounds: Array, everywhere: Mask, body: str, reach: float
) -> NDArray[np.intp]:
    """The numbers of the surfaces of other bodies that may be within reach of some of a body's."""
    own = np.array([surface.body == body for surface in surfaces])
    box = np.stack([bounds[own, 0].min(axis=0), bounds[own, 1].max(axis=0)])
    within = (_gaps(box, bounds) < reach) | everywhere | everywhere[own].any()
    return np.flatnonzero(within & ~own)


def _gaps(box: Array, boxes: Array) -> Array:
    """(N,) metres between a box and others along the axis where they are farthest apart."""
    gaps = np.maximum(box[0] - boxes[:, 1], boxes[:, 0] - box[1])
    return np.asarray(gaps.max(axis=1))


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
# So many points hold two links as a whole.
_WELD: Final = 3
# What a furnished room's contacts may take, far more than MuJoCo guesses: the sweeps against slip
# hold a square matrix of them. Nothing is taken before it is needed.
_MEMORY: Final = "2G"
# Contacts without bounce, as stiff as the step allows: things sink in by micrometres.
_RIGID: Final = {
    "solref": text([2.0 * DEFAULT_TIMESTEP, 1.0]),
    "solimp": text([0.95, 0.99, 0.001, 0.5, 2.0]),
}


# Friction of joints that holds: MuJoCo's own lets a lid droop by degrees in a second where its
# sweeps against slip have much else to do.
_DRY: Final = {
    "solreffriction": text([2.0 * DEFAULT_TIMESTEP, 1.0]),
    "solimpfriction": text([0.999, 0.999, 0.001, 0.5, 2.0]),
}


def write_mjcf(
    world: World,
    folder: Path,
    *,
    looks: Mapping[str, RobotMaterial],
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
    with claims.refilling(folder, ".orusd.mjcf.sha256") as refill:
        tree = Tree(Assets(refill.folder), looks, friction)
        which = _write_scene(world, tree, refill.folder, pairs=pairs)
        found = json.dumps(tree.prims, indent=1, ensure_ascii=False)
        atomic.write_text(refill.folder / NAMES, f"{found}\n")
    losses = [*tree.assets.losses, *tree.losses, *_restitution(world), *_moving_at_first(world)]
    return [*losses, *_left_out(which, pairs)]


def write_model(
    world: World,
    folder: Path,
    *,
    friction: Friction = DEFAULT_FRICTION,
    pairs: Choice = "auto",
    timestep: float = DEFAULT_TIMESTEP,
) -> Path:
    """Write a world without anything to look at.

    Args:
        world: What to write.
        folder: Where.
        friction: Which coefficient of each surface counts.
        pairs: As for `write_mjcf`.
        timestep: Seconds of the steps that it will be simulated with.

    Returns:
        The scene's file.

    Raises:
        StageError: The world is impossible.
        OutputError: A file cannot be written.
    """
    check_world(world)
    _write_scene(world, Tree(Assets(folder), None, friction, timestep), folder, pairs=pairs)
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
    root.append(_equality(world))
    actuators = Element("actuator")
    actuators.extend(tree.drives)
    root.append(actuators)
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
    SubElement(element, "joint", _DRY)
    return element


def _equality(world: World) -> Element:
    """Loops: points of two links that stay together, or the whole of them."""
    element = Element("equality")
    found = {
        (body.name, link.name): (link_name(body, link), body.world_from_body @ link.body_from_link)
        for body in world.bodies
        for link in body.links
    }
    for loop in world.loops:
        (one, frame), (other, _) = (found[link] for link in loop.links)
        both = {"body1": one, "body2": other, **_RIGID}
        if len(loop.points) == _WELD:
            SubElement(element, "weld", both)
            continue
        for point in loop.points:
            anchor = frame[:3, :3].T @ (point - frame[:3, 3])
            SubElement(element, "connect", {**both, "anchor": place(anchor)})
    return element


def _moving_at_first(world: World) -> list[Loss]:
    """The report on initial velocities."""
    reason = "its initial velocity is not in the file: set qvel"
    return [(path, "approximated", reason) for path in started(world)]


def _left_out(which: Which, asked: Choice) -> list[Loss]:
    """What is said of pairs that are not written."""
    if which == "all":
        return []
    what = {
        "near": "unequal surfaces that are apart",
        "close": "unequal surfaces that do not touch initially",
        "none": "unequal surfaces",
    }[which]
    why = f": all pairs would be more than {MAX_PAIRS:,} (pairs=all)" if asked == "auto" else ""
    return [("/", "approximated", f"{what} have the larger coefficient{why}")]


def _restitution(world: World) -> list[Loss]:
    contacts = (s.contact for body in world.bodies for link in body.links for s in link.shapes)
    if not any(contact.restitution > 0.0 for contact in contacts):
        return []
    return [("/", "approximated", "MuJoCo has no restitution: nothing bounces")]
