"""XML of others: read without entities, and never deeper than a parser's stack."""

import re
from pathlib import Path
from typing import Final
from xml.etree.ElementTree import Element, ParseError, fromstring
from xml.parsers import expat

from openrooms_usd import untrusted
from openrooms_usd.errors import InputError

_MAX_DEPTH: Final = 32
_DECLARES: Final = re.compile(r"<!\s*(DOCTYPE|ENTITY)", re.IGNORECASE)


def read_xml(path: Path, what: str) -> Element:
    """The root element of an XML file.

    Args:
        path: The file.
        what: What it is, for messages.

    Raises:
        InputError: It cannot be read, is no XML, has a DOCTYPE or entities, or is nested too deep.
    """
    text = untrusted.read_text(path, "model")
    if _DECLARES.search(text):
        raise _refused(path, what, "declares a DOCTYPE or entities, which it does not need")
    try:
        _check_depth(text)
        return fromstring(text)
    except (ParseError, expat.ExpatError, ValueError) as error:
        raise _refused(path, what, f"is no readable XML: {error}") from error


def _refused(path: Path, what: str, reason: str) -> InputError:
    return InputError(f"the {what} file {reason}", place=path, remedy="export it again")


def _check_depth(text: str) -> None:
    depth = 0

    def start(name: str, attributes: dict[str, str]) -> None:
        nonlocal depth
        depth += 1
        if depth > _MAX_DEPTH:
            raise ValueError(f"elements are nested deeper than {_MAX_DEPTH}")

    def end(name: str) -> None:
        nonlocal depth
        depth -= 1

    parser = expat.ParserCreate("utf-8")
    parser.StartElementHandler, parser.EndElementHandler = start, end
    parser.Parse(text.encode(), True)
