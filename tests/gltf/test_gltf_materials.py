"""What a GLB file says of a surface, looked up as glTF says, is what renderers here are given."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from openrooms_usd.colorimetry import linear_from_srgb
from openrooms_usd.rendering.scene.pictures import Picture, evaluate
from openrooms_usd.rendering.scene.surfaces import SurfaceReader
from openrooms_usd.usd.shading.surfaces import NORMAL_BIAS, NORMAL_SCALE, PreviewSurface, Texture
from tests.gltf.conftest import Export
from tests.gltf.reading import Glb
from tests.pictures import save_picture
from tests.small import Stage

Array = NDArray[Any]
CORNERS = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
# Places inside of the square; a texel of 8 bits, and of half precision, may be off by this.
PLACES = np.random.default_rng(1).uniform(0.02, 0.98, (200, 2))
CODE = 1.2 / 255.0


@pytest.fixture
def files(tmp_path: Path) -> dict[str, str]:
    """Smooth pictures without symmetry, of several sizes and channels."""
    rows, columns = np.mgrid[0:16, 0:16] / 16.0
    wave = [
        0.5 + 0.4 * np.sin(2 * np.pi * (a * rows + b * columns) + c)
        for a, b, c in ((1, 0, 0.3), (0, 1, 1.0), (1, 1, 2.0), (1, 2, 0.5))
    ]
    smooth = np.round(np.stack(wave, axis=-1) * 255).astype(np.uint8)
    return {
        "color": save_picture(tmp_path / "color.png", smooth[..., :3]),
        "rgba": save_picture(tmp_path / "rgba.png", smooth),
        "grey": save_picture(tmp_path / "grey.png", smooth[..., 3:]),
        "small": save_picture(tmp_path / "small.png", smooth[::2, ::2, :1]),
        "relief": save_picture(tmp_path / "relief.png", 96 + smooth[..., :3] // 4),
    }


def look_up(glb: Glb, info: dict[str, Any], uv: Array, folder: Path) -> Array:
    """Bilinear values of a texture, by glTF's rules: v grows downwards."""
    codes = glb.picture(info, folder)
    codes = np.repeat(codes, 3, axis=2) if codes.shape[2] == 1 else codes
    said = glb.json["samplers"][glb.json["textures"][info["index"]]["sampler"]]
    wraps = {10497: "repeat", 33648: "mirror", 33071: "clamp"}
    assert said["wrapS"] == said["wrapT"]
    picture = Picture(codes[::-1], wraps[said["wrapS"]])
    return picture.lookup(np.stack([uv[:, 0], 1.0 - uv[:, 1]], axis=-1))


def shown(glb: Glb, folder: Path) -> dict[str, Array]:
    """What the only material of a unit square says at `PLACES`."""
    (mesh,) = glb.json["meshes"]
    (primitive,) = mesh["primitives"]
    material = glb.json["materials"][primitive["material"]]
    points = glb.accessor(primitive["attributes"]["POSITION"])

    def values(info: dict[str, Any]) -> Array:
        uv = glb.accessor(primitive["attributes"][f"TEXCOORD_{info.get('texCoord', 0)}"])
        # Affine over the square: three corners say all.
        basis = np.linalg.lstsq(np.c_[points[:, :2], np.ones(len(points))], uv, rcond=None)[0]
        return look_up(glb, info, np.c_[PLACES, np.ones(len(PLACES))] @ basis, folder)

    base = material["pbrMetallicRoughness"]
    found = np.tile(base.get("baseColorFactor", [1.0] * 4), (len(PLACES), 1))
    if "baseColorTexture" in base:
        codes = values(base["baseColorTexture"])
        found[:, :3] *= linear_from_srgb(codes[:, :3])
        if codes.shape[1] == 4 and material.get("alphaMode", "OPAQUE") != "OPAQUE":
            found[:, 3] *= codes[:, 3]
    packed = np.ones((len(PLACES), 3))
    if "metallicRoughnessTexture" in base:
        packed = values(base["metallicRoughnessTexture"])
    looks = {
        "base_color": found[:, :3],
        "opacity": found[:, 3:],
        "roughness": packed[:, 1:2] * base.get("roughnessFactor", 1.0),
        "metallic": packed[:, 2:3] * base.get("metallicFactor", 1.0),
    }
    if "normalTexture" in material:
        info = material["normalTexture"]
        scale = [info.get("scale", 1.0), info.get("scale", 1.0), 1.0]
        looks["normal"] = (values(info)[:, :3] * 2.0 - 1.0) * scale
    if "emissiveFactor" in material:
        strong = material.get("extensions", {}).get("KHR_materials_emissive_strength", {})
        looks["emission"] = np.tile(material["emissiveFactor"], (len(PLACES), 1)) * strong.get(
            "emissiveStrength", 1.0
        )
        if "emissiveTexture" in material:
            looks["emission"] *= linear_from_srgb(values(material["emissiveTexture"]))
    return looks


