"""What was found in a scan, as a file beside the layer of the room that was found.

An ``.npz`` archive of the points in the level frame with all that is known of each, and of a text
with the rooms: numbers as they are, to the last bit. It holds no folder of any machine, and equal
findings give equal bytes.
"""

import hashlib
import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd import atomic
from openrooms_usd.arrays import Array
from openrooms_usd.errors import InputError
from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.registration.hints import Box
from openrooms_usd.scan.results import FoundOpening, FoundRoom
from openrooms_usd.unpickling.arrays import read_arrays

_FACTS: Final = "facts"
# The attributes of points: their types, and how many numbers each point has.
_OF_POINTS: Final[dict[str, tuple[str, int]]] = {
    "points": ("f8", 3),
    "normals": ("f4", 3),
    "colors": ("u1", 3),
    "label": ("i4", 1),
    "instance": ("i4", 1),
    "confidence": ("f4", 1),
    "sensor_origins": ("f8", 3),
}
_REMEDY: Final = "remove it, and compose the room again"


@dataclass(frozen=True, eq=False)
class FoundScan:
    """A scan and its rooms, in the level frame: floor at z = 0, Z up, metres.

    Attributes:
        source: The name of the scan's file, without its folder.
        cloud: The points.
        rooms: All that were found, or the one that a person drew.
        chosen: The numbers of those that are composed.
        scan_from_level: (4, 4) to the frame of reports: the scan's own axes, metres.
        captured: The boxes that the capture has of its objects, each with its word.
        boxes: Around things without a name that were segmented later, by their numbers; not stored
            in the file.
    """

    source: str
    cloud: Cloud
    rooms: tuple[FoundRoom, ...]
    chosen: tuple[int, ...]
    scan_from_level: Array
    captured: tuple[tuple[str, Box], ...] = ()
    boxes: Mapping[int, Box] = field(default_factory=dict)

    @property
    def composed(self) -> tuple[FoundRoom, ...]:
        """The rooms that are composed."""
        return tuple(self.rooms[number] for number in self.chosen)

    def arrays(self) -> dict[str, NDArray[Any]]:
        """All of it as arrays, by their names in the file."""
        facts = {
            "source": self.source,
            "rooms": [room.as_dict() for room in self.rooms],
            "chosen": self.chosen,
            "scan_from_level": self.scan_from_level.tolist(),
            "captured": [
                [word, box.center.tolist(), box.size.tolist(), box.rotation.tolist()]
                for word, box in self.captured
            ],
            "words": None if self.cloud.words is None else sorted(self.cloud.words.items()),
        }
        text = json.dumps(facts, sort_keys=True).encode()
        known = ((name, getattr(self.cloud, name)) for name in _OF_POINTS)
        return {
            _FACTS: np.frombuffer(text, np.uint8),
            **{
                name: np.ascontiguousarray(values, _OF_POINTS[name][0])
                for name, values in known
                if values is not None
            },
        }


def digest_of(arrays: Mapping[str, NDArray[Any]]) -> str:
    """16 hexadecimal digits of all that a file of `FoundScan.arrays` says."""
    content = hashlib.sha256()
    for name, values in sorted(arrays.items()):
        content.update(f"{name} {values.dtype.str} {values.shape}\n".encode())
        content.update(np.ascontiguousarray(values).data)
    return content.hexdigest()[:16]


def write_found(path: Path, arrays: Mapping[str, NDArray[Any]]) -> None:
    """Write what was found.

    Args:
        path: The ``.npz`` file.
        arrays: Of a `FoundScan`.

    Raises:
        OutputError: It cannot be written.
    """
    with atomic.replacing(path) as beside, beside.open("wb") as file:
        np.savez(file, **arrays)  # type: ignore[arg-type]


def read_found(path: Path, digest: str) -> FoundScan:
    """Read what was found; what the file claims is checked before it is used.

    Args:
        path: The ``.npz`` file.
        digest: What `digest_of` said when it was written.

    Raises:
        InputError: It is missing, or not what was written.
    """
    arrays = read_arrays(path, (_FACTS, *_OF_POINTS), "points")
    if digest_of(arrays) != digest:
        raise InputError("this is not what compose wrote", place=path, remedy=_REMEDY)
    try:
        facts = json.loads(arrays.pop(_FACTS).tobytes())
        words = facts["words"]
        cloud = Cloud(
            **dict(_checked(arrays)),
            words=None if words is None else {int(n): tuple(map(str, w)) for n, w in words},
        )
        found = FoundScan(
            str(facts["source"]),
            cloud,
            tuple(map(_room, facts["rooms"])),
            tuple(map(int, facts["chosen"])),
            _numbers(facts["scan_from_level"], 4, 4),
            tuple(
                (str(word), Box(_numbers(center, 3), _numbers(size, 3), _numbers(turn, 4)))
                for word, center, size, turn in facts["captured"]
            ),
        )
        if not set(found.chosen) <= set(range(len(found.rooms))):
            raise ValueError("a room is missing")
    except (ValueError, TypeError, KeyError, RecursionError) as error:
        raise InputError(f"it is damaged: {error}", place=path, remedy=_REMEDY) from error
    return found


def _checked(arrays: Mapping[str, NDArray[Any]]) -> Iterator[tuple[str, NDArray[Any]]]:
    """Arrays of the right types and sizes."""
    count = len(arrays["points"])
    for name, values in arrays.items():
        kind, width = _OF_POINTS[name]
        rows = len(values) if name == "sensor_origins" else count
        if values.dtype.str[1:] != kind or values.shape != (rows, 3)[: 1 + (width > 1)]:
            raise ValueError(f"the array {name}")
        yield name, values


def _room(said: Mapping[str, Any]) -> FoundRoom:
    ceiling = said["ceiling_height"]
    return FoundRoom(
        normal=_numbers(said["floor"]["normal"], 3),
        point=_numbers(said["floor"]["point"], 3),
        corners=_numbers(said["corners"], len(said["corners"]), 3),
        guessed=tuple(map(int, said["guessed_walls"])),
        ceiling=None if ceiling is None else float(ceiling),
        openings=tuple(map(_opening, said["openings"])),
        measures={str(name): float(value) for name, value in said["measures"].items()},
        slopes=tuple(
            (_numbers(one["normal"], 3), _numbers(one["point"], 3))
            for one in said["ceiling_planes"]
        ),
        doubtful=tuple(map(_opening, said["doubtful_openings"])),
    )


def _opening(said: Mapping[str, Any]) -> FoundOpening:
    kind = said["type"]
    if kind not in ("door", "window"):
        raise ValueError("an opening")
    corners = _numbers(said["corners"], 4, 3)
    return FoundOpening(kind, corners, float(said["confidence"]), int(said["wall"]))


def _numbers(said: Any, *shape: int) -> Array:
    found = np.array(said, dtype=np.float64)
    if found.shape != shape:
        raise ValueError(f"numbers of the shape {found.shape}")
    return found
