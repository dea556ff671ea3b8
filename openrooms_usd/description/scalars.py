"""What a scalar of YAML means: the core schema of YAML 1.2, and of its tags only the core's."""

import re
from collections.abc import Callable
from typing import Any, Final

MAX_DIGITS: Final = 100

# YAML 1.2.2, section 10.3.2: on, off, yes, no, 1_000 and 1:30 are text.
PLAIN: Final = re.compile(
    r"(?:(?P<null>~|null|Null|NULL|)"
    r"|(?P<true>true|True|TRUE)"
    r"|(?P<false>false|False|FALSE)"
    r"|(?P<decimal>[-+]?[0-9]+)"
    r"|(?P<octal>0o[0-7]+)"
    r"|(?P<hexadecimal>0x[0-9a-fA-F]+)"
    r"|(?P<float>[-+]?(?:\.[0-9]+|[0-9]+(?:\.[0-9]*)?)(?:[eE][-+]?[0-9]+)?)"
    r"|(?P<infinite>[-+]?\.(?:inf|Inf|INF))"
    r"|(?P<nan>\.(?:nan|NaN|NAN)))\Z"
)
_MEANING: Final[dict[str, Callable[[str], Any]]] = {
    "null": lambda text: None,
    "true": lambda text: True,
    "false": lambda text: False,
    "decimal": int,
    "octal": lambda text: int(text, 8),
    "hexadecimal": lambda text: int(text, 16),
    "float": float,
    "infinite": lambda text: float(text.replace(".", "")),
    "nan": lambda text: float("nan"),
}
FIRST: Final = "~nNtTfF0123456789.-+"

_CORE: Final = "tag:yaml.org,2002:"
_TYPES: Final[dict[str, tuple[type, ...]]] = {
    "null": (type(None),),
    "bool": (bool,),
    "int": (int,),
    "float": (int, float),
}


def plain(text: str) -> Any:
    """The meaning of a scalar without quotes; anything else is text.

    So is a number that is longer than any honest one: the field that it is for refuses it then.
    """
    if text and (text[0] not in FIRST or len(text) > MAX_DIGITS):
        return text
    match = PLAIN.match(text)
    return _MEANING[match.lastgroup](text) if match and match.lastgroup else text


def tagged(tag: str, text: str) -> Any:
    """The meaning of a scalar with a tag.

    Raises:
        ValueError: The tag is not in the core schema, or the text is not of its type.
    """
    kind = tag.removeprefix(_CORE)
    if tag == "!" or kind == "str":
        return text
    value = plain(text)
    if not tag.startswith(_CORE) or kind not in _TYPES:
        raise ValueError(f"tags are not allowed, found {short_tag(tag)}")
    if type(value) not in _TYPES[kind]:
        raise ValueError(f"expected a value of the tag !!{kind}, found {text!r}")
    return value


def short_tag(tag: str) -> str:
    """A tag as people write it: ``!!str``, ``!name``."""
    return f"!!{tag.removeprefix(_CORE)}" if tag.startswith(_CORE) else tag


def tag_fits(tag: str, collection: str) -> bool:
    """Whether a tag on a mapping (``map``) or a list (``seq``) says only what it is."""
    return tag in ("!", f"{_CORE}{collection}")
