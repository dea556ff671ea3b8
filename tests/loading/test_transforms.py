"""Whatever is done to a view, what its channels say of each other stays true.

The arithmetic of the identities is written here again, by the definitions in
docs/reference/channels.md and docs/explanation/light.md, with numpy alone.
"""

from collections.abc import Callable
from dataclasses import fields, replace

import numpy as np
import pytest

from openrooms_usd.errors import InputError
from openrooms_usd.loading.resizing import Resize, area_mean
from openrooms_usd.loading.sample import Sample
from openrooms_usd.loading.transforms import (
    CentreCrop,
    Compose,
    Crop,
    Exposure,
    HorizontalFlip,
    Normalise,
    QuarterTurn,
    RandomCrop,
    Transform,
    flipped,
)

FLIP = HorizontalFlip(1.0)
CHAINS: dict[str, Transform] = {
    "nothing": Compose([]),
    "crop": Crop(8, 12, 24, 16),
    "random crop": RandomCrop(36, 28),
    "middle": CentreCrop(36, 28),
    "flip": FLIP,
    "half": Resize(24, 18),
    "odd": Resize(31, 23),
    "larger": Resize(100, 70),
    "crop, flip, resize": Compose([Crop(4, 0, 40, 32), FLIP, Resize(30, 24)]),
    "resize, flip, crop": Compose([Resize(24, 18), FLIP, RandomCrop(16, 12), Exposure(90, 0.8, 1)]),
    "flip, crop, flip": Compose([FLIP, Crop(4, 4, 36, 28), FLIP, Exposure()]),
}
# What hemispheres do not follow.
TURNED: dict[str, Transform] = {
    "turn": QuarterTurn(),
    "turn back": QuarterTurn(-1),
    "turn, flip": Compose([QuarterTurn(), FLIP]),
    "flip, crop, turn, resize": Compose([FLIP, Crop(3, 5, 30, 20), QuarterTurn(3), Resize(15, 22)]),
    "upside down, flip": Compose([QuarterTurn(2), FLIP, RandomCrop(17, 19)]),
}


def points(sample: Sample) -> np.ndarray:
    """(height, width, 3) of each pixel's ray, times its depth, in the world."""
    width, height = sample.size
    fx, fy, cx, cy = (sample.K[i] for i in ((0, 0), (1, 1), (0, 2), (1, 2)))
    u, v = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
    rays = np.stack([(u - cx) / fx, (v - cy) / fy, np.ones_like(u)], axis=-1)
    camera = rays * sample.images["depth"].astype(np.float64)
    return camera @ sample.world_from_camera[:3, :3].T + sample.world_from_camera[:3, 3]


def check_geometry(sample: Sample) -> None:
    """Sizes, the pose, points, distances, normals in both frames, normals of planes."""
    width, height = sample.size
    for name, pixels in {**sample.images, **sample.lights}.items():
        assert pixels.shape[-3:-1] == (height, width), name
    turn = sample.world_from_camera[:3, :3]
    np.testing.assert_allclose(turn.T @ turn, np.eye(3), atol=1e-12)
    assert np.linalg.det(turn) == pytest.approx(1.0)
    there = sample.images["depth"][..., 0] > 0
    # A part may hold nothing but walls, but not nothing.
    assert there.mean() > 0.2
    found, stored = points(sample), sample.images["position"]
    np.testing.assert_allclose(found[there], stored[there], atol=2e-5)
    assert (stored[~there] == 0).all()
    away = np.linalg.norm(found - sample.world_from_camera[:3, 3], axis=-1)
    np.testing.assert_allclose(away[there], sample.images["distance"][there, 0], rtol=1e-5)
    normals = sample.images["normal"].astype(np.float64)
    opengl = normals @ turn * [1.0, -1.0, -1.0]
    np.testing.assert_allclose(opengl, sample.images["normal_camera"], atol=3e-3)
    lengths = np.linalg.norm(normals, axis=-1)[there]
    np.testing.assert_allclose(lengths, 1.0, atol=2e-3)
    check_planes(sample)


def check_planes(sample: Sample) -> None:
    """Right times down, of neighbours on one plane, points away from the camera's side."""
    near, plane = sample.images["position"].astype(np.float64), sample.images["normal_geometric"]
    right, down = near[:-1, 1:] - near[:-1, :-1], near[1:, :-1] - near[:-1, :-1]
    normal = -np.cross(right, down)
    length = np.linalg.norm(normal, axis=-1)
    same = (plane[:-1, :-1] != 0).any(axis=-1)
    for other in (plane[:-1, 1:], plane[1:, :-1]):
        same &= np.abs(other - plane[:-1, :-1]).max(axis=-1) < 1e-3
    instance = sample.images["instance"][..., 0]
    same &= (instance[:-1, :-1] == instance[:-1, 1:]) & (instance[:-1, :-1] == instance[1:, :-1])
    # Of two parallel planes of one thing, one lies behind the other.
    flat = [np.abs((step * plane[:-1, :-1]).sum(-1)) < 0.02 for step in (right, down)]
    same &= flat[0] & flat[1] & (length > 0)
    assert same.mean() > 0.15
    off = np.abs(normal[same] / length[same, None] - plane[:-1, :-1][same])
    # Halves of unit length, points in float32, and what is left of steps from plane to plane.
    assert np.quantile(off.max(axis=-1), 0.9) < 3e-3


