"""What people give: text or a path, a folder or the file in it, a room in any of its forms."""

import os
from collections.abc import Iterable, Mapping, Sequence
from numbers import Integral
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, get_args

from openrooms_usd import names
from openrooms_usd.errors import InputError, UnknownNameError
from openrooms_usd.spelling import did_you_mean

if TYPE_CHECKING:
    from openrooms_usd.description.room import Room

AnyPath = str | os.PathLike[str]
"""A file or folder; a scene stands for its file, a render and a view for their folders."""

DESCRIPTION: Final = "room.yaml"


def path_of(given: AnyPath, what: str = "a path") -> Path:
    """The path that an argument gives.

    Args:
        given: Text, or anything with a path.
        what: What is expected, for the message.

    Raises:
        InputError: It is something else.
    """
    if isinstance(given, (str, os.PathLike)):
        return Path(given)
    remedy = "ou.compose(room, out) makes a scene of a room" if _is_room(given) else None
    raise InputError(f"expected {what}, found {_excerpt(given)}", remedy=remedy)


def usd_file(given: AnyPath) -> Path:
    """The USD file that an argument gives: for a composed room's folder its root layer."""
    path = path_of(given, "a composed room or a USD file")
    return path / names.SCENE if path.is_dir() else path


def room_of(given: "Room | Mapping[str, Any] | AnyPath") -> "Room":
    """The room that an argument gives.

    Args:
        given: A room, plain data, a ``room.yaml``, or a folder that holds one.

    Raises:
        InputError: The file cannot be read.
        DescriptionError: It has mistakes.
    """
    from openrooms_usd import description

    if isinstance(given, description.Room):
        return given
    if isinstance(given, Mapping):
        return description.room_of(given)
    path = path_of(given, "a room, a dict or a path")
    return description.load_room(path / DESCRIPTION if path.is_dir() else path)


def size_of(given: object, what: str) -> tuple[int, int]:
    """A width and a height.

    Args:
        given: Two whole numbers.
        what: What they are, for the message.

    Raises:
        InputError: It is something else.
    """
    if isinstance(given, Sequence) and not isinstance(given, str) and len(given) == 2:
        width, height = given
        if isinstance(width, Integral) and isinstance(height, Integral):
            return int(width), int(height)
    remedy = "give a width and a height, such as (640, 480)"
    raise InputError(
        f"expected two whole numbers, found {_excerpt(given)}", place=what, remedy=remedy
    )


def choice_of(given: object, choices: object, what: str) -> None:
    """Check that a value is one of the allowed texts.

    Args:
        given: The value that the caller chose.
        choices: The ``Literal`` of all.
        what: What it is, for the message.

    Raises:
        InputError: It is something else.
    """
    known = get_args(choices)
    if given not in known:
        remedy = f"choose one of: {', '.join(known)}"
        hint = did_you_mean(given, known)
        raise InputError(f"{_excerpt(given)} cannot be chosen{hint}", place=what, remedy=remedy)


def points_of(given: object, what: str) -> list[tuple[float, float, float]]:
    """Points of the world, metres.

    Args:
        given: A sequence of x, y, z.
        what: What they are, for the message.

    Raises:
        InputError: It is something else.
    """
    try:
        return [(float(x), float(y), float(z)) for x, y, z in given]  # type: ignore[attr-defined]
    except (TypeError, ValueError):
        remedy = "give a list of points, such as [(2, 1.5, 1.2)], in metres"
        raise InputError(f"{_excerpt(given)} are not points", place=what, remedy=remedy) from None


def unknown_name(
    what: str, name: object, known: Iterable[str], place: object, remedy: str | None = None
) -> UnknownNameError:
    """The error for a name that a result does not have.

    Args:
        what: What it would be.
        name: What was asked for.
        known: What there is.
        place: The result.
        remedy: How there would be one.
    """
    names = list(known)
    near = did_you_mean(name, names)
    there = f"there are: {', '.join(names)}" if names else ""
    said = "; ".join(filter(None, (there, remedy)))
    return UnknownNameError(f"no {what} is named {name!r}{near}", place=place, remedy=said or None)


def _is_room(given: object) -> bool:
    return isinstance(given, Mapping) or type(given).__name__ == "Room"


def _excerpt(given: object) -> str:
    text = repr(given)
    return text if len(text) <= 60 else f"{text[:50]}... ({type(given).__name__})"


def names_of(given: str | Iterable[str] | None) -> list[str] | None:
    """Names from one text with commas, or from several texts; None if nothing is given."""
    found = given.split(",") if isinstance(given, str) else given
    return None if found is None else [name.strip() for name in found]
