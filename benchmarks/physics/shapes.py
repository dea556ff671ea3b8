"""Collision shapes: seconds, shapes and corners against the error, by every method, side by side.

Distances are upper bounds: how far the shapes stick out of the object, and how far its surface lies
outside of them. The volume is that of the union of the shapes by that of the object.
"""

import time
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from openrooms_usd.furniture import make
from openrooms_usd.physics.collision_error import collision_error, volumes
from openrooms_usd.physics.components import Part, components
from openrooms_usd.physics.decomposition import METHODS, Method, collision_shapes
from openrooms_usd.physics.solid import Solid
from openrooms_usd.showroom.exhibits import Exhibit, exhibits

# Ordinary objects, and some that are hard: shells, curved ones, and many parts.
ORDINARY: Final = ("table", "chair", "stool", "cabinet", "monitor")
HARD: Final = ("bowl", "trash_bin", "bathtub")
QUICK: Final = ("table", "chair", "bowl")


@dataclass(frozen=True)
class Result:
    """One method on one object."""

    object: str
    method: str
    seconds: float
    shapes: int
    boxes: int
    corners: int
    protrusion_mm: float
    uncovered_mm: float
    volume_ratio: float


def parts_of(exhibit: Exhibit) -> list[Part]:
    """The object in its closed pose, as one link of one contact material."""
    made = make(exhibit.category, exhibit.size, exhibit.style, np.random.default_rng(0))
    found = []
    for name, mesh in made.parts.items():
        corners, _ = mesh.triangles()
        found.append(Part(name, mesh.points, mesh.indices[corners]))
    return found


def measured(exhibit: Exhibit, method: Method, tolerance: float) -> Result:
    """One row of the table."""
    parts = parts_of(exhibit)
    start = time.perf_counter()
    found = collision_shapes(parts, method, tolerance)
    seconds = time.perf_counter() - start
    meshes, thing = [shape.mesh for shape in found.shapes], Solid(components(parts))
    error, filled = collision_error(meshes, thing), volumes(meshes, thing)
    return Result(
        exhibit.name,
        method,
        seconds,
        len(meshes),
        sum(shape.box for shape in found.shapes),
        sum(len(mesh.points) for mesh in meshes),
        1000.0 * error.protrusion,
        1000.0 * error.uncovered,
        filled.shapes / filled.thing if filled.thing > 0 else float("nan"),
    )


def shape_rows(
    categories: tuple[str, ...] = ORDINARY + HARD,
    methods: tuple[Method, ...] = METHODS,
    tolerance: float = 0.01,
) -> list[dict[str, Any]]:
    """The rows of the table: every object by every method."""
    return [
        vars(measured(exhibit, method, tolerance))
        for exhibit in exhibits(categories)
        for method in methods
    ]
