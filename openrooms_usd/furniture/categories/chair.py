"""Chairs: slatted wood, a moulded shell, padded seats, a bent steel tube, armchairs."""

from dataclasses import replace
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array, Mask
from openrooms_usd.furniture.categories.sofa import modern
from openrooms_usd.furniture.construction import SEAT_ROWS
from openrooms_usd.furniture.joinery.boards import (
    bent_post,
    board,
    corners,
    round_leg,
    splayed,
    square_leg,
    strip,
)
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style, numbered
from openrooms_usd.furniture.record import BuiltCategory, Classes
from openrooms_usd.furniture.schemes import CHAIRS
from openrooms_usd.geometry.curves import filleted, lengths, rectangle
from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.geometry.solids import cushion
from openrooms_usd.geometry.sweeps import extrude, sheet, tube
from openrooms_usd.geometry.vectors import points_at, unit

SEAT_HEIGHT: Final = 0.45
ARMCHAIR_WIDTH: Final = 0.64


def seat_height(height: float) -> float:
    """Where one sits: 45 cm in a chair of any height, lower only in stools and toys."""
    return SEAT_HEIGHT if height >= 0.68 else 0.62 * height


def slat(size: Size, rng: np.random.Generator) -> Parts:
    """A wooden chair: posts bent backwards, slats or ladder rungs between them."""
    width, depth, height = size
    seat = seat_height(height)
    t = min(0.034, 0.1 * width)
    rear, lean = 0.5 * depth - 0.5 * t, min(0.09, 0.18 * depth)
    kink = (rear - lean, seat)
    post = bent_post(
        [(rear - 0.45 * lean, 0.0), kink, (rear - 0.012, height)], t, t * 0.85, end=t * 0.7
    )
    x = 0.5 * (width - t)
    front = square_leg(t, 0.72 * t, seat - 0.02)
    y = -0.5 * depth + 0.5 * t + 0.012
    legs = [
        front.moved((-x, y, 0.0)),
        front.moved((x, y, 0.0)),
        post.moved((x, 0.0, 0.0)),
        post.moved((-x, 0.0, 0.0)),
    ]
    span = (y, kink[0])
    return {
        **numbered("leg", legs),
        "seat": _wooden_seat(width, -0.5 * depth, kink[0] - 0.5 * t, seat),
        **numbered("frame", _aprons(x, span, seat - 0.02, t)),
        **numbered("back", _slats(x, t, kink, (rear - 0.012, height), bool(rng.integers(2)))),
    }


def _wooden_seat(width: float, front: float, back: float, top: float) -> Mesh:
    outline = [
        (-0.5 * width, front),
        (0.5 * width, front),
        (0.48 * width, back),
        (-0.48 * width, back),
    ]
    return extrude(filleted(outline, 0.03, closed=True), 0.02, bevel=0.006, base=top - 0.02)


def _aprons(x: float, span: tuple[float, float], top: float, t: float) -> list[Mesh]:
    """Rails under the seat, and thin stretchers between the legs of each side."""
    (front, back), half = span, 0.5 * t
    rails = [board((-x + half, y - 0.009, top - 0.055), (x - half, y + 0.009, top)) for y in span]
    for side in (-x, x):
        rails.append(
            board((side - 0.009, front + half, top - 0.055), (side + 0.009, back - half, top))
        )
        low = 0.36 * top
        rails.append(
            board((side - 0.007, front + 0.4 * t, low), (side + 0.007, back + half, low + 0.022))
        )
    return rails


def _slats(
    x: float, t: float, low: tuple[float, float], high: tuple[float, float], ladder: bool
) -> list[Mesh]:
    """What one leans on: curved rungs, or a crest and a lower rail with upright slats between."""
    (y0, z0), (y1, z1) = low, high
    slope = (y1 - y0) / (z1 - z0)

    def rung(bottom: float, tall: float, thick: float) -> Mesh:
        u = np.linspace(-1.0, 1.0, 9)
        line = points_at(u * (x - 0.4 * t), 0.022 * (1.0 - u**2))
        flat = extrude(strip(line, thick), tall, bevel=0.004)
        return _leaning(flat, slope).moved((0.0, y0 + slope * (bottom - z0) - 0.004, bottom))

    crest = rung(z1 - 0.085, 0.07, 0.018)
    rise = z1 - z0
    if ladder:
        count = max(1, round((rise - 0.16) / 0.11))
        heights = z0 + 0.1 + (rise - 0.2) * np.arange(count) / max(count, 1)
        return [crest, *(rung(float(z), 0.045, 0.014) for z in heights)]
    lower = rung(z0 + 0.09, 0.04, 0.016)
    count = max(3, round(2.0 * x / 0.085))
    upright = board((-0.014, -0.005, 0.0), (0.014, 0.005, rise - 0.085 - 0.125))
    places = np.linspace(-1.0, 1.0, count + 2)[1:-1]
    foot = z0 + 0.128
    slats = [
        _leaning(upright, slope).moved(
            (u * (x - t), y0 + slope * (foot - z0) + 0.022 * (1.0 - u * u) - 0.004, foot)
        )
        for u in places
    ]
    return [crest, lower, *slats]


