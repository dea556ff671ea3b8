"""OpenRooms' model: against the published formula in double precision, and its sampling."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy import stats

Array = np.ndarray
Prepare = Callable[[str], Any]


def published(wi: Array, wo: Array, R: float, F0: Array) -> Array:
    """D F G / (4 (n.l)(n.v)) of (..., 3) unit directions, as the paper writes it."""
    h = (wi + wo) / np.linalg.norm(wi + wo, axis=-1, keepdims=True)
    n_h, n_v, n_l = h[..., 2], wi[..., 2], wo[..., 2]
    v_h = (wi * h).sum(axis=-1)
    D = R**4 / (np.pi * (n_h**2 * (R**4 - 1) + 1) ** 2)
    F = (1 - F0) * 2.0 ** ((-5.55473 * v_h - 6.98316) * v_h)[..., None] + F0
    k = (R + 1) ** 2 / 8
    G = n_v / (n_v * (1 - k) + k) * n_l / (n_l * (1 - k) + k)
    return F * (D * G / (4 * n_l * n_v))[..., None]


def half_vectors(wi: Array, R: float, u: Array, azimuth: Array) -> tuple[Array, Array]:
    """Directions that mirror ``wi``, and the solid angle of d(u) d(azimuth).

    The half vector's tangent is R^2 sqrt(u / (1 - u)), which spreads the lobe evenly over u.
    """
    tangent = R**2 * np.sqrt(u / (1 - u))
    cosine = 1 / np.sqrt(1 + tangent**2)
    h = np.stack(
        [tangent * cosine * np.cos(azimuth), tangent * cosine * np.sin(azimuth), cosine], axis=-1
    )
    v_h = h @ wi
    slopes = R**4 / (2 * (1 - u) ** 2)
    return 2 * v_h[..., None] * h - wi, np.where(v_h > 0, 4 * v_h * cosine**3 * slopes, 0.0)


def integrated(wi: Array, R: float, F0: Array, steps: int = 500) -> Array:
    """What the published lobe reflects of even light, by the midpoint rule."""
    u, azimuth = np.meshgrid(*[(np.arange(steps) + 0.5) / steps] * 2)
    wo, angle = half_vectors(wi, R, u, 2 * np.pi * azimuth)
    up = wo[..., 2] > 0
    values = published(wi, wo[up], R, F0) * (wo[up][:, 2] * angle[up])[:, None]
    return values.sum(axis=0) * 2 * np.pi / steps**2


def direction(cosine: float, azimuth: float = 0.3) -> Array:
    sine = np.sqrt(1 - cosine**2)
    return np.array([sine * np.cos(azimuth), sine * np.sin(azimuth), cosine])


def hemisphere(count: int, seed: int) -> Array:
    random = np.random.default_rng(seed).normal(size=(count, 3))
    random[:, 2] = np.abs(random[:, 2])
    return random / np.linalg.norm(random, axis=1, keepdims=True)


class Plate:
    """A flat surface of the model in the plane z = 0, evaluated in numpy's terms."""

    def __init__(self, mi: Any, base: Any = 0.5, **inputs: Any) -> None:
        self.mi = mi
        color = {"type": "rgb", "value": np.broadcast_to(base, 3).tolist()}
        self.bsdf = mi.load_dict({"type": "openrooms", "base_color": color} | inputs)
        self.context = mi.BSDFContext()

    def at(self, wi: Array) -> Any:
        import drjit as dr

        si = dr.zeros(self.mi.SurfaceInteraction3f)
        si.wi = self.mi.Vector3f(np.asarray(wi, dtype=np.float32).T)
        si.n = self.mi.Normal3f(0, 0, 1)
        si.sh_frame = self.mi.Frame3f(si.n)
        return si

    def eval_pdf(self, wi: Array, wo: Array) -> tuple[Array, Array]:
        turned = self.mi.Vector3f(np.asarray(wo, dtype=np.float32).T)
        value, density = self.bsdf.eval_pdf(self.context, self.at(wi), turned)
        return np.array(value).T, np.array(density)

    def sample(self, wi: Array, numbers: Array) -> tuple[Array, Array, Array]:
        """Directions, densities and weights from (N, 3) numbers."""
        mi, u = self.mi, np.asarray(numbers, dtype=np.float32).T
        where = mi.Point2f(u[1:])
        bs, weight = self.bsdf.sample(self.context, self.at(wi), mi.Float(u[0]), where)
        return np.array(bs.wo).T, np.array(bs.pdf), np.array(weight).T


