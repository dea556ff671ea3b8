"""Office chairs on castors: a net back with armrests, a padded high back, a plain small one."""

from typing import Final

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.furniture.construction import ALUMINIUM, ANY, STEEL, filled, row, walls
from openrooms_usd.furniture.joinery.boards import SIDE, board, profiled, strip
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style, numbered
from openrooms_usd.furniture.record import BuiltCategory, Classes
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.curves import filleted, rectangle
from openrooms_usd.geometry.mesh import Mesh, joined
from openrooms_usd.geometry.rotations import about_z
from openrooms_usd.geometry.solids import cushion, cylinder, lathe
from openrooms_usd.geometry.sweeps import extrude, sheet, tube

# Radius of the castors' wheels, and the room that a castor takes about its stem, metres.
WHEEL: Final = 0.026
CASTOR: Final = 0.04


def seat_height(height: float) -> float:
    """Where one sits in a chair of a given height, metres."""
    return float(np.clip(0.47 * height, 0.36, 0.5))


def _castor(heading: float) -> Mesh:
    """Two wheels under a hood, the stem above the origin; ``heading`` in radians."""
    r, thick = WHEEL, 0.013
    tyre = [
        (0.0, 0.0),
        (r - 0.004, 0.0),
        (r, 0.004),
        (r, thick - 0.004),
        (r - 0.004, thick),
        (0.0, thick),
    ]
    wheel = lathe(tyre, segments=12).transformed([[0, 0, 1], [1, 0, 0], [0, 1, 0]])
    angle = np.linspace(0.0, np.pi, 7)
    hood = np.stack([(r - 0.003) * np.cos(angle), r + (r - 0.003) * np.sin(angle)], axis=1)
    parts = [
        wheel.moved((0.006, 0.016, r)),
        wheel.moved((-0.006 - thick, 0.016, r)),
        profiled(hood, 0.01, SIDE, 0.001).moved((0.0, 0.016, 0.0)),
        cylinder(0.007, 0.03, segments=10, base=(0.0, 0.0, r + 0.012)),
    ]
    return joined(parts).transformed(about_z(heading))


def _base(size: Size, seat: float, rng: np.random.Generator) -> tuple[Parts, float]:
    """The star on castors and its column, and the y over which they stand."""
    width, depth, _ = size
    angle = np.radians(90.0 + 72.0 * np.arange(5))
    star = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    low, high = star.min(axis=0), star.max(axis=0)
    reach = np.array([width, depth]) - 2.0 * CASTOR
    feet = (star - 0.5 * (low + high)) * reach / (high - low)
    hub = -0.5 * (low + high) * reach / (high - low)
    root = 0.105
    arms = [_arm_of_star(hub, foot, root) for foot in feet]
    # They trail outwards, more or less.
    headings = angle - 0.5 * np.pi + rng.uniform(-0.5, 0.5, len(feet))
    castors = [
        _castor(float(h)).moved((*foot, 0.0)) for h, foot in zip(headings, feet, strict=True)
    ]
    y = float(hub[1])
    column = lathe(
        [
            (0.0, root - 0.03),
            (0.036, root - 0.03),
            (0.036, root + 0.045),
            (0.027, root + 0.05),
            (0.027, 0.55 * seat + 0.03),
            (0.015, 0.55 * seat + 0.032),
            (0.015, seat - 0.1),
            (0.0, seat - 0.1),
        ],
        segments=20,
    ).moved((0.0, y, 0.0))
    return {**numbered("leg", arms), **numbered("wheel", castors), "column": column}, y


def _arm_of_star(hub: Array, foot: Array, root: float) -> Mesh:
    """A hollow-looking arm that falls from the hub to the stem of a castor."""
    reach = float(np.linalg.norm(foot - hub))
    line = np.array([[0.0, root], [0.35 * reach, root - 0.004], [reach, 0.072]])
    profile = strip(filleted(line, 0.3), 0.052, 0.022)
    arm = profiled(profile, 0.04, SIDE, 0.005)
    points = arm.points.copy()
    points[:, 0] *= 1.0 - 0.4 * points[:, 1] / reach
    tip = cylinder(0.015, 0.03, segments=12, base=(0.0, reach, 0.053))
    c, s = (foot - hub)[::-1] / reach
    turn = np.array([[c, s, 0, hub[0]], [-s, c, 0, hub[1]], [0, 0, 1, 0], [0, 0, 0, 1.0]])
    return joined([Mesh(points, arm.counts, arm.indices, arm.normals, arm.st), tip]).transformed(
        turn
    )


def _mechanism(y: float, seat: float) -> Parts:
    """The box under the seat with its lever."""
    lever = tube(
        [(0.04, y + 0.03, seat - 0.09), (0.2, y + 0.03, seat - 0.1), (0.25, y + 0.03, seat - 0.08)],
        0.005,
        bend=0.03,
        segments=8,
    )
    return {
        "mechanism": board((-0.08, y - 0.11, seat - 0.115), (0.08, y + 0.13, seat - 0.07), 0.012),
        "lever": lever,
    }


