"""room.yaml: its models, how it is read, and its JSON Schema."""

from openrooms_usd.description.alignment import named_objects
from openrooms_usd.description.files import dump_room, load_room, parse_room
from openrooms_usd.description.layout import named_openings
from openrooms_usd.description.room import Room, room_of

__all__ = [
    "Room",
    "dump_room",
    "load_room",
    "named_objects",
    "named_openings",
    "parse_room",
    "room_of",
]
