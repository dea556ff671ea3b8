"""From what pydantic found to mistakes with a place, a path and words for people."""

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from types import UnionType
from typing import Annotated, Any, Final, Union, get_args, get_origin

from pydantic import BaseModel, BeforeValidator, Tag, ValidationError
from pydantic_core import ErrorDetails

from openrooms_usd.description import reading
from openrooms_usd.description.advice import as_linear, in_metres
from openrooms_usd.description.categories import CATEGORIES, other_words
from openrooms_usd.description.mistakes import Mistake, Place, Steps, shown
from openrooms_usd.description.model import MISTAKE
from openrooms_usd.description.substances import Substance
from openrooms_usd.description.units import degrees, kilograms, metres
from openrooms_usd.spelling import did_you_mean

# A longer list of names would not be read.
_MOST_LISTED: Final = 30

# What lists long choices, by the first of each.
_LISTS: Final = {
    CATEGORIES[0]: "orusd library list",
    get_args(Substance)[0]: "orusd materials list",
}

# What each of pydantic's findings expected; {unit} is the field's own.
_EXPECTED: Final = {
    "bool_type": "true or false",
    "dict_type": "a mapping",
    "finite_number": "a finite number",
    "float_type": "a number",
    "greater_than": "more than {gt}{unit}",
    "greater_than_equal": "at least {ge}{unit}",
    "int_type": "a whole number",
    "less_than": "less than {lt}{unit}",
    "less_than_equal": "at most {le}{unit}",
    "missing": "{entries} entries",
    "model_type": "a mapping",
    "string_pattern_mismatch": "letters, digits and _, not starting with a digit",
    "string_too_long": "at most {max_length} characters",
    "string_too_short": "at least {min_length} character",
    "string_type": "text",
    "too_long": "at most {max_length} entries",
    "too_short": "at least {min_length} entries",
    "tuple_type": "a list",
    "union_tag_not_found": "a mapping",
    "value_error": "{error}",
}
_CHOICES: Final = {"literal_error": "expected", "union_tag_invalid": "expected_tags"}
_UNIONS: Final = (Union, UnionType)
_UNITS: Final[dict[Any, str]] = {metres: " m", degrees: " deg", kilograms: " kg"}


def diagnose(
    error: ValidationError, data: reading.Mapping, model: type[BaseModel]
) -> Iterator[Mistake]:
    """Say in words for people what pydantic found.

    Args:
        error: What it raised.
        data: What it was given.
        model: What it should have made of it.
    """
    for row in error.errors(include_url=False):
        spot = _follow(row["loc"], model)
        path, place, found = _look_up(data, _path_to_blame(row["type"], spot.path), row["type"])
        too_short = row["type"] == "too_short" and isinstance(found, list)
        if too_short and len(found) >= row["ctx"]["min_length"]:
            continue  # only because of faulty entries, which have their own rows
        yield Mistake(place, path, _text(row, spot, found))


def located(data: reading.Mapping, found: Iterable[tuple[Steps, str]]) -> Iterator[Mistake]:
    """Mistakes with their places, of paths in a description and what is wrong there."""
    for steps, text in found:
        path, place, _ = _look_up(data, steps, MISTAKE)
        yield Mistake(place, path, text)


def _path_to_blame(kind: str, path: Steps) -> Steps:
    """What to point at: the list that has too few entries, the key that chooses a source."""
    if kind == "missing" and isinstance(path[-1], int):
        return path[:-1]
    return (*path, "from") if kind == "union_tag_invalid" else path


@dataclass
class _Spot:
    """What the description's types say about a path.

    Attributes:
        model: The innermost model on the way.
        annotation: The type at the path's end.
        path: The steps, without the tags that pydantic adds for sources.
        holder: The type of what holds the last step.
        rivals: By source: the models that could stand in place of ``model``.
    """

    model: type[BaseModel]
    annotation: Any
    path: Steps = ()
    holder: Any = None
    rivals: Mapping[str, type[BaseModel]] = field(default_factory=dict)


def _follow(loc: Steps, top: type[BaseModel]) -> _Spot:
    """Walk from the description's top along a path of pydantic's."""
    spot = _Spot(top, top)
    for step in loc:
        sources = _sources(spot.annotation)
        if step in sources:
            spot.annotation = spot.model = sources.pop(str(step))
            spot.rivals = sources
            continue
        spot.path += (step,)
        spot.holder = _bare(spot.annotation)
        if isinstance(spot.holder, type) and issubclass(spot.holder, BaseModel):
            if spot.holder is not spot.model:
                spot.model, spot.rivals = spot.holder, {}
            spot.annotation = _fields(spot.holder).get(str(step))
        else:
            spot.annotation = _item(spot.holder, step)
    return spot


def _fields(model: type[BaseModel]) -> dict[str, Any]:
    """The keys of a model as they are written, with their types."""
    return {
        info.alias or name: Annotated[info.annotation, *info.metadata, None]
        for name, info in model.model_fields.items()
    }


