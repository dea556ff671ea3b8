"""Pixels of an earlier frame: exact on a plane, and none where something stood before it."""

import numpy as np
import pytest

from openrooms_usd.geometry.pinhole import intrinsics, look_at, pixel_directions
from openrooms_usd.rendering.estimates import Halves
from openrooms_usd.rendering.paths.film import Accumulation, flicker
from openrooms_usd.rendering.paths.reprojection import VisibleSurfaces, reproject

SIZE = (40, 30)
K = intrinsics(60.0, *SIZE)


def surfaces(pose: np.ndarray, strip: bool = False) -> VisibleSurfaces:
    """A floor z = 0 everywhere, and over it, where asked for, a strip |x| < 0.2 at z = 1."""
    width, height = SIZE
    eye = pose[:3, 3]
    rays = (pixel_directions(K, width, height) @ pose[:3, :3].T).reshape(-1, 3)
    floor = eye + rays * (-eye[2] / rays[:, 2])[:, None]
    above = eye + rays * ((1.0 - eye[2]) / rays[:, 2])[:, None]
    near = strip & (np.abs(above[:, 0]) < 0.2)
    position = np.where(near[:, None], above, floor)
    normal = np.tile([0.0, 0.0, 1.0], (len(rays), 1))
    distance = np.linalg.norm(position - eye, axis=1)
    return VisibleSurfaces(
        K, pose, (height, width), position, normal, 1 + near.astype(np.int64), distance
    )


def test_a_plane_is_found_where_its_homography_says() -> None:
    before, now = (
        look_at((0.0, 0.0, 3.0), (0.1, 0.2, 0.0)),
        look_at((0.4, -0.2, 2.5), (0.0, 0.3, 0.0)),
    )
    taps = reproject(surfaces(now), surfaces(before))
    # x' ~ K (R + t n^T / d) K^-1 x, of the plane n . X = d in the frame of the camera now.
    relative = np.linalg.inv(before) @ now
    n = now[:3, :3].T @ [0.0, 0.0, -1.0]
    H = K @ (relative[:3, :3] + np.outer(relative[:3, 3], n) / now[2, 3]) @ np.linalg.inv(K)
    x, y = np.meshgrid(np.arange(SIZE[0]) + 0.5, np.arange(SIZE[1]) + 0.5)
    seen = np.stack([x, y, np.ones_like(x)], axis=-1).reshape(-1, 3)
    expected = seen @ H.T
    expected = expected[:, :2] / expected[:, 2:]
    inner = ((expected > 0.5) & (expected < np.array(SIZE) - 0.5)).all(axis=1)
    assert 0.5 < inner.mean() < 1.0
    # Means by bilinear weights give linear functions back: those of the pixels' own places.
    np.testing.assert_allclose(
        taps(seen[:, :2].astype(np.float32))[inner], expected[inner], atol=1e-3
    )
    outside = ((expected < -0.5) | (expected > np.array(SIZE) + 0.5)).any(axis=1)
    assert outside.any() and not taps.found[outside].any()


def test_what_was_hidden_has_no_history() -> None:
    before, now = (
        look_at((0.0, 0.0, 3.0), (0.0, 0.01, 0.0)),
        look_at((0.5, 0.0, 3.0), (0.5, 0.01, 0.0)),
    )
    fresh, old = surfaces(now, strip=True), surfaces(before, strip=True)
    taps = reproject(fresh, old)
    floor = fresh.instance == 1
    # The line of sight from the earlier camera to the floor at x passes z = 1 at 2 x / 3.
    beneath = np.abs(fresh.position[:, 0] * 2.0 / 3.0)
    assert (floor & (beneath < 0.15)).sum() > 30
    assert not taps.found[floor & (beneath < 0.15)].any()
    inside = np.abs(fresh.position[:, 0]) < 1.4
    assert taps.found[floor & (beneath > 0.25) & inside].mean() > 0.95
    # No ghost of the bright strip appears there, and nothing of the floor on the strip.
    light = np.where(old.instance == 2, 100.0, 1.0).astype(np.float32)
    truth = np.where(fresh.instance == 2, 100.0, 1.0).astype(np.float32)
    film, base = Accumulation(), np.ones((SIZE[1], SIZE[0], 3), np.float32)
    for values, history in ((light, None), (truth, taps)):
        picture = np.repeat(values.reshape(SIZE[1], SIZE[0], 1), 3, axis=2)
        found = film.add(Halves(picture, picture, (1, 1)), base, history)
    np.testing.assert_allclose(found.a[..., 0].ravel(), truth, rtol=1e-5)


