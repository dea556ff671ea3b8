"""Fans on a stand: blades in a cage of wire."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import ANY, filled, row, walls
from openrooms_usd.furniture.joinery.assembly import Assembly
from openrooms_usd.furniture.joinery.pieces import Furniture, Size, Style
from openrooms_usd.furniture.joinery.posing import facing, turned
from openrooms_usd.furniture.record import BuiltCategory, Classes
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.mesh import Mesh, joined
from openrooms_usd.geometry.solids import lathe
from openrooms_usd.geometry.sweeps import extrude, tube


def pedestal(size: Size, rng: np.random.Generator) -> Furniture:
    """A round foot, a pole, a motor behind blades that turn."""
    width, depth, height = size
    made, r = Assembly(), 0.5 * width
    z, front = height - r, -0.5 * depth
    foot = min(0.5 * depth, 0.48 * width)
    made.add(
        "base",
        lathe(
            [
                (0.0, 0.0),
                (foot, 0.0),
                (foot, 0.012),
                (0.85 * foot, 0.022),
                (0.12 * foot, 0.04),
                (0.0, 0.04),
            ],
            segments=40,
        ),
    )
    made.add("pole", tube([(0.0, 0.02, 0.03), (0.0, 0.02, z - 0.02)], 0.012, segments=14))
    motor = lathe(
        [(0.0, 0.0), (0.05, 0.0), (0.055, 0.02), (0.055, 0.09), (0.04, 0.12), (0.0, 0.125)],
        segments=28,
    )
    made.add("frame", facing(motor, (0.0, 0.075, z)))
    made.add("frame", tube([(0.0, 0.02, z - 0.06), (0.0, 0.02, z)], 0.02))
    middle = front + 0.06
    made.add("cage", _cage(r, middle, z, front))
    blade = extrude(
        [(0.02, -0.03), (0.78 * r, -0.07), (0.84 * r, 0.0), (0.76 * r, 0.08), (0.02, 0.03)], 0.003
    )
    pitched = turned(facing(blade, (0.0, 0.0, 0.0)), "x", 18.0)
    blades = joined([turned(pitched, "y", 120.0 * i) for i in range(3)])
    hub = lathe([(0.0, 0.0), (0.035, 0.0), (0.035, 0.03), (0.02, 0.04), (0.0, 0.042)], segments=24)
    at = (0.0, middle, z)
    names = made.add("blade", blades.moved(at)) + made.add(
        "hub", facing(hub, (0.0, middle + 0.015, z))
    )
    made.turn("blade", names, at, (0.0, -1.0, 0.0), (0.0, 360.0))
    return made.furniture()


def _cage(r: float, middle: float, z: float, front: float) -> Mesh:
    """Wires from a ring at the rim to the hub, before and behind the blades."""
    angle, hoop = np.linspace(0.0, 2.0 * np.pi, 48, endpoint=False), r - 0.0035
    rim = np.column_stack([hoop * np.cos(angle), np.full(48, middle), z + hoop * np.sin(angle)])
    wires = [tube(rim, 0.0035, segments=6, closed=True)]
    for deep in (front + 0.004, middle + 0.06):
        for a in np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False):
            c, s = float(np.cos(a)), float(np.sin(a))
            wires.append(
                tube(
                    [
                        (0.04 * c, deep, z + 0.04 * s),
                        (0.7 * r * c, deep, z + 0.7 * r * s),
                        ((r - 0.004) * c, middle, z + (r - 0.004) * s),
                    ],
                    0.0012,
                    segments=4,
                )
            )
        disc = lathe([(0.0, 0.0), (0.045, 0.0), (0.045, 0.004), (0.0, 0.004)], segments=20)
        wires.append(facing(disc, (0.0, deep + 0.002, z)))
    return joined(wires)


CATEGORY: Final = BuiltCategory(
    description="a fan on a stand",
    size=(0.42, 0.4, 1.2),
    min_size=(0.2, 0.18, 0.3),
    max_size=(0.7, 0.6, 1.6),
    styles={"pedestal": Style(pedestal)},
    alternative_supports=("surface",),
    mass_range=(2, 10),
    words="stand_fan pedestal_fan floor_fan electric_fan table_fan desk_fan",
    classes=Classes(ade20k="fan"),
    schemes=(scheme("plastic", chrome="cage pole"), scheme("black", black="cage pole")),
    construction=(
        row("base", filled(1500), "weight"),
        row("frame", filled(1600), "weight"),
        row(ANY, walls(1.0), "common"),
    ),
)
