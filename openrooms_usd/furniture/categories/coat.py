"""Clothes: coats, jackets and robes on hooks, shirts on hangers, one over a chair's back."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import ANY, filled, row
from openrooms_usd.furniture.joinery.linens import backed, boxed, over_bar, with_loop
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style
from openrooms_usd.furniture.placements import LOOP_M, on
from openrooms_usd.furniture.record import BuiltCategory, Classes
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.curves import filleted, lengths
from openrooms_usd.geometry.lofts import loft
from openrooms_usd.geometry.mesh import Mesh, joined
from openrooms_usd.geometry.solids import sphere
from openrooms_usd.geometry.sweeps import tube
from openrooms_usd.geometry.uv import metric
from openrooms_usd.geometry.vectors import points_at

_NOT_WET: Final = (
    "hallway closet bedroom living_room apartment office hotel classroom conference_room stairs "
    "garage basement misc lobby dining_room mail_room copy_room computer_cluster game_room gym"
)


def _garment(size: Size, folds: int, hem: float, rng: np.random.Generator) -> Mesh:
    """The body of what hangs by its collar: narrow shoulders, a wide hem in folds."""
    width, depth, height = size
    count = 40
    angle = 2.0 * np.pi * np.arange(count) / count
    phase = float(rng.uniform(0.0, 2.0 * np.pi))
    rows = [
        (0.2, 0.34, 1.0),
        (0.24, 0.44, 0.965),
        (0.5, 0.6, 0.93),
        (0.76, 0.72, 0.88),
        (0.84, 0.8, 0.8),
        (0.82, 0.86, 0.65),
        (0.84, 0.9, 0.45),
        (0.93, 0.96, 0.2),
        (1.0, 1.0, 0.0),
    ]
    rings = []
    for a, b, z in rows:
        loose = min(1.0, 2.2 * (1.0 - z))
        wave = 1.0 + 0.1 * loose * (
            0.7 * np.cos(folds * angle + phase + z) + 0.3 * np.cos((folds + 3) * angle - 5.0 * z)
        )
        low = hem * height * 0.5 * (1.0 + np.cos(2.0 * angle + phase)) * (z == 0.0)
        rings.append(
            points_at(
                0.5 * width * a * wave * np.cos(angle) / 1.1,
                0.5 * depth * b * wave * np.sin(angle) / 1.1,
                z * height + low,
            )
        )
    shell = backed(np.array(rings))
    middle = [0.0, float(shell[-1, :, 1].mean()), 0.0]
    inner = (shell[-1] - middle) * [0.9, 0.9, 1.0] + middle + [0.0, 0.0, 0.03 * height]
    end = (
        points_at(0.1 * width * np.cos(angle), 0.1 * depth * np.sin(angle), 0.12 * height) + middle
    )
    return metric(loft(np.array([end, inner, *shell[::-1]]), crease=70.0))[0]


def _sleeves(size: Size, long: float, rng: np.random.Generator) -> list[Mesh]:
    """Two sleeves that hang from the shoulders, creased at the elbow."""
    width, depth, height = size
    found = []
    for side in (-1.0, 1.0):
        top = (side * 0.2 * width, -0.36 * depth, 0.87 * height)
        end = 0.9 - long
        path = [
            top,
            (side * 0.36 * width, -0.42 * depth, 0.79 * height),
            (side * 0.4 * width, -0.5 * depth, 0.5 * (0.8 + end) * height),
            (side * 0.38 * width, -0.62 * depth, end * height),
        ]
        bent = filleted(path, 0.08, segments=3)
        run = lengths(bent)
        at = np.linspace(0.0, run[-1], 14)
        arm = np.stack([np.interp(at, run, bent[:, i]) for i in range(3)], axis=1)
        thick = min(0.05, 0.3 * depth)
        creases = rng.uniform(0.9, 1.08, len(arm))
        found.append(tube(arm, (np.linspace(thick, 0.8 * thick, 14) * creases).tolist()))
    return found


def coat(size: Size, rng: np.random.Generator) -> Parts:
    """A long coat."""
    return {"garment": with_loop(lambda rest: _coat(rest, rng), size)}


def _coat(size: Size, rng: np.random.Generator) -> Mesh:
    return boxed(joined([_garment(size, 6, 0.02, rng), *_sleeves(size, 0.55, rng)]), size)


def robe(size: Size, rng: np.random.Generator) -> Parts:
    """A bathrobe with its belt."""
    width, depth, height = size
    z = 0.56 * height
    angle = np.linspace(0.0, 2.0 * np.pi, 25)[:-1]
    around = points_at(
        0.385 * width * np.cos(angle), 0.44 * depth * np.sin(angle) - 0.02 * depth, z
    )
    ends = [
        tube(
            [(s * 0.02, 0.012 - 0.5 * depth, z), (s * 0.05, 0.012 - 0.5 * depth, z - 0.3)],
            0.011,
            segments=6,
        )
        for s in (-1.0, 1.0)
    ]
    belt = joined([tube(around, 0.012, segments=6, closed=True), *ends])
    return {"robe": with_loop(lambda rest: _coat(rest, rng), size), "belt": belt}


def jacket(size: Size, rng: np.random.Generator) -> Parts:
    """A short jacket with a hood."""
    return {"garment": with_loop(lambda rest: _jacket(rest, rng), size)}


def _jacket(size: Size, rng: np.random.Generator) -> Mesh:
    width, depth, height = size
    hood = sphere(0.5, segments=14).transformed(np.diag([0.4 * width, 0.7 * depth, 0.17 * height]))
    hood = hood.moved((0.0, -0.56 * depth, 0.87 * height))
    whole = joined([_garment(size, 5, 0.03, rng), *_sleeves(size, 0.75, rng), hood])
    return boxed(whole, size)


def on_hanger(size: Size, rng: np.random.Generator) -> Parts:
    """A shirt on a hanger, whose wire goes over a rail along Y."""
    width, depth, height = size
    r, crook = 0.5 * LOOP_M, 0.024
    tall = height - 2.0 * crook - 0.02
    shirt = _shirt((width, depth, tall), rng)
    t = np.radians(np.linspace(-90.0, 200.0, 12))
    bow = [(crook - r) * np.cos(t), np.zeros(12), height - crook + (crook - r) * np.sin(t)]
    stem = [(0.0, 0.0, tall - 0.03), (0.0, 0.0, height - 2.0 * crook - 0.004)]
    wire = tube(np.concatenate([stem, np.stack(bow, axis=1)]), r, segments=8)
    arms = tube(
        [
            (-0.4 * width, 0.0, 0.93 * tall),
            (0.0, 0.0, tall - 0.012),
            (0.4 * width, 0.0, 0.93 * tall),
        ],
        0.006,
        segments=8,
    )
    return {"shirt": shirt, "hook": wire, "hanger": arms}


def _shirt(size: Size, rng: np.random.Generator) -> Mesh:
    """A flat shirt with wide shoulders, open below, and its sleeves."""
    width, depth, height = size
    count = 40
    angle = 2.0 * np.pi * np.arange(count) / count
    phase = float(rng.uniform(0.0, 2.0 * np.pi))
    rows = [
        (0.16, 0.6, 1.0),
        (0.22, 0.66, 0.985),
        (0.62, 0.7, 0.95),
        (0.82, 0.74, 0.915),
        (0.84, 0.8, 0.8),
        (0.84, 0.88, 0.5),
        (0.86, 0.96, 0.2),
        (0.88, 1.0, 0.0),
    ]
    rings = []
    for a, b, z in rows:
        wave = 1.0 + 0.12 * (1.0 - z) ** 0.5 * np.cos(7.0 * angle + phase + 2.0 * z)
        rings.append(
            points_at(
                0.5 * width * a * np.cos(angle),
                0.5 * depth * b * wave * np.sin(angle) / 1.12,
                z * height,
            )
        )
    inner = rings[-1] * [0.94, 0.8, 1.0] + [0.0, 0.0, 0.05 * height]
    long = float(rng.choice([0.24, 0.62]))
    thick = 0.42 * depth
    sleeves = []
    for side in (-1.0, 1.0):
        path = [
            (side * 0.38 * width, 0.0, 0.905 * height),
            (side * (0.5 * width - thick), 0.0, 0.84 * height),
            (side * (0.5 * width - thick), 0.0, (0.9 - long) * height),
        ]
        sleeves.append(tube(path, thick, bend=0.05, bend_segments=3, segments=10))
    body = loft(np.array([inner, *rings[::-1]]), crease=70.0)
    return boxed(metric(joined([body, *sleeves]))[0], size)


def draped(size: Size, rng: np.random.Generator) -> Parts:
    """A cardigan over the back of a chair."""
    return {"garment": over_bar(size, rng)}


CATEGORY: Final = BuiltCategory(
    description="a coat or a jacket that hangs",
    size=(0.4, 0.18, 1.05),
    min_size=(0.2, 0.03, 0.2),
    max_size=(0.8, 0.5, 1.6),
    styles={
        "coat": Style(coat, lambda size: size[2] > 0.85),
        "jacket": Style(jacket, lambda size: 0.5 < size[2] < 0.95, (0.42, 0.18, 0.76)),
        "robe": Style(robe, lambda size: size[2] > 0.85, (0.38, 0.16, 1.15)),
        "on_hanger": Style(on_hanger, lambda size: size[1] < 0.3 * size[0], (0.46, 0.075, 0.9)),
        "draped": Style(
            draped,
            lambda size: size[1] < 0.3 * size[2] < 0.21,
            (0.42, 0.06, 0.5),
            mass_range=(0.05, 1),
        ),
    },
    support="wall",
    mount_height=0.75,
    mass_range=(0.25, 3),
    words="jacket clothing coats jackets hoodie sweater clothes_hanging",
    classes=Classes(nyu40="clothes", ade20k="apparel"),
    schemes=(
        scheme("coat_cloth"),
        scheme("terry", needs="robe", weight=100.0),
        scheme("shirt_cloth", chrome="hook", wood="hanger", needs="shirt", weight=100.0),
    ),
    construction=(row("hook hanger", filled(500), "common"), row(ANY, filled(45), "weight")),
    placements=(
        on("hook", _NOT_WET, styles="coat jacket", pose="hung", max_groups=6, max_variants=4),
        on("hook", "bathroom", styles="robe", pose="hung", weight=0.4, max_groups=1),
        on("clothes_rail", styles="on_hanger", pose="hung", max_groups=12, max_variants=5),
        on(
            "chair_back",
            "bedroom living_room office dining_room",
            styles="draped",
            pose="draped",
            clutter=2,
            weight=0.5,
            max_groups=1,
        ),
    ),
)
