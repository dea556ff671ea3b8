"""Every family: it tiles, keeps to plausible values, and means metres whatever the resolution."""

from functools import cache

import numpy as np
import pytest

from openrooms_usd.library.textures import FAMILIES, TextureParams, TextureSet, make
from openrooms_usd.library.textures.wood.boards import blocks, chevron, herringbone, planks, staves

NAMES = [name for families in FAMILIES.values() for name in families]
KINDS = {name: kind for kind, families in FAMILIES.items() for name in families}
WEIGHTS = np.array([0.2126, 0.7152, 0.0722])
# Mean luminous reflectances that are plausible: soot and fresh lime are the ends.
REFLECTANCE = {
    "fabric": (0.02, 0.85),
    "leather": (0.02, 0.75),
    "metal": (0.03, 0.9),
    "paint": (0.02, 0.85),
    "plastic": (0.02, 0.85),
    "rough_stone": (0.04, 0.75),
    "rubber": (0.02, 0.7),
    "specular_stone": (0.02, 0.85),
    "wood": (0.03, 0.75),
}


@cache
def made(name: str, resolution: int = 128) -> TextureSet:
    return make(name, 0, resolution=resolution)


def linear(encoded_bytes: np.ndarray) -> np.ndarray:
    v = encoded_bytes / 255.0
    return np.where(v <= 0.04045, v / 12.92, ((v + 0.055) / 1.055) ** 2.4)


@pytest.mark.one_in(3, rest="long")
@pytest.mark.parametrize("name", NAMES)
def test_values_are_plausible(name: str) -> None:
    material = made(name)
    albedo = linear(material.albedo)
    low, high = REFLECTANCE[KINDS[name]]
    assert low <= float((albedo @ WEIGHTS).mean()) <= high
    # Metals may reflect a primary less than soot does; dielectrics are not blacker.
    assert albedo.min() >= 0.018
    assert albedo.max() <= (1.0 if KINDS[name] == "metal" else 0.91)
    assert 0.04 <= material.roughness.mean() / 255.0 <= 1.0
    vectors = material.normal / 255.0 * 2.0 - 1.0
    np.testing.assert_allclose(np.linalg.norm(vectors, axis=-1), 1.0, atol=0.02)
    # Periodic relief leans nowhere.
    np.testing.assert_allclose(vectors[..., :2].mean(axis=(0, 1)), 0.0, atol=0.03)


@pytest.mark.one_in(3, rest="long")
@pytest.mark.parametrize("name", NAMES)
def test_metalness_is_what_the_family_says(name: str) -> None:
    even = FAMILIES[KINDS[name]][name].metallic
    values = np.unique(made(name).metallic)
    if even is None:
        assert len(values) > 1
    else:
        assert values.tolist() == [round(255 * even)]
        assert (even > 0.0) == (KINDS[name] == "metal")


@pytest.mark.one_in(5, rest="long")
@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("picture", ["albedo", "normal", "roughness", "height"])
def test_it_tiles_without_a_seam(name: str, picture: str) -> None:
    """Steps across the seam are like those between neighbours elsewhere, in both directions."""
    pixels = getattr(made(name), picture).astype(float)
    for axis in (0, 1):
        steps = np.abs(np.diff(pixels, axis=axis, append=np.take(pixels, [0], axis=axis)))
        means = np.moveaxis(steps, axis, 0).reshape(pixels.shape[axis], -1).mean(axis=1)
        inside, seam = means[:-1], means[-1]
        assert seam <= inside.max() * 1.3 + 0.25, (axis, seam, inside.max())


@pytest.mark.one_in(4, rest="long")
@pytest.mark.parametrize("name", NAMES)
def test_a_finer_grid_shows_the_same_material(name: str) -> None:
    """What is drawn does not depend on the resolution: mean colour and roughness agree."""
    coarse, fine = make(name, 0, resolution=64), made(name)
    means = [linear(one.albedo).mean((0, 1)) for one in (coarse, fine)]
    np.testing.assert_allclose(means[0], means[1], rtol=0.2, atol=0.02)
    assert coarse.roughness.mean() / 255.0 == pytest.approx(fine.roughness.mean() / 255, abs=0.05)


