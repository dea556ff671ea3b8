"""Which finish each part of a category usually has."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final

# The part that stands for all that a scheme does not name.
ANY: Final = "*"
# Schemes say "metal"; one of these is drawn for the whole object.
METAL: Final = "metal"
METALS: Final = ("steel", "brass", "black")


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


_CHAIRS: Final = ("chair", "stool", "bench")
_TABLES: Final = ("table", "desk", "coffee_table", "side_table")
_STORAGE: Final = ("cabinet", "dresser", "bookshelf", "shelf", "wardrobe", "kitchen_cabinet")
_LAMPS: Final = ("floor_lamp", "table_lamp", "ceiling_lamp", "wall_lamp", "lamp")
_COOKERS: Final = ("stove", "oven")
_HOT: Final = {"container": "cavity", "base": "black", "rack": "chrome", "handle": "steel"}
_COLD: Final = {"container": "plastic", "shelf": "plastic", "drawer_box": "plastic",
                "tray": "plastic", "base": "black"}  # fmt: skip
_HIDE: Final = {"seat_cushion": "hide", "back_cushion": "hide", "cushion": "hide"}
_TAP: Final = {"body": "chrome", "switch": "chrome"}
_DARK_TAP: Final = {"body": METAL, "switch": METAL, "spout": METAL, "drain": METAL}

SCHEMES: Final = (
    Scheme(_CHAIRS, {ANY: "wood"}, weight=3.0),
    Scheme(_CHAIRS, {ANY: "lacquer", "leg": "wood", "frame": "wood"}),
    Scheme(_CHAIRS, {ANY: "lacquer"}),
    Scheme(_CHAIRS, {ANY: "upholstery", "leg": "wood"}, needs="arm", weight=100.0),
    Scheme(("armchair",), {ANY: "upholstery", "leg": "wood"}, weight=2.0),
    Scheme(("armchair",), {ANY: "upholstery", "leg": METAL}),
    Scheme(("armchair",), {ANY: "hide", **_HIDE, "leg": "wood"}, needs="seat_cushion", weight=0.7),
    Scheme(("armchair",), {ANY: "wood"}, needs="rail", weight=100.0),
    Scheme(("bench",), {ANY: "wood", "leg": METAL}),
    Scheme(("stool",), {ANY: METAL}, needs="column", weight=100.0),
    Scheme(("office_chair",), {ANY: "black"}, weight=2.0),
    Scheme(("office_chair",), {ANY: "black", "leg": "steel", "arm_support": "steel"}),
    Scheme(("office_chair",), {ANY: "white", "back": "black", "arm": "black"}),
    Scheme(_TABLES, {ANY: "wood"}, weight=3.0),
    Scheme(_TABLES, {ANY: METAL, "tabletop": "wood", "shelf": "wood"}),
    Scheme(_TABLES, {ANY: "white", "tabletop": "wood", "shelf": "wood"}),
    Scheme(_STORAGE, {ANY: "wood"}, weight=2.0),
    Scheme(_STORAGE, {ANY: "white", "leg": "wood", "base": "white"}),
    Scheme(_STORAGE, {ANY: "wood", "door": "lacquer", "drawer_front": "lacquer"}, needs="handle"),
    Scheme(("sofa",), {ANY: "upholstery", "leg": "wood"}, weight=2.0),
    Scheme(("sofa",), {ANY: "upholstery", "leg": METAL}),
    Scheme(("sofa",), {ANY: "hide", **_HIDE, "leg": "wood"}, weight=0.7),
    Scheme(("sofa",), {ANY: "hide", **_HIDE, "leg": METAL}, weight=0.5),
    Scheme(("sofa",), {ANY: "wood"}, needs="rail", weight=100.0),
    Scheme(_LAMPS, {ANY: METAL}, weight=2.0),
    Scheme(_LAMPS, {ANY: METAL, "base": "ceramic"}),
    Scheme(("ceiling_lamp",), {ANY: "white"}, weight=2.0),
    Scheme(("ceiling_lamp",), {ANY: "brass", "candle": "white"}, needs="candle", weight=100.0),
    Scheme(_LAMPS, {ANY: METAL, "lamp_shade": "lacquer"}, needs="socket", weight=100.0),
    Scheme(("bed", "stairs", "piano"), {ANY: "wood"}, weight=3.0),
    Scheme(("bed",), {ANY: "white"}),
    Scheme(
        ("bed",),
        {ANY: "upholstery", "leg": "wood", "base": "black"},
        needs="headboard_pad",
        weight=100.0,
    ),
    Scheme(("stairs",), {ANY: "white", "step": "wood", "handrail": "wood"}, weight=2.0),
    Scheme(("stairs",), {ANY: "black", "step": "wood"}),
    Scheme(("fireplace",), {ANY: "white", "hearth": "masonry"}, weight=2.0),
    Scheme(("fireplace",), {ANY: "masonry"}),
    Scheme(("fireplace",), {ANY: "black", "hearth": "masonry"}, needs="pipe", weight=100.0),
    Scheme(
        ("rug",),
        {ANY: "carpet", "border": "carpet_border", "trim": "carpet_border", "fringe": "linen"},
    ),
    Scheme(("file_cabinet",), {ANY: "grey", "handle": "chrome"}, weight=2.0),
    Scheme(("file_cabinet",), {ANY: "white", "handle": "chrome", "wheel": "dark_plastic"}),
    Scheme(("file_cabinet",), {ANY: "black", "handle": "black"}),
    Scheme(("counter",), {ANY: "white", "countertop": "wood", "base": "black"}, weight=2.0),
    Scheme(("counter",), {ANY: "white", "countertop": "stone"}, weight=2.0),
    Scheme(("counter",), {ANY: "wood", "countertop": "stone"}),
    Scheme(
        ("counter",),
        {
            ANY: "lacquer",
            "frame": "white",
            "shelf": "white",
            "drawer_box": "white",
            "countertop": "stone",
            "base": "black",
        },
    ),
    Scheme(_COOKERS, {ANY: "steel", **_HOT, "frame": "black"}, weight=2.0),
    Scheme(_COOKERS, {ANY: "enamel", **_HOT, "knob": "enamel"}, weight=2.0),
    Scheme(_COOKERS, {ANY: "screen", **_HOT, "frame": "black", "knob": "steel"}),
    Scheme(("refrigerator",), {ANY: "enamel", **_COLD, "handle": "steel"}),
    Scheme(("refrigerator",), {ANY: "steel", **_COLD, "frame": "grey", "handle": "steel"}),
    Scheme(
        ("microwave",),
        {
            ANY: "steel",
            "container": "enamel",
            "frame": "black",
            "tray": "plastic",
            "panel": "screen",
            "handle": "steel",
            "base": "black",
        },
    ),
    Scheme(("microwave",), {ANY: "enamel", "tray": "plastic", "handle": "enamel"}),
    Scheme(("microwave",), {ANY: "black", "container": "enamel", "handle": "steel"}),
    Scheme(("dishwasher",), {ANY: "enamel", "container": "steel", "handle": "steel"}),
    Scheme(("dishwasher",), {ANY: "steel", "frame": "grey", "base": "black"}, weight=2.0),
    Scheme(("washing_machine",), {ANY: "enamel", "handle": "chrome", "base": "black"}, weight=2.0),
    Scheme(
        ("washing_machine",),
        {ANY: "enamel", "handle": "chrome", "base": "black", "door": "chrome", "panel": "grey"},
    ),
    Scheme(
        ("washing_machine",), {ANY: "grey", "handle": "chrome", "base": "black", "knob": "chrome"}
    ),
    Scheme(("faucet",), {ANY: "chrome", "switch": "chrome"}, weight=2.0),
    Scheme(("faucet",), {ANY: METAL, **_DARK_TAP}),
    Scheme(("television", "monitor"), {ANY: "black_plastic"}, weight=3.0),
    Scheme(
        ("television", "monitor"),
        {ANY: "black_plastic", "stand": "aluminium", "base": "aluminium", "foot": "aluminium"},
    ),
    Scheme(
        ("monitor",), {ANY: "pale_plastic", "button": "pale_plastic"}, needs="button", weight=100.0
    ),
    Scheme(
        ("television",),
        {ANY: "black_plastic", "frame": "wood", "antenna": "steel"},
        needs="antenna",
        weight=200.0,
    ),
    Scheme(
        ("laptop",),
        {ANY: "aluminium", "hinge": "black_plastic", "key": "black_plastic"},
        weight=2.0,
    ),
    Scheme(("laptop",), {ANY: "dark_plastic", "touchpad": "membrane", "key": "membrane"}),
    Scheme(("keyboard",), {ANY: "black_plastic", "key": "membrane"}, weight=2.0),
    Scheme(("keyboard",), {ANY: "aluminium", "key": "pale_plastic"}),
    Scheme(("keyboard",), {ANY: "pale_plastic"}),
    Scheme(("speaker",), {ANY: "black", "badge": "steel", "foot": "steel"}),
    Scheme(
        ("speaker",),
        {ANY: "wood", "rim": "black_plastic", "badge": "steel", "base": "black", "foot": "steel"},
    ),
    Scheme(
        ("speaker",), {ANY: "black_plastic", "grille": "upholstery"}, needs="grille", weight=100.0
    ),
    Scheme(("telephone",), {ANY: "dark_plastic", "button": "pale_plastic"}, weight=2.0),
    Scheme(("telephone",), {ANY: "pale_plastic"}),
    Scheme(("telephone",), {ANY: "black_plastic", "dial": "steel"}, needs="dial", weight=100.0),
    Scheme(
        ("printer",),
        {
            ANY: "pale_plastic",
            "panel": "black_plastic",
            "button": "pale_plastic",
            "handle": "black_plastic",
            "frame": "dark_plastic",
            "tray": "dark_plastic",
            "base": "black_plastic",
            "paper": "white_paper",
        },
        weight=2.0,
    ),
    Scheme(
        ("printer",),
        {
            ANY: "dark_plastic",
            "button": "pale_plastic",
            "handle": "pale_plastic",
            "paper": "white_paper",
        },
    ),
    Scheme(("trash_bin",), {ANY: "steel", "bag": "black_plastic", "base": "black_plastic"}),
    Scheme(
        ("trash_bin",),
        {ANY: "tinted_plastic", "bag": "pale_plastic", "lid": "pale_plastic"},
        weight=2.0,
    ),
    Scheme(
        ("trash_bin",),
        {
            ANY: "steel",
            "container": "black_plastic",
            "base": "black_plastic",
            "hinge": "black_plastic",
        },
        needs="pedal",
        weight=100.0,
    ),
    Scheme(("basket",), {ANY: "rope", "handle": "rope"}),
    Scheme(("basket",), {ANY: "wood"}, needs="base", weight=100.0),
    Scheme(("plant_pot",), {ANY: "glaze", "stone": "pebble"}, weight=2.0),
    Scheme(("plant_pot",), {ANY: "terracotta", "stone": "pebble"}),
    Scheme(("jar",), {ANY: "glaze", "handle": "glaze"}),
    Scheme(
        ("jar",),
        {ANY: "glaze", "lid": "wood", "seal": "membrane", "label": "bottle_label"},
        needs="seal",
        weight=100.0,
    ),
    Scheme(
        ("jar",), {ANY: "bottle_glass", "lid": METAL, "frame": METAL}, needs="frame", weight=100.0
    ),
    Scheme(("bottle",), {ANY: "aluminium", "lid": "black_plastic", "handle": "black_plastic"}),
    Scheme(
        ("bottle",),
        {ANY: "glaze", "lid": "steel", "frame": "steel", "handle": "steel"},
        needs="frame",
        weight=100.0,
    ),
    Scheme(
        ("bottle",),
        {ANY: "bottle_glass", "lid": "bottle_label", "label": "bottle_label"},
        needs="label",
        weight=100.0,
    ),
    Scheme(("bowl",), {ANY: "glaze"}, weight=3.0),
    Scheme(("bowl",), {ANY: "wood"}),
    Scheme(("clock",), {ANY: "black", "frame": "wood"}),
    Scheme(("clock",), {ANY: "black", "face": "enamel"}, needs="face", weight=20.0),
    Scheme(("clock",), {ANY: "black", "frame": METAL, "face": "enamel"}, needs="face", weight=20.0),
    Scheme(
        ("clock",),
        {
            ANY: "black",
            "frame": "wood",
            "base": "wood",
            "foot": "brass",
            "face": "enamel",
            "bezel": "brass",
        },
        needs="bezel",
        weight=500.0,
    ),
    Scheme(
        ("clock",),
        {ANY: "black", "ray": "brass", "frame": "brass", "face": "enamel"},
        needs="ray",
        weight=500.0,
    ),
    Scheme(
        ("whiteboard",),
        {
            ANY: "aluminium",
            "board": "enamel",
            "corner": "black_plastic",
            "pen": "felt_pen",
            "eraser": "membrane",
        },
    ),
    Scheme(("picture",), {ANY: "wood", "mat": "white_paper"}, weight=2.0),
    Scheme(("picture",), {ANY: "black", "mat": "white_paper"}),
    Scheme(("picture",), {ANY: "white", "mat": "white_paper"}),
    Scheme(
        ("pool_table",),
        {
            ANY: "wood",
            "tabletop": "felt",
            "cushion": "felt",
            "pocket": "black",
            "pocket_rim": "black",
            "ball": "billiard",
            "cue_ball": "sanitary",
            "foot": "steel",
        },
        weight=2.0,
    ),
    Scheme(
        ("pool_table",),
        {
            ANY: "black",
            "tabletop": "felt",
            "cushion": "felt",
            "cue": "wood",
            "ball": "billiard",
            "cue_ball": "sanitary",
            "foot": "steel",
        },
    ),
    Scheme(("bathtub",), {ANY: "sanitary", "leg": METAL}),
    Scheme(("toilet",), {ANY: "sanitary", "button": "chrome", "panel": "white"}),
    Scheme(("sink",), {ANY: "sanitary", **_TAP}),
    Scheme(("sink",), {ANY: "wood", **_TAP, "basin": "sanitary"}, needs="frame", weight=100.0),
    Scheme(
        ("sink",), {ANY: "white", **_DARK_TAP, "basin": "sanitary"}, needs="frame", weight=100.0
    ),
    Scheme(
        ("sink",),
        {ANY: "wood", **_DARK_TAP, "leg": METAL, "basin": "sanitary"},
        needs="countertop",
        weight=100.0,
    ),
    Scheme(
        ("sink",),
        {ANY: "white", **_TAP, "bowl": "steel", "countertop": "stone", "base": "black"},
        needs="bowl",
        weight=5e4,
    ),
    Scheme(
        ("sink",),
        {ANY: "white", **_TAP, "bowl": "steel", "countertop": "wood", "base": "black"},
        needs="bowl",
        weight=1e4,
    ),
    Scheme(
        ("curtain",),
        {
            ANY: "drape",
            "sheer": "sheer",
            "rod": METAL,
            "ring": METAL,
            "finial": METAL,
            "slat": "white",
            "weight": "white",
            "rail": "white",
            "chain": "white",
        },
    ),
    Scheme(("pillow",), {ANY: "linen"}),
    Scheme(("door",), {ANY: "white"}, weight=2.0),
    Scheme(("door",), {ANY: "white", "panel": "wood", "door": "wood"}),
    Scheme(("window", "opening"), {ANY: "white"}),
)
