"""Light where it is hard to find: the rooms of the benchmark, and what must hold in each."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from openrooms_usd.arrays import Array
from openrooms_usd.rendering import RenderRequest

SIZE = (32, 24)
EYE = "/World/Camera"
Passes = Array


@pytest.fixture
def case(tmp_path: Path, lit: Any) -> Any:
    """Gives by name an opened room and the integrator of its camera."""
    from benchmarks.light.hard import CASES
    from orusd_mitsuba.transport.path_integrator import PathIntegrator

    def open_case(name: str) -> tuple[Any, Any]:
        chosen = CASES[name]
        room = lit(chosen.build(tmp_path))
        camera = room.camera(*SIZE, path=EYE)
        integrator = PathIntegrator(
            room.built, room.index, camera, *SIZE, room.scene.origin, chosen.bounces + 1
        )
        return room, integrator

    return open_case


def passes(integrator: Any, count: int = 8, samples: int = 8, seed: int = 0) -> Passes:
    """(count, planes, height, width, 3)."""
    return np.stack([integrator(samples, seed + n) for n in range(count)]).astype(np.float64)


def assert_alike(a: Passes, b: Passes) -> None:
    """The means of quarters of the picture, in standard errors."""
    parts = [
        x.reshape(len(x), 2, 12, 2, 16, 3).mean(axis=(2, 4, 5)).reshape(len(x), 4) for x in (a, b)
    ]
    error = np.sqrt(sum(part.var(axis=0, ddof=1) / len(part) for part in parts))
    difference = parts[0].mean(axis=0) - parts[1].mean(axis=0)
    assert (np.abs(difference) <= 5.0 * error + 1e-9).all()


@pytest.mark.one_in(27)
@pytest.mark.parametrize(
    ("name", "bounces"),
    [
        ("mirror", 7),
        ("door ajar", 7),
        ("two openings", 7),
        ("slit", 7),
        ("50 lamps", 7),
        ("three windows", 7),
        ("lamp at the wall", 7),
        ("white", 50),
        ("coincident", 7),
    ],
)
def test_it_is_what_mitsubas_own_integrator_gives(case: Any, name: str, bounces: int) -> None:
    from orusd_mitsuba.transport.builtin_integrator import BuiltinIntegrator

    room, integrator = case(name)
    request = RenderRequest(EYE, ("radiance",), *SIZE, samples=1, bounces=bounces)
    theirs = BuiltinIntegrator(room.built, room.camera(*SIZE, path=EYE), request, room.scene.origin)
    found = passes(integrator)
    assert_alike(found[:, :3].sum(axis=1), passes(theirs, seed=500)[:, 0])
    np.testing.assert_allclose(found[:, :3].sum(axis=1), found[:, 3:].sum(axis=1), rtol=1e-4)
    assert not integrator.broken.any()


@pytest.fixture
def plain(case: Any) -> Passes:
    return passes(case("plain")[1], seed=300)


@pytest.mark.one_in(2)
@pytest.mark.parametrize("name", ["5 cm", "200 m", "far away", "zero area", "inverted"])
def test_neither_size_nor_place_nor_winding_changes_what_is_seen(
    case: Any, plain: Passes, name: str
) -> None:
    _, integrator = case(name)
    found = passes(integrator)
    assert_alike(found[:, :3].sum(axis=1), plain[:, :3].sum(axis=1))
    assert not integrator.broken.any()


def test_a_point_is_as_bright_as_the_lamp_of_its_flux(case: Any, plain: Passes) -> None:
    """Lambert's point source: I cos cos / d^2, at the floor and the walls that it sees."""
    from openrooms_usd.rendering.scene.first_hits import first_hits
    from openrooms_usd.rendering.scene.ground_truth import GroundTruth
    from orusd_mitsuba.tracer import MitsubaTracer

    room, integrator = case("point lamp")
    camera = room.camera(*SIZE, path=EYE)
    hits = first_hits(room.scene, MitsubaTracer(room.scene, room.built), camera, *SIZE)
    truth = GroundTruth(room.scene, camera, hits)
    place, normal, color = (
        truth.channel(name).astype(np.float64) for name in ("position", "normal", "base_color")
    )
    way = np.array([-0.2, 0.1, 0.9]) - place
    squared = (way**2).sum(axis=-1)
    cosine = np.maximum((way * normal).sum(axis=-1), 0.0) / np.sqrt(squared)
    intensity = 6e6 * 1e-6 * np.maximum(way[..., 2], 0.0) / np.sqrt(squared)
    expected = color / np.pi * (intensity * cosine / squared)[..., None]
    found = passes(integrator)[:, 1].mean(axis=0)
    seen = (expected.min(axis=-1) > 0.02) & (found.min(axis=-1) > 0.0)
    assert seen.mean() > 0.4
    assert np.median(found[seen] / expected[seen]) == pytest.approx(1.0, abs=0.01)


def test_black_walls_send_nothing_on(case: Any) -> None:
    planes = passes(case("black")[1], count=2).mean(axis=0)
    # The box alone is not black: what it sends to itself or by the walls is nothing.
    assert planes[1].max() > 0.0 and planes[2].max() == 0.0


def test_inside_a_closed_box_it_is_dark(case: Any) -> None:
    assert passes(case("inside a sofa")[1], count=2).max() == 0.0


@pytest.mark.slow
def test_a_sun_leaves_the_lamp_its_own_picture(case: Any) -> None:
    """1e9 nits beside 1: what is filed under the lamp is what it gives alone, in every digit."""
    planes = passes(case("sun and lamp")[1])
    lamp, window = planes[:, 3].mean(axis=0), planes[:, 4].mean(axis=0)
    assert window.mean() > 1e4 * lamp.mean() > 0.0
    spread = planes[:, 3].mean(axis=(1, 2, 3)).std(ddof=1) / planes[:, 3].mean()
    assert spread < 0.2


def test_the_wall_around_a_window_gets_nothing_from_it_at_once(case: Any) -> None:
    room, integrator = case("window's plane")
    planes = passes(integrator, count=2).mean(axis=0)
    sky_seen = planes[0].mean(axis=-1) > 0.0
    assert 0.05 < sky_seen.mean() < 0.95
    # Whole pixels of the wall: none of their neighbours sees the sky or another wall.
    assert planes[1][~sky_seen].max() > 0.0, "what it shines on is lit"
    portal = room.scene.portals[0].world_from_portal
    from openrooms_usd.rendering.scene.first_hits import first_hits
    from orusd_mitsuba.tracer import MitsubaTracer

    camera = room.camera(*SIZE, path=EYE)
    hits = first_hits(room.scene, MitsubaTracer(room.scene, room.built), camera, *SIZE)
    near = np.zeros(SIZE[0] * SIZE[1], dtype=bool)
    near[hits.pixels] = np.abs((hits.position - portal[:3, 3]) @ portal[:3, 2]) < 1e-4
    wall = near.reshape(SIZE[1], SIZE[0])
    inner = wall.copy()
    for axis, step in ((0, 1), (0, -1), (1, 1), (1, -1)):
        inner &= np.roll(wall, step, axis)
    inner[[0, -1]], inner[:, [0, -1]] = False, False
    assert inner.sum() > 20
    assert planes[1][inner].max() == 0.0
