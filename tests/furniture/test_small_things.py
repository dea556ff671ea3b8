"""Screens, keyboards, lids, pots and pictures: what is special to each."""

import numpy as np
import pytest

from openrooms_usd.furniture import CATEGORIES, make, part_of
from openrooms_usd.furniture.joinery.posing import at_rest, facing, oval, tapered, turned
from openrooms_usd.geometry.rotations import about_y
from openrooms_usd.geometry.solids import box
from tests.furniture.pieces import caster, made, parts_of


@pytest.mark.parametrize(
    ("name", "style"),
    [(name, style) for name in ("monitor", "television") for style in CATEGORIES[name].styles],
)
def test_screens_face_the_front(name: str, style: str) -> None:
    """Rays from the front meet the screen first over most of the picture."""
    furniture = made(name, style)
    (screen,) = parts_of(furniture.parts, "screen").values()
    low, high = screen.extent
    grid = np.stack(np.meshgrid(*[np.linspace(0.06, 0.94, 9)] * 2), axis=-1).reshape(-1, 2)
    origins = np.insert(low[[0, 2]] + grid * (high - low)[[0, 2]], 1, -5.0, axis=1)
    ahead = np.tile([0.0, 1.0, 0.0], (len(origins), 1))
    others = [mesh for mesh in furniture.parts.values() if mesh is not screen]
    distance = caster(screen).first_hit(origins, ahead).distance
    assert np.isfinite(distance).all()
    assert (distance < caster(*others).first_hit(origins, ahead).distance).mean() > 0.99
    size = (CATEGORIES[name].styles[style].size or CATEGORIES[name].size)[0]
    assert high[0] - low[0] > 0.8 * size


@pytest.mark.parametrize("style", CATEGORIES["laptop"].styles)
def test_laptops_show_screen_and_keys(style: str) -> None:
    furniture = made("laptop", style)
    (screen,) = parts_of(furniture.parts, "screen").values()
    normals = screen.normals[np.argsort(-np.repeat(screen.areas(), screen.counts))[:4]]
    assert abs(normals[:, 1]).min() > 0.7
    assert len(parts_of(furniture.parts, "key")) == 6
    assert (
        max(mesh.extent[1, 2] for mesh in parts_of(furniture.parts, "key").values())
        < screen.extent[1, 2]
    )


@pytest.mark.parametrize("style", ["slim", "classic"])
def test_a_laptop_shuts(style: str) -> None:
    """At the end of its hinge the lid lies on the base and within its outline."""
    furniture = made("laptop", style)
    (joint,) = furniture.joints
    lid = furniture.parts["lid"]
    shut = turned(lid, "x", joint.limits[1], joint.origin)
    base = furniture.parts["base"].extent
    assert shut.extent[0, 1] == pytest.approx(base[0, 1], abs=0.012)
    assert base[1, 2] - 0.002 < shut.extent[0, 2] < base[1, 2] + 0.012
    assert shut.extent[1, 2] < base[1, 2] + 0.02


