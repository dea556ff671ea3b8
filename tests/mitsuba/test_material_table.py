"""Many materials by one BSDF: the same numbers, and the same picture, as one BSDF for each."""

from typing import Any

import numpy as np
import pytest

from openrooms_usd.rendering.scene import codes
from openrooms_usd.rendering.scene.codes import load_picture
from openrooms_usd.rendering.scene.pictures import Picture, evaluate, load
from openrooms_usd.rendering.scene.surfaces import SurfaceReader
from openrooms_usd.usd.shading.surfaces import NORMAL_BIAS, NORMAL_SCALE, PreviewSurface, Texture
from orusd_mitsuba import variants
from orusd_mitsuba.plugins import material_table
from tests import small
from tests.mitsuba.rendering import radiance, session_of
from tests.pictures import save_picture


@pytest.fixture
def mitsuba(vectorized: str) -> Any:
    import mitsuba as mi

    mi.set_variant(variants.choose("llvm").variant)
    return mi


def noise(path: Any, height: int, width: int, channels: int = 3) -> str:
    rng = np.random.default_rng(height * width + channels)
    return str(save_picture(path, rng.integers(0, 256, (height, width, channels)).astype(np.uint8)))


@pytest.mark.parametrize("wrap", ["repeat", "mirror", "clamp"])
@pytest.mark.parametrize("size", [(1, 1), (3, 5), (16, 8)])
def test_the_table_looks_textures_up_as_the_ground_truth_does(
    mitsuba: Any, tmp_path: Any, wrap: Any, size: tuple[int, int]
) -> None:
    color, gloss = (noise(tmp_path / f"{c}.png", *size, c) for c in (3, 1))
    mapped = {"wrap_s": wrap, "wrap_t": wrap}
    preview = PreviewSurface(
        base_color=Texture(color, color_space="sRGB", scale=(0.9, 0.8, 1.5, 1.0), **mapped),
        roughness=Texture(gloss, "r", uv_scale=(2.0, 3.0), uv_rotation=30.0, **mapped),
        metallic=Texture(color, "g", bias=(0.0, -0.1, 0.0, 0.0), **mapped),
        normal=Texture(color, scale=NORMAL_SCALE, bias=NORMAL_BIAS, **mapped),
        f0=0.05,
    )
    reader = SurfaceReader()
    constant = reader.read(PreviewSurface(base_color=(0.1, 0.2, 0.3), roughness=0.7, f0=0.08))
    surface = reader.read(preview)
    assert material_table.fits(surface) and material_table.fits(constant)
    st = np.random.default_rng(1).uniform(-2.5, 3.5, (2000, 2)).astype(np.float32)
    for rows, wanted in (([surface, constant], surface), ([constant, surface], constant)):
        import drjit as dr

        table = material_table.MaterialTable(rows)
        si = dr.zeros(mitsuba.SurfaceInteraction3f, len(st))
        si.uv = mitsuba.Point2f(st.T)
        matter = table(si, mitsuba.Bool(True))
        for name, found in (
            ("base_color", matter.base_color),
            ("roughness", matter.roughness),
            ("metallic", matter.metallic),
        ):
            channels = 3 if name == "base_color" else 1
            expected = evaluate(getattr(wanted, name), st.astype(np.float64), channels)
            values = np.broadcast_to(np.array(found), (*[3] * (channels == 3), len(st)))
            np.testing.assert_allclose(values.reshape(channels, -1).T, expected, atol=2e-5)
        relief = np.broadcast_to(np.array(matter.relief), (3, len(st))).T
        flat = (0.0, 0.0, 1.0)
        expected = evaluate(wanted.normal or flat, st.astype(np.float64), 3)
        np.testing.assert_allclose(relief, expected, atol=5e-5)
        assert float(np.array(matter.f0).ravel()[0]) == pytest.approx(wanted.f0)


@pytest.mark.parametrize("stored", [1, 2, 3, 4])
@pytest.mark.parametrize("channel", ["rgb", "r", "b", "a"])
@pytest.mark.parametrize("wanted", [1, 3])
def test_codes_mean_what_the_values_are(
    tmp_path: Any, stored: int, channel: Any, wanted: int
) -> None:
    file = noise(tmp_path / "t.png", 7, 9, stored)
    for space in ("sRGB", "raw"):
        texture = Texture(
            file,
            channel,
            space,
            scale=(1.2, 0.5, 2.0, 0.7),
            bias=(0.0, 0.1, -0.3, 0.2),
            wrap_s="clamp",
            wrap_t="mirror",
        )
        coded = load_picture(texture, wanted, (0.0, 1.0), np.eye(3), {})
        plain = load(texture, wanted, (0.0, 1.0), np.eye(3))
        assert coded.coding is not None and coded.texels.dtype == np.uint8
        np.testing.assert_allclose(coded.pixels, plain.pixels, atol=6e-4)
        assert (coded.wrap, coded.losses) == (plain.wrap, plain.losses)