def _members(annotation: Any) -> list[Any]:
    """The alternatives of a type, still annotated; None is not one of them."""
    if get_origin(annotation) is Annotated and get_origin(annotation.__origin__) in _UNIONS:
        return _members(annotation.__origin__)
    if get_origin(annotation) in _UNIONS:
        return [member for member in get_args(annotation) if member is not type(None)]
    return [annotation]


def _sources(annotation: Any) -> dict[str, Any]:
    """The models between which ``from`` chooses; empty where there is no choice."""
    return {
        note.tag: member.__origin__
        for member in _members(annotation)
        for note in getattr(member, "__metadata__", ())
        if isinstance(note, Tag)
    }


def _bare(annotation: Any) -> Any:
    """A type without its annotations and without None."""
    member = _members(annotation)[0]
    return member.__origin__ if get_origin(member) is Annotated else member


def _item(holder: Any, step: str | int) -> Any:
    """The type of a list's or mapping's entries."""
    inner = get_args(holder)
    if get_origin(holder) is not tuple:
        return inner[1] if len(inner) > 1 else None
    return inner[0] if Ellipsis in inner else inner[min(int(step), len(inner) - 1)]


def _unit(annotation: Any) -> str:
    """The unit in which pydantic compares: `` m``, `` deg`` or nothing."""
    notes = [
        note
        for kind in (annotation, *_members(annotation))
        for note in getattr(kind, "__metadata__", ())
        if isinstance(note, BeforeValidator)
    ]
    return next((_UNITS[note.func] for note in notes if note.func in _UNITS), "")


def _look_up(data: reading.Mapping, path: Steps, kind: str) -> tuple[Steps, Place, Any]:
    """Where a path stands in the file and what stands there, or the nearest thing around it.

    The path comes back without the steps that a shorthand stands for.
    """
    place: Place = data.place
    found: Any = data
    for depth, step in enumerate(path):
        if isinstance(found, reading.Mapping) and step in found:
            last = kind == "extra_forbidden" and depth == len(path) - 1
            place = (found.keys_at if last else found.values_at)[str(step)]
            found = found[str(step)]
        elif isinstance(found, reading.Sequence) and _is_row(step, len(found)):
            place, found = found.values_at[int(step)], found[int(step)]
        else:
            nested = isinstance(found, (reading.Mapping, reading.Sequence))
            return (path if nested else path[:depth]), place, found
    return path, place, found


def _is_row(step: int | str, count: int) -> bool:
    """Whether a step leads into a list; those through a choice of types have names."""
    return str(step).isdecimal() and int(step) < count


def _text(row: ErrorDetails, spot: _Spot, found: Any) -> str:
    kind, context = row["type"], row.get("ctx", {})
    if kind == MISTAKE:
        return row["msg"]
    if kind == "extra_forbidden":
        return _unknown_key(spot)
    if kind == "missing" and isinstance(row["loc"][-1], str):
        return f"required key is missing{_meaning(spot)}"
    if kind in _CHOICES:
        allowed = re.findall(r"'([^']*)'", context[_CHOICES[kind]])
        also = other_words() if allowed[0] == CATEGORIES[0] else None
        hint = did_you_mean(found, allowed, also)
        hint = as_linear(spot.path, found) or hint
        return f"found {shown(found)}{hint}; allowed: {_list_choices(allowed)}"
    limits = {key: _limit(value) for key, value in context.items()}
    values = {**limits, "unit": _unit(spot.annotation), "entries": len(get_args(spot.holder))}
    expected = _EXPECTED[kind].format(**values) if kind in _EXPECTED else row["msg"]
    most = context.get("le", context.get("lt"))
    hint = as_linear(spot.path, found)
    if most is not None and _unit(spot.annotation) == " m" and isinstance(found, int | float):
        hint = in_metres(float(found), most)
    return f"expected {expected}, found {shown(found)}{hint}"


def _list_choices(allowed: Sequence[str]) -> str:
    """All choices, or so many that a person reads them."""
    if len(allowed) <= _MOST_LISTED:
        return ", ".join(allowed)
    shown_first = ", ".join(allowed[: _MOST_LISTED // 3])
    command = _LISTS.get(allowed[0], "orusd schema")
    return f"{shown_first} ... (`{command}` lists all)"


def _limit(value: Any) -> str:
    """A limit as people write it: 180 and not 180.0, 1,000,000 and not 1e+06."""
    if isinstance(value, (int, float)):
        return f"{value:,}" if isinstance(value, int) else f"{value:,.10g}"
    return str(value)


def _unknown_key(spot: _Spot) -> str:
    key, known = str(spot.path[-1]), _fields(spot.model)
    owners = [source for source, model in spot.rivals.items() if key in _fields(model)]
    hint = f" (it belongs to `from: {owners[0]}`)" if owners else did_you_mean(key, known)
    return f"unknown key{hint}; allowed: {', '.join(known)}"


def _meaning(spot: _Spot) -> str:
    """What the missing key is for, as its documentation says."""
    fields = spot.model.model_fields.items()
    said = next((i.description for n, i in fields if (i.alias or n) == spot.path[-1]), None)
    return f" ({said.rstrip('.')})" if said else ""
