"""What stands for files that cannot be passed on: Adobe's materials and ShapeNet's models.

A material's name says what it is (``Material__wood_oak_brown``); which words mean what follows the
nine categories in which the creators listed theirs. Of a model only the factors of its scale are
known beside its category: models lie in a box whose diagonal is 1 (ShapeNet's normalisation).
"""

import re
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.furniture import CATEGORIES, category

# The first row with a word of the name counts: what something is made of comes before what it
# looks like, and what covers it before what lies below.
_WORDS: Final[tuple[tuple[str, str], ...]] = (
    ("leather", "leather suede alligator crocodile snakeskin ostrich stingray nubuck hide skin"),
    ("rubber", "rubber silicone tire latex elastomer elastane"),
    (
        "plastic",
        "plastic acrylic pvc resin polymer abs sls cmx acetate polyurethane polycarbonate "
        "bakelite epoxy styrofoam polystyrene celluloid powder",
    ),
    (
        "rough_stone",
        "concrete brick bricks cement gravel slate terracotta plaster stucco roughcast "
        "road street sidewalk flagstone lavastone travertine ceramic roof rust wallpaper vinyl "
        "bone court stream stone asphalt foam ground forest rocky",
    ),
    (
        "fabric",
        "fabric carpet linen cotton wool velvet canvas denim silk knit felt cloth textile "
        "satin tweed jersey fleece rug burlap polyester nylon lace woven corduroy towel jute fur "
        "tapestry weave braid jacquard moquette sofa upholstery sisal microfiber crochet synthetic "
        "plaid tartan yarn hemp ripstop flannel chenille rope camouflage viscose polyamide tulle "
        "hair padded paper book",
    ),
    (
        "metal",
        "metal metallic steel iron aluminium aluminum bronze copper cooper brass gold silver "
        "chrome titanium zinc tin nickel rusty rusted galvanized platinum lead oxidized corrugated "
        "foil cast anodized magnesium chromium pewter plate dmd",
    ),
    (
        "wood",
        "wood parquet plywood planks plank oak walnut bamboo cork bark timber laminate mdf "
        "osb pine cherry maple ash mahogany beech teak cedar rattan wicker chipboard veneer ebony "
        "hardwood floorboards crate birch elm cardboard",
    ),
    (
        "specular_stone",
        "marble granite polished terrazzo onyx porcelain mosaic quartz agate glazed glass jade",
    ),
    ("paint", "paint painted lacquer coating coated enamel matte"),
)
_UNKNOWN: Final = "rough_stone"
_NAME: Final = re.compile(r"(?:^|/)Material__([^/]+)")
# By which factors a height that follows from the floor may differ from the usual one.
_CREDIBLE: Final = (0.5, 2.0)
_USUAL_SIDE_M: Final = 0.5


def material_name(path: str) -> str:
    """The name of a material by the path of one of its maps."""
    found = _NAME.search(path)
    return found.group(1) if found else path.rsplit("/", 1)[-1].rsplit(".", 1)[0]


def substance_of(name: str) -> str:
    """What a material is, by the words of its name; what no word says is rough stone."""
    words = set(re.split(r"[^a-z]+", name.lower()))
    return next((kind for kind, known in _WORDS if words & set(known.split())), _UNKNOWN)


def extent_of(label: str, scale: Array, origin_height: float, ceiling: float | None) -> Array:
    """(2, 3) the likely box of a missing model, in its own axes, Y up.

    Args:
        label: Its category.
        scale: (3,) factors of its pose.
        origin_height: How high the origin of its axes stands above the floor, metres. Models lie
            around it, so that this is half the height of what stands.
        ceiling: The room's height where it hangs from there, metres; None where it does not.
    """
    usual = np.array(category(label).size if label in CATEGORIES else (_USUAL_SIDE_M,) * 3)
    if ceiling is not None:
        width, depth, height = usual
        half = 0.5 * np.array([width, height, depth]) / scale
        center = np.array([0.0, (ceiling - 0.5 * height - origin_height) / scale[1], 0.0])
        return np.stack([center - half, center + half])
    width, depth, height = usual / np.linalg.norm(usual)
    standing = 2.0 * origin_height / scale[1]
    on_floor = label in CATEGORIES and category(label).support == "floor"
    if on_floor and _CREDIBLE[0] < standing / height < _CREDIBLE[1]:
        height = standing
    half = 0.5 * np.array([width, height, depth])
    return np.stack([-half, half])