def _leaning(mesh: Mesh, slope: float) -> Mesh:
    """The mesh sheared backwards by ``slope`` metres a metre of height."""
    shear = np.eye(3)
    shear[1, 2] = slope
    return mesh.transformed(shear)


def shell(size: Size, rng: np.random.Generator) -> Parts:
    """A moulded seat and back in one curve on four splayed wooden legs."""
    width, depth, height = size
    seat = seat_height(height)
    line = _shell_line(depth, seat, height)
    grid, rows = _shell_grid(line, width, float(rng.uniform(0.82, 0.95)))
    seat_shell, back_shell = _split(sheet(grid, 0.009), grid.shape[1], rows)
    under = seat - 0.045
    leg = round_leg(0.017, 0.011, under)
    x, y = 0.5 * width - 0.02, 0.5 * depth - 0.03
    heads = corners(0.3 * width, 0.27 * depth)
    legs = [splayed(leg, foot, head) for foot, head in zip(corners(x, y), heads, strict=True)]
    bars = [
        board((-0.33 * width, y - 0.02, under - 0.012), (0.33 * width, y + 0.02, under + 0.006))
        for y in (-0.27 * depth, 0.27 * depth)
    ]
    return {
        "seat": seat_shell,
        "back": back_shell,
        **numbered("leg", legs),
        **numbered("frame", bars),
    }


def _shell_line(depth: float, seat: float, height: float) -> Array:
    """(N, 2) the shell's middle in the side view, evenly spaced."""
    half = 0.5 * depth
    bend = [
        (-half, seat - 0.035),
        (-half + 0.06, seat),
        (half - 0.14, seat - 0.018),
        (half, height),
    ]
    rough = filleted(bend, 0.11, segments=10)
    s = lengths(rough)
    even = np.linspace(0.0, s[-1], 29)
    return points_at(np.interp(even, s, rough[:, 0]), np.interp(even, s, rough[:, 1]))


def _shell_grid(line: Array, width: float, taper: float) -> tuple[Array, int]:
    """The shell's front as (R, C, 3) points, and the row at which the seat becomes the back."""
    u = np.linspace(-1.0, 1.0, 17)
    t = np.linspace(0.0, 1.0, len(line))
    ends = np.clip(np.minimum(t, 1.0 - t) / 0.16, 0.0, 1.0)
    half = 0.5 * width * (0.62 + 0.38 * np.sqrt(1.0 - (1.0 - ends) ** 2))
    half *= np.interp(t, [0.0, 0.35, 0.6, 1.0], [0.96, 1.0, 0.97, taper])
    along = unit(np.gradient(line, axis=0))
    lift = np.interp(t, [0.0, 0.25, 0.5, 0.75, 1.0], [0.004, 0.02, 0.05, 0.055, 0.03])
    wrap = lift[:, None] * u**2
    y = line[:, :1] - along[:, 1:] * wrap
    z = line[:, 1:] + along[:, :1] * wrap
    grid = points_at(half[:, None] * u, y, z)
    return grid, int(np.argmax(along[:, 1] > along[:, 0]))


def _split(mesh: Mesh, columns: int, row: int) -> tuple[Mesh, Mesh]:
    """Cut a sheet at a row of its grid; normals stay as they were, so that no seam shows."""
    rows = len(mesh.points) // 2 // columns
    owner = mesh.indices.reshape(-1, 4) % (rows * columns) // columns
    upper = owner.min(axis=1) >= row
    return _faces(mesh, ~upper), _faces(mesh, upper)


def _faces(mesh: Mesh, chosen: Mask) -> Mesh:
    """The chosen quads of a mesh and the points that they use."""
    assert mesh.normals is not None and mesh.st is not None
    corner = np.repeat(chosen, 4)
    used, indices = np.unique(mesh.indices[corner], return_inverse=True)
    return Mesh(
        points=mesh.points[used],
        counts=mesh.counts[chosen],
        indices=indices.astype(np.int32),
        normals=mesh.normals[corner],
        st=mesh.st[corner],
    )


