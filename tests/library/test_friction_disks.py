"""The BRDF against scalar arithmetic, the disks against rays traced into a parabolic mirror."""

import math

import numpy as np
import pytest

from openrooms_usd.library.friction import disks


def unit(theta: float, phi: float) -> np.ndarray:
    """A direction by degrees from the normal and around it."""
    t, p = math.radians(theta), math.radians(phi)
    return np.array([math.sin(t) * math.cos(p), math.sin(t) * math.sin(p), math.cos(t)])


def published(A: float, R: float, light: np.ndarray, eye: np.ndarray, base: float) -> float:
    """The paper's formula as it is printed, in Python's floats."""
    h = light + eye
    h /= math.sqrt(float(h @ h))
    n_h, n_l, n_v, v_h = float(h[2]), float(light[2]), float(eye[2]), float(eye @ h)
    D = R**4 / (math.pi * (n_h**2 * (R**4 - 1) + 1) ** 2)
    F = (1 - base) * 2 ** ((-5.55473 * v_h - 6.98316) * v_h) + base
    k = (R + 1) ** 2 / 8
    G = n_v / (n_v * (1 - k) + k) * n_l / (n_l * (1 - k) + k)
    return A / math.pi + D * F * G / (4 * n_l * n_v)


@pytest.mark.parametrize("roughness", [0.1, 0.35, 0.7, 1.0])
@pytest.mark.parametrize("angles", [(0, 0, 0), (30, 40, 170), (70, 5, 20), (60, 60, 180)])
def test_it_is_the_published_formula(roughness, angles):
    light, eye = unit(angles[0], 0), unit(angles[1], angles[2])
    value = disks.evaluate([0.6, 0.3, 0.0], roughness, 0.0, light, eye)
    expected = [published(A, roughness, light, eye, 0.05) for A in (0.6, 0.3, 0.0)]
    np.testing.assert_allclose(value, expected, rtol=1e-9)
    metal = disks.evaluate([0.9, 0.6, 0.5], roughness, 1.0, light, eye)
    expected = [published(0.0, roughness, light, eye, base) for base in (0.9, 0.6, 0.5)]
    np.testing.assert_allclose(metal, expected, rtol=1e-9)


def test_reciprocity_and_what_lies_below():
    rng = np.random.default_rng(1)
    light, eye = (rng.standard_normal((500, 3)) for _ in range(2))
    light, eye = (v / np.linalg.norm(v, axis=1, keepdims=True) for v in (light, eye))
    there = disks.evaluate([0.5, 0.2, 0.1], 0.3, 0.4, light, eye)
    back = disks.evaluate([0.5, 0.2, 0.1], 0.3, 0.4, eye, light)
    np.testing.assert_allclose(there, back, rtol=1e-9)
    below = (light[:, 2] <= 0) | (eye[:, 2] <= 0)
    assert (there[below] == 0).all() and (there[~below] > 0).all()


@pytest.mark.parametrize("roughness", [1e-4, 0.01, 0.1, 0.5])
def test_the_distribution_is_normalised_however_narrow(roughness):
    # Substituted so that the peak is resolved: tan(theta) = R^2 s / sqrt(1 - s^2).
    s = (np.arange(20000) + 0.5) / 20000
    tangent = roughness**2 * s / np.sqrt(1 - s**2)
    cosine = 1 / np.sqrt(1 + tangent**2)
    half = np.stack([tangent * cosine, 0 * cosine, cosine], axis=-1)
    slope = roughness**2 / (1 - s**2) ** 1.5
    D = disks.distribution(half, np.array([roughness]))[:, 0]
    # Projected solid angle: cos sin dtheta = tan cos^4 dtan, with dtan = slope ds.
    total = 2 * np.pi * np.mean(D * tangent * cosine**4 * slope)
    assert total == pytest.approx(1, abs=1e-6)