ROUGHNESSES = [0.02, 0.1, 0.3, 0.6, 1.0]
COSINES = [1.0, 0.7, 0.2, 0.05]


@pytest.mark.parametrize("R", ROUGHNESSES)
@pytest.mark.parametrize("metallic", [0.0, 0.4, 1.0])
def test_values_are_those_of_the_paper(prepare: Prepare, R: float, metallic: float) -> None:
    base, F0 = np.array([0.8, 0.4, 0.1]), 0.05
    plate = Plate(prepare("llvm"), base, roughness=R, metallic=metallic, f0=F0)
    wi = hemisphere(400, 1)
    near, _ = half_vectors(direction(0.6), R, np.linspace(0.01, 0.9, 400), np.linspace(0, 6, 400))
    for a, b in ((wi, hemisphere(400, 2)), (np.broadcast_to(direction(0.6), near.shape), near)):
        above = b[:, 2] > 1e-3
        a, b = a[above], b[above]
        tint = (1 - metallic) * F0 + metallic * base
        expected = base * (1 - metallic) / np.pi + published(a, b, R, tint)
        found = plate.eval_pdf(a, b)[0]
        # Directions of single precision know the half vector to some 1e-7, the lobe's width R^2.
        np.testing.assert_allclose(found, expected * b[:, 2:], rtol=2e-5 + 5e-7 / R**2)


@pytest.mark.parametrize("R", ROUGHNESSES)
def test_light_may_go_either_way(prepare: Prepare, R: float) -> None:
    plate = Plate(prepare("llvm"), 0.3, roughness=R, metallic=0.2)
    a, b = hemisphere(500, 3), hemisphere(500, 4)
    there, back = plate.eval_pdf(a, b)[0] / b[:, 2:], plate.eval_pdf(b, a)[0] / a[:, 2:]
    np.testing.assert_allclose(there, back, rtol=1e-4)


@pytest.mark.one_in(4)
@pytest.mark.parametrize("R", ROUGHNESSES)
@pytest.mark.parametrize("cosine", COSINES)
@pytest.mark.parametrize("base, metallic", [(0.0, 0.0), (0.5, 0.0), (1.0, 0.5), (1.0, 1.0)])
def test_sampling_finds_the_integral(
    prepare: Prepare, R: float, cosine: float, base: float, metallic: float
) -> None:
    """The directional albedo by importance sampling and by quadrature of the paper's formula."""
    plate = Plate(prepare("llvm"), base, roughness=R, metallic=metallic)
    wi, count = direction(cosine), 40_000
    numbers = np.random.default_rng(5).random((count, 3))
    weights = plate.sample(np.tile(wi, (count, 1)), numbers)[2][:, 0]
    tint = np.array([0.05 * (1 - metallic) + base * metallic])
    expected = base * (1 - metallic) + integrated(wi, R, tint)[0]
    noise = weights.std() / np.sqrt(count)
    assert abs(weights.mean() - expected) < 4.5 * noise + 1e-3 * expected
    # Good sampling: no weight is far above the mean.
    assert weights.max() < 8.0 * expected


@pytest.mark.parametrize("R", [0.01, 0.1, 0.3, 0.5, 0.7, 1.0])
def test_where_the_published_model_makes_light(R: float) -> None:
    """The lobe alone never does, not even of silver; beside a white diffuse part it always does."""
    most = {0.01: 0.1605, 0.1: 0.138, 0.3: 0.087, 0.5: 0.0625, 0.7: 0.059, 1.0: 0.050}[R]
    cosines = [0.001, 0.05, 0.1, 0.15, 0.18, 0.2, 0.3, 0.6, 1.0]
    mirror = [integrated(direction(c), R, np.ones(1), 300)[0] for c in cosines]
    plastic = [integrated(direction(c), R, np.array([0.05]), 300)[0] for c in cosines]
    assert max(mirror) < 1.0005
    assert max(plastic) == pytest.approx(most, abs=0.002)
    assert min(plastic[1:]) > 0.01


