"""What is compiled for one camera serves all, and arrays lie where kernels do not depend on it."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from openrooms_usd.render import RenderRequest
from openrooms_usd.usd.lights import define_mesh_light
from openrooms_usd.usd.portals import connect_portals, define_portal
from orusd_mitsuba import MitsubaRenderer
from orusd_mitsuba.plugins.memory import aligned
from tests.mitsuba.passes import LIT, PASSES
from tests.mitsuba.test_portals import window_portal
from tests.opening import open_with


def room(build: Any) -> Any:
    """A box with a lamp and a window in the open, seen from within and, past it, from without."""
    made = build()
    made.box("/Room", 2.0, inside=True, material=made.material("/Grey", base_color=(0.5,) * 3))
    corners = [(-0.4, -0.2, 0.9), (-0.4, 0.3, 0.9), (0.1, 0.3, 0.9), (0.1, -0.2, 0.9)]
    define_mesh_light(made.quad("/Panel", corners, material="/Grey").GetPrim(), nits=100.0)
    portal = define_portal(made.stage, window_portal())
    connect_portals(made.dome().GetPrim(), [portal.GetPrim()])
    made.camera((-0.9, -0.9, 0.0), (0.3, 0.4, -0.5), path="/Within", fov=70)
    made.camera((4.0, 0.5, 2.0), (0.5, 0, 0.5), path="/Without", fov=50)
    return open_with(MitsubaRenderer(), made.stage)


def kernels_of(work: Callable[[], object]) -> set[str]:
    """The hashes of all kernels of Dr.Jit that ran meanwhile."""
    import drjit as dr

    dr.kernel_history_clear()
    with dr.scoped_set_flag(dr.JitFlag.KernelHistory, True):
        work()
        history = dr.kernel_history()
    return {entry["hash"] for entry in history if entry["type"] == dr.KernelType.JIT}


def kernels(opened: Any, request: RenderRequest) -> set[str]:
    """Those that ran for a request."""
    return kernels_of(lambda: opened.render(request))


@pytest.mark.parametrize("channels", PASSES.values(), ids=PASSES)
def test_a_second_camera_compiles_nothing(build: Any, mi: Any, channels: Any) -> None:
    opened = room(build)
    request = RenderRequest("/Within", channels, 16, 12, samples=16, grid=(4, 3))
    first = kernels(opened, request)
    assert len(first) >= 2
    other = replace(request, camera="/Without", seed=7, samples=24)
    assert not kernels(opened, other) - first


@pytest.mark.slow
def test_nor_does_it_where_all_channels_come_from_the_light_cache(build: Any, mi: Any) -> None:
    opened = room(build)
    request = RenderRequest("/Within", LIT, 16, 12, samples=4, grid=(4, 3), method="cache")
    first = kernels(opened, request)
    assert not kernels(opened, replace(request, camera="/Without", seed=7)) - first


def test_bias_is_measured_by_the_code_of_both_methods(build: Any, mi: Any) -> None:
    opened = room(build)
    biased = RenderRequest(
        "/Within", ("radiance",), 16, 12, samples=4, method="cache", measure_bias=False
    )
    both = kernels(opened, biased) | kernels(opened, replace(biased, method="reference"))
    assert not kernels(opened, replace(biased, measure_bias=True)) - both


def test_all_steps_of_a_walk_are_one_kernel(build: Any, mi: Any) -> None:
    from orusd_mitsuba.cache import population

    session = room(build).session
    steps = 2 * (population._FORGOTTEN_STEPS + population._STEPS)
    found = kernels_of(lambda: population.reached(session._scene, session._built, 1))
    assert 1 < len(found) < steps


@pytest.mark.parametrize("kind", [np.float32, np.uint32])
def test_arrays_begin_at_the_same_place_in_a_packet(kind: Any) -> None:
    for count in (1, 7, 4096):
        values = np.arange(3 * count + 1, dtype=kind)[1:].reshape(count, 3)
        found = aligned(values)
        assert found.ctypes.data % 64 == 0
        np.testing.assert_array_equal(found, values.ravel())
        assert found.dtype == kind
