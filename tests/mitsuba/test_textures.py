"""Textures: where a pixel of the picture lands, and that all who look it up agree."""

import math
from itertools import product

import numpy as np
import pytest
from pxr import Gf

from openrooms_usd.usd.shading.surfaces import NORMAL_BIAS, NORMAL_SCALE, Texture
from tests import small
from tests.pictures import save_picture
from tests.small import square

SIDE = 8
# The quad spans 2 by 2 metres: its st run from 0 to 1 and beyond where a test says so.
QUAD = square((0, 0, 0), 1)


def speckled(seed=1, high=255):
    return np.random.default_rng(seed).integers(0, high, (SIDE, SIDE, 3)).astype(np.uint8)


def from_above(texture, *, role="base_color", st_scale=1.0, **inputs):
    """A textured quad that fills a square picture, seen from straight above, +Y up."""
    made = small.Stage()
    material = made.material("/Paper", **{role: texture}, **inputs)
    st = np.array([(0, 0), (1, 0), (1, 1), (0, 1)]) * st_scale
    made.mesh("/Quad", QUAD, [[0, 1, 2, 3]], st=st, material=material)
    distance = 10.0
    fov = math.degrees(2 * math.atan(1 / distance))
    made.camera((0, 0, distance), (0, 0, 0), up=(0, 1, 0), fov=fov, aspect=1.0)
    return made


def linear(encoded):
    value = encoded / 255.0
    return np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)


def test_the_top_row_of_the_picture_is_at_t_one(shoot, tmp_path):
    pixels = speckled()
    file = save_picture(tmp_path / "paper.png", pixels)
    made = from_above(Texture(file, color_space="sRGB"))
    # As many pixels as texels: every pixel's centre is a texel's centre.
    seen = shoot(made.stage, "base_color", width=SIDE, height=SIDE).images["base_color"].pixels
    assert np.abs(seen - linear(pixels)).max() < 1e-3


ALONG = {"repeat": "wrap", "mirror": "symmetric", "clamp": "edge", "black": "constant"}


def beyond(pixels, wraps):
    """(3 H, 3 W, C) the picture and what lies around it."""
    sides = ((0, 0), (SIDE, SIDE), (0, 0)), ((SIDE, SIDE), (0, 0), (0, 0))
    expected = pixels / 255.0
    for wrap, side in zip(wraps, sides, strict=True):
        expected = np.pad(expected, side, mode=ALONG[wrap])
    return expected


@pytest.mark.parametrize("wraps", list(product(ALONG, ALONG)))
def test_wrap_modes_beyond_the_picture(shoot, tmp_path, wraps):
    pixels = speckled()
    file, size = save_picture(tmp_path / "paper.png", pixels), 3 * SIDE
    texture = Texture(file, wrap_s=wraps[0], wrap_t=wraps[1], uv_translation=(-1.0, -1.0))
    made = from_above(texture, st_scale=3.0)
    seen = shoot(made.stage, "base_color", width=size, height=size).images["base_color"].pixels
    assert np.abs(seen - beyond(pixels, wraps)).max() < 1e-3


@pytest.mark.parametrize("wraps", [("repeat", "clamp"), ("black", "mirror")])
@pytest.mark.parametrize("relief", [False, True])
def test_light_sees_wraps_that_differ(shoot, tmp_path, wraps, relief):
    """Of surfaces of the table, and by a texture of its own."""
    pixels = speckled()
    file, size = save_picture(tmp_path / "paper.png", pixels), 3 * SIDE
    texture = Texture(file, wrap_s=wraps[0], wrap_t=wraps[1], uv_translation=(-1.0, -1.0))
    made = from_above(texture, st_scale=3.0, **({"normal": (1e-4, 0.0, 1.0)} if relief else {}))
    made.dome()
    seen = shoot(made.stage, "radiance", width=size, height=size, samples=64).images["radiance"]
    # What lies between the centres of texels is linear, and pixels are means.
    expected = beyond(pixels, wraps)
    for axis in (0, 1):
        around = np.roll(expected, 1, axis) + np.roll(expected, -1, axis)
        expected = 0.75 * expected + 0.125 * around
    assert np.abs(seen.pixels - expected)[1:-1, 1:-1].mean() < 0.03


