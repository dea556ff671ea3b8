"""The whole set of channels of one pass, against passes that share no estimator with it."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from orusd_mitsuba import MitsubaRenderer
from tests.mitsuba.lamps import closed_room, lamp
from tests.mitsuba.test_light_identities import (
    SENT,
    SIZE,
    STRAIGHT,
    Passes,
    assert_alike,
    distances,
    furnished,
    of_lights,
    render,
)
from tests.opening import open_with

SEEDS = range(12)
WHOLE = (
    *SENT, "diffuse", "specular", "irradiance", "irradiance_direct", "irradiance_indirect",
    "irradiance_i", *STRAIGHT,
)  # fmt: skip
OPENROOMS = {"bsdf": "openrooms"}


def cloth(build: Any, **looks: Any) -> Any:
    """A closed room with a lamp behind a sheet, in the light of another."""
    made = closed_room(build)
    lamp(made, [(-0.3, 0.8, -0.3), (0.3, 0.8, -0.3), (0.3, 0.8, 0.3), (-0.3, 0.8, 0.3)])
    lamp(made, [(-0.2, -0.9, 0.6), (-0.2, -0.5, 0.6), (0.2, -0.5, 0.6), (0.2, -0.9, 0.6)],
         "/Other")  # fmt: skip
    sheet = made.material("/Cloth", **({"base_color": (0.5, 0.4, 0.3), "ior": 1.5} | looks))
    made.quad("/Sheet", [(-0.9, 0.5, -0.9), (0.9, 0.5, -0.9), (0.9, 0.5, 0.9), (-0.9, 0.5, 0.9)],
              material=sheet)  # fmt: skip
    return made.stage


@pytest.fixture(scope="module")
def session(build: Any, lit: Any) -> Any:
    del lit
    return open_with(MitsubaRenderer(), furnished(build, ior=1.5), OPENROOMS)


@pytest.fixture(scope="module")
def found(session: Any) -> Passes:
    return render(session, WHOLE, SEEDS)


@pytest.mark.slow
def test_the_picture_is_that_of_paths(session: Any, found: Passes) -> None:
    """By kind and by light."""
    paths = render(session, SENT, range(100, 100 + len(SEEDS)))
    for name in paths:
        assert_alike(found[name], paths[name], name)


@pytest.mark.slow
@pytest.mark.parametrize("looks", [{"transmission": 0.4}, {"opacity": 0.5}], ids=["cloth", "clear"])
@pytest.mark.parametrize("options", [OPENROOMS, {"bsdf": "preview"}], ids=["openrooms", "preview"])
def test_what_passes_a_sheet_is_that_of_paths(
    build: Any, lit: Any, looks: dict[str, float], options: dict[str, str]
) -> None:
    del lit
    made = open_with(MitsubaRenderer(), cloth(build, **looks), options)
    ours = render(made, ("irradiance", *SENT), SEEDS)
    paths = render(made, SENT, range(100, 100 + len(SEEDS)))
    for name in paths:
        if "opacity" in looks:
            # Paths find a lamp behind a clear sheet by luck: pixels say nothing.
            assert np.abs(distances(*(f[name].mean(axis=(1, 2)) for f in (ours, paths)))).max() < 5
        else:
            assert_alike(ours[name], paths[name], name)


@pytest.mark.slow
def test_what_is_received_is_what_a_white_surface_sends(
    build: Any, lit: Any, found: Passes
) -> None:
    from orusd_mitsuba.transport.path_integrator import PathIntegrator

    room = lit(furnished(build))
    white = PathIntegrator(room.built, room.index, room.camera(*SIZE), *SIZE, room.scene.origin, 8,
                           first=room.first)  # fmt: skip
    # Under other materials the light that comes back would differ: straight light alone.
    planes = np.pi * np.stack([white(16, seed) for seed in range(50, 62)]).astype(np.float64)
    assert_alike(found["irradiance_direct"], planes[:, 1])


@pytest.mark.slow
def test_straight_light_is_that_of_its_own_pass(session: Any, found: Passes) -> None:
    alone = render(session, STRAIGHT, range(100, 100 + len(SEEDS)))
    for name in alone:
        if name.startswith("visibility"):
            # A ratio, biased by what falls with the samples.
            assert np.abs(found[name].mean(axis=0) - alone[name].mean(axis=0)).mean() < 0.02
        else:
            assert_alike(found[name], alone[name], name)


@pytest.mark.slow
def test_sums_are_exact_and_nothing_is_negative(found: Passes) -> None:
    for whole, parts in (
        ("radiance", of_lights(found, "radiance_i")),
        ("radiance", [found[kind] for kind in ("emission", "direct", "indirect")]),
        ("radiance", [found[kind] for kind in ("emission", "diffuse", "specular")]),
        ("irradiance", of_lights(found, "irradiance_i")),
        ("irradiance", [found["irradiance_direct"], found["irradiance_indirect"]]),
        ("irradiance_direct", of_lights(found, "direct_i")),
    ):
        assert all(part.min() >= 0.0 for part in parts), whole
        np.testing.assert_allclose(np.sum(parts, axis=0), found[whole], rtol=2e-5, atol=1e-6)
    assert found["specular"].mean() > 0.01 * found["diffuse"].mean()


@pytest.fixture
def grey(build: Any, lit: Any) -> Callable[..., Passes]:
    """A closed room of one colour, by the metallic part of its walls."""
    del lit

    def rendered(metallic: float) -> Passes:
        made = closed_room(build, base_color=(0.5, 0.4, 0.3), metallic=metallic, roughness=0.4,
                           ior=1.5)  # fmt: skip
        lamp(made, [(-0.3, -0.3, 0.9), (-0.3, 0.3, 0.9), (0.3, 0.3, 0.9), (0.3, -0.3, 0.9)])
        opened = open_with(MitsubaRenderer(), made.stage, OPENROOMS)
        return render(opened, ("diffuse", "specular", "irradiance"), range(1), samples=4)

    return rendered


@pytest.mark.parametrize("metallic", [0.0, 0.75, 1.0])
def test_of_one_colour_diffuse_is_albedo_over_pi_times_irradiance(
    grey: Callable[..., Passes], metallic: float
) -> None:
    found = grey(metallic)
    albedo = np.array([0.5, 0.4, 0.3]) * (1.0 - metallic)
    expected = albedo / np.pi * found["irradiance"]
    assert found["irradiance"].mean() > 1.0
    np.testing.assert_allclose(found["diffuse"], expected, rtol=1e-5, atol=1e-6)
    assert found["specular"].min() >= 0.0 and found["specular"].mean() > 0.0


@pytest.mark.slow
def test_sums_take_no_more_room_for_more_samples(build: Any, lit: Any) -> None:
    """Equal seeds give equal bits, and a pixel has few strands for any number of samples."""
    from orusd_mitsuba.complete import integrator as complete
    from orusd_mitsuba.complete.meeting import CompleteScene

    room = lit(furnished(build))
    scene = CompleteScene(room.scene, room.built, room.builder, room.sources, room.index)
    from orusd_mitsuba.transport.scattered import TracedLight

    traced = TracedLight(room.built, room.index, 8)
    made = complete.CompleteIntegrator(scene, traced, room.camera(*SIZE), *SIZE, 8)
    sizes: list[int] = []
    real = complete.WholeAccumulator

    class Counted(real):  # type: ignore[valid-type,misc]
        def __init__(self, strands: int, lights: int | None, *, guided: bool) -> None:
            super().__init__(strands, lights, guided=guided)
            sizes.append(strands)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(complete, "WholeAccumulator", Counted)
        patch.setattr(complete, "_THREADS", 4 * SIZE[0] * SIZE[1])
        first = made(64, 3)
        np.testing.assert_array_equal(first, made(64, 3))
        made(256, 3)
    assert sizes == [4 * SIZE[0] * SIZE[1]] * 3
    assert not np.array_equal(first, made(64, 4))
