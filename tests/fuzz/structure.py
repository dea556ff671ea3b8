"""Spoils the values of JSON, YAML and tables: other types, missing, repeated and absurd ones."""

import json
from collections.abc import Callable
from random import Random
from typing import Any, Final

import yaml

from tests.fuzz.bytewise import NUMBERS, PATHS

# Also what JSON cannot say and Python's reader takes.
_VALUES: Final[tuple[Any, ...]] = (
    *(None, True, False, 0, -1, 1, 2, 1e308, -1e308, 1e-320, float("nan"), float("inf"), 10**30),
    *(10**400, 2**63, -(2**31), 1.5, "", "x", "nan", "1e999", [], {}, [[]], [None], {"": None}),
    *([1] * 5, ["x"] * 3, [[1, 2], [3]], [0] * 16, [1e308] * 3, {"x": {"y": []}}),
)

_MOST_PLACES: Final = 20_000


def spoil_json(data: bytes, rng: Random) -> bytes:
    """Change one to three values of a JSON text.

    Raises:
        ValueError: It is none.
    """
    text = json.dumps(_changed(json.loads(data), rng), ensure_ascii=rng.random() < 0.9)
    if rng.random() < 0.08:
        text = _twice(text, rng)
    return text.encode("utf-8", "surrogatepass")


def spoil_yaml(data: bytes, rng: Random) -> bytes:
    """Change one to three values of a YAML text.

    Raises:
        ValueError: It is none.
    """
    try:
        value = yaml.safe_load(data)
    except yaml.YAMLError as error:
        raise ValueError("no YAML") from error
    files = [(holder, key) for holder, key in _places(value) if _names_file(holder[key])]
    if files and rng.random() < 0.5:
        holder, key = rng.choice(files)
        holder[key] = rng.choice(PATHS)
        return _as_yaml(value)
    return _as_yaml(_changed(value, rng))


def spoil_table(data: bytes, rng: Random) -> bytes:
    """Change cells, rows or columns of a table."""
    text = data.decode("utf-8", "replace")
    mark = next((sign for sign in "\t;, " if sign in text), ",")
    rows = [line.split(mark) for line in text.splitlines()]
    for _ in range(rng.randint(1, 3)):
        row = rng.choice(rows) if rows else []
        what = rng.randrange(6)
        at = rng.randrange(len(row)) if row else 0
        if what == 0 and row:
            del row[at]
        elif what == 1:
            row.insert(at, rng.choice(NUMBERS))
        elif what == 2 and row:
            row[at] = rng.choice(PATHS)
        elif what == 3 and rows:
            rows.insert(rng.randrange(len(rows)), list(rows[0]))
        elif row:
            row[at] = rng.choice(NUMBERS)
    return "\n".join(mark.join(row) for row in rows).encode("utf-8", "surrogatepass") + b"\n"


_TABLES: Final = ".csv .tsv .txt .xyz .pts .traj .pincam .off .obj .mtl"
BY_SUFFIX: Final[dict[str, Callable[[bytes, Random], bytes]]] = {
    ".json": spoil_json,
    ".yaml": spoil_yaml,
    **dict.fromkeys(_TABLES.split(), spoil_table),
}


def _as_yaml(value: Any) -> bytes:
    return yaml.safe_dump(value, sort_keys=False).encode("utf-8", "surrogatepass")


def _names_file(value: Any) -> bool:
    return isinstance(value, str) and (value == "Wood" or "." in value.strip("."))


def _changed(value: Any, rng: Random) -> Any:
    for _ in range(rng.choice((1, 1, 2, 3))):
        places = _places(value)
        if not places:
            return rng.choice(_VALUES)
        holder, key = rng.choice(places)
        elsewhere, place = rng.choice(places)
        _change(holder, key, elsewhere[place], rng)
    return value


def _places(value: Any) -> list[tuple[Any, Any]]:
    """Every place in nested lists and mappings, as what holds it and its key."""
    found: list[tuple[Any, Any]] = []
    waiting = [value]
    while waiting and len(found) < _MOST_PLACES:
        holder = waiting.pop()
        keys: list[Any] = []
        if isinstance(holder, dict):
            keys = list(holder)
        elif isinstance(holder, list):
            keys = list(range(len(holder)))
        found += [(holder, key) for key in keys]
        waiting += [holder[key] for key in keys]
    return found


def _change(holder: Any, key: Any, other: Any, rng: Random) -> None:
    """Change the value at a key: another type, another place's value, nothing, too much of it."""
    what, old = rng.randrange(10), holder[key]
    if what < 4:
        holder[key] = _copy(rng.choice(_VALUES))
    elif what == 4:
        holder[key] = rng.choice(PATHS)
    elif what == 5:
        del holder[key]
    elif what == 6:
        holder[key] = _copy(other)
    elif what == 7:
        holder[key] = [old] if rng.random() < 0.5 else {"x": old}
    elif what == 8 and isinstance(holder, list):
        holder[key:key] = [_copy(old) for _ in range(rng.choice((1, 3, 300)))]
    elif isinstance(old, (int, float)) and not isinstance(old, bool):
        holder[key] = old * rng.choice((-1, 0, 1e-6, 1e3, 1e6, 1e30))
    else:
        for _ in range(rng.choice((5, 60, 900))):
            old = [old]
        holder[key] = old


def _copy(value: Any) -> Any:
    """The same value, not the same object: later changes must not reach the table above."""
    if isinstance(value, dict):
        return {key: _copy(inner) for key, inner in value.items()}
    return [_copy(inner) for inner in value] if isinstance(value, list) else value


def _twice(text: str, rng: Random) -> str:
    """A key that is there twice."""
    keys = [part.rsplit('"', 1)[-1] for part in text.split('":')[:-1]]
    at = text.find("{", rng.randrange(len(text)))
    if not keys or at < 0:
        return text
    return f'{text[: at + 1]}"{rng.choice(keys)}": 1, {text[at + 1 :]}'
