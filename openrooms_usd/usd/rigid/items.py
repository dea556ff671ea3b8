"""Shapes and visuals of links: unique names, and poses in the frame of a link."""

from collections.abc import Sequence
from dataclasses import replace
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.physics.world import Shape, Visual

Item = TypeVar("Item", Shape, Visual)


def shifted(item: Item, back: NDArray[np.float64]) -> Item:
    """A shape or a visual in a frame that has the same axes."""
    if not back[:3, 3].any():
        return item
    return replace(item, mesh=replace(item.mesh, points=item.mesh.points + back[:3, 3]))


def distinct(items: Sequence[Item]) -> list[Item]:
    """The same, with a number behind names that repeat."""
    called = unique_names([item.name for item in items])
    return [
        item if item.name == name else replace(item, name=name)
        for item, name in zip(items, called, strict=True)
    ]


def unique_names(wanted: Sequence[str]) -> list[str]:
    """The names, with a number behind those that repeat."""
    taken: set[str] = set()
    return [unique(name, taken) for name in wanted]


def unique(name: str, taken: set[str]) -> str:
    """A name that is not taken yet; it is taken then."""
    found, number = name, 0
    while found in taken:
        number += 1
        found = f"{name}_{number}"
    taken.add(found)
    return found
