"""The record of a word: of what the library builds, and of what it only knows by name.

The records of what is built stand beside their builders, each in a module of the category's name.
They are loaded here by that name, as adapters are by the names of their entry points, and only
when they are asked for: so the vocabulary costs nothing, and lower parts of the program can ask
about a category without knowing how it is built. The digest of code does not see such imports:
`codedigest.count` is told of them, so that what is made hangs on the records that it asked for.
"""

from collections.abc import Iterator
from importlib import import_module
from typing import Final, get_args

from openrooms_usd import codedigest
from openrooms_usd.categories.others import OTHERS
from openrooms_usd.categories.record import Category
from openrooms_usd.description.categories import LibraryCategory

BUILT: Final[tuple[str, ...]] = get_args(LibraryCategory)
"""The categories that the library builds."""

_HOME: Final = "openrooms_usd.library.furniture"


def module_of(name: str) -> str:
    """The full name of the module that holds the record and the builder of a built category."""
    return f"{_HOME}.{name}"


def modules() -> tuple[str, ...]:
    """The modules of all categories that the library builds."""
    return tuple(map(module_of, BUILT))


def record(word: str) -> Category | None:
    """What is known of a category; None for words that are none of ours."""
    if word not in OTHERS and word.isidentifier():
        # Also where nothing has that name: it counts once something has.
        codedigest.count(module_of(word))
    return _record(word)


def _record(word: str) -> Category | None:
    if word not in BUILT:
        return OTHERS.get(word)
    found: Category = import_module(module_of(word)).CATEGORY
    return found


def records() -> Iterator[tuple[str, Category]]:
    """All categories, those that the library builds first."""
    codedigest.count(f"{_HOME}.*")
    for name in BUILT:
        if (found := _record(name)) is not None:
            yield name, found
    yield from OTHERS.items()
