"""What is compiled for one camera serves all, and arrays lie where kernels do not depend on it."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from openrooms_usd.rendering import RenderRequest
from orusd_mitsuba.plugins.memory import aligned
from tests import small
from tests.mitsuba.passes import LIT, PASSES
from tests.mitsuba.rendering import session_of
from tests.small import square


def room() -> Any:
    """A box with a lamp and a window in the open, seen from within and, past it, from without."""
    made = small.room()
    made.quad("/Panel", square((-0.15, 0.05, 0.9), 0.25, "-Z"), material="/Grey", nits=100.0)
    made.dome(portals=(small.window((-0.5, -0.2, 0.7, 0.6)),))
    made.camera((-0.9, -0.9, 0.0), (0.3, 0.4, -0.5), path="/Within", fov=70)
    made.camera((4.0, 0.5, 2.0), (0.5, 0, 0.5), path="/Without", fov=50)
    return session_of(made.stage)


def kernels(opened: Any, request: RenderRequest) -> set[str]:
    """The hashes of all kernels of Dr.Jit that ran for a request."""
    import drjit as dr

    dr.kernel_history_clear()
    with dr.scoped_set_flag(dr.JitFlag.KernelHistory, True):
        opened.render(request)
        history = dr.kernel_history()
    return {entry["hash"] for entry in history if entry["type"] == dr.KernelType.JIT}


@pytest.mark.parametrize("channels", PASSES.values(), ids=PASSES)
def test_a_second_camera_compiles_nothing(mi: Any, channels: Any) -> None:
    opened = room()
    request = RenderRequest("/Within", channels, 16, 12, samples=16, grid=(4, 3))
    first = kernels(opened, request)
    assert len(first) >= 2
    other = replace(request, camera="/Without", seed=7, samples=24)
    assert not kernels(opened, other) - first


@pytest.mark.slow
def test_nor_does_it_where_all_channels_come_from_the_light_cache(mi: Any) -> None:
    opened = room()
    request = RenderRequest("/Within", LIT, 16, 12, samples=4, grid=(4, 3), method="cache")
    first = kernels(opened, request)
    assert not kernels(opened, replace(request, camera="/Without", seed=7)) - first


@pytest.mark.parametrize("kind", [np.float32, np.uint32])
def test_arrays_begin_at_the_same_place_in_a_packet(kind: Any) -> None:
    for count in (1, 7, 4096):
        values = np.arange(3 * count + 1, dtype=kind)[1:].reshape(count, 3)
        found = aligned(values)
        assert found.ctypes.data % 64 == 0
        np.testing.assert_array_equal(found, values.ravel())
        assert found.dtype == kind
