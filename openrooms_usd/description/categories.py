"""The names of what the parametric library can make: those of the files in its folder."""

import re
from pathlib import Path
from pkgutil import iter_modules
from typing import TYPE_CHECKING, Final, Literal, TypeAlias

# The argument of a record, a text in one or more pieces.
_WORDS: Final = re.compile(r'\bwords=\(?((?:\s*"[^"]*")+)')
_QUOTED: Final = re.compile(r'"([^"]*)"')
_FOLDER: Final = Path(__file__).parents[1] / "furniture" / "categories"

CATEGORIES: Final = tuple(sorted(module.name for module in iter_modules([str(_FOLDER)])))
"""One for each module of ``furniture/categories``, none of which is imported for it."""

if TYPE_CHECKING:
    LibraryCategory: TypeAlias = str
else:
    LibraryCategory = Literal[CATEGORIES]
    """What the parametric library can make."""


def other_words() -> dict[str, str]:
    """The category by each other word for it, as the records of the categories have them."""
    found: dict[str, str] = {}
    for name in CATEGORIES:
        text = (_FOLDER / f"{name}.py").read_text(encoding="utf-8")
        for said in _WORDS.findall(text):
            found |= dict.fromkeys("".join(_QUOTED.findall(said)).split(), name)
    return found