def cases(files: dict[str, str]) -> dict[str, dict[str, Any]]:
    turned = {"uv_rotation": 30.0, "uv_scale": (2.0, 3.0), "uv_translation": (0.1, 0.2)}
    color = Texture(files["color"], color_space="sRGB", **turned)
    rgba = Texture(files["rgba"], color_space="sRGB")
    grey = Texture(files["grey"], channel="r")
    relief = Texture(files["relief"], scale=NORMAL_SCALE, bias=NORMAL_BIAS)
    return {
        "kept": {"base_color": color, "roughness": grey},
        "tinted": {
            "base_color": Texture(
                files["color"],
                color_space="sRGB",
                wrap_s="mirror",
                wrap_t="mirror",
                scale=(0.5, 0.25, 1.0, 1.0),
            )
        },
        "brightened": {
            "base_color": Texture(
                files["color"], color_space="sRGB", scale=(1.5,) * 4, bias=(0.1, 0.0, 0.0, 0.0)
            )
        },
        "linear": {"base_color": Texture(files["color"])},
        "one file": {
            "base_color": rgba,
            "opacity": Texture(files["rgba"], channel="a", color_space="sRGB"),
        },
        "two files": {
            "base_color": color,
            "opacity": Texture(files["small"], channel="r", **turned),
        },
        "mask": {"base_color": (0.2, 0.4, 0.6), "opacity": grey, "opacity_threshold": 0.5},
        "packed": {"roughness": grey, "metallic": Texture(files["small"], channel="r")},
        "orm": {
            "roughness": Texture(files["color"], channel="g"),
            "metallic": Texture(files["color"], channel="b"),
        },
        "metal": {"roughness": grey, "metallic": 1.0},
        "relief": {"normal": relief},
        "flat relief": {
            "normal": Texture(
                files["relief"], scale=(0.5, 0.5, 2.0, 1.0), bias=(-0.25, -0.25, -1.0, 0.0)
            )
        },
        "other relief": {
            "normal": Texture(
                files["relief"], scale=(2.0, -2.0, 2.0, 1.0), bias=(-1.0, 1.0, -1.0, 0.0)
            )
        },
        "glow": {"emissive": (4674.0, 4664.0, 5375.0)},
        "picture glows": {
            "emissive": Texture(
                files["color"], color_space="sRGB", scale=(300.0, 200.0, 100.0, 1.0)
            )
        },
        "dim": {"emissive": (0.5, 0.25, 0.0)},
    }


NAMES = tuple(cases(dict.fromkeys(("color", "rgba", "grey", "small", "relief"), "")))


