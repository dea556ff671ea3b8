"""Rooms that several files of tests look at."""

from typing import Any

from pxr import Gf, Usd

from tests import small
from tests.small import square

LAMPS = ("/Ball", "/Panel")
WINDOW = "/Window"
HOLE = (-0.5, -0.5, 0.5, 0.5)


def half_hidden(**looks: Any) -> Usd.Stage:
    """A grey room with a panel over a board, and a ball."""
    made = small.room(**looks)
    made.quad("/Board", square((-0.25, 0.05, -0.5), 0.35), material="/Grey")
    panel = square((-0.15, 0.05, 0.9), 0.25, "-Z")
    made.quad("/Panel", panel, material="/Grey", nits=100.0)
    made.light("Sphere", "/Ball", 100.0, at=(0.6, 0.5, -0.2), radius=0.2)
    made.camera((-0.9, -0.9, 0.0), (0.3, 0.4, -0.5), fov=70)
    return made.stage


def furnished(lit_by: tuple[str, ...] = (*LAMPS, WINDOW), **looks: Any) -> small.Stage:
    """A panel over a board, a coloured ball, a window with sky and sun, and a glossy box."""
    on = {path: float(path in lit_by) for path in (*LAMPS, WINDOW)}
    made = small.room(hole=HOLE, **({"base_color": (0.7, 0.6, 0.5)} | looks))
    shiny = {"base_color": (0.2, 0.3, 0.6), "roughness": 0.3, "ior": 1.5} | looks
    made.box("/Box", 0.5, at=(0.4, 0.2, -0.75), material=made.material("/Shiny", **shiny))
    made.quad("/Board", square((-0.45, 0.1, 0.3), (0.35, 0.3)), material="/Grey")
    panel = square((-0.3, 0.05, 0.9), (0.2, 0.15), "-Z")
    made.quad("/Panel", panel, material="/Grey", nits=50.0 * on["/Panel"])
    tint = Gf.Vec3f(1.0, 0.5, 0.2)
    made.light("Sphere", "/Ball", 60.0 * on["/Ball"], at=(0.7, -0.3, 0.1), radius=0.1, color=tint)
    # It shines along (0, -0.77, -0.64): through the window, on the floor.
    made.light("Distant", "/Sun", 30.0 * on[WINDOW], turn=(-50, 0, 0), angle=0.0)
    made.dome(radiance=20.0 * on[WINDOW], portals=(small.window(HOLE),))
    made.camera((-0.6, -0.9, 0.2), (0.3, 0.9, -0.4), fov=75)
    return made


def little_room(*, lamp: float = 50.0, **looks: Any) -> Usd.Stage:
    """A window, a lamp and a glossy box: everything at once, but for a sun."""
    made = small.room(hole=HOLE, **({"base_color": (0.7, 0.6, 0.5)} | looks))
    shiny = {"base_color": (0.2, 0.3, 0.6), "roughness": 0.2, "ior": 1.5} | looks
    made.box("/Box", 0.5, at=(0.4, 0.2, -0.75), material=made.material("/Shiny", **shiny))
    made.light("Rect", "/Lamp", lamp, at=(-0.3, 0, 0.9), width=0.4, height=0.2)
    made.dome(radiance=20.0, portals=(small.window(HOLE),))
    made.camera((-0.6, -0.9, 0.2), (0.3, 0.9, -0.4), fov=75)
    return made.stage


def closed_room(**material: Any) -> small.Stage:
    """Two metres about the origin, seen from a corner."""
    made = small.room(**material)
    made.camera((-0.8, -0.9, 0.2), (0.3, 0.9, -0.3), fov=95)
    return made
