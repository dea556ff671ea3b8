"""Doors that stand by themselves, frame and all: panelled, flush and glazed, one leaf or two."""

from functools import partial
from typing import Final

import numpy as np

from openrooms_usd.building import leaves
from openrooms_usd.building.doors import door
from openrooms_usd.furniture.construction import ANY, filled, row, solid
from openrooms_usd.furniture.joinery.assembly import Assembly
from openrooms_usd.furniture.joinery.pieces import Furniture, Size, Style
from openrooms_usd.furniture.record import BuiltCategory, Classes, JointDamping
from openrooms_usd.furniture.schemes import scheme

# What stands around the opening: casings beside and above it, handles before and casings behind it.
_BESIDE, _ABOVE, _BEFORE, _BEHIND = 0.12, 0.06, 0.063, 0.015
_WIDE_OPEN: Final = 110.0


def build(size: Size, rng: np.random.Generator, style: str) -> Furniture:
    """A door in a frame as thick as the box allows; it opens to the front."""
    width, depth, height = size
    tall = height - _ABOVE
    made = door(
        width - _BESIDE,
        tall,
        depth - _BEFORE - _BEHIND,
        hinge="right" if rng.integers(2) else "left",
        style=style,
    )
    up = np.array([0.0, 0.0, 0.5 * tall])
    parts = Assembly()
    parts.add("frame", made.frame.moved(up))
    for leaf in made.leaves:
        at = np.array([*leaf.hinge, 0.0]) + up
        names = parts.add("door", leaf.panel.moved(at)) + parts.add("handle", leaf.handle.moved(at))
        if leaf.pane:
            names += parts.add("pane", leaf.pane.moved(at))
        parts.hinge("door", names, at, "left" if leaf.sense < 0.0 else "right", _WIDE_OPEN)
    return parts.furniture()


STYLES: Final = {name: Style(partial(build, style=name)) for name in leaves.STYLES}


CATEGORY: Final = BuiltCategory(
    description="a door with its frame",
    size=(1.0, 0.19, 2.1),
    min_size=(0.5, 0.17, 1.2),
    max_size=(3.0, 0.6, 3.2),
    styles=STYLES,
    alternative_supports=("wall",),
    fixed=True,
    words="doors doorway",
    classes=Classes("door", "door", "door"),
    schemes=(
        scheme("white", wood="threshold", weight=2.0),
        scheme("white", wood="panel door threshold"),
    ),
    construction=(
        row("frame", solid(), "common"),
        row(f"door leaf panel {ANY}", filled(350), "weight", "wood", "paint"),
    ),
    joint_damping=JointDamping(1.0, 1.0),
    view_importance=0.0,
)