@pytest.mark.parametrize("name", NAMES)
def test_a_surface_is_what_it_is_here(
    name: str, files: dict[str, str], export: Export, tmp_path: Path
) -> None:
    inputs = cases(files)[name]
    made = Stage()
    made.quad("/Square", CORNERS, material=made.material("/M", **inputs))
    glb, _ = export(made.stage)
    looks = shown(glb, tmp_path)
    surface = SurfaceReader().read(PreviewSurface(**inputs))
    st = PLACES @ surface.uv[:2, :2].T + surface.uv[:2, 2]
    for what in ("base_color", "opacity", "roughness", "metallic", "normal", "emission"):
        wanted = getattr(surface, what)
        if wanted is None or (what == "opacity" and surface.opacity == 1.0):
            assert what not in looks or what == "opacity"
            continue
        channels = 3 if what in ("base_color", "normal", "emission") else 1
        ours = evaluate(wanted, st, channels)
        theirs = looks[what]
        if name == "mask" and what == "opacity":
            # A mask is cut after the look-up there, and before it here.
            continue
        # Colours are interpolated in sRGB there, by this test, and linearly here; what is made
        # larger to be packed is interpolated twice.
        loose = what in ("base_color", "emission") or "small" in str(inputs)
        top = max(1.0, float(ours.max()))
        assert np.abs(theirs - ours).max() < (0.03 if loose else 2 * CODE) * top, what


def test_files_are_kept_and_used_once(files: dict[str, str], export: Export) -> None:
    made = Stage()
    inputs = cases(files)["kept"]
    for number, st in enumerate(((1.0, 1.0), (2.0, 2.0))):
        color = Texture(files["color"], color_space="sRGB", uv_scale=st)
        look = made.material(f"/M{number}", **inputs | {"base_color": color})
        made.quad(f"/Square{number}", np.add(CORNERS, (0, 0, number)), material=look)
    glb, _ = export(made.stage)
    assert len(glb.json["images"]) == 2
    kept = Path(files["color"]).read_bytes()
    assert kept in glb.data
    assert "extensionsRequired" not in glb.json


def test_clear_glass_lets_light_through_and_is_seen_by_all(export: Export) -> None:
    made = Stage()
    glass = made.material("/M", base_color=(1, 1, 1), opacity=0.125, roughness=0.0, ior=1.25)
    made.quad("/Pane", CORNERS, material=glass).CreateDoubleSidedAttr(True)
    leaf = made.material("/L", opacity=0.5, opacity_mode="presence", transmission=0.0)
    made.quad("/Leaf", CORNERS, material=leaf)
    glb, _ = export(made.stage)
    pane, leaf_there = glb.named("materials", "M"), glb.named("materials", "L")
    assert pane["extensions"] == {
        "KHR_materials_transmission": {"transmissionFactor": 0.875},
        "KHR_materials_ior": {"ior": 1.25},
    }
    assert pane["alphaMode"] == "BLEND" and pane["doubleSided"]
    assert pane["pbrMetallicRoughness"]["baseColorFactor"][3] == 0.3
    assert leaf_there["pbrMetallicRoughness"]["baseColorFactor"][3] == 0.5
    assert "KHR_materials_transmission" not in leaf_there.get("extensions", {})
    assert "extensionsRequired" not in glb.json


def test_tangents_lead_where_the_picture_does(files: dict[str, str], export: Export) -> None:
    made = Stage()
    relief = Texture(files["relief"], scale=NORMAL_SCALE, bias=NORMAL_BIAS, uv_rotation=90.0)
    made.quad("/Square", CORNERS, material=made.material("/M", normal=relief))
    mirrored = made.mesh(
        "/Mirrored",
        np.add(CORNERS, (2, 0, 0)),
        [[0, 1, 2, 3]],
        st=[(1, 0), (0, 0), (0, 1), (1, 1)],
        material="/M",
    )
    assert mirrored
    glb, _ = export(made.stage)
    for name, st in (("Square", (1.0, 0.0)), ("Mirrored", (-1.0, 0.0))):
        (primitive,) = glb.named("meshes", name)["primitives"]
        tangent = glb.accessor(primitive["attributes"]["TANGENT"])
        # u = -t, the way up in the picture = s: where those grow in the square.
        assert np.allclose(tangent[:, :3], (0.0, -1.0, 0.0), atol=1e-6)
        up = np.cross((0, 0, 1), tangent[0, :3]) * tangent[0, 3]
        assert np.allclose(up, (st[0], 0.0, 0.0), atol=1e-6)