@pytest.mark.one_in(4, rest="long")
@pytest.mark.parametrize("name", NAMES)
def test_the_smallest_resolution(name: str) -> None:
    material = make(name, 1, resolution=16, size=20.0 if "plank" in name else None)
    assert material.albedo.dtype == np.uint8 and material.roughness.shape == (16, 16)


def ordered(size: float, resolution: int = 512) -> TextureParams:
    return TextureParams(np.random.Generator(np.random.PCG64(5)), resolution, size)


@pytest.mark.parametrize("size", [1.0, 2.0, 3.3])
def test_pieces_keep_their_metres(size: float) -> None:
    """A larger picture has more pieces, not larger ones."""
    area = {
        "planks": planks(ordered(size), (0.15, 0.15), (0.9, 1.1)).count,
        "staves": staves(ordered(size), (0.1, 0.14)).count,
        "blocks": blocks(ordered(size), 0.12, 5).count,
        "herringbone": herringbone(ordered(size), 0.07, 5).count,
        "chevron": chevron(ordered(size), 0.4, 0.1).count,
    }
    expected = {
        "planks": size**2 / 0.15,
        "staves": size / 0.12,
        "blocks": size**2 / (0.12 * 0.024),
        "herringbone": size**2 / (0.07**2 * 5),
        "chevron": size**2 / (0.4 * 0.1),
    }
    for name, count in area.items():
        assert count == pytest.approx(expected[name], rel=0.35), name


@pytest.mark.parametrize("laid", ["herringbone", "chevron", "blocks", "planks"])
def test_pieces_wrap_around(laid: str) -> None:
    """Every piece covers the same area: none is cut by the seam into two or left over."""
    boards = {
        "herringbone": lambda: herringbone(ordered(1.4, 700), 0.07, 5),
        "chevron": lambda: chevron(ordered(1.6, 640), 0.4, 0.1),
        "blocks": lambda: blocks(ordered(1.2, 600), 0.12, 5),
        "planks": lambda: planks(ordered(2.0), (0.2, 0.2), (1.0, 1.0)),
    }[laid]()
    areas = np.bincount(boards.index.ravel(), minlength=boards.count)
    assert areas.min() > 0.9 * areas.mean() and areas.max() < 1.1 * areas.mean()
    # Across is measured from the middle: to both sides alike, at most half a width.
    assert abs(boards.across.mean()) < 0.02 * np.abs(boards.across).max()


def test_grain_runs_along_t() -> None:
    for name in ("ash_veneer", "zebrano", "bamboo_strips", "brushed_gloss", "hairline_plastic"):
        pixels = linear(made(name).albedo) @ WEIGHTS
        along_t, along_s = np.abs(np.diff(pixels, axis=0)).mean(), np.abs(np.diff(pixels)).mean()
        assert along_t < 0.6 * along_s, name


@pytest.mark.parametrize("name", ["herringbone_parquet", "chevron_parquet"])
def test_parquet_has_both_diagonals_alike(name: str) -> None:
    light = linear(made(name).albedo) @ WEIGHTS
    power = np.abs(np.fft.fft2(light - light.mean())) ** 2
    half = len(power) // 2
    rising, falling = power[1:half, 1:half].sum(), power[1:half, -1:-half:-1].sum()
    assert rising == pytest.approx(falling, rel=0.35)


def test_long_waves_are_those_of_the_finer_grid() -> None:
    """The same veins, boards and clouds, texel for texel, where the detail is resolved."""
    for name in ("limewash", "walnut_veneer", "linoleum", "herringbone_parquet", "flaking_paint"):
        coarse, fine = make(name, 3, resolution=128), make(name, 3, resolution=256)
        light = [(linear(one.albedo) @ WEIGHTS) for one in (coarse, fine)]
        halved = light[1].reshape(128, 2, 128, 2).mean(axis=(1, 3))
        assert np.corrcoef(light[0].ravel(), halved.ravel())[0, 1] > 0.7, name
