"""Names of files: every convention that is known, and words that only look like a map."""

import pytest

from openrooms_usd.library.ownmaterials import map_of

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
