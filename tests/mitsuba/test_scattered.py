"""What surfaces scatter back along rays is a path without what its first ray meets straight."""

from typing import Any

import numpy as np
import pytest

from openrooms_usd.arrays import Floats
from tests import small
from tests.mitsuba.rooms import little_room
from tests.small import square

PATHS = 4096


def _sums(room: Any, run: Any) -> Floats:
    """(kinds and lights, 3, paths) of what is added for rays of the camera."""
    import mitsuba as mi

    from orusd_mitsuba.plugins.build import load_sensor
    from orusd_mitsuba.plugins.sensors import describe_sensor
    from orusd_mitsuba.transport.path_tracing import PathAccumulator

    described = describe_sensor(room.camera(64, 64), 64, 64, room.scene.origin)
    sensor = load_sensor(described, {"type": "independent"})
    sampler = mi.load_dict({"type": "independent"})
    sampler.seed(5, PATHS)
    ray, _ = sensor.sample_ray(0.0, 0.5, sampler.next_2d(), sampler.next_2d())
    sums = PathAccumulator(PATHS, room.index.count)
    run(sampler, ray, sums)
    found = [np.asarray(entries.numpy()) for entries in (sums.kinds, sums.lights)]
    return np.concatenate(found).reshape(-1, 3, PATHS)


def test_it_is_the_rest_of_a_path(lit: Any) -> None:
    """Same random numbers: same bits, but for what the first ray met."""
    import mitsuba as mi

    from orusd_mitsuba.transport.path_tracing import trace
    from orusd_mitsuba.transport.paths import TracedPaths
    from orusd_mitsuba.transport.scattered import ScatteredLight

    room = lit(little_room())

    def whole(sampler: Any, ray: Any, sums: Any) -> None:
        trace(room.built, room.index, sampler, ray, sums, 4)

    def rest(throughput: float, before: int) -> Any:
        def run(sampler: Any, ray: Any, sums: Any) -> None:
            si = room.built.ray_intersect(ray)
            crossed = room.index.crossed(ray.o, ray.d, si.t, mi.UInt32(room.index.elsewhere))
            light = ScatteredLight(TracedPaths(room.built, room.index, 4 + before), is_cheap=False)
            color = mi.Color3f(throughput)
            light.add(sampler, ray, si, color, mi.UInt32(before), crossed, sums, mi.Bool(True))

        return run

    paths = _sums(room, whole)
    ours, later = _sums(room, rest(1.0, 0)), _sums(room, rest(0.25, 1))
    assert paths[0].max() > 1.0 and not ours[0].any()
    np.testing.assert_array_equal(ours[1:3], paths[1:3])
    np.testing.assert_allclose(ours[3:].sum(axis=0), ours[:3].sum(axis=0), rtol=1e-5)
    assert not later[:2].any()
    inside = paths[2] > 0.0
    assert inside.mean() > 0.2
    # No roulette in so few segments.
    np.testing.assert_allclose(later[2], 0.25 * (ours[1] + ours[2]), rtol=1e-5)


@pytest.mark.parametrize("opacity", [0.5])
def test_what_goes_straight_through_is_not_theirs(lit: Any, opacity: float) -> None:
    """Half of a clear sheet's light, as if all of it were there."""
    import mitsuba as mi

    from orusd_mitsuba.transport.paths import TracedPaths
    from orusd_mitsuba.transport.scattered import ScatteredLight

    means = []
    for clear in (1.0, opacity):
        made = small.Stage()
        # A sheet before the sky: without the sheet's own light all would be sky.
        black = made.material("/Sheet", base_color=(0.8,) * 3, opacity=clear, ior=1.0)
        made.quad("/Quad", square((0, 2, 0), 9, "-Y"), material=black)
        made.dome(radiance=1.0)
        made.camera((0, 0, 0), (0, 1, 0), fov=40)
        room = lit(made.stage)

        def run(sampler: Any, ray: Any, sums: Any, room: Any = room) -> None:
            si = room.built.ray_intersect(ray)
            light = ScatteredLight(TracedPaths(room.built, room.index, 8), is_cheap=False)
            elsewhere = mi.UInt32(room.index.elsewhere)
            light.add(
                sampler, ray, si, mi.Color3f(1.0), mi.UInt32(0), elsewhere, sums, mi.Bool(True)
            )

        means.append(_sums(room, run)[:3].sum(axis=0).mean())
    assert means[0] == pytest.approx(0.8, rel=0.02)
    assert means[1] == pytest.approx(opacity * means[0], rel=0.06)
