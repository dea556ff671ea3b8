"""Trash bins: open with a bag, with a lid on a pedal, of wire, with a flap that swings."""

from dataclasses import replace
from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import ANY, STEEL, row, walls
from openrooms_usd.furniture.joinery.boards import SIDE, board, profiled, strip
from openrooms_usd.furniture.joinery.pieces import Furniture, Joint, Parts, Size, Style
from openrooms_usd.furniture.joinery.posing import band, hoop, oval, tapered
from openrooms_usd.furniture.record import BuiltCategory, Classes, JointDamping
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.mesh import Mesh, joined
from openrooms_usd.geometry.solids import cylinder, lathe
from openrooms_usd.geometry.sweeps import tube

# Of a flap that swings, above its centre of mass.
_PIVOT_ABOVE_M: Final = 0.008


def _bucket(low: float, high: float, z: tuple[float, float], wall: float, rim: float) -> Mesh:
    """A hollow cone frustum open above, with a rolled rim; radii ``low`` and ``high``."""
    a, b = z
    slope = (high - low) / (b - a)
    roll = b - 2.0 * rim
    profile = [
        (0.0, a),
        (low - 0.006, a),
        (low, a + 0.006),
        (high - slope * 2.0 * rim, roll),
        (high + rim - wall, roll),
        (high + rim, roll + 0.5 * rim),
        (high + rim, b - 0.4 * rim),
        (high + rim - wall, b),
        (high - wall, b),
        (low - wall, a + wall + 0.004),
        (0.0, a + wall + 0.004),
    ]
    return lathe(profile, segments=44)


def bin_open(size: Size, rng: np.random.Generator) -> Parts:
    """A tapered bin without a lid, a bag folded over its rim."""
    r, h = 0.5 * min(size[0], size[1]), size[2]
    low = float(rng.uniform(0.7, 0.8)) * r
    rim = 0.006
    lip = _bucket(low, r - rim, (0.0, h), 0.003, rim)
    turn = np.linspace(0.0, 2.0 * np.pi, 49)[:-1]
    wave = 0.6 * h + 0.012 * np.sin(3.0 * turn) + 0.008 * np.sin(5.0 * turn + 1.0)
    inner = low + (r - rim - low) * 0.985 - 0.006
    bag = lathe(
        [
            (inner - 0.002, 0.62 * h),
            (inner, 0.62 * h),
            (inner + 0.002, h - 0.001),
            (inner, h - 0.001),
        ],
        segments=44,
    )
    hanging = bag.points.copy()
    below = hanging[:, 2] < 0.8 * h
    around = np.arctan2(hanging[:, 1], hanging[:, 0]) % (2.0 * np.pi)
    hanging[below, 2] = np.interp(around[below], turn, wave, period=2.0 * np.pi)
    return {"container": oval(lip, size), "bag": oval(replace(bag, points=hanging), size)}


def bin_pedal(size: Size, rng: np.random.Generator) -> Furniture:
    """A steel cylinder with a bucket inside, a pedal, and a lid that its hinge lifts."""
    width, depth, h = size
    reach = min(0.03, 0.12 * depth)
    r = 0.5 * min(width, depth - reach)
    back = 0.5 * reach
    split = h - min(0.05, 0.16 * h)
    shell = band(r - 0.004, r, 0.012, split, 48)
    floor = cylinder(r - 0.003, 0.012, segments=40, base=(0.0, 0.0, 0.012))
    foot = lathe([(0.0, 0.0), (r - 0.006, 0.0), (r - 0.003, 0.014), (0.0, 0.014)], segments=44)
    bucket = _bucket(0.84 * r, 0.9 * r - 0.004, (0.026, split - 0.004), 0.003, 0.004)
    t = np.linspace(0.0, 0.5 * np.pi, 9)
    low = split + 0.002
    dome = np.stack([r * np.cos(t) ** 0.6, low + 0.012 + (h - low - 0.012) * np.sin(t)], axis=1)
    dome[-1, 0] = 0.0
    lid = lathe([(0.0, low), (r, low), *dome], segments=48)
    sy = (depth - reach) / (2.0 * r)
    shape = np.diag([width / (2.0 * r), sy, 1.0])
    offset = (0.0, back, 0.0)
    names = {"body": joined([shell, floor]), "base": foot, "container": bucket, "lid": lid}
    parts = {name: mesh.transformed(shape).moved(offset) for name, mesh in names.items()}
    hinge = (0.0, 0.5 * depth, low)
    parts["hinge"] = board(
        (-0.035, 0.5 * depth - 0.016, split - 0.02),
        (0.035, 0.5 * depth - 0.004, split + 0.001),
        0.003,
    )
    pedal = min(0.045, 0.3 * r) * float(rng.uniform(0.9, 1.2))
    parts["pedal"] = board(
        (-pedal, -0.5 * depth, 0.014), (pedal, -0.5 * depth + reach + 0.001, 0.022), 0.003
    )
    step = (0.0, -0.5 * depth + reach, 0.018)
    return Furniture(
        parts,
        (
            Joint("lid_0", "hinge", ("lid",), hinge, (-1.0, 0.0, 0.0), (0.0, 80.0)),
            Joint("pedal_0", "hinge", ("pedal",), step, (1.0, 0.0, 0.0), (0.0, 8.0)),
        ),
    )