def check_light(sample: Sample) -> None:
    """Lights sum to the whole, and shares stay shares."""
    whole = sample.images["radiance"]
    np.testing.assert_allclose(
        sample.lights["radiance_i"].sum(axis=0), whole, rtol=1e-4, atol=1e-4 * whole.max()
    )
    share = sample.lights["visibility_i"]
    assert share.min() >= 0.0 and share.max() <= 1.0 + 1e-5
    np.testing.assert_allclose(
        share * sample.lights["unoccluded_i"],
        sample.lights["direct_i"],
        rtol=2e-3,
        atol=1e-4 * sample.lights["direct_i"].max(),
    )


@pytest.mark.parametrize("chain", CHAINS)
def test_identities_hold_after_any_chain(
    chain: str, sample: Sample, rng: np.random.Generator
) -> None:
    changed = CHAINS[chain](sample, rng)
    check_geometry(changed)
    check_light(changed)


@pytest.mark.parametrize("chain", TURNED)
def test_identities_hold_when_the_camera_rolls(
    chain: str, sample: Sample, rng: np.random.Generator
) -> None:
    changed = TURNED[chain](replace(sample, grids={}), rng)
    check_geometry(changed)
    check_light(changed)


def irradiance(hemisphere: np.ndarray, normal: np.ndarray, pose: np.ndarray, about: np.ndarray):
    """Of one hemisphere, about any direction of the world: cosines times solid angles."""
    up = -pose[:3, 1]
    y = up - (up @ normal) * normal
    y /= np.linalg.norm(y)
    x = np.cross(normal, y)
    total = np.zeros(3)
    for row in range(16):
        theta = (row + 0.5) / 16 * np.pi / 2
        angle = (np.cos(row * np.pi / 32) - np.cos((row + 1) * np.pi / 32)) * 2 * np.pi / 32
        for column in range(32):
            phi = ((column + 0.5) / 32 - 0.5) * 2 * np.pi
            towards = (
                np.sin(theta) * np.cos(phi) * x
                + np.sin(theta) * np.sin(phi) * y
                + np.cos(theta) * normal
            )
            total += hemisphere[row, column] * max(0.0, towards @ about) * angle
    return total


def test_hemispheres_send_the_same_light_from_the_same_place(sample: Sample) -> None:
    """About the normal, and about directions that tell one azimuth from another."""
    mirror = np.array([-1.0, 1.0, 1.0])
    part = Crop(8, 12, 24, 16)(sample, np.random.default_rng(0))
    other = flipped(part)
    grid, turned = part.grids["environment"], other.grids["environment"]
    assert grid.shape == turned.shape == (4, 6, 16, 32, 3)
    for row, column in ((0, 0), (2, 1), (3, 5)):
        here = sample.grids["environment"][row + 3, column + 2]
        assert (here == grid[row, column]).all()
        normal = sample.images["normal"][4 * (row + 3) + 2, 4 * (column + 2) + 2].astype(float)
        there = part.images["normal"][4 * row + 2, 4 * column + 2]
        back = other.images["normal"][4 * row + 2, 24 - 1 - (4 * column + 2)]
        np.testing.assert_array_equal(normal.astype(np.float32), there)
        np.testing.assert_array_equal(there * mirror, back)
        normal /= np.linalg.norm(normal)
        for about in (normal, np.array([0.6, 0.0, 0.8]), np.array([-0.48, 0.6, 0.64])):
            before = irradiance(here, normal, sample.world_from_camera, about)
            after = irradiance(
                turned[row, 5 - column], normal * mirror, other.world_from_camera, about * mirror
            )
            assert before.max() > 0
            np.testing.assert_allclose(after, before, rtol=1e-5)


def same(a: Sample, b: Sample) -> bool:
    def bits(value: object) -> object:
        if isinstance(value, np.ndarray):
            return value.dtype, value.shape, value.tobytes()
        if isinstance(value, dict):
            return {key: bits(inner) for key, inner in value.items()}
        return value

    return all(bits(getattr(a, f.name)) == bits(getattr(b, f.name)) for f in fields(Sample))


