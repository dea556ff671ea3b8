"""Keys of one section of a description get other values; the rest of its text stays as it stands.

The text is cut where the parser says that keys and values stand, and read again afterwards: what
comes out is the same description with those keys changed, or nothing. A comment goes only where it
stands inside of a value that is replaced.
"""

import json
import re
import textwrap
from collections.abc import Iterator, Mapping
from typing import Any, Final, NamedTuple

import yaml

from openrooms_usd.description.former import name_in
from openrooms_usd.description.reading import read_yaml
from openrooms_usd.errors import DescriptionError

_WIDTH: Final = 100
_STEP: Final = 2
_PLAIN: Final = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
# What YAML 1.1 or 1.2 reads as something else than text.
_WORDS: Final = {"true", "false", "null", "yes", "no", "on", "off", "y", "n"}
_LOADER: Final = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


class _Cut(NamedTuple):
    """Text from ``start`` to ``end`` becomes ``text``."""

    start: int
    end: int
    text: str


def rewritten(text: str, section: str, values: Mapping[str, Any], name: str = "room.yaml") -> str:
    """Give keys of a section other values.

    Args:
        text: A description that reads without mistakes.
        section: The section's key, such as ``layout``; it is added where it is missing, and keeps
            a former name.
        values: The new values by their keys: plain data, and None for keys to leave out.
        name: The file's name, for messages.

    Returns:
        The text with these keys changed. Keys that are new come after the section's others.

    Raises:
        DescriptionError: The text is so written that no part of it can be changed alone, for
            example because an alias elsewhere stands for what is replaced.
    """
    data, _ = read_yaml(text, name)
    section = name_in(data, section)
    held = data.get(section) or {}
    wanted = {key: held[key] for key in held if values.get(key, held[key]) is not None}
    wanted.update({key: value for key, value in values.items() if value is not None})
    mark = "\ufeff" if text.startswith("\ufeff") else ""
    body = text.removeprefix(mark).replace("\r\n", "\n")
    for cut in sorted(_cuts(body, section, values), reverse=True):
        body = body[: cut.start] + cut.text + body[cut.end :]
    made = mark + (body.replace("\n", "\r\n") if "\r\n" in text else body)
    if not _reads_as(made, {**data, section: wanted}, name):
        raise DescriptionError(
            f"the section {section} is written in a way that does not let parts of it be changed",
            place=name,
            remedy="write it without anchors, aliases and tags, one key a line",
        )
    return made


def _reads_as(text: str, wanted: Mapping[str, Any], name: str) -> bool:
    try:
        data, mistakes = read_yaml(text, name)
    except DescriptionError:
        return False
    return not mistakes and data == wanted


def _cuts(text: str, section: str, values: Mapping[str, Any]) -> Iterator[_Cut]:
    root: Any = yaml.compose(text, Loader=_LOADER)
    given = {key: value for key, value in values.items() if value is not None}
    if root is None or not root.value:
        yield _Cut(len(text), len(text), _appended(text, section, given, 0))
        return
    pairs = {key.value: (key, value) for key, value in root.value}
    if section not in pairs:
        if root.flow_style:
            yield from _in_flow(text, root, {section: given})
        else:
            column = root.value[0][0].start_mark.column
            yield _Cut(len(text), len(text), _appended(text, section, given, column))
        return
    key, node = pairs[section]
    if not isinstance(node, yaml.MappingNode) or not node.value:
        start, end = _colon(text, key), max(_end(text, node), _colon(text, key))
        block = not root.flow_style
        made = _block(given, key.start_mark.column + _STEP) if block else f" {_flow(given)}"
        yield _Cut(start, end, made)
    elif node.flow_style:
        yield from _in_flow(text, node, values)
    elif not given and all(held.value in values for held, _ in node.value):
        yield _Cut(_colon(text, key), _end(text, node), " {}")
    else:
        yield from _in_block(text, node, values)


def _in_block(text: str, node: Any, values: Mapping[str, Any]) -> Iterator[_Cut]:
    """A mapping with a key on each line."""
    column = node.value[0][0].start_mark.column
    held = {key.value: (key, value) for key, value in node.value}
    for name, value in values.items():
        if name in held:
            key, old = held[name]
            start, end = _colon(text, key), max(_end(text, old), _colon(text, key))
            if value is None:
                yield _Cut(_line_start(text, key.start_mark.index), _line_end(text, end) + 1, "")
            else:
                yield _Cut(start, end, _value(value, column + _STEP, len(name) + column + 2))
    last = _end(text, node.value[-1][1])
    at = _line_end(text, max(last, _colon(text, node.value[-1][0])))
    new = {k: v for k, v in values.items() if v is not None and k not in held}
    if new:
        yield _Cut(at, at, _block(new, column))


