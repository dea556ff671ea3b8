"""Folders of maps: which picture drives which input, how it is decoded, and what is said of it."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import OpenImageIO
import pytest

from openrooms_usd.arrays import Array
from openrooms_usd.errors import InputError
from openrooms_usd.library.ownmaterials import (
    OwnMaterial,
    files_of,
    from_constants,
    map_of,
    publish,
    read_material,
)
from openrooms_usd.library.ownmaterials.normalmaps import Relief, green_agreement, read_relief
from openrooms_usd.usd.shading.surfaces import NORMAL_BIAS, NORMAL_SCALE, PreviewSurface

Folder = Callable[..., Path]

AMBIENTCG = tuple(
    """
    Wood043_1K-JPG_Color.png Wood043_1K-JPG_NormalGL.png Wood043_1K-JPG_NormalDX.png
    Wood043_1K-JPG_Roughness.png Wood043_1K-JPG_Metalness.png Wood043_1K-JPG_Displacement.png
    Wood043_1K-JPG_AmbientOcclusion.png Wood043_1K-JPG_Opacity.png
    """.split()
)


def write_picture(path: Path, *, width: int = 4, height: int = 4, channels: int = 3) -> Path:
    pixels = np.random.default_rng(len(path.name)).random((height, width, channels), np.float32)
    kind = "half" if path.suffix == ".exr" else "uint8"
    file = OpenImageIO.ImageOutput.create(str(path))
    assert file.open(str(path), OpenImageIO.ImageSpec(width, height, channels, kind))
    assert file.write_image(pixels)
    file.close()
    return path


@pytest.fixture
def folder(tmp_path: Path) -> Folder:
    def make(*names: str, **how: int) -> Path:
        for name in names:
            write_picture(tmp_path / name, **how)
        return tmp_path

    return make


def used(material: OwnMaterial) -> dict[str, tuple[str, str]]:
    return {k: (Path(t.file).name, t.channel) for k, t in material.textures.items()}


def test_the_naming_of_ambientcg(folder: Folder) -> None:
    material = read_material(folder(*AMBIENTCG))
    assert used(material) == {
        "base_color": ("Wood043_1K-JPG_Color.png", "rgb"),
        "normal": ("Wood043_1K-JPG_NormalGL.png", "rgb"),
        "roughness": ("Wood043_1K-JPG_Roughness.png", "r"),
        "metallic": ("Wood043_1K-JPG_Metalness.png", "r"),
        "occlusion": ("Wood043_1K-JPG_AmbientOcclusion.png", "r"),
        "opacity": ("Wood043_1K-JPG_Opacity.png", "r"),
    }
    spaces = {k: t.color_space for k, t in material.textures.items()}
    assert spaces.pop("base_color") == "sRGB"
    assert set(spaces.values()) == {"raw"}
    assert material.surface.opacity_mode == "presence"
    assert any("Displacement" in loss for loss in material.losses)


def test_the_naming_of_poly_haven_with_linear_and_packed_pictures(folder: Folder) -> None:
    material = read_material(
        folder("oak_diff_1k.exr", "oak_nor_gl_1k.exr", "oak_arm_1k.png", "oak_disp_1k.png")
    )
    assert used(material) == {
        "base_color": ("oak_diff_1k.exr", "rgb"),
        "normal": ("oak_nor_gl_1k.exr", "rgb"),
        "roughness": ("oak_arm_1k.png", "g"),
        "metallic": ("oak_arm_1k.png", "b"),
        "occlusion": ("oak_arm_1k.png", "r"),
    }
    assert material.textures["base_color"].color_space == "raw"


def test_maps_of_their_own_come_before_packed_ones(folder: Folder) -> None:
    material = read_material(folder("a_diff.png", "a_rough.png", "a_arm.png"))
    assert used(material)["roughness"] == ("a_rough.png", "r")
    assert used(material)["metallic"] == ("a_arm.png", "b")


def test_the_names_of_openrooms(folder: Folder) -> None:
    names = ("diffuse_tiled.png", "normal_tiled.png", "rough_tiled.png")
    assert set(used(read_material(folder(*names)))) == {"base_color", "normal", "roughness"}


def test_directx_normals_are_turned_by_the_sign_of_green(folder: Folder) -> None:
    normal = read_material(folder("a_Color.png", "a_NormalDX.png")).textures["normal"]
    assert normal.scale == (2.0, -2.0, 2.0, 1.0)
    assert normal.bias == (-1.0, 1.0, -1.0, 0.0)
    opengl = read_material(folder("a_NormalGL.png")).textures["normal"]
    assert (opengl.scale, opengl.bias) == (NORMAL_SCALE, NORMAL_BIAS)
    # The same green means the opposite.
    texel = 0.8
    assert texel * normal.scale[1] + normal.bias[1] == pytest.approx(-(texel * 2 - 1))


def test_glossiness_is_inverted_and_the_specular_workflow_reported(folder: Folder) -> None:
    material = read_material(folder("a_albedo.png", "a_glossiness.png", "a_specular.png"))
    gloss = material.textures["roughness"]
    assert 0.3 * gloss.scale[0] + gloss.bias[0] == pytest.approx(0.7)
    assert any("a_specular.png" in loss and "workflow" in loss for loss in material.losses)


def test_of_two_resolutions_the_larger_is_taken(folder: Folder, tmp_path: Path) -> None:
    write_picture(tmp_path / "a_diff_2k.png", width=8, height=8)
    material = read_material(folder("a_diff_1k.png", "a_rough_1k.png"))
    assert used(material)["base_color"][0] == "a_diff_2k.png"
    assert any("a_diff_1k.png: left out" in loss for loss in material.losses)


def test_two_materials_in_one_folder_are_refused(folder: Folder) -> None:
    with pytest.raises(InputError, match=r"Oak_Color.png, Pine_Color.png") as caught:
        read_material(folder("Oak_Color.png", "Pine_Color.png"))
    assert "its own folder" in str(caught.value)


def test_a_folder_without_colour_names_what_it_knows(folder: Folder) -> None:
    with pytest.raises(InputError, match=r"no base colour .*a_rough.png"):
        read_material(folder("a_rough.png", "preview.png"))


def test_missing_maps_keep_the_defaults_and_are_said(folder: Folder) -> None:
    material = read_material(folder("a_Color.png", "preview.png"))
    assert material.surface.roughness == PreviewSurface.roughness
    assert material.surface.normal == PreviewSurface.normal
    losses = " ".join(material.losses)
    assert "no roughness map" in losses
    assert "preview.png: left out" in losses
    assert "1 m wide is assumed" in losses


def test_a_link_out_of_the_folder_is_refused(folder: Folder, tmp_path: Path) -> None:
    inside = tmp_path / "inside"
    inside.mkdir()
    (inside / "a_Color.png").symlink_to(write_picture(tmp_path / "secret.png"))
    with pytest.raises(InputError, match="base_color is a link to outside"):
        read_material(inside)


def test_a_broken_picture_is_one_clear_error(tmp_path: Path) -> None:
    (tmp_path / "a_Color.png").write_bytes(b"no picture")
    with pytest.raises(InputError, match="not a readable picture"):
        read_material(tmp_path)
    with pytest.raises(InputError, match="no such file or folder"):
        read_material(tmp_path / "elsewhere")


def test_the_height_follows_from_the_proportions(folder: Folder, tmp_path: Path) -> None:
    write_picture(tmp_path / "a_Roughness.png", width=4, height=4)
    path = folder("a_Color.png", width=8, height=4)
    material = read_material(path, physical_size=2.0)
    assert material.size == (2.0, 1.0)
    assert any("a_Roughness.png: its proportions differ" in loss for loss in material.losses)
    assert read_material(path, physical_size=(2.0, 3.0)).size == (2.0, 3.0)
    assert [read_material(path, physical_size=x).size[0] for x in (1e-3, 1e3)] == [1e-3, 1e3]
    for size in (0.0, -1.0, float("nan"), 1e9):
        with pytest.raises(InputError):
            read_material(path, physical_size=(size, size))


@pytest.mark.parametrize("across", [False, True])
def test_in_metres_a_tile_covers_its_size(folder: Folder, across: bool) -> None:
    material = read_material(folder("a_Color.png"), physical_size=(2.0, 0.5))
    base = replace(
        material.textures["base_color"],
        uv_scale=(3.0, 2.0),
        uv_rotation=30.0,
        uv_translation=(0.1, 0.2),
    )
    material = replace(material, surface=replace(material.surface, base_color=base))
    placed = material.in_metres("./textures", across=across).base_color
    turn = np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1.0]]) if across else np.eye(3)
    expected = base.uv_matrix @ np.diag([1 / 2.0, 1 / 0.5, 1.0]) @ turn
    assert np.allclose(placed.uv_matrix, expected)  # type: ignore[union-attr]


def test_publishing_copies_each_picture_once_by_its_content(folder: Folder, tmp_path: Path) -> None:
    path = folder("a_Color.png", "a_arm.png")
    (tmp_path / "a_Roughness.png").write_bytes((tmp_path / "a_arm.png").read_bytes())
    material = read_material(path)
    out = tmp_path / "out"
    kept: list[str] = []

    def keep(name: str) -> Path:
        kept.append(name)
        return out / name

    publish(material, keep)
    surface = material.in_metres("./materials/textures")
    written = {p.name: p.read_bytes() for p in (out / "textures").iterdir()}
    assert len(written) == 2
    assert set(kept) >= {f"textures/{name}" for name in written}
    for name, texture in replace(material, surface=surface).textures.items():
        source = Path(material.textures[name].file)
        assert written[Path(texture.file).name] == source.read_bytes()
        assert str(tmp_path) not in texture.file
    assert material.identifier == read_material(path).identifier
    assert material.identifier != read_material(path, physical_size=3.0).identifier


@pytest.mark.parametrize(
    ("text", "licence"),
    [
        ("SPDX-License-Identifier: CC-BY-4.0\n", "CC-BY-4.0"),
        ("Creative Commons Zero (CC0) 1.0", "CC0-1.0"),
        ("Attribution-NonCommercial 4.0 International", "CC-BY-NC-4.0"),
        ("\n My own terms \nmore", "My own terms"),
    ],
)
def test_the_licence_beside_the_maps_is_recorded(
    folder: Folder, tmp_path: Path, text: str, licence: str
) -> None:
    path = folder("a_Color.png")
    assert read_material(path).licence == "unknown"
    (tmp_path / "LICENSE.txt").write_text(text)
    assert read_material(path).licence == licence
    assert files_of(path) == sorted([tmp_path / "LICENSE.txt", tmp_path / "a_Color.png"])


def test_constants() -> None:
    given = {"base_color": [0.1, 0.2, 0.3], "roughness": 0.25, "metallic": 1, "normal": None}
    surface = from_constants(given).surface
    assert (surface.base_color, surface.roughness) == ((0.1, 0.2, 0.3), 0.25)
    assert surface.metallic == 1.0
    bad = [
        {"base_color": 0.5},
        {"roughness": 2.0},
        {"gloss": 0.5},
        {"normal": (0, 0, 1)},
        {"metallic": float("nan")},
        {"roughness": "rough"},
    ]
    for mistake in bad:
        with pytest.raises(InputError):
            from_constants(mistake)


@pytest.mark.one_in(3)
@pytest.mark.parametrize("name", ["wood-floor-43", "tiles", "gold"])
def test_real_folders(name: str, real: Callable[[str], Path]) -> None:
    material = read_material(real(f"pbr_ambientcg/{name}"), physical_size=1.0)
    assert {"base_color", "normal", "roughness"} <= set(material.textures)
    assert ("metallic" in material.textures) == (name != "tiles")
    # Older sets of this source hold DirectX normals and do not say so; their heights do.
    assert material.textures["normal"].scale[1] == -2.0


KNOWN = {
    "Wood043_1K-JPG_NormalGL": ("normal_gl", "wood043"),
    "WoodFloor043_1K_AmbientOcclusion": ("occlusion", "wood floor043"),
    "brown_planks_nor_dx_4k": ("normal_dx", "brown planks"),
    "brown_planks_arm_2k": ("occlusion_roughness_metallic", "brown planks"),
    "rock_col_2_1k": ("base_color", "rock 2"),
    "Stone-Normal-OpenGL": ("normal_gl", "stone"),
    "T_Brick_BaseColor": ("base_color", "t brick"),
    "T_Brick_ORM": ("occlusion_roughness_metallic", "t brick"),
    "Chair_metallicRoughness": ("metallic_roughness", "chair"),
    "Chair_occlusionRoughnessMetallic": ("occlusion_roughness_metallic", "chair"),
    "diffuse_tiled": ("base_color", ""),
    "rough_tiled": ("roughness", ""),
    "paint glossiness 2048x2048": ("glossiness", "paint"),
    "oak_rough_16bit": ("roughness", "oak"),
    "gold_metal": ("metallic", "gold"),
}


@pytest.mark.parametrize("stem", sorted(KNOWN))
def test_known_names(stem: str) -> None:
    assert map_of(stem) == KNOWN[stem]


@pytest.mark.parametrize("stem", ["Wood043", "preview", "", "1k", "colorful", "normandy_1", "___"])
def test_names_that_say_nothing(stem: str) -> None:
    assert map_of(stem) is None


SIDE = 64


def write(path: Path, pixels: Array, kind: str) -> str:
    height, width, channels = pixels.shape
    file = OpenImageIO.ImageOutput.create(str(path))
    assert file.open(str(path), OpenImageIO.ImageSpec(width, height, channels, kind))
    assert file.write_image(np.ascontiguousarray(pixels, dtype=np.float32))
    file.close()
    return str(path)


def relief(seed: int, *, grooves: bool = False) -> tuple[Array, Array]:
    """Heights of a sum of waves with their OpenGL normals by its exact derivatives."""
    rng = np.random.default_rng(seed)
    s, t = np.meshgrid((np.arange(SIDE) + 0.5) / SIDE, 1 - (np.arange(SIDE) + 0.5) / SIDE)
    height, along_s, along_t = np.zeros_like(s), np.zeros_like(s), np.zeros_like(s)
    for _ in range(6):
        m, n = (0, rng.integers(1, 4)) if grooves else rng.integers(-3, 4, 2)
        phase, size = rng.uniform(0, 2 * np.pi), 0.02
        angle = 2 * np.pi * (m * s + n * t) + phase
        height += size * np.sin(angle)
        along_s += size * 2 * np.pi * m * np.cos(angle)
        along_t += size * 2 * np.pi * n * np.cos(angle)
    normals = np.dstack([-along_s, -along_t, np.ones_like(s)])
    return height, normals / np.linalg.norm(normals, axis=2, keepdims=True)


def packed(normals: Array) -> Array:
    return np.asarray((normals + 1) / 2)


@pytest.mark.parametrize("seed", range(5))
def test_slopes_tell_where_green_points(seed: int) -> None:
    _, normals = relief(seed)
    assert green_agreement(normals) > 0.9
    assert green_agreement(normals * (1, -1, 1)) < -0.9


@pytest.mark.parametrize("sign", [1, -1])
def test_grooves_along_one_axis_are_told_by_their_heights(tmp_path: Path, sign: int) -> None:
    height, normals = relief(3, grooves=True)
    file = write(tmp_path / "n.png", packed(normals * (1, sign, 1)), "uint8")
    heights = write(tmp_path / "h.png", (height - height.min())[..., None] * 4, "uint8")
    blind = read_relief(file, None)
    assert isinstance(blind, Relief)
    assert "OpenGL is assumed" in blind.losses[0]
    seen = read_relief(file, None, heights)
    assert isinstance(seen, Relief)
    assert np.sign(seen.scale[1]) == sign
    assert "its displacement map shows" in seen.losses[0]


@pytest.mark.parametrize("stated", ["up", "down", None])
@pytest.mark.parametrize(("suffix", "signed"), [(".png", False), (".exr", False), (".exr", True)])
def test_the_way_from_stored_values_to_opengl(
    tmp_path: Path, stated: str | None, suffix: str, signed: bool
) -> None:
    _, normals = relief(1)
    written = normals * (1, 1 if stated == "up" else -1, 1)
    values = written if signed else packed(written)
    kind = "float" if suffix == ".exr" else "uint16"
    found = read_relief(write(tmp_path / f"n{suffix}", values, kind), stated)  # type: ignore[arg-type]
    assert isinstance(found, Relief)
    restored = values * found.scale[:3] + found.bias[:3]
    assert np.abs(restored - normals).max() < 1e-6
    assert bool(found.losses) == (stated is None)


@pytest.mark.parametrize("channels", [1, 3])
def test_grey_pictures_are_no_normal_maps(tmp_path: Path, channels: int) -> None:
    height, _ = relief(2)
    grey = np.repeat((height - height.min())[..., None], channels, axis=2)
    reason = read_relief(write(tmp_path / "n.png", grey, "uint8"), "up")
    assert isinstance(reason, str)
    assert "heights, not normals" in reason


def test_a_single_texel_is_a_normal(tmp_path: Path) -> None:
    found = read_relief(write(tmp_path / "n.png", np.array([[[0.5, 0.5, 1.0]]]), "uint8"), None)
    assert isinstance(found, Relief)
