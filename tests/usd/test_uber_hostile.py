"""Networks of MaterialX that make no sense: nothing raises, and every number is finite."""

import random
from pathlib import Path

import numpy as np
import pytest
from pxr import Usd, UsdShade

from openrooms_usd.render.scene.surfaces import SurfaceReader
from openrooms_usd.usd.materialreader import read_preview_surface
from openrooms_usd.usd.materials import Texture
from tests.usd.test_materials import write_picture

SURFACES = ("standard_surface", "open_pbr_surface", "gltf_pbr", "UsdPreviewSurface")
NODES = (
    "image_color3", "image_float", "tiledimage_color3", "UsdUVTexture", "constant_color3",
    "convert_float_color3", "dot_color3", "multiply_color3", "divide_color3FA", "add_float",
    "subtract_vector2", "mix_color3", "invert_float", "remap_color3", "clamp_vector3",
    "extract_color4", "separate3_color3", "swizzle_color3_float", "combine3_vector3", "normalmap",
    "place2d_vector2", "rotate2d_vector2", "texcoord_vector2", "geompropvalue_vector2", "noise2d",
)  # fmt: skip
NAMES = (
    "in", "in1", "in2", "in3", "fg", "bg", "mix", "value", "amount", "low", "high", "inlow",
    "inhigh", "outlow", "outhigh", "index", "channels", "scale", "texcoord", "st",
    "default", "uvtiling", "uvoffset", "realworldimagesize", "pivot", "rotate", "offset",
    "operationorder", "geomprop", "uaddressmode", "fallback",
)  # fmt: skip
INPUTS = (
    "base", "base_color", "base_weight", "metalness", "specular", "specular_IOR", "specular_ior",
    "specular_weight", "specular_roughness", "opacity", "geometry_opacity", "emission",
    "emission_color", "coat", "coat_weight", "coat_color", "coat_roughness", "transmission",
    "transmission_color", "transmission_weight", "thin_walled", "normal", "geometry_normal",
    "alpha", "alpha_mode", "alpha_cutoff", "emissive", "diffuseColor", "roughness", "ior",
    "displacement", "sheen", "subsurface_color", "opacityMode",
)  # fmt: skip
VALUES = (
    ("float", "nan"), ("float", "inf"), ("float", "0"), ("float", "1"), ("float", "-3.5"),
    ("float", "1e38"), ("int", "-2147483648"), ("bool", "1"), ("string", '"rgba"'),
    ("token", '"constant"'), ("asset", "@a.png@"), ("asset", "@none.png@"), ("asset", "@@"),
    ("float2", "(0, 2)"), ("float3", "(1, nan, 2)"), ("color3f", "(0.2, 0.5, 0.7)"),
    ("color3f", "(-1e30, 0, 1e30)"), ("float4", "(1, 2, 3, 4)"), ("float[]", "[]"),
    ("float[]", "[1, 2, 3, 4, 5, 6]"), ("matrix4d", "((1,0,0,0),(0,1,0,0),(0,0,1,0),(0,0,0,1))"),
    ("half", "0.5"), ("double", "2"), ("string", '""'),
)  # fmt: skip


def network(seed: int) -> str:
    rng = random.Random(seed)

    def inputs(names: tuple[str, ...], many: int, linked: float) -> str:
        lines = []
        for name in rng.sample(names, min(many, len(names))):
            kind, value = rng.choice(VALUES)
            target = f"</M/N{rng.randrange(8)}.outputs:{rng.choice(('out', 'r', 'outr'))}>"
            if rng.random() < linked:
                lines.append(f"{kind} inputs:{name}.connect = {target}")
            else:
                lines.append(f"{kind} inputs:{name} = {value}")
        return "\n".join(lines)

    outputs = "float outputs:out\nfloat outputs:r\nfloat outputs:outr"
    nodes = "".join(
        f'def Shader "N{number}"\n{{\nuniform token info:id = "ND_{rng.choice(NODES)}"\n'
        f"{inputs(NAMES, 12, 0.3)}\nasset inputs:file = @{rng.choice('ab')}.png@\n{outputs}\n}}\n"
        for number in range(8)
    )
    kind = rng.choice(SURFACES)
    return (
        '#usda 1.0\ndef Material "M"\n{\n'
        "token outputs:mtlx:surface.connect = </M/S.outputs:out>\n"
        f'def Shader "S"\n{{\nuniform token info:id = "ND_{kind}_surfaceshader"\n'
        f"{inputs(INPUTS, 18, 0.6)}\ntoken outputs:out\n}}\n{nodes}}}\n"
    )


@pytest.mark.filterwarnings("ignore")
def test_networks_of_nonsense_are_surfaces(tmp_path: Path) -> None:
    write_picture(tmp_path / "a.png", np.full((2, 2, 3), 90, np.uint8))
    textured = 0
    for seed in range(150):
        file = tmp_path / f"{seed}.usda"
        file.write_text(network(seed))
        stage = Usd.Stage.Open(str(file))
        surface, losses = read_preview_surface(UsdShade.Material(stage.GetPrimAtPath("/M")))
        textured += any(isinstance(value, Texture) for value in vars(surface).values())
        read = SurfaceReader().read(surface)
        for name, value in vars(read).items():
            if isinstance(value, int | float | tuple) and name not in ("losses", "primvar"):
                assert np.isfinite(np.array(value, dtype=float)).all(), (seed, name, losses)
    assert textured > 20
