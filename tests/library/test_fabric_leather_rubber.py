"""Fabrics, leathers and rubbers: they tile, keep to their colours, and are woven as they say."""

from itertools import pairwise

import numpy as np
import pytest

from openrooms_usd.library.textures import fabric, leather, rubber
from openrooms_usd.library.textures.base.family import Family, TextureParams
from openrooms_usd.library.textures.base.lattice import cells, whole
from openrooms_usd.library.textures.base.maps import ALBEDO_RANGE, Maps, normals
from openrooms_usd.library.textures.base.noise import apart
from openrooms_usd.library.textures.base.recipe import tinted
from openrooms_usd.library.textures.base.strewn import fibres
from openrooms_usd.library.textures.fabric.weave import (
    Thread,
    pattern,
    pointed,
    satin,
    twill,
    woven,
)
from openrooms_usd.library.textures.fabric.woven import WOVEN
from openrooms_usd.library.textures.rubber.sheets import MOULDS

FAMILIES: dict[str, Family] = {**fabric.FAMILIES, **leather.FAMILIES, **rubber.FAMILIES}


def order(seed: int, resolution: int, size: float, **options: object) -> TextureParams:
    return TextureParams(np.random.Generator(np.random.PCG64(seed)), resolution, size, **options)  # type: ignore[arg-type]


def made(name: str, seed: int = 0, resolution: int = 96, **options: object) -> Maps:
    family = FAMILIES[name]
    size = options.pop("size", family.size)
    return family.make(order(seed, resolution, size, **options))  # type: ignore[arg-type]


def test_each_substance_has_its_dozen() -> None:
    counts = [len(module.FAMILIES) for module in (fabric, leather, rubber)]
    assert min(counts) >= 14 and sum(counts) == len(FAMILIES)


@pytest.mark.one_in(3, rest="long")
@pytest.mark.parametrize("name", FAMILIES)
def test_values_are_finite_and_plausible(name: str) -> None:
    maps = made(name, 3)
    assert maps.albedo.shape == (96, 96, 3) and maps.height.shape == maps.roughness.shape == (
        96,
        96,
    )
    assert maps.albedo.dtype == maps.height.dtype == maps.roughness.dtype == np.float64
    assert (
        ALBEDO_RANGE[0] - 1e-12 <= maps.albedo.min() <= maps.albedo.max() <= ALBEDO_RANGE[1] + 1e-12
    )
    assert 0.02 <= maps.albedo.mean() <= 0.75
    glossy = name in ("patent_leather",)
    assert (0.05 if glossy else 0.2) <= maps.roughness.mean() <= (0.12 if glossy else 1.0)
    vectors = normals(maps.height, FAMILIES[name].size / 96)
    assert np.isfinite(vectors).all() and vectors[..., 2].min() > 0.02
    # Nothing here is deeper than a shag carpet's pile or the holes of a mat.
    assert 1e-5 < np.ptp(maps.height) < 0.016


@pytest.mark.one_in(2, rest="long")
@pytest.mark.parametrize("name", FAMILIES)
def test_they_tile_without_a_seam_at_any_size(name: str) -> None:
    """Steps across the seam are like those between neighbours elsewhere, in both directions."""
    # No repeat was meant for this size.
    maps = made(name, 5, 256, size=FAMILIES[name].size * 0.83)
    for field in (maps.albedo.mean(axis=-1), maps.height, maps.roughness):
        for axis in (0, 1):
            steps = np.abs(field - np.roll(field, 1, axis)).mean(axis=1 - axis)
            inside = steps[1:]
            usual = max(1.05 * inside.max(), inside.mean() + 6.0 * inside.std())
            assert steps[0] <= usual + 1e-12, (axis, steps[0], usual)


@pytest.mark.one_in(4, rest="long")
@pytest.mark.parametrize("name", FAMILIES)
def test_equal_orders_give_equal_maps_and_others_do_not(name: str) -> None:
    first, again, other = (made(name, seed, 48) for seed in (7, 7, 8))
    for kind in ("albedo", "height", "roughness"):
        assert getattr(first, kind).tobytes() == getattr(again, kind).tobytes()
    assert not np.array_equal(first.albedo, other.albedo)
    assert not np.array_equal(first.height, other.height)


@pytest.mark.one_in(2, rest="long")
@pytest.mark.parametrize("name", FAMILIES)
def test_what_is_given_is_kept(name: str) -> None:
    color = (0.24, 0.30, 0.16)
    maps = made(name, 1, color=color, roughness=0.55)
    np.testing.assert_allclose(maps.albedo.mean(axis=(0, 1)), color, rtol=0.02)
    assert maps.roughness.mean() == pytest.approx(0.55, abs=0.005)


