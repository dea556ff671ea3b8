"""Toys: a teddy, building blocks, a ball, a car."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import ANY, filled, row, walls
from openrooms_usd.furniture.joinery.boards import FRONT, SIDE, profiled
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style, numbered
from openrooms_usd.furniture.joinery.posing import seated, turned
from openrooms_usd.furniture.placements import on
from openrooms_usd.furniture.record import BuiltCategory, Classes
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.mesh import Mesh, joined
from openrooms_usd.geometry.solids import cylinder, lathe, rounded_box, sphere
from openrooms_usd.geometry.uv import metric


def teddy(size: Size, rng: np.random.Generator) -> Parts:
    """A bear of cloth that sits."""
    width, depth, height = size

    def blob(rx: float, ry: float, rz: float, x: float, y: float, z: float) -> Mesh:
        unit_ = sphere(1.0, segments=16 if rx > 0.15 else 10)
        scaled = unit_.transformed(np.diag([rx * width, ry * depth, rz * height]))
        return metric(scaled)[0].moved((x * width, y * depth, z * height))

    body = [blob(0.27, 0.27, 0.28, 0.0, 0.22, 0.28), blob(0.24, 0.26, 0.205, 0.0, 0.15, 0.7)]
    limbs = [blob(0.12, 0.3, 0.1, s * 0.26, -0.18, 0.1) for s in (-1, 1)]
    arms = [
        turned(blob(0.09, 0.1, 0.2, 0.0, 0.0, 0.0), "y", -s * 32.0).moved(
            (s * 0.36 * width, 0.07 * depth, 0.4 * height)
        )
        for s in (-1, 1)
    ]
    ears = [blob(0.085, 0.07, 0.075, s * 0.19, 0.19, 0.915) for s in (-1, 1)]
    snout = blob(0.1, 0.12, 0.075, 0.0, -0.1, 0.655)
    soles = [blob(0.09, 0.03, 0.078, s * 0.26, -0.475, 0.1) for s in (-1, 1)]
    eyes = [blob(0.018, 0.02, 0.016, s * 0.09, -0.088, 0.745) for s in (-1, 1)]
    nose = blob(0.035, 0.03, 0.022, 0.0, -0.21, 0.685)
    return {
        "toy": joined([*body, *limbs, *arms, *ears]),
        "pad": joined([snout, *soles]),
        "eye": joined([*eyes, nose]),
    }


def blocks(size: Size, rng: np.random.Generator) -> Parts:
    """Building blocks of wood, some on each other."""
    width, depth, height = size
    side = height / 2.0
    x, y = 0.5 * (width - side), 0.5 * (depth - side)
    spots = [(-x, -y), (x, y), (0.15 * width, -0.32 * depth), (-0.3 * width, 0.3 * depth)]
    found = [rounded_box((side, side, side), 0.0015, center=(a, b, 0.5 * side)) for a, b in spots]
    top = rounded_box((side, side, side), 0.0015)
    found.append(
        turned(top, "z", float(rng.uniform(-20.0, 20.0))).moved(
            (0.13 * width, -0.3 * depth, 1.5 * side)
        )
    )
    roof = profiled([(-0.5 * side, 0.0), (0.5 * side, 0.0), (0.0, 0.55 * side)], side, FRONT, 0.001)
    found.append(roof.moved((-0.02 * width, 0.36 * depth, 0.0)))
    return numbered("block", found)


def ball(size: Size, rng: np.random.Generator) -> Parts:
    """A ball of two colours, a little flattened where it rests: it would roll away."""
    r = 0.5 * size[2]
    t = np.linspace(-0.5 * np.pi, 0.5 * np.pi, 19)
    whole = np.stack([r * np.cos(t), r + r * np.sin(t)], axis=1)
    whole[[0, -1], 0] = 0.0
    low, high = 6, 12
    cuts = [whole[: low + 1], whole[low : high + 1], whole[high:]]
    meshes = [
        lathe([*map(tuple, cuts[0]), (0.0, cuts[0][-1][1])], segments=26, crease=50.0),
        lathe(
            [(0.0, cuts[1][0][1]), *map(tuple, cuts[1]), (0.0, cuts[1][-1][1])],
            segments=26,
            crease=50.0,
        ),
        lathe([(0.0, cuts[2][0][1]), *map(tuple, cuts[2])], segments=26, crease=50.0),
    ]
    lean = float(rng.uniform(10.0, 60.0))
    caps, stripe = (
        seated(turned(mesh, "x", lean, (0.0, 0.0, r)).moved((0.0, 0.0, -0.03 * r)), 50.0)
        for mesh in (joined([meshes[0], meshes[2]]), meshes[1])
    )
    return {"ball": caps, "stripe": stripe}


def car(size: Size, rng: np.random.Generator) -> Parts:
    """A small car on four wheels, its front towards -Y."""
    width, depth, height = size
    a, w = 0.5 * depth, 0.2 * height
    side = [
        (-a, w),
        (-0.97 * a, 0.5 * height),
        (-0.5 * a, 0.58 * height),
        (-0.28 * a, 0.97 * height),
        (0.5 * a, height),
        (0.8 * a, 0.6 * height),
        (a, 0.55 * height),
        (a, w),
    ]
    body = profiled(side, width, SIDE, 0.003)
    pane = [
        (-0.43 * a, 0.6 * height),
        (-0.25 * a, 0.9 * height),
        (0.45 * a, 0.92 * height),
        (0.64 * a, 0.6 * height),
    ]
    glass = profiled(pane, width + 0.0008, SIDE, 0.0)
    r = 0.27 * height
    tyre = turned(cylinder(r, 0.16 * width, bevel=0.15 * r, segments=18), "y", 90.0)
    places = [(x, y, r) for x in (-0.5 * width, 0.34 * width) for y in (-0.55 * a, 0.55 * a)]
    wheels = [tyre.moved(place) for place in places]
    return {"car": body, "window": glass, **numbered("wheel", wheels)}


CATEGORY: Final = BuiltCategory(
    description="a toy",
    size=(0.22, 0.2, 0.28),
    min_size=(0.03, 0.03, 0.02),
    max_size=(0.9, 0.9, 1.0),
    styles={
        "teddy": Style(teddy, lambda size: size[2] > 0.8 * size[0]),
        "blocks": Style(blocks, lambda size: size[2] < 0.7 * size[0], (0.19, 0.16, 0.08)),
        "ball": Style(ball, lambda size: 0.8 < size[2] / size[0] < 1.25, (0.18, 0.18, 0.18)),
        "car": Style(car, lambda size: max(size[0], size[2]) < size[1], (0.075, 0.17, 0.065)),
    },
    alternative_supports=("surface",),
    mass_range=(0.03, 1.6),
    words="toys teddy_bear teddy stuffed_animal doll ball toy_car lego plush blocks",
    classes=Classes(ade20k="plaything"),
    schemes=(
        scheme("toy_plastic", membrane="wheel", cavity="window"),
        scheme("plush", plush_pad="pad", cavity="eye", needs="eye", weight=100.0),
    ),
    construction=(
        row("block car", filled(500), "common"),
        row("ball stripe", walls(1.5, 1100), "common"),
        row(ANY, filled(90), "common"),
    ),
    placements=(
        on(
            "floor_open floor_corner",
            "living_room bedroom",
            weight=0.4,
            count=(1, 3),
            cluster="toys",
            clutter=2,
            max_groups=3,
            pose="flat",
        ),
        on("in_basket", "living_room bedroom apartment game_room", weight=0.6, count=(1, 3)),
        on(
            "bed_head bed_foot armchair_seat",
            "living_room bedroom apartment",
            styles="teddy",
            weight=0.1,
            max_groups=1,
        ),
        on("shelf low_shelf", "bedroom", weight=0.4, max_groups=3),
    ),
)
