"""Every thing of the library rests where it stands, alone on a floor, in both engines."""

from typing import Final

import numpy as np
import pytest

from openrooms_usd.furniture import CATEGORIES
from openrooms_usd.library.construction import mass_of_part, movable, tolerance_of
from openrooms_usd.physics.components import Part
from openrooms_usd.physics.decomposition import collision_shapes
from openrooms_usd.physics.mass import combined
from openrooms_usd.physics.world import Body, Contact, Link, Shape, World
from openrooms_usd.simulation.robots import triangles
from openrooms_usd.simulation.settling import displacements
from tests.engines import ENGINES
from tests.furniture.pieces import STYLES, piece

from .conftest import at, floor, running

SECONDS, MOST_MM, MOST_DEG = 0.5, 2.0, 0.2
STANDING = sorted(
    name
    for name, spec in CATEGORIES.items()
    if spec.support in ("floor", "surface") and movable(name, spec.support)
)
QUICK = ("backpack", "jar", "photo_frame", "table_lamp")
# What moves farther, and why.
EXCUSED: Final[dict[tuple[str, str], str]] = {
    ("bag", "hung"): "it hangs on a hook",
    ("dish_cloth", "draped"): "it hangs over a rail",
    ("throw", "draped"): "it hangs over a back",
    ("towel", "hung"): "it hangs on a hook",
    ("towel", "draped"): "it hangs over a rail",
    ("television", "mounted"): "it hangs on a wall",
    ("umbrella", "rolled"): "it leans in a stand",
    ("pillow", "square"): "it leans against a back",
    ("guitar", "acoustic"): "it leans on a stand that its shapes fill",
    ("guitar", "electric"): "it leans on a stand that its shapes fill",
}


def thing(name: str, style: str, x: float) -> Body:
    parts = []
    for part, mesh in piece(name, style).parts.items():
        found = triangles(mesh)
        parts.append(Part(part, found.points, found.triangles))
    mass = combined(mass_of_part(name, p.name, None, p.points, p.triangles) for p in parts)
    shapes = collision_shapes(parts, tolerance=tolerance_of(name, 0.01)).shapes
    contact = Contact(0.5, 0.4)
    meshes = tuple(Shape(f"shape_{i}", s.mesh, contact) for i, s in enumerate(shapes))
    link = Link(style, f"/{style}", np.eye(4), mass, meshes)
    return Body(style, f"/{style}", at(x, 0.0, 0.0), (link,), category=name)


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=[] if n in QUICK else pytest.mark.long) for n in STANDING]
)
@pytest.mark.parametrize("engine", ENGINES)
def test_a_thing_rests(engine: str, name: str) -> None:
    styles = [style for category, style in STYLES if category == name]
    things = [thing(name, style, 4.0 * row) for row, style in enumerate(styles)]
    ground = floor(size=(8.0 * len(styles) + 8.0, 8.0, 0.2))
    with running(engine, world := World((ground, *things))) as simulation:
        simulation.step(SECONDS)
        moved = list(displacements(world, simulation))
    loose = {row.body for row in moved if row.millimetres > MOST_MM or row.degrees > MOST_DEG}
    assert loose <= {style for category, style in EXCUSED if category == name}
