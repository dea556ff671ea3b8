"""Windows that hang on a wall, frame and all: casements, small panes, sliding sashes, fixed."""

from functools import partial
from typing import Final

import numpy as np

from openrooms_usd.building import windows
from openrooms_usd.furniture.joinery.assembly import Assembly
from openrooms_usd.furniture.joinery.pieces import Furniture, Joint, Size, Style
from openrooms_usd.furniture.record import BuiltCategory, Classes
from openrooms_usd.furniture.schemes import scheme

# The sill board stands out on both sides and into the room.
_BESIDE, _BEFORE = 0.08, 0.04
# The frame stands at 60 % of the thickness of the wall that it is built for.
_SHARE, _FRAME = 0.6, 0.07


def build(size: Size, rng: np.random.Generator, style: str) -> Furniture:
    """A window with a sill board; its sashes turn to the front, or slide."""
    width, depth, height = size
    thickness = (depth - _BEFORE - 0.5 * _FRAME) / _SHARE
    tall = height - 2.0 * windows.EMBED
    made = windows.window(width - _BESIDE, tall, thickness, board=True, style=style)
    up = np.array([0.0, 0.0, 0.5 * tall])
    parts = Assembly()
    parts.add("frame", made.frame.moved(up))
    for glass in made.panes:
        parts.add("pane", glass.moved(up))
    for number, sash in enumerate(made.sashes):
        x, y, z = (np.array(sash.origin) + up).tolist()
        names = parts.add("sash", sash.mesh.moved((x, y, z)))
        names += parts.add("pane", sash.pane.moved((x, y, z)))
        parts.joints.append(
            Joint(f"sash_{number}", sash.kind, names, (x, y, z), sash.axis, (0.0, sash.upper))
        )
    return parts.furniture()


STYLES: Final = {name: Style(partial(build, style=name)) for name in windows.STYLES}


CATEGORY: Final = BuiltCategory(
    description="a window with its frame",
    size=(1.2, 0.14, 1.3),
    min_size=(0.4, 0.12, 0.4),
    max_size=(4.0, 0.6, 3.0),
    styles=STYLES,
    support="wall",
    alternative_supports=("floor",),
    mount_height=0.9,
    fixed=True,
    words="windows",
    classes=Classes("window", "window", "windowpane"),
    schemes=(scheme("white"),),
    view_importance=0.0,
)
