"""What furniture is usually made of: finishes, and which finish each part of a category has."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Final

import numpy as np

Color = tuple[float, float, float]

# The part that stands for all that a scheme does not name.
ANY: Final = "*"
# What a part gets of which nothing is known.
UNKNOWN: Final = "lacquer"
# Schemes say "metal"; one of these is drawn for the whole object.
METAL: Final = "metal"
METALS: Final = ("steel", "brass", "black")


@dataclass(frozen=True)
class Finish:
    """A treatment of surfaces, before chance decides the rest.

    Attributes:
        family: Family of textures, or a name for people where it has none.
        variants: Variants of the family, one of which is drawn; empty for a plain constant.
        colors: Mean base colours, scene-linear Rec.709, one of which is drawn; empty: the family's.
        roughness: Range of the mean perceptual roughness; None: the family's.
        metallic: 0 or 1.
        choices: How many different ones a room has; more objects share them.
    """

    family: str
    variants: tuple[str, ...] = ()
    colors: tuple[Color, ...] = ()
    roughness: tuple[float, float] | None = None
    metallic: float = 0.0
    choices: int = 1


FINISHES: Final[dict[str, Finish]] = {
    "wood": Finish("wood", ("panel",), choices=3),
    "lacquer": Finish(
        "paint", ("satin",),
        colors=((0.76, 0.75, 0.72), (0.42, 0.41, 0.39), (0.065, 0.07, 0.075), (0.27, 0.33, 0.27),
                (0.13, 0.22, 0.31), (0.58, 0.50, 0.39)),
        roughness=(0.3, 0.48), choices=3,
    ),
    "white": Finish("paint", ("satin",), colors=((0.79, 0.785, 0.77),), roughness=(0.34, 0.42)),
    "upholstery": Finish("fabric", ("plain", "twill", "basket"), choices=3),
    "linen": Finish(
        "fabric", ("plain",),
        colors=((0.58, 0.56, 0.52), (0.5, 0.47, 0.41), (0.36, 0.42, 0.46)), choices=2,
    ),
    "shade": Finish(
        "fabric", ("plain",), colors=((0.6, 0.58, 0.53), (0.57, 0.5, 0.4)), choices=2,
    ),
    "black": Finish("paint", ("powder",), colors=((0.03, 0.03, 0.032),), roughness=(0.45, 0.6)),
    "steel": Finish("metal", colors=((0.56, 0.55, 0.53),), roughness=(0.24, 0.38), metallic=1.0),
    "brass": Finish("metal", colors=((0.70, 0.51, 0.25),), roughness=(0.22, 0.34), metallic=1.0),
    "ceramic": Finish(
        "ceramic", colors=((0.78, 0.77, 0.74), (0.45, 0.47, 0.45), (0.25, 0.29, 0.31)),
        roughness=(0.08, 0.2), choices=2,
    ),
    "sanitary": Finish("ceramic", colors=((0.8, 0.8, 0.79),), roughness=(0.06, 0.1)),
    "screen": Finish("glass", colors=((0.022, 0.022, 0.025),), roughness=(0.06, 0.12)),
    "bulb": Finish("glass", colors=((0.8, 0.8, 0.79),), roughness=(0.2, 0.3)),
}  # fmt: skip

# Parts that are the same on whatever they are found.
PARTS: Final = {
    "seat_cushion": "upholstery",
    "back_cushion": "upholstery",
    "cushion": "upholstery",
    "pillow": "linen",
    "mattress": "linen",
    "blanket": "upholstery",
    "lamp_shade": "shade",
    "lamp_pole": METAL,
    "light_bulb": "bulb",
    "handle": METAL,
    "tube": METAL,
    "glass": "screen",
    "screen": "screen",
}
# Wide parts whose grain runs along their width, as people saw them.
ACROSS: Final = frozenset({"tabletop", "shelf", "drawer_front", "rail", "step"})


@dataclass(frozen=True)
class Scheme:
    """Which finish the parts of some categories have.

    Attributes:
        categories: For which.
        finishes: By part; `ANY` for all others that are not in `PARTS`.
        needs: A part that the object must have, by which its build is recognised.
        weight: How often it is chosen among those that fit.
    """

    categories: tuple[str, ...]
    finishes: Mapping[str, str] = field(default_factory=dict)
    needs: str | None = None
    weight: float = 1.0


_CHAIRS: Final = ("chair", "armchair", "stool", "bench")
_TABLES: Final = ("table", "desk", "coffee_table", "side_table")
_STORAGE: Final = ("cabinet", "dresser", "bookshelf", "shelf", "wardrobe", "kitchen_cabinet")
_LAMPS: Final = ("floor_lamp", "table_lamp", "ceiling_lamp", "wall_lamp", "lamp")
_APPLIANCES: Final = ("refrigerator", "dishwasher", "washing_machine", "stove", "microwave")
_SANITARY: Final = ("bathtub", "sink", "toilet")

SCHEMES: Final = (
    Scheme(_CHAIRS, {ANY: "wood"}, weight=3.0),
    Scheme(_CHAIRS, {ANY: "lacquer", "leg": "wood", "frame": "wood"}),
    Scheme(_CHAIRS, {ANY: "lacquer"}),
    Scheme(_CHAIRS, {ANY: "upholstery", "leg": "wood"}, needs="arm", weight=100.0),
    Scheme(_TABLES, {ANY: "wood"}, weight=3.0),
    Scheme(_TABLES, {ANY: METAL, "tabletop": "wood", "shelf": "wood"}),
    Scheme(_TABLES, {ANY: "white", "tabletop": "wood", "shelf": "wood"}),
    Scheme(_STORAGE, {ANY: "wood"}, weight=2.0),
    Scheme(_STORAGE, {ANY: "white", "leg": "wood", "base": "white"}),
    Scheme(_STORAGE, {ANY: "wood", "door": "lacquer", "drawer_front": "lacquer"}, needs="handle"),
    Scheme(("sofa",), {ANY: "upholstery", "leg": "wood"}, weight=2.0),
    Scheme(("sofa",), {ANY: "upholstery", "leg": METAL}),
    Scheme(("sofa",), {ANY: "wood"}, needs="rail", weight=100.0),
    Scheme(_LAMPS, {ANY: METAL}, weight=2.0),
    Scheme(_LAMPS, {ANY: METAL, "base": "ceramic"}),
    Scheme(("ceiling_lamp",), {ANY: "white"}, weight=2.0),
    Scheme(("bed", "stairs", "piano"), {ANY: "wood"}),
    Scheme(_APPLIANCES, {ANY: "white"}, weight=2.0),
    Scheme(_APPLIANCES, {ANY: "steel"}),
    Scheme(("television", "monitor", "laptop", "speaker"), {ANY: "black"}),
    Scheme(_SANITARY, {ANY: "sanitary"}),
    Scheme(("curtain", "pillow"), {ANY: "linen"}),
    Scheme(("door",), {ANY: "white"}, weight=2.0),
    Scheme(("door",), {ANY: "white", "panel": "wood"}),
    Scheme(("window", "opening"), {ANY: "white"}),
)


def finishes_of(category: str, parts: Iterable[str], rng: np.random.Generator) -> dict[str, str]:
    """Choose a finish for each part of an object.

    Args:
        category: What it is; any word.
        parts: Its semantic parts; any words.
        rng: Draws one of the schemes that fit, and its metal.

    Returns:
        Keys of `FINISHES` by part.
    """
    names = sorted(set(parts))
    fitting = [
        scheme
        for scheme in SCHEMES
        if category in scheme.categories and (scheme.needs is None or scheme.needs in names)
    ]
    weights = np.cumsum([scheme.weight for scheme in fitting] or [1.0])
    drawn = int(np.searchsorted(weights, rng.uniform(0.0, weights[-1]), side="right"))
    chosen = fitting[drawn].finishes if fitting else {}
    metal = METALS[int(rng.integers(len(METALS)))]
    rest = chosen.get(ANY, UNKNOWN)
    picked = {part: chosen.get(part, PARTS.get(part, rest)) for part in names}
    return {part: metal if finish == METAL else finish for part, finish in picked.items()}