@pytest.mark.parametrize("style", CATEGORIES["keyboard"].styles)
def test_keys_are_apart_and_light(style: str) -> None:
    rows = parts_of(made("keyboard", style).parts, "key").values()
    keys = sum(len(mesh.points) // 8 for mesh in rows)
    assert 50 < keys < 120
    assert sum(int((mesh.counts - 2).sum()) for mesh in rows) == 12 * keys
    for mesh in rows:
        boxes = mesh.points.reshape(-1, 8, 3)
        low, high = boxes.min(axis=1), boxes.max(axis=1)
        i, j = np.triu_indices(len(low), 1)
        apart = np.maximum(low[i] - high[j], low[j] - high[i])[:, :2].max(axis=1)
        # Halves that are turned have boxes that overlap a little.
        assert apart.min() > (-0.006 if style == "split" else 0.0)


@pytest.mark.parametrize("name", ["trash_bin", "basket", "jar", "bowl"])
def test_vessels_are_hollow(name: str) -> None:
    """A ray down their middle, lids aside, goes deep before it meets a bottom."""
    for style in CATEGORIES[name].styles:
        furniture = made(name, style)
        lids = {"lid", "handle", "frame", "fruit", "label", "seal"}
        meshes = [m for n, m in furniture.parts.items() if part_of(n) not in lids]
        top = max(mesh.extent[1, 2] for mesh in meshes)
        hit = caster(*meshes).first_hit(np.array([[0.003, 0.002, top + 1]]), -np.eye(3)[2:])
        depth = float(hit.distance[0]) - 1.0
        assert depth > (0.4 if (name, style) == ("bowl", "footed") else 0.7) * top, style


@pytest.mark.parametrize("style", CATEGORIES["plant_pot"].styles)
def test_plants_grow_out_of_their_pot(style: str) -> None:
    furniture = made("plant_pot", style)
    pot, soil = furniture.parts["pot"].extent, furniture.parts["soil"].extent
    green = [furniture.parts[name] for name in ("leaf", "stem", "plant") if name in furniture.parts]
    low = min(mesh.extent[0, 2] for mesh in green)
    # Fronds and trails hang down beside their pot.
    hangs = style in ("fern", "ivy")
    assert (-1e-9 if hangs else soil[0, 2] - 0.05) < low < pot[1, 2]
    assert pot[0, 2] == pytest.approx(0)
    assert soil[1, 2] < pot[1, 2]
    assert (soil[1, :2] < pot[1, :2]).all()
    # Leaves differ: no two plants are alike, but each repeats from its seed.
    other = made("plant_pot", style, 1).parts
    assert {n: len(m.points) for n, m in other.items()} != {
        n: len(m.points) for n, m in furniture.parts.items()
    } or not np.allclose(other["pot"].points, furniture.parts["pot"].points)


@pytest.mark.parametrize("style", CATEGORIES["clock"].styles)
def test_clocks_can_be_read(style: str) -> None:
    furniture = made("clock", style)
    hand = furniture.parts["hand"].extent
    for name in ("frame", "face", "number"):
        if name in furniture.parts and (name, style) not in (
            ("frame", "round"),
            ("frame", "sunburst"),
        ):
            assert hand[0, 1] < furniture.parts[name].extent[0, 1]
    twelve = (furniture.parts["number"].extent[1] - furniture.parts["number"].extent[0])[[0, 2]]
    assert twelve[0] == pytest.approx(twelve[1], rel=0.05)


@pytest.mark.parametrize("name", ["picture", "whiteboard", "clock", "wall_lamp"])
def test_wall_things_touch_the_wall(name: str) -> None:
    """A part of some size lies in the plane of the back."""
    spec = CATEGORIES[name]
    for style, how in spec.styles.items():
        size = how.size or spec.size
        if style in ("mantel", "mobile"):
            continue
        furniture = make(name, size, style, np.random.default_rng(0))
        points = np.concatenate([mesh.points for mesh in furniture.parts.values()])
        flush = points[points[:, 1] > 0.5 * size[1] - 1e-6]
        assert len(flush) >= 3, style
        assert np.ptp(flush[:, 0]) > 0.03, style
        assert np.ptp(flush[:, 2]) > 0.03, style


@pytest.mark.parametrize("style", CATEGORIES["picture"].styles)
def test_colours_lie_on_their_picture(style: str) -> None:
    """Fields and accents stand out by the thickness of paint, within the canvas."""
    for seed in range(4):
        furniture = made("picture", style, seed)
        (canvas,) = parts_of(furniture.parts, "canvas").values()
        low, high = canvas.extent
        for mesh in parts_of(furniture.parts, "field", "accent").values():
            a, b = mesh.extent
            assert (a[[0, 2]] > low[[0, 2]] - 1e-3).all()
            assert (b[[0, 2]] < high[[0, 2]] + 1e-3).all()
            assert 0 < low[1] - a[1] < 0.002


def test_turning() -> None:
    bar = made("keyboard", "slim").parts["frame"]
    back = turned(turned(bar, "y", 30.0, (1, 2, 3)), "y", -30.0, (1, 2, 3))
    np.testing.assert_allclose(back.points, bar.points, atol=1e-12)
    quarter = turned(bar, "z", 90.0)
    np.testing.assert_allclose(quarter.points[:, 1], bar.points[:, 0], atol=1e-12)
    assert turned(bar, "x", 90.0).volume() == pytest.approx(bar.volume())
    np.testing.assert_allclose(facing(bar, (0, 0, 1)).extent[0, 1], -bar.extent[1, 2])


def test_tapering_and_ovals() -> None:
    pot = made("bowl", "round").parts["container"]
    half = tapered(pot, "z", (0.5, 1.0))
    top = pot.points[:, 2] > pot.extent[1, 2] - 1e-9
    np.testing.assert_allclose(half.points[top, 0], 0.5 * pot.points[top, 0], atol=1e-9)
    np.testing.assert_allclose(half.points[top, 1], pot.points[top, 1], atol=1e-9)
    wide = oval(pot, (2.0, 1.0, 1.0))
    np.testing.assert_allclose(wide.points[:, 0], 2 * pot.points[:, 0])
    np.testing.assert_allclose(wide.points[:, 1], pot.points[:, 1])


@pytest.mark.parametrize("seed", range(6))
def test_rolled_napkins_lie_on_their_ends_not_on_their_rings(seed: int) -> None:
    parts = make("napkin", (0.2, 0.045, 0.045), "ringed", np.random.default_rng(seed)).parts
    cloth, ring = parts["cloth"], parts["ring"]
    flat = cloth.points[cloth.points[:, 2] < 2e-4]
    assert ring.extent[0, 2] > 0.001
    assert np.ptp(flat[:, 0]) > 0.19 and flat[:, 1].min() < -0.001 and flat[:, 1].max() > 0.0
    # The ring is around the cloth there.
    inner = np.abs(cloth.points[:, 0]) < 0.0121
    assert np.abs(cloth.points[inner, 1]).max() < np.abs(ring.points[:, 1]).max()


def test_what_lies_is_turned_until_it_lies_still() -> None:
    """A slab of 3 by 1 by 1 that stands on an edge lies down on the nearest side."""
    slab = box((0.3, 0.1, 0.1)).transformed(about_y(np.radians(30.0)))
    lying = at_rest({"slab": slab}, (0.3, 0.1, 0.1))["slab"]
    height = lying.points[:, 2] - lying.points[:, 2].min()
    assert sorted(np.round(height, 6)) == [0.0] * 4 + [0.1] * 4
    assert at_rest({"slab": lying}, (0.3, 0.1, 0.1))["slab"] is lying
