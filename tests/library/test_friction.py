"""References, mapping and table of friction: sourced, bounded, continuous, and as they are made."""

import io
import math

import numpy as np
import pytest

from openrooms_usd.library.friction import disks, friction_of, physics_of
from openrooms_usd.library.friction import table as shipped
from openrooms_usd.library.friction.make import table_bytes
from openrooms_usd.library.friction.mapping import Mapping, blended
from openrooms_usd.library.friction.references import (
    SUBSTANCES,
    counterface_factors,
    density,
    references,
    restitution,
    sources,
)

ROWS = references()


@pytest.fixture(scope="module")
def mapping() -> Mapping:
    return Mapping(ROWS)


def random_looks(count: int, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    return rng.random((count, 3)), rng.random(count)


def test_every_reference_has_a_source_and_plausible_numbers():
    assert {row.source for row in ROWS} == set(sources())
    assert len(ROWS) >= 40
    for row in ROWS:
        assert 0.05 < row.static < 1.5, row.name
        assert row.dynamic is None or 0 < row.dynamic <= row.static, row.name
        assert all(0 < c < 1 for c in row.albedo) and 0 < row.roughness <= 1, row.name
        assert 100 < row.density < 10_000, row.name
    for substance in SUBSTANCES:
        assert sum(row.substance == substance for row in ROWS) >= 3, substance
        assert 0 <= restitution(substance) <= 1 and density(substance) > 100
    assert len({(row.name, row.counterface) for row in ROWS}) == len(ROWS)


def test_counterfaces_are_told_apart():
    # Coefficients that are products of two parts: the factors are found up to the pull to 1.
    parts = {"metal": 0.7, "wood": 1.0, "rubber": 1.6}
    twin = [
        type(row)(**{**row.__dict__, "counterface": face, "static": 0.4 * factor})
        for row in ROWS
        for face, factor in parts.items()
    ]
    found = counterface_factors(tuple(twin))
    for face in parts:
        assert found[face] / found["wood"] == pytest.approx(parts[face], rel=0.03)
    assert np.prod(list(found.values())) == pytest.approx(1.0)


def test_blending_in_closed_form():
    own, known = np.array([[0.0], [2.0]]), np.array([0.2, 0.6])
    near, _ = blended(np.array([0.0]), own, known, 0.5, bandwidth=1.0, prior_weight=1.0)
    w = np.array([1.0, np.exp(-2.0)]) + 0.5
    expected = (2 * (w @ known) / w.sum() + 2 * 0.5) / 4
    assert float(near) == pytest.approx(expected)
    far, variance = blended(np.array([1e3]), own, known, 0.4)
    assert float(far) == pytest.approx(0.4) and float(variance) == pytest.approx(0.08)


@pytest.mark.one_in(81)
@pytest.mark.parametrize("substance", SUBSTANCES)
def test_no_value_beyond_what_is_known(mapping, substance):
    albedo, roughness = random_looks(300)
    found = mapping.friction(substance, albedo, roughness)
    own = [r.static / mapping.factors[r.counterface] for r in ROWS if r.substance == substance]
    anything = float(mapping.unknown().static)
    assert found.static.min() >= min(*own, anything) and found.static.max() <= max(*own, anything)
    assert (found.dynamic <= found.static).all() and (found.dynamic > 0.3 * found.static).all()
    assert (found.spread > 0.05).all() and (found.spread < 0.5).all()


@pytest.mark.slow
def test_a_reference_draws_its_own_looks_to_itself(mapping):
    drawn, deaf = [], Mapping(ROWS, bandwidth=np.inf)
    for row in ROWS:
        own = row.static / mapping.factors[row.counterface]
        here, plain = (
            float(known.friction(row.substance, row.albedo, row.roughness).static)
            for known in (mapping, deaf)
        )
        drawn.append(abs(here - own) - abs(plain - own))
    assert np.mean(drawn) < -0.005


@pytest.mark.slow
def test_the_shipped_table_is_what_is_made():
    data, file = table_bytes(), shipped.FILE.read_bytes()
    made = np.load(io.BytesIO(data), allow_pickle=False)
    assert made.dtype == np.float32 and made.shape == shipped.SHAPE
    assert (len(data), data[:80]) == (len(file), file[:80])
    # On another machine a value may round to the next of the four decimals.
    np.testing.assert_allclose(np.load(shipped.FILE, allow_pickle=False), made, atol=1.01e-4)


@pytest.mark.one_in(3)
@pytest.mark.parametrize("substance", SUBSTANCES)
def test_nodes_are_the_mapping(mapping, substance):
    albedo = np.array(
        [[a, b, c] for a in shipped.ALBEDO for b in shipped.ALBEDO for c in shipped.ALBEDO]
    )
    for roughness in (0.0, 0.3, 1.0):
        exact = mapping.friction(substance, albedo, roughness)
        for a, b in zip(friction_of(substance, albedo, roughness), exact, strict=True):
            np.testing.assert_allclose(a, b, atol=1e-4)


@pytest.mark.parametrize("substance", SUBSTANCES)
def test_between_the_nodes(mapping, substance):
    albedo, roughness = random_looks(400, 3)
    exact = mapping.friction(substance, albedo, roughness).static
    error = np.abs(friction_of(substance, albedo, roughness).static - exact)
    assert error.max() < 0.05 and error.mean() < 0.006


@pytest.mark.parametrize("substance", [*SUBSTANCES, None])
def test_it_is_continuous(substance):
    """No step is steeper than the steepest between neighbouring nodes."""
    number = len(SUBSTANCES) if substance is None else SUBSTANCES.index(substance)
    static = np.load(shipped.FILE, allow_pickle=False)[number, ..., 0].astype(np.float64)
    axes = [shipped.ALBEDO] * 3 + [shipped.ROUGHNESS]
    steepest = []
    for axis, nodes in enumerate(axes):
        widths = np.diff(nodes).reshape([-1 if axis == other else 1 for other in range(4)])
        steepest.append(np.abs(np.diff(static, axis=axis) / widths).max())
    rng = np.random.default_rng(5)
    start = rng.random((2000, 4))
    # Many small steps, half of them begun on a node's plane.
    start[:1000, 3] = np.round(start[:1000, 3] * 10) / 10
    step = rng.uniform(-1, 1, (2000, 4)) * 10.0 ** rng.uniform(-9, -1, (2000, 1))
    end = np.clip(start + step, 0, 1)
    a, b = (friction_of(substance, x[:, :3], x[:, 3]).static for x in (start, end))
    assert (np.abs(a - b) <= np.abs(end - start) @ np.array(steepest) + 1e-12).all()


def test_it_is_between_its_nodes_and_clamped():
    low = friction_of("metal", [0.0, 0.0, 0.0], 0.0)
    assert friction_of("metal", [-3.0, 0.0, np.nan], -1.0) == low
    high = friction_of("metal", [1.0, 1.0, 1.0], 1.0)
    assert friction_of("metal", [5.0, np.inf, 1.0], 7.0) == high
    albedo, roughness = random_looks(1000, 9)
    for substance in SUBSTANCES:
        own = np.load(shipped.FILE, allow_pickle=False)[SUBSTANCES.index(substance)]
        for index, value in enumerate(friction_of(substance, albedo, roughness)):
            assert own[..., index].min() - 1e-6 <= value.min()
            assert value.max() <= own[..., index].max() + 1e-6


def test_pictures_and_shapes(monkeypatch):
    albedo, roughness = random_looks(6 * 7, 2)
    whole = friction_of("wood", albedo.reshape(6, 7, 3), roughness.reshape(6, 7))
    assert whole.static.shape == (6, 7)
    one = friction_of("wood", albedo[10], roughness[10])
    assert float(one.static) == whole.static[1, 3] and one.static.shape == ()
    monkeypatch.setattr(shipped, "_PIXELS_AT_A_TIME", 5)
    np.testing.assert_array_equal(
        friction_of("wood", albedo, roughness).static.reshape(6, 7), whole.static
    )
    assert friction_of("wood", np.zeros((0, 3)), np.zeros(0)).static.shape == (0,)


def test_who_knows_nothing_is_least_sure():
    unknown = friction_of(None, [0.2, 0.9, 0.1], 0.4)
    other = friction_of(None, [0.7, 0.0, 0.3], 0.9)
    assert [float(v) for v in unknown] == pytest.approx([float(v) for v in other])
    spreads = [float(friction_of(s, [0.3, 0.3, 0.3], 0.5).spread) for s in SUBSTANCES]
    assert float(unknown.spread) > np.median(spreads)


def test_the_physics_of_a_material():
    rubber, metal = (physics_of(s, (0.1, 0.1, 0.1), 0.6) for s in ("rubber", "metal"))
    assert rubber.static_friction > metal.static_friction
    assert metal.density > 5 * rubber.density
    assert rubber.friction_spread is not None and rubber.friction_spread > 0.1
    assert rubber.dynamic_friction <= rubber.static_friction


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
