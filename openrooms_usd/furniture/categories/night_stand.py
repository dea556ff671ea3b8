"""Night stands: two drawers, or one over an open shelf."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import STORAGE_ROWS
from openrooms_usd.furniture.joinery.carcass import closed
from openrooms_usd.furniture.joinery.fronts import drawers, drawn_look
from openrooms_usd.furniture.joinery.pieces import Furniture, Size, Style
from openrooms_usd.furniture.joinery.small_table import nightstand
from openrooms_usd.furniture.record import BuiltCategory, Classes
from openrooms_usd.furniture.schemes import STORAGE


def chest(size: Size, rng: np.random.Generator) -> Furniture:
    """Drawers on short legs or on a plinth."""
    raised = rng.uniform() < 0.6
    cabinet = closed(size, min(0.13, 0.25 * size[2]) if raised else 0.05)
    if raised:
        cabinet.legs()
    else:
        cabinet.plinth()
    look = drawn_look(rng)
    drawers(cabinet.made, cabinet.overlay, cabinet.face, cabinet.back - 0.03, look)
    return cabinet.made.furniture()


CATEGORY: Final = BuiltCategory(
    description="a small chest beside a bed",
    size=(0.48, 0.42, 0.55),
    min_size=(0.28, 0.25, 0.35),
    max_size=(0.9, 0.7, 0.85),
    styles={"drawers": Style(chest), "open": Style(nightstand)},
    one_variant_per_room=True,
    mass_range=(6, 22),
    words="nightstand bedside_table night_table bedside_cabinet bedside_chest",
    classes=Classes("table", "night_stand", "table"),
    schemes=STORAGE,
    construction=STORAGE_ROWS,
    offers_surfaces=("bedside", "drawer", "low_shelf"),
)