def test_a_still_camera_finds_its_own_pixels() -> None:
    here = surfaces(look_at((0.3, -0.2, 2.0), (0.0, 0.3, 0.0)), strip=True)
    taps = reproject(here, here)
    values = np.random.default_rng(0).random((SIZE[0] * SIZE[1], 3)).astype(np.float32)
    np.testing.assert_array_equal(taps(values), values)


def test_the_surroundings_turn_with_the_camera() -> None:
    def sky(pose: np.ndarray) -> VisibleSurfaces:
        rays = pixel_directions(K, *SIZE).reshape(-1, 3) @ pose[:3, :3].T
        nothing = np.zeros(len(rays), np.int64)
        return VisibleSurfaces(
            K, pose, SIZE[::-1], pose[:3, 3] + 1e5 * rays, 0 * rays, nothing, 1e5 + 0.0 * nothing
        )

    before, now = look_at((0, 0, 0), (1, 0.0, 0)), look_at((0.2, 0.1, 0), (1.2, 0.15, 0))
    assert 0.7 < reproject(sky(now), sky(before)).found.mean() < 1.0


@pytest.fixture
def still() -> tuple[VisibleSurfaces, np.ndarray]:
    return surfaces(look_at((0.0, 0.0, 3.0), (0.0, 0.1, 0.0))), np.full(
        (*SIZE[::-1], 3), 0.5, np.float32
    )


def noisy(rng: np.random.Generator, deviation: float) -> Halves:
    a, b = rng.normal(2.0, deviation, (2, SIZE[1], SIZE[0], 3)).astype(np.float32)
    return Halves(a, b, (1, 1))


def test_frames_add_up_to_their_mean_and_say_its_error(
    still: tuple[VisibleSurfaces, np.ndarray],
) -> None:
    here, base = still
    taps, film, rng = reproject(here, here), Accumulation(), np.random.default_rng(3)
    for number in range(16):
        found = film.add(noisy(rng, 0.4), base, taps if number else None)
    mean = 0.5 * (found.a + found.b)
    # Two halves of sixteen frames.
    assert np.std(mean) == pytest.approx(0.4 / np.sqrt(32), rel=0.05)
    assert np.mean(mean) == pytest.approx(2.0, abs=0.01)
    assert found.error == pytest.approx(np.var(mean) / 4.04, rel=0.1)
    # Later frames change little, and what flickers is far below the error of one.
    more = film.add(noisy(rng, 0.4), base, taps)
    assert flicker(0.5 * (more.a + more.b), mean, taps) < 0.1 * 0.4 / 2.0


def test_a_first_frame_of_many_samples_counts_for_many(
    still: tuple[VisibleSurfaces, np.ndarray],
) -> None:
    here, base = still
    film, one = Accumulation(), np.ones_like(base)
    film.add(Halves(one, one, (1, 1)), base, None, frames=8)
    rng = np.random.default_rng(0)
    noise = rng.normal(0.0, 0.5, base.shape).astype(np.float32)
    found = film.add(Halves(one + noise, one + noise, (1, 1)), base, reproject(here, here))
    np.testing.assert_allclose(found.a, one + noise / 9.0, atol=0.02)


def test_light_that_changes_is_not_dragged_along(still: tuple[VisibleSurfaces, np.ndarray]) -> None:
    here, base = still
    taps, film = reproject(here, here), Accumulation()
    for number, light in enumerate((10.0, 10.0, 10.0, 1.0)):
        picture = np.full_like(base, light)
        found = film.add(Halves(picture, picture, (1, 1)), base, taps if number else None)
    np.testing.assert_allclose(found.a, 1.0, rtol=1e-4)


def test_flicker_of_independent_frames_is_their_error(
    still: tuple[VisibleSurfaces, np.ndarray],
) -> None:
    here, _ = still
    rng = np.random.default_rng(1)
    grey = rng.normal(1.0, 0.05, (2, SIZE[1], SIZE[0], 1)).astype(np.float32)
    a, b = np.repeat(grey, 3, axis=-1)
    assert flicker(a, b, reproject(here, here)) == pytest.approx(0.05, rel=0.1)
    assert flicker(a, a, reproject(here, here)) < 1e-12
