"""A relit picture is the one that a fresh render of the turned lamps gives."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import UsdLux

from openrooms_usd.arrays import Floats
from openrooms_usd.rendering.relight import Relighting, light_factors, relit
from openrooms_usd.usd.light.lights import Portal, define_mesh_light, define_portal
from tests import small
from tests.mitsuba.rendering import session_of, shown
from tests.small import square

NITS = {"near": 800.0, "far": 3000.0}
HALVES = 6


def room_with_lamps(factors: dict[str, float], kelvin: float = 4000.0) -> Any:
    room = small.Stage()
    grey = room.material("/Grey", base_color=(0.7, 0.5, 0.4))
    room.box("/Room", 2.0, inside=True, material=grey)
    for name, x in (("near", -0.6), ("far", 0.5)):
        lamp = [(x, -0.2, 0.9), (x, 0.2, 0.9), (x + 0.2, 0.2, 0.9), (x + 0.2, -0.2, 0.9)]
        prim = room.quad(f"/{name}", lamp, material=grey).GetPrim()
        temperature = kelvin if name == "far" else 3000.0
        define_mesh_light(prim, nits=NITS[name] * factors.get(name, 1.0), kelvin=temperature)
    room.camera((-0.8, -0.8, 0.0), (0.6, 0.6, -0.5), fov=70.0)
    return room.stage


def render(session: Any, channel: str, seed: int) -> dict[str, Floats]:
    return {
        name: image.pixels
        for name, image in shown(
            session, channel, width=16, height=12, samples=64, seed=seed
        ).images.items()
    }


def z_scores(old: Any, how: Callable[[str], Relighting], path: str, fresh: Any) -> Any:
    """Differences between relit and fresh blocks of 4 x 4 pixels over their spread.

    Args:
        old: The stage to relight.
        how: What becomes of the light of a name.
        path: Its prim: names are whatever the stage gives.
        fresh: The stage to render.
    """
    before, after = session_of(old), session_of(fresh)
    lights = before.lights
    (name,) = (light.name for light in lights if light.path == path)
    factors = light_factors(lights, how(name), Path("old"))
    ours, theirs = [], []
    for seed in range(HALVES):
        found = render(before, "radiance_i", seed)
        ours.append(relit({i: found[f"radiance_{i}"] for i in factors}, factors))
        theirs.append(render(after, "radiance", seed + 50)["radiance"])
    a, b = (np.array(x).reshape(HALVES, 3, 4, 4, 4, 3).mean(axis=(2, 4)) for x in (ours, theirs))
    spread = np.sqrt((a.var(axis=0, ddof=1) + b.var(axis=0, ddof=1)) / HALVES)
    same = (spread == 0.0) & (a.mean(axis=0) == b.mean(axis=0))
    return np.asarray((a.mean(axis=0) - b.mean(axis=0)) / np.where(same, 1.0, spread))


CASES = {
    "off": (lambda name: Relighting({name: 0.0}), {"far": 0.0}, 4000.0),
    "scaled": (lambda name: Relighting({name: 0.3}), {"far": 0.3}, 4000.0),
    "warmer": (lambda name: Relighting({}, {name: 2700.0}), {}, 2700.0),
}


@pytest.mark.usefixtures("vectorized")
@pytest.mark.one_in(3)
@pytest.mark.parametrize("case", CASES)
def test_relit_agrees_with_a_fresh_render(case: str) -> None:
    how, factors, kelvin = CASES[case]
    old, fresh = room_with_lamps({}), room_with_lamps(factors, kelvin)
    scores = z_scores(old, how, "/far", fresh)
    # Of Student's distribution with some 10 degrees of freedom; 36 values.
    assert np.abs(scores).max() < 6.0
    assert 0.2 < np.sqrt((scores**2).mean()) < 2.0


# Corners of a black box of 2 m about the origin, but for a hole of 1 m in its side at +Y.
BOX = [
    square((0, 0, -1), 1),
    square((0, 0, 1), 1),
    square((-1, 0, 0), 1, "+X"),
    square((1, 0, 0), 1, "+X"),
    square((0, -1, 0), 1, "-Y"),
    square((0, 1, -0.75), (0.25, 1), "-Y"),
    square((0, 1, 0.75), (0.25, 1), "-Y"),
    square((-0.75, 1, 0), (0.5, 0.25), "-Y"),
    square((0.75, 1, 0), (0.5, 0.25), "-Y"),
]


def corner(*, boxed: bool, sky: float = 500.0) -> Any:
    """A floor and a wall under the sky with a window before them, or in a black box with a hole."""
    room = small.Stage()
    grey = room.material("/Grey", base_color=(0.7, 0.5, 0.4))
    black = room.material("/Black", base_color=(0.0, 0.0, 0.0))
    for number, side in enumerate(BOX if boxed else ()):
        room.quad(f"/Side_{number}", side, material=black)
    floor = square((0, 0, -0.9), 0.9)
    room.quad("/Floor", floor, material=grey)
    wall = square((0, -0.9, 0), 0.9, "-Y")
    room.quad("/Wall", wall, material=grey)
    room.dome(radiance=sky)
    frame = np.eye(4)
    frame[:3, :3] = np.array([[-1, 0, 0], [0, 0, 1], [0, 1, 0]]).T
    frame[1, 3] = 1.0
    define_portal(room.stage, Portal("/window", frame, 1.0, 1.0))
    room.camera((-0.7, 0.8, 0.6), (0.4, -0.6, -0.5), fov=80.0)
    return room.stage


@pytest.mark.usefixtures("vectorized")
@pytest.mark.slow
def test_a_window_alone_is_a_hole_in_a_black_box() -> None:
    """Brighter sky in the window, none elsewhere: as an aperture of black walls lets it in."""
    old, fresh = corner(boxed=False), corner(boxed=True, sky=1000.0)
    scores = z_scores(old, lambda name: Relighting({name: 2.0, "elsewhere": 0.0}), "/window", fresh)
    assert np.abs(scores).max() < 6.0
    assert 0.2 < np.sqrt((scores**2).mean()) < 2.0


def test_black_bodies_are_the_standards() -> None:
    color = np.array(UsdLux.BlackbodyTemperatureAsRgb(2700.0))
    assert color @ [0.2126, 0.7152, 0.0722] == pytest.approx(1.0, abs=0.02)
