"""Jars, bottles and bowls, turned on a lathe; all are hollow."""

from collections.abc import Sequence

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.furniture.joinery.pieces import Parts, Size, numbered
from openrooms_usd.furniture.joinery.posing import band, turned
from openrooms_usd.geometry.curves import filleted
from openrooms_usd.geometry.mesh import Mesh, joined
from openrooms_usd.geometry.normals import with_normals
from openrooms_usd.geometry.solids import cylinder, lathe, sphere
from openrooms_usd.geometry.sweeps import tube
from openrooms_usd.geometry.uv import cube_projection

Line = Sequence[tuple[float, float]]


def _radius(size: Size) -> float:
    return 0.5 * min(size[0], size[1])


def hollow(outer: Line, wall: float, floor: float, rounding: float, segments: int = 40) -> Mesh:
    """A vessel open above.

    Args:
        outer: Radius and height of its outside from the foot to the rim, metres.
        wall: Its thickness.
        floor: Height of the inside's lowest point.
        rounding: Of the outline's corners; 0 for one that is smooth already.
        segments: Sides around the axis.
    """
    line = np.asarray([(0.0, outer[0][1]), *outer])
    if rounding > 0.0:
        line = filleted(line, rounding, segments=5)
    kept = line[line[:, 1] >= floor]
    inner = kept - [wall, 0.0]
    inner[:, 0] = np.maximum(inner[:, 0], 0.15 * wall)
    base = float(np.interp(floor, line[:, 1], line[:, 0])) - wall
    inside = np.concatenate([inner[::-1], [(max(base, 0.2 * wall), floor), (0.0, floor)]])
    steps = np.linalg.norm(np.diff(inside, axis=0), axis=1) > 1e-6
    profile = np.concatenate([line, inside[:-1][steps], inside[-1:]])
    return lathe(profile, segments=segments, crease=50.0)


def smooth_line(points: Line, count: int = 28) -> list[tuple[float, float]]:
    """A curve through points by monotone time and cubic segments (Catmull-Rom)."""
    p = np.asarray([points[0], *points, points[-1]], dtype=np.float64)
    t = np.linspace(0.0, len(points) - 1.0, count)
    i = np.minimum(t.astype(int), len(points) - 2)
    u = (t - i)[:, None]
    a, b, c, d = (p[i + k] for k in range(4))
    curve: Array = 0.5 * (
        2.0 * b
        + (c - a) * u
        + (2.0 * a - 5.0 * b + 4.0 * c - d) * u**2
        + (3.0 * b - a - 3.0 * c + d) * u**3
    )
    return [(float(r), float(z)) for r, z in curve]


def jar_ginger(size: Size, rng: np.random.Generator) -> Parts:
    """A bellied ceramic jar with a domed lid."""
    r, h = _radius(size), size[2]
    neck = float(rng.uniform(0.5, 0.6)) * r
    body = smooth_line(
        [
            (0.62 * r, 0.0),
            (0.7 * r, 0.06 * h),
            (0.95 * r, 0.35 * h),
            (0.985 * r, 0.52 * h),
            (0.78 * r, 0.72 * h),
            (neck, 0.78 * h),
            (neck, 0.84 * h),
        ]
    )
    scale = r / max(radius for radius, _ in body)
    body = [(radius * scale, z) for radius, z in body]
    dome = smooth_line(
        [
            (neck * 1.22, 0.82 * h),
            (neck * 1.24, 0.86 * h),
            (0.8 * neck, 0.93 * h),
            (0.14 * neck, 0.955 * h),
        ],
        14,
    )
    lid = lathe(
        [(0.0, 0.825 * h), (neck * 1.2, 0.825 * h), *dome[1:], (0.0, 0.956 * h)], segments=36
    )
    knob = sphere(0.035 * h, segments=16, center=(0.0, 0.0, 0.965 * h))
    return {"container": hollow(body, 0.04 * r, 0.05 * h, 0.0), "lid": lid, "handle": knob}


def jar_preserving(size: Size, rng: np.random.Generator) -> Parts:
    """A straight one with shoulders, a screwed metal lid and a ring around its neck."""
    r, h = _radius(size), size[2]
    wide = float(rng.uniform(0.76, 0.84)) * r
    body = [(0.94 * r, 0.0), (r, 0.05 * h), (r, 0.72 * h), (wide, 0.82 * h), (wide, 0.9 * h)]
    ribs = int(rng.integers(28, 40))
    lid = cylinder(1.06 * wide, 0.15 * h, bevel=0.03 * h, segments=ribs, base=(0.0, 0.0, 0.85 * h))
    ring = band(wide - 0.01 * r, 1.05 * wide, 0.815 * h, 0.84 * h)
    return {"container": hollow(body, 0.05 * r, 0.04 * h, 0.08 * r), "lid": lid, "frame": ring}


