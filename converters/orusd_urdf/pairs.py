"""Friction of pairs for MuJoCo, which takes the larger coefficient: ours is the geometric mean."""

from collections.abc import Iterable, Iterator
from itertools import combinations
from typing import Final, Literal
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from openrooms_usd import names
from openrooms_usd.physics import pair
from openrooms_usd.physics.world import World
from orusd_urdf.frames import text
from orusd_urdf.tree import Surface, link_name

Which = Literal["all", "near", "none"]

# Coefficients that differ by less are taken as one: a pair of them is off by half of it.
_EQUAL: Final = 0.01
# Metres between things that count as near.
_NEAR: Final = 0.5


def contact_element(world: World, surfaces: Iterable[Surface], which: Which) -> Element:
    """Explicit pairs for unequal surfaces, and no contacts among the links of one body.

    The number of pairs grows with the square of that of shapes, and MuJoCo looks at each of them in
    every step.

    Args:
        world: Its bodies.
        surfaces: The geoms of its shapes.
        which: ``all`` that can meet; those that meet the room or are ``near`` at first; or
            ``none``. Others have the larger coefficient.
    """
    element = Element("contact")
    for body in world.bodies:
        for one, other in combinations(body.links, 2):
            both = {"body1": link_name(body, one), "body2": link_name(body, other)}
            SubElement(element, "exclude", both)
    rooms = {body.name for body in world.bodies if body.path == names.ROOM}
    for a, b in unequal_pairs(surfaces) if which != "none" else ():
        if which == "all" or {a.body, b.body} & rooms or _are_near(a, b):
            coefficient = text(pair.friction(a.friction, b.friction))
            both = {"geom1": a.geom, "geom2": b.geom, "friction": f"{coefficient} {coefficient}"}
            SubElement(element, "pair", both)
    return element


def unequal_pairs(surfaces: Iterable[Surface]) -> Iterator[tuple[Surface, Surface]]:
    """Pairs of different bodies that can meet and whose coefficients differ."""
    for a, b in combinations(surfaces, 2):
        larger, smaller = max(a.friction, b.friction), min(a.friction, b.friction)
        if a.body != b.body and (a.moves or b.moves) and larger - smaller > _EQUAL * larger:
            yield a, b


def _are_near(a: Surface, b: Surface) -> bool:
    gaps = np.maximum(a.bounds[0] - b.bounds[1], b.bounds[0] - a.bounds[1])
    return bool(gaps.max() < _NEAR)