def test_transform_scales_then_turns_then_moves(shoot, tmp_path):
    pixels = speckled()
    file = save_picture(tmp_path / "paper.png", pixels)
    texture = Texture(file, uv_scale=(2.0, 0.5), uv_rotation=90.0, uv_translation=(0.25, 0.125))
    made = from_above(texture)
    size = 2 * SIDE
    seen = shoot(made.stage, "base_color", width=size, height=size).images["base_color"].pixels
    for row in range(size):
        for column in range(size):
            s, t = (column + 0.5) / size, 1 - (row + 0.5) / size
            # Scaled, turned by 90 degrees counter-clockwise, moved; then bilinear by hand.
            u, v = -0.5 * t + 0.25, 2.0 * s + 0.125
            x, y = u * SIDE - 0.5, (1 - v) * SIDE - 0.5
            i, j = math.floor(x), math.floor(y)
            value = sum(
                pixels[(j + dj) % SIDE, (i + di) % SIDE]
                / 255.0
                * abs(1 - di - (x - i))
                * abs(1 - dj - (y - j))
                for di in (0, 1)
                for dj in (0, 1)
            )
            assert np.abs(seen[row, column] - value).max() < 1e-3


def test_scale_bias_and_single_channels(shoot, tmp_path):
    pixels = speckled()
    file = save_picture(tmp_path / "paper.png", pixels)
    texture = Texture(file, channel="g", scale=(1, 0.5, 1, 1), bias=(0, 0.25, 0, 0))
    made = from_above(texture, role="roughness", base_color=Texture(file))
    images = shoot(made.stage, "roughness", "base_color", width=SIDE, height=SIDE).images
    assert np.abs(images["roughness"].pixels[..., 0] - (pixels[..., 1] / 510.0 + 0.25)).max() < 1e-3
    assert np.abs(images["base_color"].pixels - pixels / 255.0).max() < 1e-3


def test_materials_that_share_a_picture_show_it_each_in_its_way(shoot, tmp_path):
    """One of half the radiance, one mirrored along s."""
    pixels = speckled()
    file = save_picture(tmp_path / "lamp.png", pixels)
    st = np.array([(0, 0), (1, 0), (1, 1), (0, 1)])
    ways = {"scale": (0.5, 0.5, 0.5, 1.0)}, {"uv_scale": (-1.0, 1.0)}
    shown = []
    for chosen in (ways[:1], ways[1:], ways):
        made = small.Stage()
        for number, way in enumerate(chosen):
            material = made.material(f"/Glow{number}", emissive=Texture(file, **way))
            moved = [(x, y, 1e-3 * number) for x, y, _ in QUAD]
            made.mesh(f"/Quad{number}", moved, [[0, 1, 2, 3]], st=st, material=material)
        fov = math.degrees(2 * math.atan(1 / 10))
        made.camera((0, 0, 10), (0, 0, 0), up=(0, 1, 0), fov=fov, aspect=1.0)
        seen = shoot(made.stage, "radiance", width=SIDE, height=SIDE, samples=4)
        shown.append(seen.images["radiance"].pixels)
    assert np.abs(shown[1] - shown[2]).max() < 0.02
    assert np.abs(shown[0] - shown[1]).max() > 0.1


def test_textures_of_one_material_may_be_placed_differently(shoot, tmp_path):
    pixels = speckled()
    file = save_picture(tmp_path / "paper.png", pixels)
    turned = Texture(file, uv_scale=(2.0, 0.5), uv_rotation=30.0, uv_translation=(0.4, 0.1))
    upright = Texture(file, channel="b")
    made = from_above(upright, role="roughness", base_color=turned)
    images = shoot(made.stage, "roughness", "base_color", width=SIDE, height=SIDE).images
    assert np.abs(images["roughness"].pixels[..., 0] - pixels[..., 2] / 255.0).max() < 1.1e-2
    assert images["base_color"].pixels.std() > 0.05