def _seat_pad(width: float, depth: float, thick: float, y: float, top: float) -> Mesh:
    """A cushion whose front edge falls away under the knees."""
    pad = cushion((width, depth, thick), radius=0.035, crown=(0.012, 0.012, 0.012))
    points = pad.points.copy()
    ahead = np.clip((-points[:, 1] / depth - 0.15) / 0.35, 0.0, 1.0)
    points[:, 2] -= 0.03 * ahead**2
    return Mesh(points, pad.counts, pad.indices, pad.normals, pad.st).moved(
        (0.0, y, top - 0.5 * thick)
    )


def _armrests(x: float, y: float, seat: float, top: float) -> Parts:
    """A post from under the seat at each side, and a pad on it."""
    pads, posts = [], []
    for side in (-1.0, 1.0):
        path = [
            (side * 0.1, y, seat - 0.085),
            (side * (x - 0.03), y, seat - 0.085),
            (side * (x - 0.035), y, top - 0.02),
        ]
        posts.append(tube(path, 0.014, bend=0.05, bend_segments=5, segments=10))
        outline = filleted(rectangle(0.075, 0.24), 0.035, closed=True)
        pad = extrude(outline, 0.028, bevel=0.008, base=top - 0.028)
        pads.append(pad.moved((side * (x - 0.0375), y - 0.02, 0.0)))
    return {**numbered("arm", pads), **numbered("arm_support", posts)}


def task(size: Size, rng: np.random.Generator) -> Parts:
    """A frame with a net for the back, a padded seat, and armrests."""
    width, depth, height = size
    seat = seat_height(height)
    parts, y = _base(size, seat, rng)
    wide = min(0.5, width - 0.11)
    deep = min(0.48, 0.74 * depth)
    middle = y - 0.02
    rear = middle + 0.5 * deep - 0.02
    low, lean = seat + 0.05, min(0.12, 0.5 * depth - rear - 0.02)
    grid = _back_grid(0.93 * wide, low, height - 0.008, rear, lean, float(rng.uniform(0.72, 0.9)))
    loop = np.concatenate([grid[0], grid[1:, -1], grid[-1, -2::-1], grid[-2:0:-1, 0]])
    spine = [
        (0.0, y + 0.08, seat - 0.09),
        (0.0, rear + 0.05, seat - 0.07),
        (0.0, rear + 0.055, seat + 0.06),
        (0.0, rear + 0.45 * lean + 0.035, seat + 0.5 * (height - seat)),
    ]
    arm_top = min(seat + 0.21, height - 0.1)
    return {
        **parts,
        **_mechanism(y, seat),
        "seat_cushion": _seat_pad(wide, deep, 0.075, middle, seat),
        "back": sheet(grid, 0.006),
        "back_frame": tube(loop, 0.011, segments=8, closed=True),
        "back_support": tube(spine, 0.016, bend=0.06, bend_segments=5, segments=10),
        **_armrests(0.5 * min(width, 0.7), y + 0.02, seat, arm_top),
    }


def _back_grid(
    wide: float,
    low: float,
    high: float,
    y: float,
    lean: float,
    taper: float,
    bulge: float = 0.03,
    wrap: float = 0.045,
) -> Array:
    """(R, C, 3) a back that leans, bulges at the loins and wraps forwards at its sides."""
    u, v = np.linspace(-1.0, 1.0, 13), np.linspace(0.0, 1.0, 13)
    ends = np.clip(np.minimum(v, 1.0 - v) / 0.14, 0.0, 1.0)
    half = 0.5 * wide * np.interp(v, [0, 0.35, 1], [0.86, 1.0, taper])
    half *= 0.8 + 0.2 * np.sqrt(1.0 - (1.0 - ends) ** 2)
    line = y + lean * v**1.4 - bulge * np.sin(np.pi * np.clip(1.3 * v, 0.0, 1.0))
    x = half[:, None] * u
    across = line[:, None] - wrap * u**2
    z = np.broadcast_to((low + (high - low) * v)[:, None], x.shape)
    return np.stack([x, across, z], axis=-1)


