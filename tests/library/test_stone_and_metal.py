"""Stone and metal: whole pieces of stated sizes, joints of stated widths, edges that meet."""

from functools import cache

import numpy as np
import pytest

from openrooms_usd.arrays import Array
from openrooms_usd.library.textures import metal, rough_stone, specular_stone
from openrooms_usd.library.textures.base.cells import hexagons, scales, scattered_cells
from openrooms_usd.library.textures.base.courses import bond, random_courses
from openrooms_usd.library.textures.base.family import Family, TextureParams
from openrooms_usd.library.textures.base.maps import Maps, encoded
from openrooms_usd.library.textures.base.recipe import covered, displaced, fractal, whole
from openrooms_usd.library.textures.base.strewn import chips, lines, pits
from openrooms_usd.library.textures.metal.metals import ALUMINIUM, COPPER, IRON, SILVER
from openrooms_usd.library.textures.rough_stone.masonry import JOINT, STANDARD, english_bond

Field = Array

FAMILIES: dict[str, Family] = {**rough_stone.FAMILIES, **specular_stone.FAMILIES, **metal.FAMILIES}


def order(
    size: float = 1.0, resolution: int = 256, seed: int = 0, **asked: tuple[float, ...] | float
) -> TextureParams:
    return TextureParams(np.random.default_rng(seed), resolution, size, **asked)  # type: ignore[arg-type]


@cache
def made(name: str) -> Maps:
    return FAMILIES[name].make(order(FAMILIES[name].size))


@pytest.mark.parametrize("name", FAMILIES)
def test_maps_are_finite_and_in_range(name: str) -> None:
    maps = made(name)
    for field in (maps.albedo, maps.height, maps.roughness, np.asarray(maps.metallic)):
        assert np.all(np.isfinite(field))
    assert maps.albedo.min() > 0.0 and maps.albedo.max() <= 1.05
    assert maps.roughness.min() >= 0.02 and maps.roughness.max() <= 1.0
    assert np.ptp(maps.height) < 0.06


@pytest.mark.one_in(4, rest="long")
@pytest.mark.parametrize("name", FAMILIES)
def test_equal_orders_give_equal_bytes(name: str) -> None:
    size = FAMILIES[name].size
    first = encoded(FAMILIES[name].make(order(size, 64, 3)), size)
    again = encoded(FAMILIES[name].make(order(size, 64, 3)), size)
    other = encoded(FAMILIES[name].make(order(size, 64, 4)), size)
    for picture in ("albedo", "normal", "roughness", "height"):
        np.testing.assert_array_equal(getattr(first, picture), getattr(again, picture))
    assert np.any(first.albedo != other.albedo)


@pytest.mark.parametrize("name", FAMILIES)
def test_means_asked_for_are_met(name: str) -> None:
    size, color = FAMILIES[name].size, (0.35, 0.30, 0.25)
    maps = FAMILIES[name].make(order(size, 96, 1, color=color, roughness=0.5))
    np.testing.assert_allclose(maps.albedo.mean(axis=(0, 1)), color, rtol=1e-9)
    assert maps.roughness.mean() == pytest.approx(0.5, abs=0.03)


@pytest.mark.parametrize("name", metal.FAMILIES)
def test_metalness_is_one_or_nothing(name: str) -> None:
    """But for edges and tarnish in between; constant families say so."""
    metallic = np.broadcast_to(made(name).metallic, (256, 256))
    stated = FAMILIES[name].metallic
    if stated is not None:
        assert np.all(metallic == stated)
    elif name != "tarnished_brass":
        assert np.mean((metallic > 0.02) & (metallic < 0.35)) < 0.25
        assert metallic.min() < 0.05 < 0.5 < metallic.max()


@pytest.mark.slow
def test_holes_of_a_perforated_sheet_have_their_share() -> None:
    """Circles of 5 mm, 8 mm apart: 20 columns of them, and 24 rows where 23.1 would be regular."""
    solid = FAMILIES["perforated_sheet"].make(order(0.16, 1024)).metallic
    assert np.mean(solid) == pytest.approx(1.0 - 20 * 24 * np.pi * 2.5**2 / 160**2, abs=5e-4)