@pytest.mark.one_in(2)
@pytest.mark.parametrize("wrap", ["repeat", "mirror", "clamp"])
def test_the_renderer_sees_the_colours_that_the_channel_says(shoot, tmp_path, wrap):
    file = save_picture(tmp_path / "paper.png", speckled())
    how = {"wrap_s": wrap, "wrap_t": wrap, "uv_rotation": 30.0, "uv_translation": (0.3, -0.2)}
    made = from_above(Texture(file, color_space="sRGB", **how), st_scale=2.5)
    made.dome(radiance=10.0)
    size = {"width": 64, "height": 64}
    color = shoot(made.stage, "base_color", **size).images["base_color"].pixels
    # A plane under a constant sky receives pi L: its radiance is its colour times L. Pixels are
    # averaged there and not here, so neighbours are compared in sums.
    light = shoot(made.stage, "radiance", samples=64, bounces=1, **size).images["radiance"].pixels
    assert np.corrcoef(color.ravel(), light.ravel())[0, 1] > 0.99
    assert np.abs(light.mean(axis=(0, 1)) / 10 - color.mean(axis=(0, 1))).max() < 0.01


def relief():
    """Two tilted halves: left leans along +u, right along +v."""
    left, right = np.array([0.5, 0.0, 0.8660254]), np.array([0.0, 0.6, 0.8])
    normals = np.where(np.arange(SIDE)[None, :, None] < SIDE / 2, left, right)
    return np.round((np.broadcast_to(normals, (SIDE, SIDE, 3)) + 1) / 2 * 255).astype(np.uint8)


@pytest.mark.parametrize("rotation", [0.0, 90.0])
def test_normal_maps_tilt_along_u_and_v(shoot, tmp_path, rotation):
    file = save_picture(tmp_path / "relief.png", relief())
    texture = Texture(file, scale=NORMAL_SCALE, bias=NORMAL_BIAS, uv_rotation=rotation)
    made = from_above(texture, role="normal")
    seen = shoot(made.stage, "normal", width=SIDE, height=SIDE).images["normal"].pixels
    if rotation == 0.0:
        # u runs along +X and v along +Y here.
        assert np.allclose(seen[2, 1], (0.5, 0, 0.866), atol=0.01)
        assert np.allclose(seen[2, 6], (0, 0.6, 0.8), atol=0.01)
    else:
        # u = -t and v = s: the picture's u axis looks along -Y, its v axis along +X.
        leaning = seen.reshape(-1, 3)
        along_u = leaning[np.abs(leaning[:, 0]) < 0.01]
        along_v = leaning[np.abs(leaning[:, 1]) < 0.01]
        assert np.allclose(np.median(along_u, axis=0), (0, -0.5, 0.866), atol=0.01)
        assert np.allclose(np.median(along_v, axis=0), (0.6, 0, 0.8), atol=0.01)


@pytest.mark.parametrize("behind", [False, True])
@pytest.mark.parametrize("rotation", [0.0, 90.0])
def test_the_renderer_shades_with_the_normals_that_the_channel_says(
    shoot, tmp_path, rotation, behind
):
    file = save_picture(tmp_path / "relief.png", relief())
    texture = Texture(file, scale=NORMAL_SCALE, bias=NORMAL_BIAS, uv_rotation=rotation)
    made = from_above(texture, role="normal", base_color=(1.0, 1.0, 1.0))
    side = -1.0 if behind else 1.0
    made.camera((0, 0, 10 * side), (0, 0, 0), up=(0, 1, 0), fov=11.4, aspect=1.0)
    light = np.array([0.3, 0.2, side])
    light /= np.linalg.norm(light)
    sun = made.light("Distant", "/Sun", np.pi, angle=0.0)
    turn = Gf.Rotation(Gf.Vec3d(0, 0, 1), Gf.Vec3d(*light))
    sun.AddTransformOp().Set(Gf.Matrix4d().SetRotate(turn))
    images = shoot(
        made.stage, "normal", "radiance", width=SIDE, height=SIDE, samples=64, bounces=1
    ).images
    expected = images["normal"].pixels @ light
    seen = images["radiance"].pixels[..., 0]
    # At the border between the halves a pixel's mean is not its centre.
    neighbours = [np.roll(seen, step, axis) for step in (1, -1) for axis in (0, 1)]
    settled = np.max([np.abs(seen - other) for other in neighbours], axis=0) < 0.02
    assert settled.mean() > 0.2
    assert np.abs(seen - expected)[settled].max() < 0.01


