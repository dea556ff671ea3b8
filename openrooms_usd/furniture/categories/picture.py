"""Pictures on a wall."""

from typing import Final

from openrooms_usd.furniture.construction import filled, row
from openrooms_usd.furniture.joinery.paintings import any_of, botanical, landscape, shapes, skyline
from openrooms_usd.furniture.joinery.pieces import Style
from openrooms_usd.furniture.joinery.posters import brushed_circle, line_drawing, poster, street_map
from openrooms_usd.furniture.joinery.wall_board import canvas, framed, framed_as, triptych
from openrooms_usd.furniture.placements import on
from openrooms_usd.furniture.record import WIDE, BuiltCategory, Classes
from openrooms_usd.furniture.schemes import METAL, Scheme, landscape_print, scheme


def _palette(tones: str, frame: str) -> Scheme:
    """The scheme of a landscape in tones that fit together."""
    return scheme(frame, landscape_print(tones), white_paper="mat", needs="ground", weight=100.0)


CATEGORY: Final = BuiltCategory(
    description="a picture on a wall",
    size=(0.5, 0.025, 0.7),
    min_size=(0.12, 0.012, 0.12),
    max_size=(3.0, 0.1, 2.2),
    styles={
        "framed": Style(framed, lambda size: size[0] < 2.2 * size[2], weight=2.0),
        "canvas": Style(canvas, lambda size: size[0] < 2.2 * size[2], (0.8, 0.03, 0.6)),
        "landscape": Style(
            framed_as(landscape, (0.1, 0.18)), lambda size: size[0] > size[2], (0.7, 0.022, 0.5)
        ),
        "skyline": Style(
            framed_as(skyline, (0.12, 0.2)), lambda size: size[0] > size[2], (0.6, 0.022, 0.42)
        ),
        "botanical": Style(
            framed_as(botanical, (0.06, 0.12)), lambda size: size[0] < size[2], (0.36, 0.02, 0.5)
        ),
        "drawing": Style(
            framed_as(any_of(line_drawing, brushed_circle), (0.08, 0.18)),
            lambda size: size[0] < 1.3 * size[2],
            (0.42, 0.02, 0.52),
        ),
        "poster": Style(
            framed_as(any_of(poster, street_map, shapes), (0.0, 0.03)),
            lambda size: size[0] < size[2],
            (0.5, 0.022, 0.7),
        ),
        "triptych": Style(
            triptych, lambda size: size[0] > 1.4 * size[2], (1.2, 0.03, 0.6), weight=0.3
        ),
    },
    size_variation=WIDE,
    support="wall",
    mount_height=1.25,
    mass_range=(0.8, 5),
    words="painting poster pictures photo picture_frame art artwork bulletin_board calendar "
    "corkboard map notice_board photograph pin_board tapestry wall_art "
    "wall_hanging",
    classes=Classes(nyu40="picture", ade20k="painting"),
    schemes=(
        scheme("wood", white_paper="mat", weight=2.0),
        scheme("black", white_paper="mat"),
        scheme("white", white_paper="mat"),
        _palette("dawn", "wood"),
        _palette("meadow", "white"),
        _palette("silver", "black"),
        _palette("ochre", "wood"),
        scheme(METAL, white_paper="mat"),
        *(
            scheme(
                frame,
                {"canvas": ground, "street": street, "river": river},
                white_paper="mat",
                picture_ink="ink",
                needs=needs,
                weight=100.0,
            )
            for frame, ground, street, river in (
                ("black", "white_paper", "picture_ink", "meadow_far"),
                ("wood", "paper", "dawn_near", "dawn_far"),
                ("white", "print_ground", "white_paper", "silver_near"),
            )
            for needs in ("ink", "river")
        ),
        scheme("wood", white_paper="mat", paper="canvas", needs="stem", weight=100.0),
        scheme("black", white_paper="mat canvas", needs="stem", weight=100.0),
    ),
    construction=(row("canvas", filled(200), "common"),),
    placements=(on("wall", max_groups=5, max_variants=5),),
    view_importance=0.4,
)
