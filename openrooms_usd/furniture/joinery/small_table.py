"""Low tables before sofas, and small ones beside seats and beds."""

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.furniture.joinery.assembly import Assembly
from openrooms_usd.furniture.joinery.boards import board, corners, cut_level, round_leg, splayed
from openrooms_usd.furniture.joinery.cells import BOARD, HANDLE, SEAT, columns
from openrooms_usd.furniture.joinery.fronts import drawer, drawn_look
from openrooms_usd.furniture.joinery.pieces import Furniture, Parts, Size, numbered
from openrooms_usd.geometry.curves import filleted, rectangle
from openrooms_usd.geometry.lofts import loft, ring, superellipse
from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.geometry.rotations import about_z, pose
from openrooms_usd.geometry.solids import cylinder, lathe
from openrooms_usd.geometry.sweeps import extrude, tube


def _slab(outline: Array, thick: float, high: float, bevel: float = 0.004) -> Mesh:
    return extrude(outline, thick, bevel=bevel, base=high - thick)


def hairpin(size: Size, rng: np.random.Generator) -> Parts:
    """A thick slab on four bent steel rods."""
    width, depth, height = size
    thick = float(rng.uniform(0.03, 0.045))
    under, r, spread = height - thick, 0.006, 0.045
    legs = []
    for a, b in corners(0.5 * width - 0.09, 0.5 * depth - 0.09):
        out = np.array([np.sign(a), np.sign(b)]) / np.sqrt(2.0)
        side = np.array([-out[1], out[0]])
        head, foot = np.array([a, b]), np.array([a, b]) + 0.035 * out
        path = [
            (*(head + spread * side), under),
            (*(foot + 0.012 * side), 0.7 * r),
            (*(foot - 0.012 * side), 0.7 * r),
            (*(head - spread * side), under),
        ]
        legs.append(cut_level(tube(filleted(path, 0.01), r, segments=8)))
    plates = [
        board((a - 0.05, b - 0.05, under - 0.004), (a + 0.05, b + 0.05, under), 0.001)
        for a, b in corners(0.5 * width - 0.09, 0.5 * depth - 0.09)
    ]
    return {
        "tabletop": _slab(filleted(rectangle(width, depth), 0.02, closed=True), thick, height),
        **numbered("leg", legs),
        **numbered("frame", plates),
    }


def drum(size: Size, rng: np.random.Generator) -> Parts:
    """A round or oval top on a ring of upright staves."""
    width, depth, height = size
    thick = 0.024
    under = height - thick
    count = max(18, round(np.pi * 0.5 * (width + depth) / float(rng.uniform(0.06, 0.09))))
    angle = 2.0 * np.pi * np.arange(count) / count
    share = 0.82
    staves = []
    stave = board((-0.008, -0.016, 0.018), (0.008, 0.016, under))
    for t in angle:
        x, y = share * 0.5 * width * np.cos(t), share * 0.5 * depth * np.sin(t)
        heading = np.arctan2(y / depth**2, x / width**2)
        staves.append(stave.transformed(pose(about_z(heading), (x, y, 0.0))))
    oval = superellipse(width, depth, segments=56)
    foot = superellipse(share * width + 0.03, share * depth + 0.03, segments=48)
    return {
        "tabletop": _slab(oval, thick, height, 0.008),
        **numbered("leg", staves),
        "base": _slab(foot, 0.02, 0.02),
    }


def sled(size: Size, rng: np.random.Generator) -> Parts:
    """Two closed frames of square steel under the top, tied by rails."""
    width, depth, height = size
    thick, t = float(rng.uniform(0.022, 0.04)), 0.025
    under, x, y = height - thick, 0.5 * width - 0.08, 0.5 * depth - 0.02
    frames = []
    for s in (-1.0, 1.0):
        a, b = s * x - 0.5 * t, s * x + 0.5 * t
        frames += [
            board((a, -y, 0.0), (b, t - y, under)),
            board((a, y - t, 0.0), (b, y, under)),
            board((a, t - y, 0.0), (b, y - t, t)),
            board((a, t - y, under - t), (b, y - t, under)),
        ]
    rails = [
        board((0.5 * t - x, p - 0.5 * t, under - t), (x - 0.5 * t, p + 0.5 * t, under))
        for p in (0.5 * t - y, y - 0.5 * t)
    ]
    return {
        "tabletop": _slab(filleted(rectangle(width, depth), 0.006, closed=True), thick, height),
        **numbered("leg", frames),
        **numbered("frame", rails),
    }


def chest(size: Size, rng: np.random.Generator) -> Furniture:
    """A low block with drawers in front and an open compartment above them."""
    width, depth, height = size
    made, look = Assembly(), drawn_look(rng, 0.0)
    half, front, back = 0.5 * width - 0.02, -0.5 * depth + 0.01 + HANDLE + BOARD, 0.5 * depth - 0.02
    foot, under = 0.05, height - 0.024
    middle = foot + 0.56 * (under - foot)
    made.board(
        "tabletop", (-0.5 * width, -0.5 * depth, under), (0.5 * width, 0.5 * depth, height), 0.003
    )
    made.add(
        "frame",
        *(
            board(
                (min(s * half, s * (half - BOARD)), front, foot),
                (max(s * half, s * (half - BOARD)), back, under),
            )
            for s in (-1.0, 1.0)
        ),
        board((BOARD - half, front, foot), (half - BOARD, back, foot + BOARD)),
        board((BOARD - half, back - BOARD, foot + BOARD), (half - BOARD, back, middle)),
    )
    made.board("shelf", (BOARD - half, front, middle), (half - BOARD, back, middle + BOARD))
    made.board("base", (0.04 - half, front + 0.04, 0.0), (half - 0.04, back - 0.04, foot))
    count = max(1, round(width / 0.6))
    cells = columns((-half, half, foot, middle + BOARD), count)
    for cell in cells[1:]:
        made.board(
            "frame", (cell[0] - 0.009, front, foot + BOARD), (cell[0] + 0.009, back - BOARD, middle)
        )
    for cell in cells:
        drawer(made, cell, front - SEAT, back - BOARD - 0.002, look)
    return made.furniture()


