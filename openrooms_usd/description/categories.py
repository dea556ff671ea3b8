"""The names of what the parametric library can make: those of the files in its folder."""

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