def bin_wire(size: Size, rng: np.random.Generator) -> Parts:
    """A basket of crossed wires around a sheet-metal floor."""
    r, h = 0.5 * min(size[0], size[1]), size[2]
    thick = 0.003
    top, low = r - thick, float(rng.uniform(0.74, 0.84)) * r
    count = 22
    wires = []
    for lean in (-1.0, 1.0):
        for k in range(count):
            angle = 2.0 * np.pi * (k + lean * np.linspace(0.0, 2.2, 6)) / count
            z = np.linspace(0.004, h - thick, 6)
            radius = low + (top - low) * z / h
            line = np.stack([radius * np.cos(angle), radius * np.sin(angle), z], axis=1)
            wires.append(tube(line, 0.0011, segments=4))
    rings = [
        hoop(top, h - thick, thick),
        hoop(low, 0.004, 0.004),
        hoop(0.5 * (top + low), 0.5 * h, 0.002),
    ]
    floor = cylinder(low, 0.003, base=(0.0, 0.0, 0.002))
    return {
        "frame": oval(joined(rings), size),
        "container": oval(joined(wires), size),
        "base": oval(floor, size),
    }


def bin_swing(size: Size, rng: np.random.Generator) -> Furniture:
    """A square bin under a hood with a flap that swings both ways."""
    width, depth, h = size
    hood = h - min(0.26 * h, 0.2)
    x, y, wall = 0.5 * width, 0.5 * depth, 0.004
    inset = float(rng.uniform(0.85, 0.92))
    sides = [
        board((-x, -y, 0.0), (x, -y + wall, hood)),
        board((-x, y - wall, 0.0), (x, y, hood)),
        board((-x, -y, 0.0), (-x + wall, y, hood)),
        board((x - wall, -y, 0.0), (x, y, hood)),
        board((-x, -y, 0.0), (x, y, 0.008)),
    ]
    body = tapered(
        joined(sides).transformed(np.diag([inset, inset, 1.0])), "z", (1 / inset, 1 / inset)
    )
    gable = [(-y, hood - 0.004), (y, hood - 0.004), (0.3 * y, h), (-0.3 * y, h)]
    cheek = profiled(gable, 0.12 * width, SIDE, 0.004)
    cheeks = [cheek.moved((side * (x - 0.06 * width), 0.0, 0.0)) for side in (-1.0, 1.0)]
    ridge = board((-x + 0.01, -0.3 * y, h - 0.01), (x - 0.01, 0.3 * y, h - 0.001), 0.003)
    top, low = np.array([-0.31 * y, h - 0.016]), np.array([-0.95 * y, hood + 0.006])
    # Of one thickness, so that its middle is its centre of mass, and it hangs shut.
    flap = profiled(strip([top, low], 0.005), 0.75 * width, SIDE, 0.001)
    rear = profiled(
        [
            (0.31 * y, h - 0.012),
            (0.97 * y, hood + 0.002),
            (0.97 * y - 0.008, hood + 0.002),
            (0.31 * y - 0.004, h - 0.02),
        ],
        0.77 * width,
        SIDE,
        0.001,
    )
    across, up = (0.5 * (top + low)).tolist()
    pivot = (0.0, across, up + _PIVOT_ABOVE_M)
    return Furniture(
        {"container": body, "frame": joined([*cheeks, ridge, rear]), "lid": flap},
        (Joint("lid_0", "hinge", ("lid",), pivot, (1.0, 0.0, 0.0), (-55.0, 55.0)),),
    )


CATEGORY: Final = BuiltCategory(
    description="a bin for waste",
    size=(0.28, 0.28, 0.32),
    max_size=(0.8, 0.8, 1.2),
    styles={
        "open": Style(bin_open),
        "pedal": Style(bin_pedal, lambda size: size[2] > 0.22, (0.26, 0.29, 0.42)),
        "wire": Style(bin_wire),
        "swing": Style(bin_swing, lambda size: size[2] > 0.4, (0.32, 0.26, 0.62)),
    },
    round=True,
    one_variant_per_room=True,
    mass_range=(0.2, 6),
    words="trash_can trashcan garbage_bin garbage_can bin recycling_bin waste_basket "
    "wastebasket ashcan dustbin litter_bin recycle_bin rubbish_bin trash_barrel",
    classes=Classes("trash_bin", "otherfurniture", "ashcan"),
    synsets=("02747177",),
    schemes=(
        scheme("steel", black_plastic="bag base"),
        scheme("tinted_plastic", pale_plastic="bag lid", weight=2.0),
        scheme("steel", black_plastic="container base hinge", needs="pedal", weight=100.0),
    ),
    construction=(
        row("bag", walls(0.05, 950), "common"),
        row(ANY, walls(0.4, STEEL), "sheet", "metal", "paint"),
    ),
    joint_damping=JointDamping(0.02, 0.01),
    offers_surfaces=("in_bin",),
    view_importance=0.0,
)