def test_clear_parts_are_seen_through(shoot, tmp_path):
    pixels = np.full((SIDE, SIDE, 3), 255, dtype=np.uint8)
    pixels[:, : SIDE // 2] = 0
    file = save_picture(tmp_path / "leaf.png", pixels)
    texture = Texture(file, channel="r", wrap_s="clamp", wrap_t="clamp")
    made = from_above(texture, role="opacity", opacity_threshold=0.5)
    below = [(x, y, z - 3.0) for x, y, z in np.array(QUAD) * 2.0]
    made.quad("/Below", below)
    images = shoot(made.stage, "depth", "instance", width=SIDE, height=SIDE).images
    assert np.allclose(images["depth"].pixels[:, : SIDE // 2], 13.0, atol=1e-5)
    assert np.allclose(images["depth"].pixels[:, SIDE // 2 :], 10.0, atol=1e-5)
    assert len(np.unique(images["instance"].pixels)) == 2


def test_what_cannot_be_read_is_reported_and_rendered_all_the_same(open_stage, shoot, tmp_path):
    broken = tmp_path / "broken.png"
    broken.write_bytes(b"this is no picture")
    made = small.Stage()
    cases = {
        "missing": Texture(str(tmp_path / "missing.png")),
        "broken": Texture(str(broken), fallback=(0.25, 0.5, 0.75, 1.0)),
        "nan": (float("nan"), 0.5, 0.5),
    }
    for number, (name, value) in enumerate(cases.items()):
        material = made.material(f"/{name}", base_color=value)
        points = np.add(QUAD, [3 * number, 0, 0])
        made.mesh(f"/quad_{name}", points, [[0, 1, 2, 3]], material=material)
    made.camera((3, 0, 12), (3, 0, 0), up=(0, 1, 0))
    made.dome()
    images = shoot(made.stage, "base_color", "radiance").images
    assert all(np.isfinite(image.pixels).all() for image in images.values())
    losses = {path: reason for path, _, reason in open_stage(made.stage).report.losses()}
    assert "missing" in losses["/missing"]
    assert "broken.png" in losses["/broken"]
    assert "finite" in losses["/nan"]
    middle = images["base_color"].pixels[12, 16]
    assert np.allclose(middle, (0.25, 0.5, 0.75), atol=1e-3)


def test_the_picture_of_a_rectangle_light_is_upright_from_its_lit_side(shoot, tmp_path):
    pixels = speckled().astype(np.float32) / 255
    made = small.Stage()
    light = made.light("Rect", "/Light", 3.0, width=2.0, height=2.0)
    light.CreateTextureFileAttr(save_picture(tmp_path / "film.exr", pixels))
    distance = 10.0
    fov = math.degrees(2 * math.atan(1 / distance))
    made.camera((0, 0, -distance), (0, 0, 0), up=(0, 1, 0), fov=fov, aspect=1.0)
    size = {"width": SIDE, "height": SIDE}
    seen = shoot(made.stage, "radiance", samples=64, bounces=0, **size).images["radiance"].pixels
    assert np.corrcoef(seen.ravel(), pixels.ravel())[0, 1] > 0.9
    assert seen.mean() == pytest.approx(3 * pixels.mean(), rel=0.02)
