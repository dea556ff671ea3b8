"""The friction of a floor from what it looks like: the mean of its per-pixel map."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from openrooms_usd.physics.world import Body, Contact, Link, Shape, World
from openrooms_usd.rendering.contract import View
from openrooms_usd.rendering.friction import FRICTION


def mean_friction(view: View, legend: Mapping[int, str], semantic: str = "floor") -> float:
    """The mean of the static coefficient over the pixels of a class: what an engine may take.

    Args:
        view: With the channels ``friction`` and ``semantic``.
        legend: What the numbers of ``semantic`` mean.
        semantic: The class.

    Returns:
        The mean; NaN where the class is not seen.
    """
    numbers = [number for number, name in legend.items() if name == semantic]
    seen = np.isin(view.images["semantic"].pixels[..., 0], numbers)
    values = view.images[FRICTION].pixels[..., 0][seen]
    return float(values.mean(dtype=np.float64)) if seen.any() else float("nan")


def with_friction(world: World, ending: str, coefficient: float) -> World:
    """The world with one coefficient for all shapes of some surface.

    Args:
        world: A room.
        ending: What the name of a shape or the path of its link ends with, in any case, such as
            ``floor``.
        coefficient: Static; the dynamic one keeps its ratio to it.
    """

    def fits(link: Link, shape: Shape) -> bool:
        return shape.name.lower().startswith(ending) or link.path.lower().endswith(ending)

    def refitted(body: Body) -> Body:
        links = (
            replace(
                link,
                shapes=tuple(
                    replace(shape, contact=_scaled(shape.contact, coefficient))
                    if fits(link, shape)
                    else shape
                    for shape in link.shapes
                ),
            )
            for link in body.links
        )
        return replace(body, links=tuple(links))

    return replace(world, bodies=tuple(map(refitted, world.bodies)))


def _scaled(contact: Contact, coefficient: float) -> Contact:
    old = contact.static_friction
    ratio = contact.dynamic_friction / old if old > 0.0 else 1.0
    return replace(contact, static_friction=coefficient, dynamic_friction=ratio * coefficient)