@pytest.mark.one_in(25, rest="long")
@pytest.mark.parametrize("name", ["linen", "sisal", "cable_knit", "crocodile_leather", "sponge"])
def test_a_finer_grid_shows_the_same_piece(name: str) -> None:
    """Means over four texels of twice the resolution are what the coarse grid has."""
    coarse, fine = made(name, 9, 512), made(name, 9, 1024)
    for kind in ("height", "albedo"):
        a, b = getattr(coarse, kind), getattr(fine, kind)
        b = b.reshape(512, 2, 512, 2, -1).mean(axis=(1, 3))
        assert np.corrcoef(a.ravel(), b.ravel())[0, 1] > 0.9


@pytest.mark.one_in(4, rest="long")
@pytest.mark.parametrize("name", FAMILIES)
@pytest.mark.parametrize(("resolution", "size"), [(1, 1e-3), (33, 1e3)])
def test_extreme_sizes_are_finite(name: str, resolution: int, size: float) -> None:
    maps = made(name, 2, resolution, size=size)
    for field in (maps.albedo, maps.height, maps.roughness):
        assert np.isfinite(field).all() and len(field) == resolution


def peak(profile: np.ndarray) -> int:
    """Number of periods of the strongest wave in a profile's slope."""
    n = len(profile)
    k = np.arange(1, n // 2)
    waves = np.exp(-2j * np.pi * np.outer(k, np.arange(n)) / n)
    return int(k[np.abs(waves @ (profile - np.roll(profile, 1))).argmax()])


# Threads a centimetre of warp and weft, as sellers state them; weft hardly shows in warp faces.
THREADS = {
    "linen": (15, 13),
    "canvas": (18, 10),
    "twill": (18, 15),
    "tartan": (12, 12),
    "houndstooth": (9, 9),
    "herringbone": (11, 10),
    "denim": (25, None),
    "ticking": (24, None),
    "satin": (34, None),
    "sisal": (3.2, 2.6),
    "basket_weave": (7, 7),
}


@pytest.mark.one_in(3, rest="long")
@pytest.mark.parametrize("name", THREADS)
def test_threads_are_as_many_as_stated(name: str) -> None:
    size = FAMILIES[name].size
    height = made(name, 4, 640).height
    for axis, count in enumerate(THREADS[name]):
        if count is not None:
            found = peak(height.mean(axis=axis)) / (100.0 * size)
            assert found == pytest.approx(count, rel=0.16), (name, axis)


@pytest.mark.parametrize(
    ("name", "low", "high"),
    [
        ("corduroy", 2.4, 3.6),
        ("jersey_knit", 0.6, 1.6),
        ("loop_carpet", 1.7, 1.9),
        ("ribbed_rubber", 3.06, 4.14),
        ("coin_rubber", 28.0, 38.0),
        ("needlefelt_carpet", 5.3, 5.7),
    ],
)
def test_repeats_are_as_wide_as_stated(name: str, low: float, high: float) -> None:
    """Millimetres along s; half of it where every second row is shifted or a loop has two legs."""
    width = 1000.0 * FAMILIES[name].size / peak(made(name, 6, 512).height.mean(axis=0))
    assert low * 0.97 <= width <= high * 1.03


def test_repeats_are_whole_multiples_and_never_finer_than_texels() -> None:
    assert whole(order(0, 1000, 0.1), 0.0013) == 77
    assert whole(order(0, 1000, 0.1), 0.0013, 24) == 72
    assert whole(order(0, 1000, 0.1), 3.0, 24) == 24
    assert whole(order(0, 100, 0.1), 0.0001) == 40


@pytest.mark.parametrize(
    "weave", [pattern("X.", ".X"), twill(3, 1), twill(2, 2), satin(8, 3), pointed(twill(2, 2), 12)]
)
def test_the_thread_on_top_is_the_one_that_the_weave_says(weave: np.ndarray) -> None:
    """At the middle of each crossing, rows of the weave running down as those of the picture."""
    picks, ends = weave.shape[0] * 2, weave.shape[1] * 2
    even = Thread((1.0, 1.0), slub=0.0, melange=0.0, bend=0.0)
    resolution = 9 * picks * ends
    rng = np.random.default_rng(0)
    # One row and one column of texels through each crossing would do; the lattice is cut down.
    cloth = woven(rng, weave, (even, even), (ends, picks), min(resolution, 720))
    n = len(cloth.height)
    row = ((np.arange(picks) + 0.5) * n / picks).astype(int)
    column = ((np.arange(ends) + 0.5) * n / ends).astype(int)
    on_top = cloth.is_warp[np.ix_(row, column)]
    np.testing.assert_array_equal(on_top, np.tile(weave, (2, 2)).astype(bool))


def test_weaves_are_what_weavers_call_them() -> None:
    assert twill(3, 1).mean() == 0.75
    # Each float of a satin is bound once, never beside another binding.
    bound = satin(8, 3) == 0
    assert (bound.sum(axis=0) == 1).all() and (bound.sum(axis=1) == 1).all()
    assert not (bound & np.roll(bound, (1, 1), (0, 1))).any()
    assert not (bound & np.roll(bound, (1, -1), (0, 1))).any()
    # Ribs climb by one end a pick; a herringbone's run back after twelve ends.
    assert all(np.array_equal(a, np.roll(b, 1)) for a, b in pairwise(twill(2, 2)))
    weave = WOVEN["herringbone"].weave
    assert all(np.array_equal(a[:12], np.roll(b[:12], 1)) for a, b in pairwise(weave))
    assert all(np.array_equal(a[12:], np.roll(b[12:], -1)) for a, b in pairwise(weave))


def test_threads_of_a_plain_weave_swing_like_a_cosine() -> None:
    even = Thread((1.0, 1.0), slub=0.0, melange=0.0, bend=0.0)
    n, threads, crimp = 252, 4, 0.45
    rng = np.random.default_rng(0)
    cloth = woven(rng, pattern("X.", ".X"), (even, even), (threads, threads), n, crimp)
    middle = n // threads // 2
    crossings = (np.arange(n) + 0.5) / n * threads - 0.5
    axis = crimp * np.cos(np.pi * crossings) + 0.5
    seen = cloth.is_warp[:, middle]
    np.testing.assert_allclose(cloth.height[seen, middle], axis[seen], atol=1e-3)
    assert 0.4 < seen.mean() < 0.7


@pytest.mark.parametrize("angle", [0.0, 0.4, -0.7, 1.3])
def test_fibres_run_where_they_are_told(angle: float) -> None:
    """The direction of least change, from the structure tensor, from t towards s."""
    field = fibres(np.random.default_rng(1), 256, 0.1, 0.003, 0.02, angle)
    ds = np.roll(field, -1, 1) - np.roll(field, 1, 1)
    dt = np.roll(field, 1, 0) - np.roll(field, -1, 0)
    tensor = np.array([[np.mean(ds * ds), np.mean(ds * dt)], [np.mean(ds * dt), np.mean(dt * dt)]])
    s, t = np.linalg.eigh(tensor)[1][:, 0]
    found = np.arctan2(s * np.sign(t), abs(t))
    assert found == pytest.approx(angle, abs=0.06)


@pytest.mark.parametrize(("jitter", "stagger"), [(0.0, 0.0), (0.8, 0.0), (0.45, 0.5)])
def test_cells_are_those_of_the_nearest_middles(jitter: float, stagger: float) -> None:
    """Against all middles and their eight images, from the same draws."""
    n, columns, rows = 60, 5, 6
    found = cells(np.random.default_rng(3), n, columns, rows, jitter, stagger)
    stray = (apart(np.random.default_rng(3)).random((2, rows, columns)) - 0.5) * jitter
    j, i = np.mgrid[:rows, :columns]
    s, t = i + 0.5 + stray[0] + stagger * (j % 2 - 0.5), j + 0.5 + stray[1]
    images = [(di * columns, dj * rows) for di in (-1, 0, 1) for dj in (-1, 0, 1)]
    middles = np.concatenate([np.stack([s + a, t + b], -1).reshape(-1, 2) for a, b in images])
    y, x = np.mgrid[:n, :n] + 0.5
    reach = np.hypot(
        x[..., None] * columns / n - middles[:, 0], y[..., None] * rows / n - middles[:, 1]
    )
    ranked = np.sort(reach, axis=-1)
    np.testing.assert_allclose(found.nearest, ranked[..., 0], atol=1e-12)
    np.testing.assert_allclose(found.border, ranked[..., 1] - ranked[..., 0], atol=1e-9)
    clear = ranked[..., 1] - ranked[..., 0] > 1e-9
    np.testing.assert_array_equal(found.index[clear], (reach.argmin(-1) % (rows * columns))[clear])


@pytest.mark.parametrize("mean", [(0.02, 0.02, 0.02), (0.9, 0.88, 0.85), (0.5, 0.1, 0.03)])
def test_contrast_yields_to_the_mean(mean: tuple[float, float, float]) -> None:
    shade = 0.2 + np.random.default_rng(5).random((64, 64)) ** 3
    albedo = tinted(shade, np.array(mean))
    assert albedo.min() >= ALBEDO_RANGE[0] and albedo.max() <= ALBEDO_RANGE[1]
    np.testing.assert_allclose(albedo.mean(axis=(0, 1)), mean, rtol=0.06)


def test_studs_cover_the_share_of_their_discs() -> None:
    mould = MOULDS["coin_rubber"]
    relief = mould.relief(order(0, 600, mould.size), mould.pitch)
    assert relief.mean() == pytest.approx(np.pi * 0.73**2 / 4.0, abs=0.004)
