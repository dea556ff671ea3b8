"""The names of what the parametric library can make: those of the files in its folder."""

import ast
from pathlib import Path
from pkgutil import iter_modules
from typing import TYPE_CHECKING, Final, Literal, TypeAlias

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
        tree = ast.parse((_FOLDER / f"{name}.py").read_text(encoding="utf-8"))
        said = (node for node in ast.walk(tree) if isinstance(node, ast.keyword))
        values = [row.value for row in said if row.arg == "words"]
        texts = [value.value for value in values if isinstance(value, ast.Constant)]
        found |= {word: name for text in texts for word in str(text).split()}
    return found
