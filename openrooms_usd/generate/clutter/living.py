"""How people leave a room: what lies about in it, level by level, each adding to the one before."""

from collections.abc import Sequence

from openrooms_usd.draws import generator
from openrooms_usd.generate.clutter.laying import taken_by
from openrooms_usd.generate.clutter.making import Makes
from openrooms_usd.generate.clutter.scatter import Scatter
from openrooms_usd.generate.clutter.spots import Surfaces, spots
from openrooms_usd.generate.items import Item
from openrooms_usd.generate.placement import Arrangement
from openrooms_usd.generate.shapes import Shapes

Groups = Sequence[tuple[str, Sequence[Item]]]


def lived_in(
    groups: Groups, room: Arrangement, shapes: Shapes, room_type: str, seed: int, level: int
) -> list[tuple[str, list[Item]]]:
    """The groups of a room with what lies on them, and a group of what lies about.

    What one level adds is drawn and laid after all that the levels below have: so a level holds
    everything of those below it.

    Args:
        groups: Titles and items, in the room's frame.
        room: The room with its paths; takes in what stands on the floor.
        shapes: The forms of the room's furniture.
        room_type: One of the 27.
        seed: Fixes everything that is drawn.
        level: 0 nothing, 1 tidy, 2 lived in, 3 messy.
    """
    full = [(title, list(items)) for title, items in groups]
    if not level:
        return full
    surfaces = Surfaces(shapes)
    items = [item for _, group in groups for item in group]
    rng = generator(seed, "generate", room_type, "clutter")
    scatter = Scatter(rng, surfaces, Makes(rng), taken_by(items, surfaces), room_type)
    tops = list(enumerate(spots(groups, surfaces, room_type)))
    for step in range(1, level + 1):
        scatter.rng = scatter.makes.rng = generator(seed, "generate", room_type, "clutter", step)
        for number, spot in tops:
            scatter.fill(number, spot, step)
    for group, item in scatter.added:
        full[group][1].append(item)
    return full