def jar_canister(size: Size, rng: np.random.Generator) -> Parts:
    """A cylinder for the kitchen under a thick wooden lid."""
    r, h = _radius(size), size[2]
    split = float(rng.uniform(0.84, 0.89)) * h
    body = [(0.97 * r, 0.0), (r, 0.02 * h), (r, split)]
    lid = cylinder(
        0.985 * r, h - split - 0.001, bevel=0.004, segments=40, base=(0.0, 0.0, split + 0.001)
    )
    plug = cylinder(0.9 * r, 0.05 * h, segments=40, base=(0.0, 0.0, split - 0.045 * h))
    seal = band(0.89 * r, 0.93 * r, split - 0.02 * h, split - 0.005 * h, 36)
    label = band(r - 0.0004, r, 0.3 * h, 0.55 * h, 40)
    container = hollow([(0.995 * a, z) for a, z in body], 0.06 * r, 0.04 * h, 0.004)
    return {"container": container, "lid": joined([lid, plug]), "seal": seal, "label": label}


def bottle_wine(size: Size, rng: np.random.Generator) -> Parts:
    """A bottle with shoulders, a long neck, a label and a sealed cork."""
    r, h = _radius(size), size[2]
    neck, shoulder = 0.36 * r, float(rng.uniform(0.56, 0.63)) * h
    body = smooth_line(
        [
            (neck, 0.74 * h),
            (0.42 * r, 0.71 * h),
            (0.86 * r, shoulder + 0.04 * h),
            (r, shoulder - 0.03 * h),
        ],
        12,
    )[::-1]
    peak = max(a for a, _ in body)
    body = [(a * r / peak, z) for a, z in body]
    outer = [
        (0.93 * r, 0.0),
        (r, 0.02 * h),
        *body,
        (neck, 0.95 * h),
        (1.15 * neck, 0.955 * h),
        (1.15 * neck, 0.98 * h),
        (0.95 * neck, 0.99 * h),
    ]
    label = band(r - 0.0005, 1.006 * r, 0.14 * h, 0.42 * h, 40)
    cap = lathe(
        [
            (0.0, 0.86 * h),
            (1.02 * neck, 0.86 * h),
            (1.04 * neck, 0.945 * h),
            (1.22 * neck, 0.95 * h),
            (1.22 * neck, h - 0.002),
            (1.1 * neck, h),
            (0.0, h),
        ],
        segments=28,
    )
    return {
        "container": lathe([(0.0, 0.0), *outer, (0.0, 0.99 * h)], segments=40),
        "label": label,
        "lid": cap,
    }


def bottle_sport(size: Size, rng: np.random.Generator) -> Parts:
    """A steel flask with a screwed lid and a loop to carry it."""
    r, h = _radius(size), size[2]
    top = 0.8 * h
    body = [
        (0.9 * r, 0.0),
        (r, 0.03 * h),
        (r, top - 0.1 * h),
        (0.66 * r, top),
        (0.66 * r, top + 0.02 * h),
    ]
    lid = cylinder(0.72 * r, 0.1 * h, bevel=0.004, segments=30, base=(0.0, 0.0, top + 0.01 * h))
    thick = 0.07 * r
    arch = [
        (-0.5 * r, 0.0, top + 0.07 * h),
        (-0.5 * r, 0.0, h - thick),
        (0.5 * r, 0.0, h - thick),
        (0.5 * r, 0.0, top + 0.07 * h),
    ]
    loop = turned(tube(arch, thick, bend=0.3 * r, segments=10), "z", float(rng.uniform(0.0, 180.0)))
    outline = filleted([(0.0, 0.0), *body, (0.0, top + 0.02 * h)], 0.12 * r, segments=5)
    return {"container": lathe(outline, segments=36), "lid": lid, "handle": loop}


def bottle_pump(size: Size, rng: np.random.Generator) -> Parts:
    """A soap dispenser: a rounded body, a pump with a spout to the front."""
    r, h = _radius(size), size[2]
    top = 0.7 * h
    body = [
        (0.93 * r, 0.0),
        (r, 0.02 * h),
        (r, top - 0.12 * h),
        (0.4 * r, top),
        (0.4 * r, top + 0.02 * h),
    ]
    outline = filleted(
        [(0.0, 0.0), *body, (0.0, top + 0.02 * h)], float(rng.uniform(0.2, 0.45)) * r, segments=6
    )
    collar = cylinder(0.46 * r, 0.07 * h, bevel=0.003, segments=28, base=(0.0, 0.0, top))
    stem = cylinder(0.11 * r, 0.2 * h, segments=14, base=(0.0, 0.0, top + 0.05 * h))
    head = cylinder(0.3 * r, 0.05 * h, bevel=0.004, segments=24, base=(0.0, 0.0, 0.95 * h))
    nozzle = [(0.0, 0.0, 0.975 * h), (0.0, -0.8 * r, 0.975 * h), (0.0, -0.98 * r, 0.94 * h)]
    spout = tube(nozzle, 0.09 * r, bend=0.15 * r, segments=10)
    return {
        "container": lathe(outline, segments=36),
        "lid": collar,
        "frame": stem,
        "handle": joined([head, spout]),
    }


