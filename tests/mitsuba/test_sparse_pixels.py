"""Pixels from anywhere in a picture are those that the whole picture has there."""

from typing import Any

import numpy as np
import pytest

from tests.mitsuba.conftest import Lit
from tests.mitsuba.rooms import half_hidden

SIZE = (20, 15)
PIXELS = np.array([0, 19, 20, 137, 138, 299, 5], np.uint32)


@pytest.fixture
def integrator(mi: Any) -> Any:
    from orusd_mitsuba.transport.path_integrator import PathIntegrator

    lit = Lit(half_hidden())
    return PathIntegrator(lit.built, lit.index, lit.camera(*SIZE), *SIZE, lit.scene.origin, 3)


def test_rays_begin_in_their_pixels(integrator: Any, mi: Any) -> None:
    from orusd_mitsuba.transport.bands import Band

    def directions(integrator: Any) -> np.ndarray:
        band = Band(integrator, slice(0, integrator.size[0]), 2, 0)
        return band.ray(mi.Point2f(0.3, 0.8), mi.Point2f(0.5)).d.numpy().T.reshape(-1, 2, 3)

    whole, some = directions(integrator), directions(integrator.sparse(PIXELS))
    assert np.allclose(some, whole[PIXELS], atol=1e-6)
    assert np.abs(whole[1:] - whole[:-1]).max() > 1e-2


@pytest.mark.slow
def test_means_are_those_of_the_whole_picture(integrator: Any) -> None:
    some = integrator.sparse(PIXELS)
    assert some.size == some.broken.shape == (1, len(PIXELS))
    # Each kind and light, at the standard error of the difference.
    rows, columns = np.divmod(PIXELS, SIZE[0])
    whole = np.stack([integrator(256, seed)[:, rows, columns] for seed in range(4)])
    found = np.stack([some(256, 50 + seed)[:, 0] for seed in range(4)])
    error = np.sqrt((whole.var(axis=0, ddof=1) + found.var(axis=0, ddof=1)) / 4)
    off = np.abs(whole.mean(axis=0) - found.mean(axis=0))
    assert np.median(off / np.maximum(error, 1e-6)) < 1.5
    assert np.allclose(whole.mean(axis=0).sum(axis=1), found.mean(axis=0).sum(axis=1), rtol=0.05)
    # What was not made sparse is as it was.
    assert integrator(1, 0).shape == (integrator.planes, SIZE[1], SIZE[0], 3)


def test_hemispheres_of_some_points(mi: Any) -> None:
    from openrooms_usd.geometry.hemisphere import untiled
    from orusd_mitsuba.tracer import MitsubaTracer
    from orusd_mitsuba.transport.hemispheres import HemisphereIntegrator

    lit = Lit(half_hidden())
    camera = lit.camera(4, 3)
    integrator = HemisphereIntegrator(
        lit.scene, lit.built, lit.index, MitsubaTracer(lit.scene, lit.built), camera, (4, 3), 3
    )
    # As if the seventh pixel saw nothing.
    integrator._pixels = integrator._pixels[integrator._pixels != 6]
    integrator._incident = integrator._incident.sparse(np.delete(np.arange(12), 6))
    points = np.array([7, 2, 6, 11], np.uint32)
    some = integrator.sparse(points)
    assert some.size == (16, 4 * 32)

    def means(integrator: Any) -> np.ndarray:
        return np.array([untiled(plane).mean(axis=(2, 3)) for plane in integrator(8, 1)])

    whole = means(integrator).reshape(2, 12, 3)[:, points]
    found = means(some)[:, 0]
    assert (found[:, 2] == 0.0).all() and (found[:, [0, 1, 3]] > 0.0).all()
    assert np.allclose(found, whole, rtol=0.1)
