"""How large things are: about as the library says, a little more or less."""

from typing import Final

import numpy as np

from openrooms_usd.library.furniture import MIN_SIDE, Size

# How much the sides of a category vary about the usual ones: width, depth, height.
_USUAL_SPREAD: Final = (0.1, 0.06, 0.04)
_SPREADS: Final[dict[str, tuple[float, float, float]]] = {
    **dict.fromkeys(
        ("stove", "oven", "dishwasher", "washing_machine", "keyboard", "telephone", "microwave",
         "toilet", "counter", "sink", "kitchen_cabinet", "faucet"), (0.0, 0.0, 0.0)
    ),
    **dict.fromkeys(("plant_pot", "picture", "box", "basket", "rug", "jar"), (0.3, 0.25, 0.25)),
    **dict.fromkeys(("bookshelf", "cabinet", "wardrobe", "table", "coffee_table"), (0.2, 0.1, 0.1)),
    "monitor": (0.15, 0.0, 0.1),
    "ceiling_lamp": (0.25, 0.25, 0.1),
}  # fmt: skip
# What is as deep as it is wide.
_ROUND: Final = frozenset(
    ("bottle", "jar", "bowl", "plant_pot", "stool", "trash_bin", "floor_lamp", "table_lamp",
     "ceiling_lamp", "side_table", "office_chair")
)  # fmt: skip
# A room has one make of each of these: people buy them together, and assets are shared.
ALIKE: Final = frozenset(
    ("chair", "office_chair", "stool", "bench", "bookshelf", "file_cabinet", "washing_machine",
     "table_lamp", "floor_lamp", "wall_lamp", "monitor", "keyboard", "telephone", "laptop",
     "printer", "trash_bin", "speaker")
)  # fmt: skip


def drawn_size(
    rng: np.random.Generator,
    name: str,
    usual: Size,
    given: tuple[float | None, float | None, float | None],
    modesty: float = 0.0,
) -> Size:
    """A size in a category's usual range, to the centimetre (below 10 cm to the millimetre).

    Args:
        rng: Draws it.
        name: The category.
        usual: Its usual size, metres.
        given: Sides that are decided already, metres.
        modesty: 1 draws no side larger than usual.
    """
    sides = []
    for side, share, wanted in zip(usual, _SPREADS.get(name, _USUAL_SPREAD), given, strict=True):
        drawn = side * (1.0 + float(rng.uniform(-share, share * (1.0 - modesty))))
        sides.append(
            max(MIN_SIDE, round(drawn if wanted is None else wanted, 3 if side < 0.1 else 2))
        )
    if name in _ROUND and usual[0] == usual[1]:
        sides[1] = sides[0]
    return sides[0], sides[1], sides[2]