def bowl_round(size: Size, rng: np.random.Generator) -> Parts:
    """A plain bowl on a low ring."""
    r, h = _radius(size), size[2]
    power = float(rng.uniform(1.7, 2.6))
    t = np.linspace(0.42, 1.0, 12)
    side = np.stack([r * t, 0.06 * h + 0.94 * h * ((t - 0.42) / 0.58) ** power], axis=1)
    outer = [(0.4 * r, 0.0), (0.42 * r, 0.05 * h), *map(tuple, side)]
    return {"container": hollow(outer, 0.03 * r, 0.1 * h, 0.0, 52)}


def bowl_footed(size: Size, rng: np.random.Generator) -> Parts:
    """A shallow dish on a stem."""
    r, h = _radius(size), size[2]
    stem = float(rng.uniform(0.08, 0.14)) * r
    foot = smooth_line(
        [
            (0.55 * r, 0.0),
            (0.5 * r, 0.05 * h),
            (stem, 0.2 * h),
            (stem, 0.42 * h),
            (0.3 * r, 0.5 * h),
        ],
        14,
    )
    dish = [(0.3 * r, 0.48 * h), (0.75 * r, 0.62 * h), (0.97 * r, 0.9 * h), (r, h)]
    bottom = lathe([(0.0, 0.0), *foot, (0.0, 0.5 * h)], segments=40, crease=50.0)
    return {"container": hollow(dish, 0.035 * r, 0.54 * h, 0.12 * r, 48), "base": bottom}


def bowl_fruit(size: Size, rng: np.random.Generator) -> Parts:
    """A wide bowl of fruit."""
    r, h = _radius(size), size[2]
    rim = 0.62 * h
    outer = [(0.5 * r, 0.0), (0.85 * r, 0.3 * rim), (r, rim)]
    ball = min(0.27 * r, 0.3 * h)
    ring = int(rng.integers(5, 7))
    start = float(rng.uniform(0.0, 2.0 * np.pi))
    fruit = []
    for i in range(ring):
        angle, size_ = start + 2.0 * np.pi * i / ring, ball * float(rng.uniform(0.9, 1.0))
        at = (0.54 * r * np.cos(angle), 0.54 * r * np.sin(angle), 0.14 * rim + size_)
        fruit.append(_fruit(size_, rng).moved(at))
    last = _fruit(ball, rng)
    fruit.append(last.moved((0.0, 0.0, h - last.extent[1, 2])))
    return {
        "container": hollow(outer, 0.03 * r, 0.1 * rim, 0.25 * r, 44),
        **numbered("fruit", fruit),
    }


def _fruit(radius: float, rng: np.random.Generator) -> Mesh:
    """An apple: dimpled above, a little narrower below."""
    t = np.linspace(-0.5 * np.pi, 0.5 * np.pi, 15)
    r = radius * np.cos(t) * (1.0 + 0.06 * np.sin(t))
    z = radius * (
        0.92 * np.sin(t) - 0.25 * np.exp(-((r / (0.3 * radius)) ** 2)) * np.sign(np.sin(t))
    )
    r[[0, -1]] = 0.0
    apple = lathe(np.stack([r, z], axis=1), segments=20)
    return turned(apple, "x", float(rng.uniform(-35.0, 35.0)))


def bowl_oval(size: Size, rng: np.random.Generator) -> Parts:
    """A rectangular dish with rounded corners and slanted sides."""
    width, depth, height = size
    corner = float(rng.uniform(0.2, 0.3)) * min(width, depth)
    lower = 0.78
    wall = 0.035 * min(width, depth)

    def outline(scale: float, inset: float) -> Array:
        x, y = 0.5 * width * scale - inset, 0.5 * depth * scale - inset
        return filleted([(-x, -y), (x, -y), (x, y), (-x, y)], corner, segments=6, closed=True)

    steps = [
        (lower, 0.0, 0.0),
        (0.99, 0.0, 0.9 * height),
        (1.0, 0.0, height),
        (1.0, wall, height),
        (lower, wall, 1.2 * wall),
    ]
    flat = [(outline(scale, inset), z) for scale, inset, z in steps]
    return {"container": _lofted([np.insert(line, 2, z, axis=1) for line, z in flat])}


def _lofted(rings: list[Array]) -> Mesh:
    """A solid whose surface passes through rings (N, 3); the first and the last are closed."""
    count, last = len(rings[0]), len(rings) - 1
    i, j = (a.ravel() for a in np.indices((last, count)))
    after = (j + 1) % count
    quads = np.stack(
        [i * count + j, i * count + after, (i + 1) * count + after, (i + 1) * count + j], 1
    )
    caps = np.concatenate([np.arange(count)[::-1], last * count + np.arange(count)])
    mesh = Mesh(
        points=np.concatenate(rings),
        counts=np.array([*[4] * len(quads), count, count], dtype=np.int32),
        indices=np.concatenate([quads.ravel(), caps]).astype(np.int32),
    )
    return with_normals(cube_projection(mesh), crease=50.0)
