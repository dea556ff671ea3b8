"""When generated rooms are seen: how high the sun stands, what is on, what is closed.

Moments are drawn by what people take pictures at: mostly by day, often with the sun in a window,
under clouds, in the last light, at dusk against lit rooms, and sometimes at night.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from openrooms_usd.draws import generator
from openrooms_usd.library.styles.assignment.weights import drawn
from openrooms_usd.library.styles.beams import WORK_ROOMS


@dataclass(frozen=True)
class Moment:
    """A kind of moment.

    Attributes:
        weight: How often rooms are seen at it.
        elevation: Range of the sun's height above the horizon, degrees.
        shines_in: Whether the sun stands before a window.
        overcast: Whether clouds cover the sky.
        turbidity: Range of the haze.
        ceiling: How often the lamps on the ceiling are on in homes, and where people work.
        others: How often each other lamp is on.
        dimmed: How often lamps that are on are dimmed at home.
        screens: How often a screen is on at home, and where people work.
        closed: How often curtains and blinds are closed at home, and where people work.
    """

    weight: float
    elevation: tuple[float, float]
    ceiling: tuple[float, float]
    others: float
    shines_in: bool = False
    overcast: bool = False
    turbidity: tuple[float, float] = (2.2, 4.5)
    dimmed: float = 0.0
    screens: tuple[float, float] = (0.25, 0.7)
    closed: tuple[float, float] = (0.0, 0.0)


MOMENTS: Final[Mapping[str, Moment]] = {
    "sun": Moment(0.38, (15.0, 45.0), (0.1, 0.5), 0.12, shines_in=True),
    "day": Moment(0.1, (25.0, 60.0), (0.2, 0.7), 0.2),
    "overcast": Moment(0.2, (15.0, 50.0), (0.45, 0.95), 0.45, overcast=True),
    "golden": Moment(0.12, (4.0, 10.0), (0.3, 0.9), 0.6, shines_in=True, dimmed=0.4),
    "dusk": Moment(
        0.12, (-5.0, -2.5), (0.45, 0.95), 0.95, dimmed=0.5, screens=(0.5, 0.6), closed=(0.25, 0.1)
    ),
    "night": Moment(
        0.08, (-50.0, -14.0), (0.45, 0.95), 0.95, dimmed=0.5, screens=(0.5, 0.4), closed=(0.8, 0.5)
    ),
}


def moment_of(room_type: str, seed: int) -> str:
    """The name of the moment at which a room is seen; lamps and curtains go by it.

    Args:
        room_type: Its kind.
        seed: What it was drawn by.
    """
    weights = {name: moment.weight for name, moment in MOMENTS.items()}
    return drawn(generator(seed, "generate", room_type, "moment"), weights)


def closes(room_type: str, seed: int) -> bool:
    """Whether curtains and blinds of a room are closed at its moment."""
    often = MOMENTS[moment_of(room_type, seed)].closed[room_type in WORK_ROOMS]
    return bool(generator(seed, "generate", room_type, "closed").random() < often)