def test_twice_is_the_same_bit_for_bit(sample: Sample) -> None:
    once = flipped(sample)
    assert once.mirrored and not same(once, sample)
    assert same(flipped(once), sample)
    four = replace(sample, grids={})
    assert same(QuarterTurn(4)(four, np.random.default_rng(0)), four)
    around = four
    for _ in range(4):
        around = QuarterTurn()(around, np.random.default_rng(0))
    assert around.size == four.size
    for name, pixels in four.images.items():
        np.testing.assert_array_equal(around.images[name], pixels)
    np.testing.assert_array_equal(around.world_from_camera, four.world_from_camera)


def test_boxes_of_lights_are_mirrored_with_the_room(sample: Sample) -> None:
    other = flipped(sample)
    corners = np.array([[x, y, z, 2.0] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) / 2

    def box(s: Sample, light: int) -> np.ndarray:
        size = np.append(s.box_size[light], 1.0)
        found = (s.world_from_box[light] @ (corners * size).T).T[:, :3]
        return found[np.lexsort(found.T)]

    for light in range(len(sample.light_numbers)):
        mirrored = box(sample, light) * [-1.0, 1.0, 1.0]
        expected = mirrored[np.lexsort(mirrored.T)]
        np.testing.assert_allclose(box(other, light), expected, atol=1e-9)
        turn = sample.world_from_box[light, :3, :3], other.world_from_box[light, :3, :3]
        assert np.linalg.det(turn[0]) == pytest.approx(np.linalg.det(turn[1]))


@pytest.mark.parametrize("factor", [2, 3])
def test_a_resized_view_is_the_view_that_a_renderer_gives(
    factor: int, sample: Sample, finer: Callable[[int, int], Sample], rng: np.random.Generator
) -> None:
    """Depth is that of the new rays where they meet the same plane, not of pixels beside them."""
    fine = finer(48 * factor, 36 * factor)
    small = Resize(48, 36)(fine, rng)
    np.testing.assert_allclose(small.K, sample.K, rtol=1e-12)
    plane = small.images["normal_geometric"], sample.images["normal_geometric"]
    met = (np.abs(plane[0] - plane[1]).max(axis=-1) < 1e-3) & (
        small.images["instance"] == sample.images["instance"]
    )[..., 0]
    assert met.mean() > 0.8
    off = np.abs(small.images["depth"] - sample.images["depth"])[met]
    # The same plane in nearly all of them; the rest are parallel faces of one thing.
    assert np.quantile(off, 0.97) < 1e-4
    # Every depth is near one that was rendered: none lies between a thing and the wall behind it.
    nearest = fine.images["depth"][factor // 2 :: factor, factor // 2 :: factor]
    assert (np.abs(small.images["depth"] - nearest) <= 0.11 * nearest).all()


def test_means_are_over_areas() -> None:
    ramp = np.arange(12, dtype=np.float32).reshape(1, 12, 1)
    np.testing.assert_allclose(area_mean(ramp, 3, -2)[0, :, 0], [1.5, 5.5, 9.5])
    # 12 into 5: edges at 2.4, 4.8, 7.2 and 9.6.
    first = (0 + 1 + 0.4 * 2) / 2.4
    np.testing.assert_allclose(area_mean(ramp, 5, -2)[0, 0, 0], first, rtol=1e-6)
    wide = area_mean(ramp, 30, -2)[0, :, 0]
    np.testing.assert_allclose(wide.mean(), 5.5, rtol=1e-6)
    assert wide[0] == 0 and wide[1] == 0


def test_labels_stay_labels_and_shares_are_asked_for(
    sample: Sample, rng: np.random.Generator
) -> None:
    small = Resize(31, 23, averaged=("base_color",))(sample, rng)
    for name in ("semantic", "instance"):
        assert small.images[name].dtype == np.int64
        assert set(np.unique(small.images[name])) <= set(np.unique(sample.images[name]))
    assert set(np.unique(small.lights["mask_i"])) <= {0.0, 1.0}
    nearest = Resize(31, 23)(sample, rng)
    assert (nearest.images["base_color"] != small.images["base_color"]).any()
    np.testing.assert_allclose(
        small.images["base_color"].mean(), sample.images["base_color"].mean(), rtol=1e-5
    )
    with pytest.raises(InputError, match="'depth' have no mean"):
        Resize(31, 23, averaged=("depth",))(sample, rng)


def test_exposure_scales_all_light_alike(sample: Sample, rng: np.random.Generator) -> None:
    bright = Exposure(95, 0.9)(sample, rng)
    assert np.percentile(bright.images["radiance"], 95) == pytest.approx(0.9, rel=1e-5)
    for name in ("irradiance", "radiance"):
        ratio = bright.images[name].sum() / sample.images[name].sum()
        assert ratio == pytest.approx(bright.light_scale, rel=1e-4)
    np.testing.assert_allclose(
        bright.grids["environment"], sample.grids["environment"] * bright.light_scale, rtol=1e-5
    )
    np.testing.assert_array_equal(bright.lights["visibility_i"], sample.lights["visibility_i"])
    drawn = [Exposure(stops=1.0)(sample, rng).light_scale / bright.light_scale for _ in range(20)]
    assert 0.5 <= min(drawn) < 0.8 and 1.25 < max(drawn) <= 2.0
    black = replace(sample, images={"radiance": np.zeros((36, 48, 3), np.float32)})
    assert Exposure()(black, rng).light_scale == 1.0


def test_normalise_centres(sample: Sample, rng: np.random.Generator) -> None:
    color = sample.images["base_color"].reshape(-1, 3)
    statistics = {"base_color": (color.mean(0).tolist(), color.std(0).tolist())}
    found = Normalise(statistics)(sample, rng).images["base_color"].reshape(-1, 3)
    np.testing.assert_allclose(found.mean(0), 0.0, atol=1e-4)
    np.testing.assert_allclose(found.std(0), 1.0, rtol=1e-3)


def test_channels_that_are_not_there_are_told(sample: Sample, rng: np.random.Generator) -> None:
    with pytest.raises(InputError, match="no 'base_colour' to normalise"):
        Normalise({"base_colour": ([0.5], [1.0])})(sample, rng)
    with pytest.raises(InputError, match="'base_colour' have no mean"):
        Resize(31, 23, averaged=("base_colour",))(sample, rng)


def test_parts_keep_to_the_cells_of_hemispheres(sample: Sample) -> None:
    with pytest.raises(InputError, match="cuts through cells"):
        Crop(2, 0, 24, 16)(sample, np.random.default_rng(0))
    with pytest.raises(InputError, match="is not in a picture of 48x36"):
        Crop(30, 0, 24, 16)(sample, np.random.default_rng(0))
    with pytest.raises(InputError, match="hangs on the camera's up"):
        QuarterTurn()(sample, np.random.default_rng(0))
    seen = set()
    for seed in range(40):
        part = RandomCrop(16, 12)(sample, np.random.default_rng(seed))
        left, top = (sample.K - part.K)[:2, 2]
        seen.add((left, top))
        assert part.grids["environment"].shape[:2] == (3, 4)
    assert {left for left, _ in seen} == {0, 4, 8, 12, 16, 20, 24, 28, 32}
    assert max(top for _, top in seen) == 24


def planted(sample: Sample, what: str) -> Sample:
    """A mirrored view in which one thing was forgotten."""
    right = flipped(sample)
    if what in ("K", "world_from_camera"):
        wrong = sample.K + np.array([[0, 0, 0.5], [0, 0, 0], [0, 0, 0]])
        return replace(right, **{what: wrong if what == "K" else sample.world_from_camera})
    if what == "visibility_i":
        return replace(right, lights={**right.lights, what: sample.lights[what]})
    return replace(right, images={**right.images, what: sample.images[what][:, ::-1]})


@pytest.mark.parametrize(
    "what", ["K", "world_from_camera", "position", "normal", "normal_camera", "visibility_i"]
)
def test_what_is_forgotten_is_found(what: str, sample: Sample) -> None:
    with pytest.raises(AssertionError):
        wrong = planted(sample, what)
        check_geometry(wrong)
        check_light(wrong)


@pytest.mark.parametrize("chain", [FLIP, QuarterTurn(), QuarterTurn(3), Resize(24, 18)])
def test_motion_leads_to_where_the_point_is_in_the_next_frame(
    chain: Transform, sample: Sample, rng: np.random.Generator
) -> None:
    """The flow to a camera that has moved, by its definition, of both pictures changed alike."""
    step = np.eye(4)
    step[:3, 3] = (0.1, -0.05, 0.2)
    after = replace(sample, world_from_camera=sample.world_from_camera @ step, grids={})

    def flow(now: Sample, then: Sample) -> np.ndarray:
        camera = np.linalg.inv(then.world_from_camera)
        seen = now.images["position"].astype(float) @ camera[:3, :3].T + camera[:3, 3]
        place = seen @ then.K.T
        width, height = now.size
        u, v = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
        return place[..., :2] / place[..., 2:] - np.stack([u, v], axis=-1)

    images = {**sample.images, "flow": flow(sample, after).astype(np.float32)}
    now, then = (chain(one, rng) for one in (replace(sample, images=images, grids={}), after))
    there = (now.images["depth"] > 0)[..., 0]
    off = np.abs(now.images["flow"] - flow(now, then))[there]
    # A resized pixel has the flow of the nearest one.
    assert np.quantile(off, 0.95) < (0.1 if isinstance(chain, Resize) else 1e-3)