def upholstered(size: Size, rng: np.random.Generator) -> Parts:
    """A dining chair with a padded seat and a padded, slightly curved back."""
    width, depth, height = size
    seat = seat_height(height)
    lean = min(0.1, 0.2 * depth)
    thick = 0.075
    rear = 0.5 * depth - lean
    pad = cushion((width, depth - lean + 0.01, 0.1), radius=0.035, crown=(0.004, 0.004, 0.018))
    seat_pad = pad.moved((0.0, -0.5 * lean + 0.005, seat - 0.05))
    rest = cushion(
        (width * 0.97, thick, height - seat + 0.06), radius=0.03, crown=(0.006, 0.012, 0.01)
    )
    rest = rest.moved((0.0, 0.0, 0.5 * (height - seat + 0.06)))
    slope = lean / (height - seat + 0.06)
    back = _curved(_leaning(rest, slope), 0.02, 0.5 * width).moved(
        (0.0, rear - 0.5 * thick, seat - 0.06)
    )
    top = seat - 0.09
    leg = square_leg(0.036, float(rng.uniform(0.02, 0.03)), top)
    x, y = 0.5 * width - 0.03, 0.5 * depth - 0.03
    heads = [(-x, -y), (x, -y), (x, y - lean), (-x, y - lean)]
    feet = [(-x, -y), (x, -y), (x, y - 0.25 * lean), (-x, y - 0.25 * lean)]
    legs = [splayed(leg, foot, head) for foot, head in zip(feet, heads, strict=True)]
    frame = board((-x, -y, top - 0.01), (x, y - lean, top + 0.02), 0.004)
    return {"seat_cushion": seat_pad, "back_cushion": back, **numbered("leg", legs), "frame": frame}


def _curved(mesh: Mesh, sagitta: float, half: float) -> Mesh:
    """The mesh bent forwards at its sides by ``sagitta`` metres; for gentle bends."""
    points = mesh.points.copy()
    points[:, 1] -= sagitta * (points[:, 0] / half) ** 2
    return replace(mesh, points=points)


def sled(size: Size, rng: np.random.Generator) -> Parts:
    """A cantilever: one bent steel tube, a seat and a back of plywood."""
    width, depth, height = size
    seat, radius = seat_height(height), 0.011
    x, front, rear = 0.5 * width - radius, -0.5 * depth + radius, 0.5 * depth - radius
    hip = rear - min(0.1, 0.2 * depth)
    side = [
        (rear, height - 0.03),
        (hip, seat - 0.03),
        (front, seat - 0.03),
        (front, radius),
        (rear - 0.02, radius),
    ]
    path = [(-x, *p) for p in side] + [(x, *p) for p in side[::-1]]
    frame = tube(path, radius, bend=0.055, bend_segments=6)
    seat_board = extrude(
        filleted(rectangle(width - 0.002, hip - front - 0.05), 0.05, closed=True),
        0.014,
        bevel=0.004,
        base=seat - 0.014,
    ).moved((0.0, 0.5 * (front + hip) - 0.01, 0.0))
    u = np.linspace(-1.0, 1.0, 13)
    v = np.linspace(0.0, 1.0, 9)
    tall = float(rng.uniform(0.5, 0.62)) * (height - seat)
    slope = (rear - hip) / (height - seat)
    z = height - tall * (1.0 - v)
    y = hip + slope * (z - seat) - radius - 0.004
    ends = np.clip(np.minimum(v, 1.0 - v) / 0.3, 0.0, 1.0)
    half = x * (0.86 + 0.14 * np.sqrt(1.0 - (1.0 - ends) ** 2))
    grid = points_at(half[:, None] * u, y[:, None] + 0.012 - 0.02 * u**2, z[:, None])
    return {"tube": frame, "seat": seat_board, "back": sheet(grid, 0.01)}


def _slim(size: Size) -> bool:
    return size[0] < ARMCHAIR_WIDTH


CATEGORY: Final = BuiltCategory(
    description="a seat for one, with a back",
    size=(0.46, 0.53, 0.84),
    min_size=(0.34, 0.36, 0.55),
    max_size=(1.1, 1.1, 1.4),
    styles={
        "slat": Style(slat, _slim),
        "shell": Style(shell, _slim),
        "upholstered": Style(upholstered, _slim),
        "sled": Style(sled, _slim),
        "armchair": Style(modern, lambda size: not _slim(size)),
    },
    one_variant_per_room=True,
    mass_range=(2.3, 10),
    words="dining_chair folding_chair chairs high_chair highchair wheelchair",
    classes=Classes("chair", "chair", "chair", "chair"),
    synsets=("03001627",),
    schemes=CHAIRS,
    construction=SEAT_ROWS,
    offers_surfaces=("chair_back", "chair_seat"),
    view_importance=0.4,
)