def fits(counts: Array, expected: Array) -> bool:
    """Pearson's test at 1e-4, cells with few expected counts taken together."""
    order = np.argsort(expected, axis=None)
    pooled = np.cumsum(expected.ravel()[order]) < 10
    few, many = order[pooled], order[~pooled]
    found = np.append(counts.ravel()[many], counts.ravel()[few].sum())
    wanted = np.append(expected.ravel()[many], expected.ravel()[few].sum())
    terms = (found - wanted) ** 2 / np.maximum(wanted, 1e-9)
    terms = terms[wanted > 1.0]
    return bool(stats.chi2.sf(terms.sum(), len(terms) - 1) > 1e-4)


@pytest.mark.parametrize("R", ROUGHNESSES)
@pytest.mark.parametrize("cosine", COSINES)
def test_directions_follow_their_density_in_the_lobe(
    prepare: Prepare, R: float, cosine: float
) -> None:
    """Chi-square over cells of the half vector; what lies outside of the lobe is one cell more."""
    plate = Plate(prepare("llvm"), 0.3, roughness=R)
    wi, count, (rows, columns), fine = direction(cosine), 60_000, (10, 16), 24
    wo, _, weights = plate.sample(
        np.tile(wi, (count, 1)), np.random.default_rng(6).random((count, 3))
    )
    wo = wo[weights[:, 0] > 0].astype(np.float64)
    h = (wo + wi) / np.linalg.norm(wo + wi, axis=1, keepdims=True)
    squared = (h[:, 0] ** 2 + h[:, 1] ** 2) / h[:, 2] ** 2 / R**4
    u, azimuth = squared / (1 + squared), np.arctan2(h[:, 1], h[:, 0]) % (2 * np.pi)
    edges = np.linspace(0, 0.95, rows + 1), np.linspace(0, 2 * np.pi, columns + 1)
    counts = np.histogram2d(u, azimuth, bins=edges)[0]

    steps = [(np.arange(n * fine) + 0.5) / (n * fine) for n in (rows, columns)]
    grid = np.meshgrid(0.95 * steps[0], 2 * np.pi * steps[1], indexing="ij")
    towards, angle = half_vectors(wi, R, *grid)
    flat = towards.reshape(-1, 3)
    density = plate.eval_pdf(np.broadcast_to(wi, flat.shape), flat)[1].reshape(angle.shape)
    size = 0.95 * 2 * np.pi / angle.size
    cells = (density * angle * size).reshape(rows, fine, columns, fine).sum(axis=(1, 3))
    expected = np.append(count * cells, count * (1 - cells.sum()))
    assert fits(np.append(counts, count - counts.sum()), expected)


@pytest.mark.parametrize("R, passed", [(0.3, 0.0), (0.7, 0.8), (1.0, 0.3)])
@pytest.mark.parametrize("cosine", [0.9, 0.3, -0.5])
def test_directions_follow_their_density_all_around(
    prepare: Prepare, R: float, passed: float, cosine: float
) -> None:
    """Chi-square over the sphere, with the diffuse parts on both sides, seen from both sides."""
    plate = Plate(prepare("llvm"), 0.5, roughness=R, transmission=passed)
    wi, count, (rows, columns), fine = direction(cosine), 60_000, (16, 12), 24
    wo, _, weights = plate.sample(
        np.tile(wi, (count, 1)), np.random.default_rng(7).random((count, 3))
    )
    wo = wo[weights[:, 0] > 0]
    edges = np.linspace(-1, 1, rows + 1), np.linspace(-np.pi, np.pi, columns + 1)
    counts = np.histogram2d(wo[:, 2], np.arctan2(wo[:, 1], wo[:, 0]), bins=edges)[0]
    z, azimuth = np.meshgrid(
        *[(np.arange(n * fine) + 0.5) / (n * fine) for n in (rows, columns)], indexing="ij"
    )
    z, azimuth = 2 * z - 1, 2 * np.pi * azimuth - np.pi
    sine = np.sqrt(1 - z**2)
    flat = np.stack([sine * np.cos(azimuth), sine * np.sin(azimuth), z], axis=-1).reshape(-1, 3)
    density = plate.eval_pdf(np.broadcast_to(wi, flat.shape), flat)[1].reshape(z.shape)
    cells = (density * 4 * np.pi / z.size).reshape(rows, fine, columns, fine).sum(axis=(1, 3))
    expected = np.append(count * cells, count * (1 - cells.sum()))
    assert fits(np.append(counts, count - counts.sum()), expected)
