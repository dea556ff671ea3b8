"""Names of a module that are loaded on first use (PEP 562)."""

from collections.abc import Callable, Iterable, Mapping
from importlib import import_module
from typing import Any


def homes(package: str, offered: Mapping[str, Iterable[str]]) -> dict[str, str]:
    """The module of each name.

    Args:
        package: What the modules lie in.
        offered: The names that each module offers, by its name in the package.
    """
    return {name: f"{package}.{home}" for home, names in offered.items() for name in names}


def loader(module: str, homes: Mapping[str, str]) -> Callable[[str], Any]:
    """A ``__getattr__`` for a module.

    Args:
        module: Its name, for messages.
        homes: By the name of what it offers: the module that defines it, or the package in which
            the module of that name lies.
    """

    def load(name: str) -> Any:
        """Load a public name from its module on first use."""
        if name not in homes:
            raise AttributeError(f"module {module!r} has no attribute {name!r}")
        home = homes[name]
        value = getattr(import_module(home), name, None)
        return import_module(f"{home}.{name}") if value is None else value

    return load
