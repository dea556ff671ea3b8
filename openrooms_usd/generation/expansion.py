"""``from: generate`` in a description becomes what it stands for, before any step runs."""

from pathlib import Path
from typing import Any

from openrooms_usd.description.furniture import ObjectList, named_objects
from openrooms_usd.description.generate import GeneratedFurniture, GeneratedLayout
from openrooms_usd.description.layout import PolygonLayout
from openrooms_usd.description.room import Room
from openrooms_usd.generation.clutter.described import lying_in, rows
from openrooms_usd.generation.describing import layout_section, objects, row_of
from openrooms_usd.generation.environments import environment
from openrooms_usd.generation.finishing import finished
from openrooms_usd.generation.lighting import lamps, screens
from openrooms_usd.generation.rooms import Generated, furnish, generate, style_of
from openrooms_usd.generation.shell import shell_of


def expanded(room: Room) -> Room:
    """A description without generated sections: polygon, openings, objects and lamps are explicit.

    What lies about (``clutter``) is explicit too, on described furniture as on drawn.

    A generated layout is furnished too, unless the description has furniture of its own, and it
    is seen at a moment that is drawn, unless the description has an environment. Lamps that the
    description gives keep what it says of them; all are on in a room whose moment is not drawn.

    Args:
        room: Any description.

    Returns:
        The same room where nothing is generated.

    Raises:
        InputError: No room of the wanted area can be made.
    """
    layout, wants_layout = room.layout, isinstance(room.layout, GeneratedLayout)
    wants_objects = isinstance(room.furniture, GeneratedFurniture) or (
        wants_layout and "furniture" not in room.model_fields_set
    )
    if not wants_layout and not wants_objects:
        return _with_clutter(room) if room.clutter else room
    if isinstance(layout, GeneratedLayout):
        clutter = room.clutter if wants_objects else 0
        is_seen = "environment" not in room.lights.model_fields_set
        made = generate(
            room.room, room.seed, layout.area, room.style, clutter,
            seen=is_seen, thickness=layout.wall_thickness,
        )  # fmt: skip
    else:
        assert isinstance(layout, PolygonLayout), "a description allows no others"
        shell = finished(shell_of(layout), layout)
        style = room.style or style_of(room.room, room.seed)
        made = furnish(room.room, room.seed, shell, style, room.clutter)
    explicit = _with(room, made, wants_layout, wants_objects)
    return _with_clutter(explicit) if room.clutter and not wants_objects else explicit


def _with_clutter(room: Room) -> Room:
    """A described room with what lies about among its objects."""
    layout, listed = room.layout, room.furniture
    assert isinstance(layout, PolygonLayout), "a description allows no others"
    assert isinstance(listed, ObjectList), "a description allows no others"
    shell = finished(shell_of(layout), layout)
    folder = room.folder or Path()
    lying = lying_in(listed.objects, shell, room.room, room.seed, room.clutter, folder)
    described = named_objects(listed.objects)
    names = {name: name for name, _ in described}
    found = [
        row_of(name, item, carrier, (carrier, below) if below else None)
        for name, item, carrier, below in rows(lying, list(names))
    ]
    data: dict[str, Any] = room.model_dump(by_alias=True, exclude_unset=True)
    data["clutter"] = 0
    own = data.setdefault("furniture", {"from": "objects"}).get("objects", ())
    kept = [{**row, "name": name} for row, name in zip(own, names, strict=True)]
    data["furniture"]["objects"] = [*kept, *found]
    return Room.model_validate(data).located(room.folder)


def _with(room: Room, made: Generated, wants_layout: bool, wants_objects: bool) -> Room:
    data: dict[str, Any] = room.model_dump(by_alias=True, exclude_unset=True)
    if isinstance(room.layout, GeneratedLayout):
        data["layout"] = layout_section(made) | {"wall_thickness": room.layout.wall_thickness}
    if wants_objects:
        data["style"] = made.style
        data["furniture"] = {
            "from": "objects",
            "objects": [row for _, row in objects(made.furnishing)],
        }
        lights = data.setdefault("lights", {})
        if wants_layout:
            lights.setdefault("environment", environment(made))
        seen = lights.get("environment") == environment(made)
        lights["lamps"] = lamps(made, seen=seen) | lights.get("lamps", {})
        if seen:
            lights["screens"] = screens(made) | lights.get("screens", {})
    return Room.model_validate(data).located(room.folder)
