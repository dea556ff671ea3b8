"""The record of a word: of what the library builds, and of what it only knows by name.

Each category that the library builds is a module of ``categories``, which is loaded on demand, so
one room loads only the builders of its own furniture. The digest of code does not see such imports:
they are reported to `codedigest.count`, so that results depend on the records that they used.
"""

from collections.abc import Iterator
from importlib import import_module
from typing import Final

from openrooms_usd import codedigest
from openrooms_usd.description.categories import CATEGORIES
from openrooms_usd.furniture import categories
from openrooms_usd.furniture.others import OTHERS
from openrooms_usd.furniture.record import BuiltCategory, Category

BUILT: Final = CATEGORIES
"""The categories that the library builds."""


def module_of(name: str) -> str:
    """The full name of the module that holds the record and the builder of a built category."""
    return f"{categories.__name__}.{name}"


def modules() -> tuple[str, ...]:
    """The modules of all categories that the library builds."""
    return tuple(map(module_of, BUILT))


def built(name: str) -> BuiltCategory:
    """The record of a category that the library builds, one of `BUILT`."""
    codedigest.count(module_of(name))
    return _load(name)


def record(word: str) -> Category | None:
    """What is known of a category; None for unknown words."""
    if word not in OTHERS and word.isidentifier():
        # Also where nothing has that name: it counts once something has.
        codedigest.count(module_of(word))
    return _load(word) if word in BUILT else OTHERS.get(word)


def records() -> Iterator[tuple[str, Category]]:
    """All categories, those that the library builds first."""
    codedigest.count(f"{categories.__name__}.*")
    for name in BUILT:
        yield name, _load(name)
    yield from OTHERS.items()


def _load(name: str) -> BuiltCategory:
    found: BuiltCategory = import_module(module_of(name)).CATEGORY
    return found
