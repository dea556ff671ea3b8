"""A room from Python's own data: the same words about its mistakes as of a file's."""

import os
from collections.abc import Mapping as AnyMapping
from typing import Any, Final

from pydantic import BaseModel, ValidationError

from openrooms_usd.description.diagnosis import diagnose
from openrooms_usd.description.former import rename_sections
from openrooms_usd.description.mistakes import Mistake, MistakesError, Place, Steps, shown
from openrooms_usd.description.reading import MAX_DEPTH, Mapping, Sequence
from openrooms_usd.errors import DescriptionError

_NAME: Final = "the room"


def placed(data: AnyMapping[str, Any]) -> Mapping:
    """Plain data whose keys and items know their order, as those of a file know their lines.

    Tuples are lists, and arrays and numbers of numpy are lists and numbers.

    Raises:
        DescriptionError: It is not a mapping, is nested too deep, or has a key that is not text.
    """
    found = data if isinstance(data, Mapping) else _Placing().placed(data, ())
    if not isinstance(found, Mapping):
        text = f"expected keys such as `layout`, found {shown(found)}"
        raise MistakesError(_NAME, [Mistake(_nowhere(0), (), text)])
    return found


def refused(
    error: ValidationError, data: AnyMapping[str, Any], model: type[BaseModel]
) -> DescriptionError:
    """The error for what pydantic found in data that is not from a file."""
    found = placed(data)
    rename_sections(found, _NAME)
    return MistakesError(_NAME, diagnose(error, found, model))


def _nowhere(number: int) -> Place:
    """No line of a file; its order among the others."""
    return Place(0, number)


class _Placing:
    """Copies data into mappings and lists that know their order."""

    def __init__(self) -> None:
        self._count = 0

    def placed(self, value: Any, path: Steps) -> Any:
        """A value of the description, with all that it holds."""
        if len(path) > MAX_DEPTH:
            text = f"nested more than {MAX_DEPTH} levels deep"
            raise MistakesError(_NAME, [Mistake(self._next(), path, text)])
        if hasattr(value, "tolist"):
            value = value.tolist()
        if isinstance(value, AnyMapping):
            return self._mapping(value, path)
        if isinstance(value, (list, tuple)):
            return self._sequence(value, path)
        return os.fspath(value) if isinstance(value, os.PathLike) else value

    def _next(self) -> Place:
        self._count += 1
        return _nowhere(self._count)

    def _mapping(self, data: AnyMapping[Any, Any], path: Steps) -> Mapping:
        found = Mapping(self._next())
        for key, value in data.items():
            place = self._next()
            if not isinstance(key, str):
                text = f"a key must be text, found {shown(key)}"
                raise MistakesError(_NAME, [Mistake(place, path, text)])
            found.keys_at[key] = place
            found.pending = key
            found.take(self.placed(value, (*path, key)), place)
        return found

    def _sequence(self, data: list[Any] | tuple[Any, ...], path: Steps) -> Sequence:
        found = Sequence(self._next())
        for index, value in enumerate(data):
            place = self._next()
            found.take(self.placed(value, (*path, index)), place)
        return found