def test_bare_metals_keep_their_reflectance() -> None:
    """Silver is brighter than any paint: what is stored is not cut where metal lies bare."""
    maps = FAMILIES["polished_metal"].make(order(0.3, 64, color=SILVER))
    stored = encoded(maps, 0.3).albedo[..., 0] / 255.0
    assert (((stored + 0.055) / 1.055) ** 2.4).mean() == pytest.approx(SILVER[0], abs=0.01)
    assert COPPER[0] > COPPER[1] > COPPER[2] and min(ALUMINIUM) > max(IRON)


@pytest.mark.parametrize("size", [0.9, 1.0, 1.8, 2.37])
def test_bricks_are_whole_and_their_joints_ten_millimetres(size: float) -> None:
    wall = bond(order(size, 1500), STANDARD, 0.5, 2)
    columns, rows = whole(size, STANDARD[0]), whole(size, STANDARD[1], 2)
    assert wall.count == columns * rows and rows % 2 == 0
    assert size / columns == pytest.approx(STANDARD[0], rel=0.15)
    assert size / rows == pytest.approx(STANDARD[1], rel=0.15)
    # Covered shares are exact whatever the resolution: edges are averaged over their texel.
    face = covered(order(size, 1500), wall.inside(JOINT))
    expected = (1 - JOINT * columns / size) * (1 - JOINT * rows / size)
    assert face.mean() == pytest.approx(expected, abs=2e-3)
    # Along the middle of a course there are as many joints as bricks.
    joints = wall.inside(JOINT)[1500 // rows // 2] < 0
    assert np.count_nonzero(joints & ~np.roll(joints, 1)) == columns


def test_courses_wrap_around() -> None:
    """No brick is cut in two by the seam: all have one area; courses shift by half a brick."""
    wall = bond(order(0.9, 720), STANDARD, 0.5, 2)
    assert np.ptp(np.bincount(wall.index.ravel(), minlength=wall.count)) == 0
    upper, lower = wall.across[30], wall.across[90]
    np.testing.assert_allclose(np.roll(upper, 720 // 4 // 2), lower, atol=1e-12)
    bonded = english_bond(order(0.9, 720))
    assert sorted(set(np.bincount(bonded.index.ravel()))) == [90 * 60, 180 * 60]


def test_random_courses_fill_the_side_within_their_ranges() -> None:
    wall = random_courses(order(2.0, 800), (0.15, 0.30), (0.3, 0.6))
    areas = np.bincount(wall.index.ravel(), minlength=wall.count) * (2.0 / 800) ** 2
    assert areas.min() > 0.5 * 0.15 * 0.3 and areas.max() < 2.0 * 0.3 * 0.6
    assert wall.side.min() > -1e-12 and wall.bed.min() > -1e-12


def test_cells_are_those_of_the_nearest_site() -> None:
    """By brute force over all sites and their copies around."""
    asked = order(1.0, 60, 5)
    cells = scattered_cells(asked, 0.2)
    place = (np.arange(60) + 0.5) / 60
    s, t = np.meshgrid(place, place)
    sites = {
        int(i): ((s - cells.across)[cells.index == i][0], (t + cells.up)[cells.index == i][0])
        for i in np.unique(cells.index)
    }
    assert len(sites) == cells.count == 25
    distance = np.full((2, 60, 60), np.inf)
    for at_s, at_t in sites.values():
        for shift_s in (-1, 0, 1):
            for shift_t in (-1, 0, 1):
                own = np.hypot(s - at_s % 1 + shift_s, t - at_t % 1 + shift_t)
                distance = np.sort([*distance, own], axis=0)[:2]
    np.testing.assert_allclose(cells.radius, distance[0], atol=1e-9)
    facet = (distance[1] ** 2 - distance[0] ** 2) / 2
    np.testing.assert_allclose(cells.facet, facet, atol=1e-9)


def test_hexagons_are_regular() -> None:
    cells = hexagons(order(1.0, 1000), 0.1)
    assert cells.count == 10 * 12
    areas = np.bincount(cells.index.ravel(), minlength=cells.count)
    assert areas.min() > 0.97 * areas.mean()
    assert cells.edge.max() == pytest.approx(0.05, rel=0.05)
    assert cells.radius.max() == pytest.approx(0.1 / np.sqrt(3), rel=0.04)
    # All six neighbours are as far as the rounded rows allow.
    assert cells.gap.min() == pytest.approx(np.hypot(0.05, 1 / 12))
    assert cells.gap.max() == pytest.approx(0.1)


def test_scales_cover_the_plane_and_overlap() -> None:
    laid = scales(order(1.0, 800), 0.1)
    assert laid.count == 10 * 20
    areas = np.bincount(laid.index.ravel(), minlength=laid.count)
    # A column of two rows a pitch high has two scales: each a square of half its width squared.
    np.testing.assert_allclose(areas, 800**2 / 200, rtol=0.06)
    assert laid.edge.min() >= 0.0 and laid.radius.max() < 0.1
    # Each is as wide to the left as to the right of its middle.
    lean = np.bincount(laid.index.ravel(), laid.across.ravel()) / areas
    np.testing.assert_allclose(lean, 0.0, atol=5e-4)


def test_strewn_things_cover_their_share_and_keep_apart() -> None:
    asked = order(1.0, 1024, 2)
    holes = pits(asked, 0.05, (0.004, 0.02))
    # Overlaps take some: 1 - exp(-share).
    assert covered(asked, holes.inside).mean() == pytest.approx(1 - np.exp(-0.05), rel=0.2)
    stones = chips(asked, 0.6, (0.01, 0.03))
    beside = np.roll(stones.index, 1, axis=1)
    border = stones.index != beside
    touching = border & (stones.index > 0) & (beside > 0)
    assert stones.index.max() > 100 and touching.sum() < 0.01 * border.sum()


def test_lines_have_their_length() -> None:
    """Their weights add up to the lengths, and straight ones do not leave their direction."""
    drawn = lines(order(1.0, 256, 1), 1, (0.25, 0.25), 0.0, (0.0, 0.0))
    assert np.count_nonzero(drawn.sum(axis=1)) <= 2
    assert np.count_nonzero(drawn.sum(axis=0)) == pytest.approx(64, abs=3)


def test_fractal_noise_falls_as_its_exponent_says() -> None:
    """Mean power of the band around f is f^-2(1 + H)."""
    field = np.mean(
        [np.abs(np.fft.fft2(fractal(order(1.0, 256, seed), 1.0, 0.5))) ** 2 for seed in range(8)],
        axis=0,
    )
    f = np.fft.fftfreq(256, 1 / 256)
    radius = np.hypot(f[:, None], f)
    power = [field[(radius > r) & (radius < 1.2 * r)].mean() for r in (20.0, 80.0)]
    assert np.log(power[0] / power[1]) / np.log(4.0) == pytest.approx(3.0, abs=0.15)


def test_displacement_reads_beside() -> None:
    """By whole texels it is a roll, along +s to the right and along +t upwards."""
    field = np.random.default_rng(0).random((32, 32))
    step = np.full((32, 32), 3.0 / 32)
    moved = displaced(field, order(1.0, 32), step, np.zeros_like(step))
    np.testing.assert_allclose(moved, np.roll(field, -3, axis=1), atol=1e-12)
    moved = displaced(field, order(1.0, 32), np.zeros_like(step), step)
    np.testing.assert_allclose(moved, np.roll(field, 3, axis=0), atol=1e-12)


@pytest.mark.parametrize("name", ["running_bond_brick", "subway_tiles", "penny_mosaic"])
def test_joints_lie_deeper_and_grout_is_rough(name: str) -> None:
    maps = FAMILIES[name].make(order(FAMILIES[name].size / 2, 512))
    low = maps.height < np.percentile(maps.height, 5)
    rougher = maps.roughness[low].mean() - maps.roughness[~low].mean()
    assert name == "running_bond_brick" or rougher > 0.2
    assert 0.5e-3 < np.percentile(maps.height, 99) - np.percentile(maps.height, 1) < 8e-3
