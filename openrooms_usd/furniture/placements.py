"""Where small things lie: the words by which records say it, for what lies and for what carries.

A record says where its category lies (`SurfacePlacement`) in terms of what people use a surface
for, never of the furniture that offers it; furniture says which surfaces it has
(`BuiltCategory.offers_surfaces`). The two meet in `openrooms_usd.generation.clutter`, which looks
for the surfaces on the real meshes.
"""

from dataclasses import dataclass
from typing import Final, Literal, cast

Place = Literal[
    # Hard tops, by their use.
    "worktop",
    "sink_edge",
    "hob",
    "dining_table",
    "coffee_table",
    "side_table",
    "desk",
    "bedside",
    "dresser_top",
    "cabinet_top",
    "media_top",
    "appliance_top",
    "shop_counter",
    "window_sill",
    "mantel",
    "basin_edge",
    "bath_rim",
    "cistern",
    # Within furniture.
    "shelf",
    "low_shelf",
    "wardrobe_shelf",
    "cupboard",
    "drawer",
    # What gives way.
    "bed_head",
    "bed_foot",
    "sofa_seat",
    "sofa_arm",
    "armchair_seat",
    "chair_seat",
    # Over which things hang.
    "chair_back",
    "towel_rail",
    "clothes_rail",
    "hook",
    # The floor and the walls.
    "floor_corner",
    "floor_by_door",
    "floor_by_wall",
    "floor_beside_bed",
    "floor_beside_sofa",
    "floor_by_media",
    "floor_under_desk",
    "floor_before_basin",
    "floor_open",
    "wall",
    # Within and on other small things.
    "in_basket",
    "in_bowl",
    "in_bin",
    "on_tray",
    "on_stack",
    "beside_toilet",
]
"""What people use a place for.

``worktop``: of a kitchen, away from sink and hob. ``sink_edge``: the worktop or rim within 40 cm of
a kitchen's sink. ``hob``: the burners. ``dining_table``: also of kitchens. ``desk``: also tables
that people work or meet at. ``bedside``: the table beside a bed. ``cabinet_top``: sideboards and
low shelves. ``media_top``: what the television stands on. ``appliance_top``: of washing machines
and refrigerators. ``mantel``: of a fireplace. ``basin_edge``: rim or top of a bathroom's basin.
``cistern``: of a toilet.

``shelf``: a board with clearance above that is open to the front. ``low_shelf``: one below 60 cm,
also below tables. ``wardrobe_shelf``, ``cupboard``, ``drawer``: behind a front.

``bed_head``: by the pillows. ``bed_foot``: the last third of a bed's length.

``floor_by_media``: at the wall beside what a television stands on.
``floor_by_wall``: with its back to a wall. ``floor_under_desk``: against the wall below a desk.
``floor_before_basin``: before basin, bath or shower. ``floor_open``: anywhere off the walking
paths, for toys. ``wall``: pictures and clocks.

``hook``: each hook takes one thing. ``clothes_rail``: of a rack, for what is on hangers.
``in_bowl``, ``in_bin``: what is dropped in and settles.
"""

Pose = Literal[
    "upright", "flat", "stacked", "row", "leaning", "on_back", "on_side", "draped", "hung"
]
"""How a thing lies. All poses begin with the thing as it is built: its base at z = 0, its front
towards -Y.

``upright``: as built, its front within 20 degrees to those who use the place. ``flat``: as built,
turned any way. ``stacked``: several alike on top of each other, as built, a little turned against
each other. ``row``: several alike side by side, fronts forward. ``leaning``: as built, its lower
front edge away from what is behind it and its upper back edge against that (a book, a tray, a
board, a picture at a wall; a cushion at the back of a sofa). ``on_back``: laid on its +Y side.
``on_side``: laid on its +X side. ``draped``: over an edge (below). ``hung``: from a hook or a rail
by the loop on its top (below).

A ``draped`` thing is built as an upside-down U: two flaps that hang down towards -Y and +Y from a
ridge along X. The wanted depth is that of what it hangs over plus twice `DRAPED_WALL_M`, so that
each flap is `DRAPED_WALL_M` thick, with all folds on its outside. The wanted height is from the
longer flap's hem (z = 0) to the top of the ridge. The front flap (-Y) is the longer one.

A ``hung`` thing ends on its top in a loop across X, `LOOP_M` thick, whose highest point is at x =
0. On a hook it is `LOOP_BACK_M` before its back, on a rail at y = 0. Below the loop's underside
`LOOP_RISE_M` are free for what it hangs on.
"""

DRAPED_WALL_M: Final = 0.012
"""Thickness of each flap of a draped thing, folds included, metres."""
LOOP_M: Final = 0.005
"""Thickness of the loop by which a thing hangs, metres."""
LOOP_BACK_M: Final = 0.012
"""How far before the back of a thing the loop is by which it hangs on a hook, metres."""
LOOP_RISE_M: Final = 0.021
"""From the top of a thing to the underside of its loop, metres."""


@dataclass(frozen=True, kw_only=True)
class SurfacePlacement:
    """Where a category lies, how often, how many at once and in what pose.

    Attributes:
        on: The places; any of them.
        rooms: The room types where it does; all by default.
        styles: The styles of the category that lie so; all by default. A hung and a folded towel
            are two styles.
        weight: How often it is drawn for such a place, beside all others that may lie there: 1 is
            what one would expect there, 0.2 is rare.
        count: Least and greatest number that lie together, of one make; how high a stack is, how
            long a row.
        pose: How.
        cluster: What it is used with: things of one cluster lie close together on a surface
            (bottles and soap at a sink: ``washing``; mugs and a pot: ``coffee``; papers and a
            pen: ``writing``). Empty: with nothing.
        clutter: The level from which on it lies about: 1 tidy, 2 lived in, 3 messy.
        max_groups: How many such groups a room has at most.
        max_variants: How many makes of it a room has at most: forks are alike, books are not.
    """

    on: tuple[Place, ...]
    rooms: tuple[str, ...] = ()
    styles: tuple[str, ...] = ()
    weight: float = 1.0
    count: tuple[int, int] = (1, 1)
    pose: Pose = "upright"
    cluster: str = ""
    clutter: int = 1
    max_groups: int = 2
    max_variants: int = 2


def on(
    places: str,
    rooms: str = "",
    *,
    styles: str = "",
    weight: float = 1.0,
    count: tuple[int, int] = (1, 1),
    pose: Pose = "upright",
    cluster: str = "",
    clutter: int = 1,
    max_groups: int = 2,
    max_variants: int = 2,
) -> SurfacePlacement:
    """Where a category lies: a `SurfacePlacement`, of words that stand apart by blanks."""
    return SurfacePlacement(
        on=cast("tuple[Place, ...]", tuple(places.split())),
        rooms=tuple(rooms.split()),
        styles=tuple(styles.split()),
        weight=weight,
        count=count,
        pose=pose,
        cluster=cluster,
        clutter=clutter,
        max_groups=max_groups,
        max_variants=max_variants,
    )