def test_what_is_not_of_eight_bits_is_no_row(tmp_path: Any) -> None:
    values = np.random.default_rng(1).random((4, 4, 3)).astype(np.float32)
    file = save_picture(tmp_path / "t.exr", values)
    reader = SurfaceReader()
    for preview in (
        PreviewSurface(base_color=Texture(file), f0=0.05),
        PreviewSurface(opacity=0.5, f0=0.05),
        PreviewSurface(),
    ):
        assert not material_table.fits(reader.read(preview))


def room(folder: Any) -> Any:
    made = small.Stage()
    for number in range(4):
        color = noise(folder / f"c{number}.png", 4 + number, 6)
        relief = np.full((2, 2, 3), (118 + 5 * number, 140, 230), dtype=np.uint8)
        look = made.material(
            f"/Look_{number}",
            f0=0.05,
            ior=1.5,
            base_color=Texture(color, color_space="sRGB", uv_scale=(2, 2)),
            roughness=0.2 + 0.2 * number if number else Texture(color, "g"),
            normal=Texture(
                save_picture(folder / f"n{number}.png", relief),
                scale=NORMAL_SCALE,
                bias=NORMAL_BIAS,
            ),
        )
        x = 1.1 * number - 1.7
        made.quad(
            f"/Q_{number}",
            [(x, -1, 0), (x + 1, -1, 0), (x + 1, 1, 0.3), (x, 1, 0.3)],
            material=look,
        )
    cloth = made.material("/Cloth", f0=0.05, base_color=(0.4, 0.3, 0.3), transmission=0.3)
    made.quad("/Sheet", [(-2, 1, 0), (2, 1, 0), (2, 1, 1), (-2, 1, 1)], material=cloth)
    glass = made.material("/Glass", base_color=(0.4, 0.3, 0.3), opacity=0.4, f0=0.05)
    made.quad("/Pane", [(-2, 0, 0.2), (0, 0, 0.2), (0, 0, 1), (-2, 0, 1)], material=glass)
    made.dome(radiance=3.0)
    made.camera((0, -4, 2), (0, 0, 0.2))
    return made.stage


@pytest.mark.slow
def test_one_bsdf_or_many_give_the_same_picture(
    tmp_path: Any, mitsuba: Any, monkeypatch: Any
) -> None:
    stage = room(tmp_path)
    pixels = {}
    for tabulated in (True, False):
        if not tabulated:
            monkeypatch.setattr(material_table, "fits", lambda surface: False)
        session = session_of(stage, variant="llvm")
        shared = {id(shape.bsdf()) for shape in session.session._built.shapes()}
        assert len(shared) == (2 if tabulated else 6)
        pixels[tabulated] = radiance(session, width=48, height=36, samples=32).astype(np.float64)
    # The same random numbers: rounding alone may send a path another way.
    difference = np.abs(pixels[True] - pixels[False]) / pixels[False].mean()
    assert np.median(difference) < 1e-4
    assert difference.mean() < 2e-3


def test_each_picture_is_read_once(tmp_path: Any, mitsuba: Any, monkeypatch: Any) -> None:
    stage, read = room(tmp_path), []
    once = codes.read_codes
    monkeypatch.setattr(codes, "read_codes", lambda file: read.append(file) or once(file))
    session_of(stage, variant="llvm")
    # Four colours and four normals; the roughness is another channel of one of them.
    assert len(read) == 9 and len(set(read)) == 8


def test_tints_and_places_of_one_picture_share_its_codes(tmp_path: Any) -> None:
    file = noise(tmp_path / "t.png", 8, 8)
    reader = SurfaceReader()
    previews = [
        PreviewSurface(
            base_color=Texture(file, scale=(1.0, tint, tint, 1.0), uv_translation=(tint, 0.0)),
            f0=0.05,
        )
        for tint in (1.0, 0.9, 0.8)
    ]
    reader.prefetch(previews)
    pictures = [reader.read(preview).base_color for preview in previews]
    assert all(isinstance(picture, Picture) for picture in pictures)
    assert len({id(picture.texels) for picture in pictures}) == 1  # type: ignore[union-attr]
    assert len({picture.coding for picture in pictures}) == 3  # type: ignore[union-attr]