def traced(x: float, y: float) -> np.ndarray:
    """Follow a ray along the axis to the mirror and off it, by bisection and differences."""

    def mirror(px: float, py: float, pz: float) -> float:
        return pz - 1 + (px * px + py * py) / 4

    low, high = -50.0, 50.0  # of the ray's height; the mirror is crossed once
    for _ in range(200):
        middle = (low + high) / 2
        low, high = (low, middle) if mirror(x, y, middle) > 0 else (middle, high)
    point, step = np.array([x, y, low]), 1e-6
    gradient = np.array(
        [
            (mirror(*(point + step * axis)) - mirror(*(point - step * axis))) / (2 * step)
            for axis in np.eye(3)
        ]
    )
    normal = gradient / np.linalg.norm(gradient)
    incoming = np.array([0.0, 0.0, 1.0])
    outgoing = incoming - 2 * (incoming @ normal) * normal
    # It must pass the focus; then the eye sees the sample from where the ray came.
    closest = point - (point @ outgoing) * outgoing
    assert np.linalg.norm(closest) < 1e-6 * max(1.0, np.linalg.norm(point))
    return -outgoing


@pytest.mark.parametrize(
    "place", [(0.01, 0.0), (1.0, 0.0), (-0.4, 1.3), (0.0, 1.99), (1.4, -1.4), (2.0, 0.0)]
)
def test_mirror_against_traced_rays(place):
    np.testing.assert_allclose(disks.directions(*place), traced(*place), atol=1e-8)


def test_the_disk_is_the_hemisphere():
    angle = np.radians(np.array([0.0, 20.0, 60.0, 90.0]))
    np.testing.assert_allclose(
        disks.directions(2 * np.tan(angle / 2), 0.0)[:, 2], np.cos(angle), atol=1e-12
    )
    seen = disks._pixels()
    np.testing.assert_allclose(np.linalg.norm(seen, axis=1), 1.0)
    assert seen[:, 2].min() > 0
    # The share of a square's pixels that lie in the disk.
    assert len(seen) / disks.RESOLUTION**2 == pytest.approx(np.pi / 4, abs=0.02)


def pictures(roughness: float, metallic: float = 0.0) -> np.ndarray:
    """(lights, N, N) red disks with 0 around."""
    n = disks.RESOLUTION
    centres = (2 * np.arange(n) + 1) / n * 2 - 2
    inside = disks.directions(centres[None, :], centres[:, None])[..., 2] > 0
    found = np.zeros((len(disks.LIGHTS), n, n))
    value = disks.reflectance_disks([0.5, 0.4, 0.3], roughness, metallic)
    found[:, inside] = value[..., 0]
    return found


@pytest.mark.parametrize("roughness", [0.2, 0.6])
def test_light_in_a_plane_gives_disks_that_it_halves(roughness):
    shown = pictures(roughness)
    np.testing.assert_allclose(shown, shown[:, ::-1, :], rtol=1e-9)
    assert np.abs(shown[1:] - shown[1:, :, ::-1]).max() > 1e-3, "the light comes from one side"


def test_light_along_the_normal_gives_rings(monkeypatch):
    monkeypatch.setattr(disks, "LIGHTS", (0.0,))
    shown = pictures(0.3)[0]
    for turned in (shown.T, shown[::-1], shown[:, ::-1]):
        np.testing.assert_allclose(shown, turned, rtol=1e-9)
    middle = shown[disks.RESOLUTION // 2]
    assert middle.argmax() == disks.RESOLUTION // 2


def test_highlights_lie_opposite_the_light_and_shrink():
    centres = (2 * np.arange(disks.RESOLUTION) + 1) / disks.RESOLUTION * 2 - 2
    for index, angle in enumerate(disks.LIGHTS[:2]):
        row = pictures(0.2)[index][disks.RESOLUTION // 2]
        expected = -2 * math.tan(math.radians(angle) / 2)
        assert centres[row.argmax()] == pytest.approx(expected, abs=4 / disks.RESOLUTION)
    wide, narrow = ([np.count_nonzero(p > p.max() / 2) for p in pictures(r)] for r in (0.9, 0.2))
    assert all(a > b for a, b in zip(wide, narrow, strict=True))


def test_equal_ratios_become_equal_steps():
    dim = np.full((1, 1, 3), 0.3)
    steps = [disks.logarithms(dim * factor)[0] for factor in (1.0, 4.0, 16.0)]
    assert steps[1] - steps[0] == pytest.approx(steps[2] - steps[1], rel=0.02)
    assert np.isfinite(disks.logarithms(np.zeros((3, 5, 3)))).all()
