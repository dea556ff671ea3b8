"""Magazines and newspapers: thin, printed, their covers a little lifted."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import ANY, filled, row
from openrooms_usd.furniture.joinery.linens import between, folded_pile
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style
from openrooms_usd.furniture.joinery.prints import Print, label_lines, printed_cover
from openrooms_usd.furniture.placements import on
from openrooms_usd.furniture.record import BuiltCategory, Classes
from openrooms_usd.furniture.schemes import scheme


def glossy(size: Size, rng: np.random.Generator) -> Parts:
    """A magazine with its cover up."""
    width, depth, height = size
    thick = 0.8 * height
    u, v = np.meshgrid(np.linspace(-0.5, 0.5, 7), np.linspace(-0.5, 0.5, 5))
    lift = (height - thick) * np.clip(2.0 * (u + 0.0), 0.0, 1.0) ** 2 * (1.0 - 0.5 * (v + 0.5))
    top = np.stack([width * u, depth * v, thick + lift], axis=-1)
    low = np.stack([width * u, depth * v, 0.0 * u], axis=-1)
    print_ = printed_cover(0.9 * width, 0.97 * depth, rng)
    print_.titles += label_lines(print_, (0.06, 0.45, 0.3, 0.5), 4, rng, 1)
    up = np.eye(4)
    # The right edge of the cover is lifted: the print ends before.
    up[:3, 3] = (-0.49 * width, -0.485 * depth, thick + 0.0002)
    up[0, 0] = 0.56
    return {"cover": between(top, low), **print_.parts(up)}


def newspaper(size: Size, rng: np.random.Generator) -> Parts:
    """A newspaper folded in half: columns of lines, a headline, a picture."""
    width, depth, height = size
    body = folded_pile((width, depth, height), 3, rng)
    page = Print((width, depth))
    page.titles += [page.bar((0.08, 0.86), (0.92, 0.93)), page.bar((0.08, 0.76), (0.7, 0.8))]
    page.fields.append(page.bar((0.38, 0.42), (0.92, 0.72)))
    columns = ((0.08, 0.72, 20), (0.38, 0.38, 9), (0.67, 0.38, 9))
    for left, high, count in columns:
        page.lines += label_lines(page, (left, left + 0.26, 0.08, high), count, rng)
    up = np.eye(4)
    up[:3, 3] = (-0.5 * width, -0.5 * depth, height - 0.0002)
    return {"paper": body, **page.parts(up)}


CATEGORY: Final = BuiltCategory(
    description="a magazine or a newspaper",
    size=(0.21, 0.28, 0.007),
    min_size=(0.1, 0.12, 0.005),
    max_size=(0.5, 0.6, 0.06),
    styles={"glossy": Style(glossy), "newspaper": Style(newspaper, size=(0.3, 0.38, 0.012))},
    support="surface",
    mass_range=(0.1, 0.9),
    words="magazines newspaper newspapers brochure",
    classes=Classes(nyu40="paper"),
    schemes=(
        scheme("package", package_field="field", package_ink="title text"),
        scheme("newsprint", print="field text", cavity="title", needs="paper", weight=100.0),
    ),
    construction=(row(ANY, filled(700), "common"),),
    placements=(
        on(
            "coffee_table side_table",
            pose="stacked",
            count=(1, 4),
            weight=0.8,
            styles="glossy",
            max_variants=4,
            cluster="reading",
        ),
        on("sofa_seat armchair_seat bed_foot", pose="flat", clutter=2, weight=0.3, max_groups=1),
        on(
            "low_shelf in_basket",
            pose="stacked",
            count=(2, 5),
            weight=0.6,
            styles="glossy",
            max_variants=4,
        ),
        on(
            "dining_table worktop",
            "kitchen dining_room",
            pose="flat",
            styles="newspaper",
            clutter=2,
            weight=0.4,
            max_groups=1,
        ),
        on(
            "floor_beside_sofa",
            pose="flat",
            count=(1, 3),
            clutter=3,
            weight=0.4,
            max_groups=1,
            styles="glossy",
            max_variants=4,
        ),
    ),
)