def executive(size: Size, rng: np.random.Generator) -> Parts:
    """A thick padded seat, a high back in padded bands, and closed arms."""
    width, depth, height = size
    seat = seat_height(height)
    parts, y = _base(size, seat, rng)
    wide, deep = min(0.54, width - 0.1), min(0.5, 0.76 * depth)
    middle = y - 0.01
    rear = middle + 0.5 * deep - 0.05
    count = int(rng.integers(2, 5))
    lean = max(0.02, min(0.14, 0.5 * depth - rear - 0.09))
    bands = _bands(0.96 * wide, seat - 0.03, height, rear, lean, count)
    arm_top = min(seat + 0.2, height - 0.12)
    x, reach = 0.5 * min(width, 0.72) - 0.02, 0.36 * depth
    loops = [
        tube(
            [
                (s * (x - 0.07), middle - reach * 0.4, seat - 0.05),
                (s * x, middle - reach * 0.5, arm_top - 0.012),
                (s * x, middle + reach * 0.5, arm_top - 0.012),
                (s * (x - 0.06), middle + reach * 0.5, seat - 0.05),
            ],
            0.016,
            bend=0.07,
            bend_segments=5,
            segments=10,
        )
        for s in (-1.0, 1.0)
    ]
    pad = cushion((0.055, reach * 0.75, 0.035), radius=0.015, crown=(0.002, 0.004, 0.006))
    return {
        **parts,
        **_mechanism(y, seat),
        "seat_cushion": _seat_pad(wide, deep, 0.12, middle, seat),
        **numbered("back_cushion", bands),
        "back": _shell_behind(0.9 * wide, seat - 0.06, height - 0.03, rear + 0.078, lean),
        **numbered("arm", [pad.moved((s * x, middle, arm_top - 0.012)) for s in (-1.0, 1.0)]),
        **numbered("arm_support", loops),
    }


def _bands(wide: float, low: float, high: float, y: float, lean: float, count: int) -> list[Mesh]:
    """Cushions above each other along a back that leans, metres."""
    tall = (high - low) / count
    made = []
    for i in range(count):
        narrow = 1.0 - 0.1 * (i / max(1, count - 1)) ** 2
        pad = cushion((wide * narrow, 0.1, tall + 0.012), radius=0.035, crown=(0.006, 0.014, 0.004))
        middle = (i + 0.5) / count
        shear = np.eye(3)
        shear[1, 2] = 1.3 * lean * middle**0.3 / (high - low)
        made.append(
            pad.transformed(shear).moved((0.0, y + lean * middle**1.3, low + tall * (i + 0.5)))
        )
    return made


def _shell_behind(wide: float, low: float, high: float, y: float, lean: float) -> Mesh:
    # It stays behind the cushions, which are flat: all of it is behind their backs.
    return sheet(_back_grid(wide, low, high, y, lean, 0.9, bulge=0.0, wrap=0.006), 0.02)


def clerk(size: Size, rng: np.random.Generator) -> Parts:
    """A plain chair without arms: a small padded back on one bent bar."""
    width, depth, height = size
    seat = seat_height(height)
    parts, y = _base(size, seat, rng)
    wide, deep = min(0.46, 0.78 * width), min(0.44, 0.7 * depth)
    middle = y - 0.02
    tall = min(float(rng.uniform(0.26, 0.36)), 0.7 * (height - seat))
    rear = middle + 0.5 * deep
    back = cushion((0.9 * wide, 0.06, tall), radius=0.025, crown=(0.02, 0.008, 0.02))
    points = back.points.copy()
    points[:, 1] -= 0.035 * (points[:, 0] / (0.45 * wide)) ** 2
    pad = Mesh(points, back.counts, back.indices, back.normals, back.st)
    lean = np.eye(3)
    lean[1, 2] = 0.12
    bar = [
        (0.0, y + 0.08, seat - 0.08),
        (0.0, rear + 0.06, seat - 0.06),
        (0.0, rear + 0.045, height - 0.6 * tall),
    ]
    return {
        **parts,
        **_mechanism(y, seat),
        "seat_cushion": _seat_pad(wide, deep, 0.07, middle, seat),
        "back_cushion": pad.transformed(lean).moved((0.0, rear + 0.02, height - 0.5 * tall)),
        "back_support": tube(bar, 0.013, bend=0.06, bend_segments=5, segments=10),
    }


CATEGORY: Final = BuiltCategory(
    description="a swivel chair on castors",
    size=(0.66, 0.66, 1.05),
    min_size=(0.45, 0.45, 0.7),
    max_size=(0.9, 0.95, 1.5),
    styles={
        "task": Style(task, lambda size: size[0] > 0.55),
        "executive": Style(executive, lambda size: size[0] > 0.58, (0.68, 0.72, 1.15)),
        "clerk": Style(clerk, lambda size: size[2] < 1.05, (0.6, 0.6, 0.92)),
    },
    round=True,
    one_variant_per_room=True,
    mass_range=(8, 22),
    words="swivel_chair desk_chair task_chair computer_chair rolling_chair",
    classes=Classes("chair", "chair", "swivel_chair", "chair"),
    schemes=(
        scheme("black", weight=2.0),
        scheme("black", steel="leg arm_support"),
        scheme("white", black="back arm"),
    ),
    construction=(
        row("seat_cushion seat", filled(150), "weight"),
        row("back_cushion", filled(60), "foam"),
        row("leg", walls(4, ALUMINIUM), "common"),
        row("mechanism", walls(4, STEEL), "weight"),
        row("column back_support", walls(3, STEEL), "common"),
        row("arm_support", walls(2.5, STEEL), "common"),
        row("back back_frame arm", walls(3, 1100), "common"),
        row(ANY, filled(110), "weight"),
    ),
    view_importance=0.8,
)
