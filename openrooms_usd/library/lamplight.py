"""Colour temperatures of lamps as they are sold, by the kind of the room."""

from typing import Final

# Where people work, lamps are cooler, and on by day, too.
WORK_ROOMS: Final = frozenset(
    {"bookstore", "classroom", "computer_cluster", "conference_room", "copy_room", "gym", "library",
     "lobby", "mail_room", "office"}
)  # fmt: skip
# Where people neither live nor work for long.
_USEFUL_ROOMS: Final = frozenset(
    {"basement", "bathroom", "closet", "garage", "kitchen", "laundry_room", "storage"}
)
# Kelvin; as often as they stand here.
HOME_KELVIN: Final = (2700, 2700, 2700, 2800, 3000)
_USEFUL_KELVIN: Final = (2700, 3000, 3000, 3500, 4000)
_WORK_KELVIN: Final = (3500, 4000, 4000)


def lamp_kelvin(room_type: str) -> tuple[int, ...]:
    """Colour temperatures of which a room of this kind has one."""
    if room_type in WORK_ROOMS:
        return _WORK_KELVIN
    return _USEFUL_KELVIN if room_type in _USEFUL_ROOMS else HOME_KELVIN
