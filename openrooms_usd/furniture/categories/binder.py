"""Ring binders for a shelf, and folders that lie."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import ANY, filled, row, solid
from openrooms_usd.furniture.joinery.boards import board
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style, numbered
from openrooms_usd.furniture.joinery.posing import band, turned
from openrooms_usd.furniture.placements import on
from openrooms_usd.furniture.record import STANDARD, BuiltCategory
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.mesh import Mesh, joined
from openrooms_usd.geometry.solids import box, cylinder


def standing(size: Size, rng: np.random.Generator) -> Parts:
    """A binder that shows its spine: a label, a hole to pull it by."""
    width, depth, height = size
    x, y, w = 0.5 * width, 0.5 * depth, 0.0022
    shell = [
        box((w, depth, height), (-x + 0.5 * w, 0.0, 0.5 * height)),
        box((w, depth, height), (x - 0.5 * w, 0.0, 0.5 * height)),
        box((width, w, height), (0.0, -y + 0.5 * w, 0.5 * height)),
    ]
    papers = box((0.6 * width, 0.78 * depth, 0.9 * height), (0.0, -0.02 * depth, 0.49 * height))
    tag = box((0.72 * width, 0.0008, 0.44 * height), (0.0, -y, 0.66 * height))
    lines = [
        box((0.45 * width, 0.0012, 0.008), (0.0, -y, (0.8 - 0.06 * k) * height)) for k in range(3)
    ]
    hole = turned(band(0.011, 0.0135, -0.001, 0.0008, 20), "x", 90.0)
    dark = turned(cylinder(0.0112, 0.0012, segments=20), "x", 90.0).moved((0.0, 0.0006, 0.0))
    at = (0.0, -y, 0.16 * height)
    return {
        "cover": joined(shell),
        "pages": papers,
        "label": tag,
        "text": joined(lines),
        "ring": hole.moved(at),
        "hole": dark.moved(at),
    }


def folder(size: Size, rng: np.random.Generator) -> Parts:
    """Folders of card, some in each other, papers looking out."""
    width, depth, height = size
    found: list[Mesh] = []
    sheets: list[Mesh] = []
    count = 3
    each = height / count
    y = 0.5 * depth
    for k in range(count):
        z, shift = k * each, 0.02 * width * (k - 1)
        low, high = (-0.48 * width + shift, -y, z), (0.48 * width + shift, y, z + 0.6 * each)
        found.append(board(low, high, 0.0006))
        left, right = -0.45 * width + shift, 0.49 * width + 0.5 * shift
        low, high = (left, -0.96 * y, z + 0.55 * each), (right, 0.94 * y, z + 0.95 * each)
        sheets.append(board(low, high, 0.0005))
    half = 0.48 * width
    top = board((-half, -y, height - 0.2 * each), (half, y, height), 0.0006)
    return {**numbered("folder", [*found, top]), "paper": joined(sheets)}


CATEGORY: Final = BuiltCategory(
    description="a ring binder, or folders",
    size=(0.075, 0.285, 0.318),
    min_size=(0.02, 0.1, 0.01),
    max_size=(0.4, 0.45, 0.45),
    styles={
        "standing": Style(standing, lambda size: size[2] > size[0]),
        "folders": Style(folder, lambda size: size[2] < 0.1, (0.24, 0.32, 0.022)),
    },
    size_variation=STANDARD,
    one_variant_per_room=True,
    support="surface",
    mass_range=(0.15, 4),
    words="binders folder folders ring_binder file_folder",
    schemes=(
        scheme(
            "binder", white_paper="label", print="text", steel="ring", cavity="hole", weight=2.0
        ),
        scheme("white_paper", envelope="folder", needs="folder", weight=100.0),
    ),
    construction=(row("pages paper", filled(420), "weight"), row(ANY, solid(700), "common")),
    placements=(
        on(
            "shelf low_shelf",
            "office",
            styles="standing",
            pose="row",
            count=(3, 6),
            weight=0.9,
            max_groups=4,
        ),
        on("desk cabinet_top", "office", styles="folders", pose="flat", weight=0.4, max_groups=1),
    ),
)
