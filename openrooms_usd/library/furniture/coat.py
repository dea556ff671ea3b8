"""Clothes that hang on a hook: a coat, a jacket; and one thrown over a chair's back."""

from typing import Final

import numpy as np

from openrooms_usd.categories import makes
from openrooms_usd.categories.makes import ANY
from openrooms_usd.categories.record import NO_SYNSET, PLAIN_HINGES, RIGID, UNLABELED, Classes
from openrooms_usd.categories.schemes import Scheme
from openrooms_usd.geometry.curves import filleted
from openrooms_usd.geometry.lofts import loft
from openrooms_usd.geometry.mesh import Mesh, joined
from openrooms_usd.geometry.solids import sphere
from openrooms_usd.geometry.sweeps import tube
from openrooms_usd.geometry.uv import metric
from openrooms_usd.library.furniture.built import NO_APPLIANCE, NO_LAMP, USUAL, BuiltCategory
from openrooms_usd.library.furniture.joinery import Parts, Size, Style
from openrooms_usd.library.furniture.linens import boxed, over_bar
from openrooms_usd.library.furniture.lying import Lies


def _garment(size: Size, folds: int, hem: float, rng: np.random.Generator) -> Mesh:
    """The body of what hangs by its collar: narrow shoulders, a wide hem in folds."""
    width, depth, height = size
    count = 40
    angle = 2.0 * np.pi * np.arange(count) / count
    phase = float(rng.uniform(0.0, 2.0 * np.pi))
    rows = [(0.2, 0.3, 1.0), (0.26, 0.42, 0.965), (0.44, 0.62, 0.93), (0.66, 0.78, 0.86),
            (0.74, 0.88, 0.7), (0.82, 0.9, 0.45), (0.93, 0.96, 0.2), (1.0, 1.0, 0.0)]  # fmt: skip
    rings = []
    for a, b, z in rows:
        wave = 1.0 + 0.1 * (1.0 - z) ** 0.5 * np.cos(folds * angle + phase + z)
        low = hem * height * 0.5 * (1.0 + np.cos(2.0 * angle + phase)) * (z == 0.0)
        rings.append(np.stack([0.5 * width * a * wave * np.cos(angle) / 1.1,
                               0.5 * depth * b * wave * np.sin(angle) / 1.1,
                               z * height + low], axis=1))  # fmt: skip
    inner = rings[-1] * [0.9, 0.9, 1.0] + [0.0, 0.0, 0.03 * height]
    end = np.stack([0.1 * width * np.cos(angle), 0.1 * depth * np.sin(angle),
                    np.full(count, 0.12 * height)], axis=1)  # fmt: skip
    return metric(loft(np.array([end, inner, *rings[::-1]]), crease=70.0))[0]


def _sleeves(size: Size, long: float) -> list[Mesh]:
    """Two sleeves that hang from the shoulders."""
    width, depth, height = size
    found = []
    for side in (-1.0, 1.0):
        top = (side * 0.2 * width, 0.0, 0.905 * height)
        path = [top, (side * 0.31 * width, -0.06 * depth, 0.79 * height),
                (side * 0.345 * width, -0.12 * depth, (0.9 - 0.5 * long) * height),
                (side * 0.35 * width, -0.2 * depth, (0.9 - long) * height)]  # fmt: skip
        arm = filleted(path, 0.08, segments=3)
        found.append(tube(arm, np.linspace(0.058, 0.05, len(arm)).tolist(), segments=12))
    return found


def coat(size: Size, rng: np.random.Generator) -> Parts:
    """A long coat."""
    body = _garment(size, 6, 0.02, rng)
    return {"garment": boxed(joined([body, *_sleeves(size, 0.55)]), size)}


def jacket(size: Size, rng: np.random.Generator) -> Parts:
    """A short jacket with a hood."""
    width, depth, height = size
    body = _garment((width, depth, 0.95 * height), 5, 0.03, rng)
    hood = sphere(0.5, segments=14).transformed(np.diag([0.4 * width, 0.7 * depth, 0.17 * height]))
    sleeves = _sleeves((width, depth, 0.95 * height), 0.75)
    whole = joined([body, *sleeves, hood.moved((0.0, -0.16 * depth, 0.89 * height))])
    return {"garment": boxed(whole, size)}


def draped(size: Size, rng: np.random.Generator) -> Parts:
    """A cardigan over the back of a chair."""
    return {"garment": over_bar(size, rng)}


CATEGORY: Final = BuiltCategory(
    description="a coat or a jacket that hangs",
    size=(0.46, 0.2, 1.05),
    least=(0.2, 0.03, 0.2),
    most=(0.8, 0.5, 1.6),
    styles={
        "coat": Style(coat, lambda size: size[2] > 0.85),
        "jacket": Style(jacket, lambda size: 0.5 < size[2] < 0.95, (0.46, 0.2, 0.76)),
        "draped": Style(draped, lambda size: size[1] < 0.3 * size[2] < 0.21, (0.42, 0.06, 0.5)),
    },
    spread=USUAL,
    round=False,
    alike=False,
    support="wall",
    also=(),
    level=0.75,
    lumen=NO_LAMP,
    weighs={"draped": (0.05, 1), ANY: (0.25, 3)},
    worktop=NO_APPLIANCE,
    fixed=False,
    words="jacket clothing coats jackets hoodie sweater clothes_hanging",
    classes=Classes(UNLABELED, "clothes", "apparel", UNLABELED),
    synsets=NO_SYNSET,
    schemes=(Scheme({ANY: "coat_cloth"}),),
    makes=(makes.row(ANY, makes.filled(45), "weight"),),
    hinges=PLAIN_HINGES,
    yields=RIGID,
    lies=(
        Lies(on=("hook",), styles=("coat", "jacket"), pose="hung", weight=1.0, most=3),
        Lies(on=("clothes_rail",), styles=("coat", "jacket"), pose="hung", weight=0.6, most=3),
        Lies(
            on=("chair_back",),
            rooms=("bedroom", "living_room", "office", "dining_room"),
            styles=("draped",),
            pose="draped",
            clutter=2,
            weight=0.5,
            most=1,
        ),
    ),
)
