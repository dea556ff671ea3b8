"""Cloths over edges, and what hangs on hooks and rails: made to fit, drawn by the records."""

from openrooms_usd.furniture import category
from openrooms_usd.generation.clutter.amounts import DRAPED, HUNG
from openrooms_usd.generation.clutter.draping import Edge, hang_over
from openrooms_usd.generation.clutter.ground import Ground
from openrooms_usd.generation.clutter.hooks import Peg
from openrooms_usd.generation.clutter.laying import item_at, posed_object
from openrooms_usd.generation.clutter.scatter import Scatter


def drape(scatter: Scatter, number: int, edge: Edge, level: int) -> None:
    """Hang a cloth over an edge, as often as a level has it.

    Args:
        scatter: Lays things in this room.
        number: The edge's, the same at all levels.
        edge: The edge.
        level: 1, 2 or 3.
    """
    drawn = scatter.drawn(number, edge.place, level)
    wanted = scatter.rng.random() < DRAPED[edge.place][level - 1]
    make = scatter.variants.draw(*drawn) if drawn and wanted else None
    if drawn is None or make is None:
        return
    (width, _, height), style = make
    fit = hang_over(edge, width, height, scatter.rng)
    spec, carrier = category(drawn[0]), edge.carrier
    if fit is None or not all(
        low <= side <= high
        for low, side, high in zip(spec.min_size, fit.size, spec.max_size, strict=True)
    ):
        return
    thing = posed_object(scatter.surfaces, drawn[0], (fit.size, style))
    pose = (*carrier.at(fit.x, fit.y), carrier.yaw + fit.yaw)
    box = thing.standing(pose, carrier.z + fit.z)
    if not len(scatter.taken.near(box, {carrier.key})):
        item = item_at(thing, scatter.key(drawn[0]), pose, carrier.z + fit.z, carrier.key)
        scatter.note(number, *drawn)
        scatter.add(edge.group, item, box)


def hang(scatter: Scatter, number: int, peg: Peg, ground: Ground, level: int) -> None:
    """Hang a thing on a hook or a rail, as often as a level has it.

    Args:
        scatter: Lays things in this room.
        number: The carrier's, the same at all levels.
        peg: The hook.
        ground: The room's walls.
        level: 1, 2 or 3.
    """
    drawn = scatter.drawn(number, peg.place, level)
    wanted = scatter.rng.random() < HUNG[peg.place][level - 1]
    make = scatter.variants.draw(*drawn) if drawn and wanted else None
    if drawn is None or make is None:
        return
    thing, carrier = posed_object(scatter.surfaces, drawn[0], make), peg.carrier
    x, y, z = peg.hung(thing.size)
    turn = peg.yaw + 180.0 * float(peg.yaw > 0.0 and scatter.rng.random() < 0.5)
    pose = (*carrier.at(x, y), carrier.yaw + turn)
    box = thing.standing(pose, carrier.z + z)
    if carrier.z + z < 0.02 or ground.meets_walls(box):
        return
    if not len(scatter.taken.near(box, {carrier.key})):
        item = item_at(thing, scatter.key(drawn[0]), pose, carrier.z + z, carrier.key)
        scatter.note(number, *drawn)
        scatter.add(peg.group, item, box)
