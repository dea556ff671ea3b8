"""The neutral form of a captured room, which importers fill and stages read.

Everything is in metres, Z up, right-handed; every part is optional, because every capture lacks
something. ``source_from_world`` is the way back to the frame of the original file.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal, Protocol

import numpy as np
from numpy.typing import NDArray

Confidence = Literal["low", "medium", "high"]


@dataclass(frozen=True)
class CapturedOpening:
    """A rectangle cut into a wall.

    Attributes:
        id: The identifier in the source.
        kind: ``window``, ``door`` (with a leaf) or ``opening`` (without).
        center: (3,) centre of the rectangle, metres.
        direction: (3,) unit vector along its width, horizontal.
        width: Metres.
        height: Metres.
        is_open: Whether a door's leaf stands open; None when unknown.
        confidence: How sure the source is.
    """

    id: str
    kind: Literal["window", "door", "opening"]
    center: NDArray[np.float64]
    direction: NDArray[np.float64]
    width: float
    height: float
    is_open: bool | None = None
    confidence: Confidence | None = None


@dataclass(frozen=True)
class CapturedBox:
    """An object known by its oriented box.

    Attributes:
        id: The identifier in the source.
        label: The source's own category name.
        center: (3,) metres.
        rotation: (3, 3) box axes as columns: width (right), depth (back), height (up), seen by
            somebody who stands before the object's front and looks at it from its own -Y side.
        size: (3,) full width, depth and height, metres.
        confidence: How sure the source is.
        attributes: Whatever else the source knows, as plain strings.
    """

    id: str
    label: str
    center: NDArray[np.float64]
    rotation: NDArray[np.float64]
    size: NDArray[np.float64]
    confidence: Confidence | None = None
    attributes: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Capture:
    """What an importer read.

    Attributes:
        source: The name of the file that was read, without its folder.
        source_from_world: (4, 4) takes world points (metres, Z up) to the source's own frame.
        floor: (N, 2) corners of the floor polygon, counter-clockwise seen from above, metres;
            None when the source has none.
        height: Floor to ceiling, metres; None when the source does not know.
        openings: Windows, doors and openings.
        boxes: Objects known by their boxes.
        notes: What was dropped or guessed, one sentence each.
    """

    source: str
    source_from_world: NDArray[np.float64]
    floor: NDArray[np.float64] | None = None
    height: float | None = None
    openings: tuple[CapturedOpening, ...] = ()
    boxes: tuple[CapturedBox, ...] = ()
    notes: tuple[str, ...] = ()


class Importer(Protocol):
    """Reads foreign files; registered as an entry point ``openrooms_usd.importers``."""

    def read(self, source: Path) -> Capture:
        """Read a foreign file or folder.

        Raises:
            InputError: It is missing, unreadable or not of this kind.
        """
        ...
