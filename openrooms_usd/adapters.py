"""Finds importers, renderers, exporters and the like by entry point, ours and others."""

from collections.abc import Mapping
from importlib.metadata import EntryPoint, entry_points
from typing import Any, Final

from openrooms_usd.errors import InputError, MissingPackageError
from openrooms_usd.spelling import did_you_mean

IMPORTERS: Final = "openrooms_usd.importers"
RENDERERS: Final = "openrooms_usd.renderers"
EXPORTERS: Final = "openrooms_usd.exporters"
DATASETS: Final = "openrooms_usd.datasets"
ENGINES: Final = "openrooms_usd.engines"
SEGMENTERS: Final = "openrooms_usd.segmenters"
EXECUTORS: Final = "openrooms_usd.executors"
SOURCES: Final = "openrooms_usd.sources"
PHOTOGRAPHS: Final = "openrooms_usd.photographs"


def available(group: str) -> dict[str, EntryPoint]:
    """The adapters of a group by name, sorted; none of them is imported."""
    return {point.name: point for point in sorted(entry_points(group=group), key=lambda p: p.name)}


def find(group: str, name: str) -> EntryPoint:
    """The adapter ``name`` of a group, not imported yet.

    Raises:
        InputError: No adapter has that name.
    """
    found = available(group)
    if name not in found:
        kind = _kind(group)
        known = ", ".join(found) or "none: install the package first (pip install -e .)"
        raise InputError(
            f"no {kind} is named {name!r}{did_you_mean(name, found)}", remedy=f"installed: {known}"
        )
    return found[name]


def load(group: str, name: str) -> Any:
    """Import the adapter ``name`` of a group and make one.

    Args:
        group: One of `IMPORTERS`, `RENDERERS`, `EXPORTERS`, `DATASETS`, `ENGINES`, `SEGMENTERS`,
            `EXECUTORS`, `SOURCES`, `PHOTOGRAPHS`.
        name: The name under which it is registered.

    Returns:
        A new instance of the adapter's class.

    Raises:
        InputError: No adapter has that name.
        MissingPackageError: The adapter needs a package that is not installed.
    """
    point = find(group, name)
    try:
        factory = point.load()
    except ImportError as error:
        raise MissingPackageError(
            f"the {_kind(group)} {name!r} needs the package {error.name!r}, which cannot be "
            f"imported ({error})",
            remedy=f"pip install {error.name or 'the missing package'}",
        ) from error
    return factory()


def check_options(
    group: str, name: str, declared: Mapping[str, str], given: Mapping[str, str]
) -> None:
    """Refuse options that an adapter does not declare.

    Args:
        group: Its group.
        name: The name under which it is registered.
        declared: What may be asked of it, for people, by name.
        given: What is asked.

    Raises:
        InputError: It has no such option.
    """
    for option in given:
        if option not in declared:
            known = ", ".join(sorted(declared)) or "none"
            raise InputError(
                f"the {_kind(group)} {name!r} has no option {option!r}"
                f"{did_you_mean(option, declared)}",
                place="options",
                remedy=f"it has: {known}",
            )


def _kind(group: str) -> str:
    return group.rpartition(".")[2].removesuffix("s")