def _in_flow(text: str, node: Any, values: Mapping[str, Any]) -> Iterator[_Cut]:
    """A mapping in braces."""
    held = [key.value for key, _ in node.value]
    for place, (key, old) in enumerate(node.value):
        if key.value not in values:
            continue
        value = values[key.value]
        if value is not None:
            yield _Cut(_colon(text, key), _end(text, old), f" {_flow(value)}")
        elif place + 1 < len(node.value):
            yield _Cut(key.start_mark.index, node.value[place + 1][0].start_mark.index, "")
        else:
            before = _end(text, node.value[place - 1][1]) if place else key.start_mark.index
            yield _Cut(before, _end(text, old), "")
    new = [f"{k}: {_flow(v)}" for k, v in values.items() if v is not None and k not in held]
    if new:
        last = node.value[-1][1]
        yield _Cut(_end(text, last), _end(text, last), f", {', '.join(new)}")


def _appended(text: str, section: str, values: Mapping[str, Any], column: int) -> str:
    """A section after all that there is."""
    newline = "" if not text or text.endswith("\n") else "\n"
    return f"{newline}{' ' * column}{section}:{_block(values, column + _STEP)}\n"


def _block(values: Mapping[str, Any], column: int) -> str:
    """A mapping with a key on each line, beginning with the end of the line before."""
    lines = (
        f"\n{' ' * column}{key}:{_value(value, column + _STEP, column + len(key) + 1)}"
        for key, value in values.items()
    )
    return "".join(lines) if values else " {}"


def _value(value: Any, column: int, used: int) -> str:
    """A value after its key: on the same line, or each mapping of a list on a line of its own."""
    if isinstance(value, list) and value and all(isinstance(row, dict) for row in value):
        return "".join(f"\n{' ' * column}- {_flow(row)}" for row in value)
    line = _flow(value)
    if len(line) + used < _WIDTH or not _is_numbers(value):
        return f" {line}"
    # No number has a space or a hyphen inside of it.
    wrapped = textwrap.wrap(line, _WIDTH - column, initial_indent="x" * max(0, used - column))
    wrapped[0] = wrapped[0][max(0, used - column) :]
    return " " + f"\n{' ' * column}".join(wrapped)


def _is_numbers(value: Any) -> bool:
    if isinstance(value, list):
        return all(map(_is_numbers, value))
    return isinstance(value, (int, float))


def _flow(value: Any) -> str:
    """A value on one line."""
    if isinstance(value, Mapping):
        return f"{{{', '.join(f'{_flow(k)}: {_flow(v)}' for k, v in value.items())}}}"
    if isinstance(value, list):
        return f"[{', '.join(map(_flow, value))}]"
    if isinstance(value, bool) or value is None:
        return {True: "true", False: "false", None: "null"}[value]
    if isinstance(value, (int, float)):
        return repr(value)
    if _PLAIN.fullmatch(value) and value.lower() not in _WORDS:
        return str(value)
    return _quoted(value)


def _quoted(value: str) -> str:
    """Text in single quotes where that says it, else with escapes."""
    plain = value.isprintable() and value == value.strip()
    return "'" + value.replace("'", "''") + "'" if plain else json.dumps(value)


def _colon(text: str, key: Any) -> int:
    """Where what follows a key's colon begins."""
    return text.index(":", int(key.end_mark.index)) + 1


def _end(text: str, node: Any) -> int:
    """Where a value ends; the parser's mark of blocks is where the next thing begins."""
    if isinstance(node, yaml.CollectionNode) and not node.flow_style and node.value:
        last = node.value[-1]
        return _end(text, last[1] if isinstance(last, tuple) else last)
    start, end = int(node.start_mark.index), int(node.end_mark.index)
    return start + len(text[start:end].rstrip())


def _line_start(text: str, at: int) -> int:
    return text.rfind("\n", 0, at) + 1


def _line_end(text: str, at: int) -> int:
    found = text.find("\n", at)
    return len(text) if found < 0 else found