def tripod(size: Size, rng: np.random.Generator) -> Parts:
    """A round tray with a rim on three splayed legs."""
    width, depth, height = size
    rim = float(rng.uniform(0.012, 0.035))
    under = height - rim - 0.014
    outline = superellipse(width, depth, segments=44)
    inner = superellipse(width - 0.016, depth - 0.016, segments=44)
    angle = np.radians(90.0 + 120.0 * np.arange(3))
    spread = np.stack([0.5 * width * np.cos(angle), 0.5 * depth * np.sin(angle)], axis=1)
    leg = round_leg(0.014, 0.009, under + 0.004)
    path = np.concatenate([0.5 * (outline + inner), np.full((44, 1), height - 0.004)], axis=1)
    return {
        "tabletop": _slab(outline, 0.014, height - rim, 0.003),
        "rim": _hoop(outline, inner, height - rim - 0.002, height)
        if rim > 0.02
        else tube(path, 0.004, segments=8, closed=True),
        **numbered("leg", [splayed(leg, 0.92 * p, 0.42 * p) for p in spread]),
    }


def _hoop(outer: Array, inner: Array, low: float, high: float) -> Mesh:
    """A thin upright ring between two outlines."""
    rings = [ring(outer, low), ring(outer, high), ring(inner, high), ring(inner, low)]
    return loft(rings, closed=True)


def nightstand(size: Size, rng: np.random.Generator) -> Furniture:
    """A drawer over an open shelf, on short legs."""
    width, depth, height = size
    made, look = Assembly(), drawn_look(rng)
    half, foot = 0.5 * width, min(0.14, 0.3 * height)
    front, back = -0.5 * depth + HANDLE + BOARD + SEAT, 0.5 * depth
    split = foot + float(rng.uniform(0.45, 0.6)) * (height - foot)
    made.add(
        "frame",
        *(
            board(
                (min(s * half, s * (half - BOARD)), front, foot),
                (max(s * half, s * (half - BOARD)), back, height - BOARD),
            )
            for s in (-1.0, 1.0)
        ),
        board((BOARD - half, front, foot), (half - BOARD, back, foot + BOARD)),
        board((BOARD - half, back - 0.012, foot + BOARD), (half - BOARD, back, height - BOARD)),
    )
    made.board("tabletop", (-half, front, height - BOARD), (half, back, height), 0.003)
    made.board("shelf", (BOARD - half, front, split), (half - BOARD, back - 0.012, split + BOARD))
    drawer(made, (-half, half, split, height), front - SEAT, back - 0.03, look)
    leg = round_leg(0.016, 0.01, foot + 0.004)
    middle = 0.5 * (front + back)
    for a, b in corners(half - 0.05, 0.5 * (back - front) - 0.05):
        out = (a + np.sign(a) * 0.02, b + np.sign(b) * 0.02)
        made.add("leg", splayed(leg, out, (a, b)).moved((0.0, middle, 0.0)))
    return made.furniture()


def bracket(size: Size, rng: np.random.Generator) -> Parts:
    """A top held from one side by a bent steel frame, to be pushed over a seat."""
    width, depth, height = size
    thick, r = 0.02, 0.011
    under, x, y = height - thick, 0.5 * width - r, 0.5 * depth - 0.04
    side = 1.0 if rng.integers(2) else -1.0
    path = [
        (-side * x, -y, under - r),
        (side * x, -y, under - r),
        (side * x, -y, r),
        (-side * x, -y, r),
        (-side * x, y, r),
        (side * x, y, r),
        (side * x, y, under - r),
        (-side * x, y, under - r),
    ]
    outline = filleted(rectangle(width, depth), 0.03, closed=True)
    return {
        "tabletop": _slab(outline, thick, height),
        "leg": tube(path, r, bend=0.03, bend_segments=5, segments=10),
        "frame": tube([(-side * x, -y, under - r), (-side * x, y, under - r)], r, segments=10),
    }


def block(size: Size, rng: np.random.Generator) -> Parts:
    """A solid-looking cylinder waisted in its middle, such as a ceramic seat or a trunk."""
    width, depth, height = size
    r, waist = 0.5 * width, float(rng.uniform(0.62, 1.0))
    t = np.linspace(0.0, 1.0, 13)
    side = r * (1.0 - (1.0 - waist) * np.sin(np.pi * t))
    profile = np.stack([side, 0.008 + (height - 0.016) * t], axis=1)
    rounded = [(0.0, 0.0), (r - 0.008, 0.0), *profile, (r - 0.008, height), (0.0, height)]
    oval = np.diag([1.0, depth / width, 1.0])
    top = cylinder(0.94 * r, 0.004, bevel=0.001, segments=40, base=(0.0, 0.0, height - 0.0035))
    return {
        "base": lathe(rounded, segments=40)
        .transformed(oval)
        .transformed(np.diag([1.0, 1.0, (height - 0.0005) / height])),
        "tabletop": top.transformed(oval),
    }


def compact(size: Size) -> bool:
    """Whether a table of a size, metres, is about as deep as it is wide."""
    return max(size[:2]) < 1.35 * min(size[:2])
