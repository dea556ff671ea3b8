"""XML of others: read without entities, and never deeper than a parser's stack."""

import re
from pathlib import Path
from typing import Final
from xml.etree.ElementTree import Element, ParseError, fromstring
from xml.parsers import expat

from openrooms_usd import untrusted
from openrooms_usd.errors import InputError
from openrooms_usd.untrusted import Kind

_MAX_DEPTH: Final = 32
# A tree takes a hundred times the memory of its text.
_MOST_ELEMENTS: Final = 1_000_000
_DECLARES: Final = re.compile(r"<!\s*(DOCTYPE|ENTITY)", re.IGNORECASE)


def read_xml(
    path: Path, what: str, kind: Kind = "model", most_elements: int = _MOST_ELEMENTS
) -> Element:
    """The root element of an XML file.

    Args:
        path: The file.
        what: What it is, for messages.
        kind: How large it may be.
        most_elements: How many elements it may have.

    Raises:
        InputError: It cannot be read, is not XML, has a DOCTYPE or entities, is nested too deep, or
            has too many elements.
    """
    text = untrusted.read_text(path, kind)
    if _DECLARES.search(text):
        raise _refused(path, what, "declares a DOCTYPE or entities, which it does not need")
    try:
        _check_extent(text, most_elements)
        return fromstring(text)
    except (ParseError, expat.ExpatError, ValueError) as error:
        raise _refused(path, what, f"is not readable XML: {error}") from error


def _refused(path: Path, what: str, reason: str) -> InputError:
    return InputError(f"the {what} file {reason}", place=path, remedy="export it again")


def _check_extent(text: str, most_elements: int) -> None:
    """See how deep and how large a tree would be, before it is built."""
    depth = count = 0

    def start(name: str, attributes: dict[str, str]) -> None:
        nonlocal depth, count
        depth, count = depth + 1, count + 1
        if depth > _MAX_DEPTH:
            raise ValueError(f"elements are nested deeper than {_MAX_DEPTH}")
        if count > most_elements:
            raise ValueError(f"it has more than {most_elements:,} elements")

    def end(name: str) -> None:
        nonlocal depth
        depth -= 1

    parser = expat.ParserCreate("utf-8")
    parser.StartElementHandler, parser.EndElementHandler = start, end
    parser.Parse(text.encode(), True)
