"""Rails of hooks on a wall, to hang coats, bags and towels from."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import row, solid, walls
from openrooms_usd.furniture.joinery.boards import board
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style, numbered
from openrooms_usd.furniture.record import MADE_TO_MEASURE, BuiltCategory
from openrooms_usd.furniture.schemes import METAL, scheme
from openrooms_usd.geometry.mesh import Mesh, joined
from openrooms_usd.geometry.solids import sphere
from openrooms_usd.geometry.sweeps import tube


def _hook(reach: float, tall: float) -> Mesh:
    """A double hook on the plane y = 0, about the origin."""
    path = [
        (0.0, 0.0, 0.0),
        (0.0, -0.45 * reach, -0.25 * tall),
        (0.0, -reach, 0.0),
        (0.0, -0.97 * reach, 0.5 * tall),
    ]
    lower = tube(path, 0.0045, bend=0.3 * reach, bend_segments=3, segments=8)
    ball = sphere(0.008, segments=10, center=(0.0, -0.97 * reach, 0.5 * tall))
    return joined([lower, ball])


def _row(size: Size, count: int) -> list[Mesh]:
    width, depth, height = size
    span = np.linspace(-0.5, 0.5, count) * (width - min(0.18, 0.4 * width)) if count > 1 else [0.0]
    hook = _hook(depth - 0.0215, 0.5 * height)
    return [hook.moved((float(x), 0.5 * depth - 0.016, 0.36 * height)) for x in span]


def plank(size: Size, rng: np.random.Generator) -> Parts:
    """A board with hooks."""
    width, depth, height = size
    count = max(2, round(width / 0.16))
    x, y = 0.5 * width, 0.5 * depth
    return {
        "frame": board((-x, y - 0.018, 0.0), (x, y, height), 0.003),
        **numbered("hook", _row(size, count)),
    }


def single(size: Size, rng: np.random.Generator) -> Parts:
    """One hook on its plate."""
    width, depth, height = size
    x, y = 0.5 * width, 0.5 * depth
    plate = board((-x, y - 0.018, 0.0), (x, y, height), 0.003)
    return {"plate": plate, **numbered("hook", _row(size, 1))}


CATEGORY: Final = BuiltCategory(
    description="hooks on a wall",
    size=(0.7, 0.075, 0.11),
    min_size=(0.02, 0.03, 0.04),
    max_size=(2.0, 0.2, 0.4),
    styles={
        "plank": Style(plank, lambda size: size[0] > 0.2),
        "single": Style(single, lambda size: size[0] <= 0.2, (0.03, 0.06, 0.1)),
    },
    size_variation=MADE_TO_MEASURE,
    support="wall",
    mount_height=1.62,
    mass_range=(0.02, 4),
    words="hook hooks coat_hook coat_hooks hanger towel_hook wall_hook clothes_hook",
    schemes=(
        scheme("wood", metal="hook", weight=3.0),
        scheme("white", metal="hook"),
        scheme(METAL, metal="hook", needs="plate", weight=100.0),
    ),
    construction=(
        row("hook", solid(3000), "common", "metal", "paint"),
        row("plate", walls(1.5), "sheet", "metal", "paint"),
        row("frame", solid(650), "common"),
    ),
    offers_surfaces=("hook",),
)
