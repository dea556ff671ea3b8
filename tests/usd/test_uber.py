"""Surfaces and nodes of MaterialX: numbers by its formulas, and all else by name."""

import math
import random
from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO
import pytest
from pxr import Usd, UsdShade

from openrooms_usd.colorimetry import linear_from_srgb
from openrooms_usd.rendering.scene.codes import load_picture
from openrooms_usd.rendering.scene.pictures import load
from openrooms_usd.rendering.scene.surfaces import SurfaceReader
from openrooms_usd.usd.shading import uber
from openrooms_usd.usd.shading.materialreader import read_preview_surface
from openrooms_usd.usd.shading.materials import PreviewSurface, Texture
from openrooms_usd.usd.shading.surfaces import f0_of
from tests.usd.test_materials import write_picture

STANDARD, OPEN_PBR, GLTF, PREVIEW = (
    f"ND_{name}_surfaceshader"
    for name in ("standard_surface", "open_pbr_surface", "gltf_pbr", "UsdPreviewSurface")
)
PIXELS = np.array([[[51, 102, 204]]], np.uint8)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    file = OpenImageIO.ImageOutput.create(str(tmp_path / "a.png"))
    assert file.open(str(tmp_path / "a.png"), OpenImageIO.ImageSpec(1, 1, 3, "uint8"))
    assert file.write_image(PIXELS) and file.close()
    return tmp_path


def read(
    folder: Path, kind: str, inputs: str, nodes: str = "", beside: str = ""
) -> tuple[PreviewSurface, str]:
    """A surface of some kind, its inputs and the nodes beside it, written as people write them."""
    text = f"""#usda 1.0
    def Material "M"
    {{
        color3f inputs:unset
        token outputs:mtlx:surface.connect = </M/S.outputs:out>
        {beside}
        def Shader "S"
        {{
            uniform token info:id = "{kind}"
            {inputs}
            token outputs:out
        }}
        {nodes}
    }}
    """
    (folder / "m.usda").write_text(text)
    stage = Usd.Stage.Open(str(folder / "m.usda"))
    surface, losses = read_preview_surface(UsdShade.Material(stage.GetPrimAtPath("/M")))
    return surface, "\n".join(losses)


def node(name: str, kind: str, inputs: str, output: str = "color3f outputs:out") -> str:
    return f'def Shader "{name}" {{\n uniform token info:id = "{kind}"\n {inputs}\n {output}\n }}\n'


IMAGE = node("I", "ND_image_color3", 'asset inputs:file = @a.png@ (colorSpace = "raw")')


def value(texture: Any, least: float = 0.0) -> list[float]:
    """What a texture is at its only texel."""
    assert isinstance(texture, Texture)
    channels = 3 if texture.channel == "rgb" else 1
    picture = load(texture, channels, (least, math.inf), np.eye(3))
    found: list[float] = picture.pixels[0, 0].astype(float).tolist()
    return found


def test_standard_surface_and_its_defaults(folder: Path) -> None:
    surface, losses = read(folder, STANDARD, "")
    assert losses == "" and surface.base_color == pytest.approx((0.8, 0.8, 0.8))
    assert (surface.roughness, surface.metallic, surface.ior) == (0.2, 0.0, 1.5)
    given = """
        float inputs:base = 0.5
        color3f inputs:base_color = (0.2, 0.4, 0.6)
        float inputs:metalness = 0.25
        float inputs:specular_roughness = 0.75
        float inputs:specular = 0.5
        float inputs:specular_IOR = 1.6
        color3f inputs:opacity = (0.25, 0.5, 0.75)
        float inputs:emission = 3
        color3f inputs:emission_color = (1, 2, 4)
        float inputs:coat = 0.5
        color3f inputs:coat_color = (1, 0.5, 0)
        float inputs:sheen = 0
        color3f inputs:sheen_color = (1, 0, 0)
        float inputs:thin_film_IOR = 2
        float inputs:diffuse_roughness = 0
        color3f inputs:subsurface_color.connect = </M.inputs:unset>
    """
    surface, losses = read(folder, STANDARD, given)
    assert losses == ""
    # A half coat takes a half of what its colour takes; the specular weight is one of reflectance.
    assert surface.base_color == pytest.approx((0.1, 0.15, 0.15))
    assert (surface.metallic, surface.roughness, surface.opacity) == (0.25, 0.75, 0.5)
    assert f0_of(surface.ior) == pytest.approx(0.5 * f0_of(1.6), rel=1e-6)
    assert surface.emissive == pytest.approx((3.0, 6.0, 12.0))
    assert (surface.clearcoat, surface.clearcoat_roughness) == (0.5, 0.1)
    assert surface.opacity_mode == "presence"


def test_open_pbr_and_its_defaults(folder: Path) -> None:
    surface, losses = read(folder, OPEN_PBR, "")
    assert losses == "" and surface.base_color == pytest.approx((0.8, 0.8, 0.8))
    assert (surface.roughness, surface.ior, surface.clearcoat) == (0.3, 1.5, 0.0)
    given = """
        color3f inputs:base_color = (0.2, 0.4, 0.6)
        float inputs:base_metalness = 1
        float inputs:emission_luminance = 100
        color3f inputs:emission_color = (1, 0.5, 0)
        float inputs:geometry_opacity = 0.5
        float inputs:coat_weight = 1
    """
    surface, losses = read(folder, OPEN_PBR, given)
    assert losses == "" and surface.emissive == pytest.approx((100.0, 50.0, 0.0))
    assert (surface.metallic, surface.opacity, surface.clearcoat) == (1.0, 0.5, 1.0)


@pytest.mark.parametrize(
    ("kind", "clear", "thin"),
    [
        (STANDARD, "transmission", "bool inputs:thin_walled = 1"),
        (OPEN_PBR, "transmission_weight", "bool inputs:geometry_thin_walled = 1"),
    ],
)
def test_clear_glass_is_a_pane(folder: Path, kind: str, clear: str, thin: str) -> None:
    given = f"float inputs:{clear} = 1\n color3f inputs:transmission_color = (0.5, 0.75, 1)\n"
    given += "float inputs:specular_roughness = 0\n"
    surface, losses = read(folder, kind, given + thin)
    assert (surface.pane, losses) == ((0.5, 0.75, 1.0), "")
    assert "without refraction" in read(folder, kind, given)[1]
    mixed, losses = read(folder, kind, given.replace(" = 1\n", " = 0.75\n", 1))
    assert mixed.pane is None and mixed.opacity == 0.25 and "straight through" in losses


def test_gltf_says_how_alpha_counts(folder: Path) -> None:
    given = "float inputs:alpha = 0.5\n int inputs:alpha_mode = {}\n"
    found = [read(folder, GLTF, given.format(mode))[0] for mode in range(3)]
    assert [surface.opacity for surface in found] == [1.0, 0.5, 0.5]
    assert [surface.opacity_threshold for surface in found] == [0.0, 0.5, 0.0]


def test_preview_surface_by_its_other_name(folder: Path) -> None:
    given = "color3f inputs:diffuseColor.connect = </M/I.outputs:out>\n"
    given += "float inputs:ior = 1.25\n float inputs:metallic.connect = </M/X.outputs:out>"
    extract = node(
        "X",
        "ND_extract_color3",
        "color3f inputs:in.connect = </M/I.outputs:out>\n int inputs:index = 2",
        "float outputs:out",
    )
    surface, losses = read(folder, PREVIEW, given, IMAGE + extract)
    assert losses == "" and surface.ior == 1.25
    assert value(surface.base_color) == pytest.approx([0.2, 0.4, 0.8], abs=1e-3)
    assert value(surface.metallic) == pytest.approx([0.8], abs=1e-3)


def test_what_is_left_out_is_named(folder: Path) -> None:
    given = """
        float inputs:subsurface = 0.5
        color3f inputs:subsurface_color = (1, 0, 0)
        float inputs:specular_anisotropy = 0.5
        color3f inputs:specular_color = (1, 0.5, 0.5)
        float inputs:of_another_make = 2
        float inputs:base.connect = </M/N.outputs:out>
    """
    noise = node("N", "ND_noise2d_float", "", "float outputs:out")
    surface, losses = read(folder, STANDARD, given, noise)
    assert surface.base_color == pytest.approx((0.8, 0.8, 0.8))
    for name in (
        "subsurface",
        "subsurface_color",
        "specular_anisotropy",
        "specular_color",
        "of_another_make",
    ):
        assert f"/M/S.{name}: it is left out" in losses
    assert "ND_noise2d_float cannot drive it" in losses and len(losses.splitlines()) == 6


# What a node makes of the picture's (0.2, 0.4, 0.8), by MaterialX's words.
OPERATIONS = {
    ("multiply", "color3f inputs:in2 = (0.5, 1, 2)"): (0.1, 0.4, 1.6),
    ("multiply", "float inputs:in2 = 0.5"): (0.1, 0.2, 0.4),
    ("divide", "color3f inputs:in2 = (2, 4, 8)"): (0.1, 0.1, 0.1),
    ("add", "color3f inputs:in2 = (0.1, 0.2, 0.3)"): (0.3, 0.6, 1.1),
    ("subtract", "color3f inputs:in2 = (0.1, 0.2, 0.3)"): (0.1, 0.2, 0.5),
    ("invert", ""): (0.8, 0.6, 0.2),
    ("remap", "float inputs:outlow = 1\n float inputs:outhigh = 3"): (1.4, 1.8, 2.6),
    ("mix", "color3f inputs:bg = (1, 1, 0)\n float inputs:mix = 0.25"): (0.8, 0.85, 0.2),
    ("dot", ""): (0.2, 0.4, 0.8),
}


@pytest.mark.parametrize("operation", OPERATIONS)
def test_operations_are_worked_into_the_texture(folder: Path, operation: tuple[str, str]) -> None:
    name, inputs = operation
    socket = {"mix": "fg"}.get(name, "in" if name in ("invert", "remap", "dot") else "in1")
    for kind, source in (("I", IMAGE), ("C", _constant())):
        picture = f"color3f inputs:{socket}.connect = </M/{kind}.outputs:out>\n"
        made = source + node("O", f"ND_{name}_color3", picture + inputs)
        given = "color3f inputs:base_color.connect = </M/O.outputs:out>"
        surface, losses = read(folder, STANDARD, given, made)
        assert losses == ""
        found = value(surface.base_color) if kind == "I" else surface.base_color
        assert found == pytest.approx(OPERATIONS[operation], abs=2e-3), kind


def _constant() -> str:
    return node("C", "ND_constant_color3", "color3f inputs:value = (0.2, 0.4, 0.8)")


def test_two_textures_in_one_are_told(folder: Path) -> None:
    both = "color3f inputs:in1.connect = </M/I.outputs:out>\n"
    made = IMAGE + node("O", "ND_multiply_color3", both + both.replace("in1", "in2"))
    surface, losses = read(
        folder, STANDARD, "color3f inputs:base_color.connect = </M/O.outputs:out>", made
    )
    assert value(surface.base_color) == pytest.approx([0.2, 0.4, 0.8], abs=1e-3)
    assert "of two textures is replaced by the first" in losses


@pytest.mark.parametrize(
    ("kind", "space", "encoded"),
    [
        ("color3", "srgb_texture", True),
        ("color3", "lin_rec709", False),
        ("color3", "", True),
        ("vector3", "", False),
    ],
)
def test_color_spaces_of_files(folder: Path, kind: str, space: str, encoded: bool) -> None:
    said = f'(colorSpace = "{space}")' if space else ""
    image = node("I", f"ND_image_{kind}", f"asset inputs:file = @a.png@ {said}")
    given = "color3f inputs:base_color.connect = </M/I.outputs:out>"
    surface, losses = read(folder, STANDARD, given, image)
    stored = PIXELS[0, 0] / 255.0
    expected = linear_from_srgb(stored) if encoded else stored
    assert losses == "" and value(surface.base_color) == pytest.approx(expected, abs=1e-3)


def test_constants_that_are_encoded(folder: Path) -> None:
    given = 'color3f inputs:base_color = (0.5, 0.25, 1) (colorSpace = "srgb_texture")'
    expected = linear_from_srgb(np.array([0.5, 0.25, 1.0]))
    assert read(folder, STANDARD, given)[0].base_color == pytest.approx(tuple(expected), abs=1e-6)


def test_normal_maps(folder: Path) -> None:
    image = IMAGE.replace("color3", "vector3")
    half = "float3 inputs:in.connect = </M/I.outputs:out>\n float inputs:scale = 0.5"
    made = image + node("O", "ND_normalmap", half)
    surface, losses = read(
        folder, STANDARD, "float3 inputs:normal.connect = </M/O.outputs:out>", made
    )
    assert losses == "" and value(surface.normal, -1.0) == pytest.approx(
        [-0.3, -0.1, 0.6], abs=2e-3
    )


@pytest.mark.parametrize("order", [0, 1])
def test_coordinates_by_the_formulas_of_materialx(folder: Path, order: int) -> None:
    """A tiled image behind a placement behind a product, computed step by step."""
    place = node(
        "P",
        "ND_place2d_vector2",
        f"""
        float2 inputs:texcoord.connect = </M/Q.outputs:out>
        float2 inputs:pivot = (0.5, 0.25)
        float2 inputs:scale = (2, 2)
        float inputs:rotate = 30
        float2 inputs:offset = (0.1, -0.2)
        int inputs:operationorder = {order}""",
        "float2 outputs:out",
    )
    times = node(
        "Q",
        "ND_multiply_vector2",
        """
        float2 inputs:in1.connect = </M/U.outputs:out>
        float2 inputs:in2 = (3, 3)""",
        "float2 outputs:out",
    )
    reader = node(
        "U", "ND_geompropvalue_vector2", 'string inputs:geomprop = "map2"', "float2 outputs:out"
    )
    image = node(
        "I",
        "ND_tiledimage_color3",
        """
        asset inputs:file = @a.png@
        float2 inputs:texcoord.connect = </M/P.outputs:out>
        float2 inputs:uvtiling = (4, 4)
        float2 inputs:uvoffset = (0.5, 0.25)""",
    )
    surface, losses = read(
        folder,
        STANDARD,
        "color3f inputs:base_color.connect = </M/I.outputs:out>",
        image + place + times + reader,
    )
    texture = surface.base_color
    assert losses == "" and isinstance(texture, Texture) and texture.primvar == "map2"
    x, y = 3 * 0.3 - 0.5, 3 * 0.7 - 0.25
    cos, sin = math.cos(math.radians(30)), math.sin(math.radians(30))
    if order:
        x, y = x - 0.1, y + 0.2
        x, y = cos * x + sin * y, -sin * x + cos * y
        x, y = x / 2 + 0.5, y / 2 + 0.25
    else:
        x, y = x / 2, y / 2
        x, y = cos * x + sin * y, -sin * x + cos * y
        x, y = x - 0.1 + 0.5, y + 0.2 + 0.25
    expected = 4 * x - 0.5, 4 * y - 0.25
    assert (texture.uv_matrix @ [0.3, 0.7, 1.0])[:2] == pytest.approx(expected)
    assert texture.wrap_s == "repeat"


TINT = "color3f inputs:in2 = (1, 0.5, 0.25)"
NUMBER = node("F", "ND_image_float", "asset inputs:file = @a.png@", "float outputs:out")


@pytest.mark.parametrize("by", ["weight", "node", "parts"])
def test_a_number_that_is_tinted_is_a_colour(folder: Path, by: str) -> None:
    weight = "float inputs:base.connect = </M/F.outputs:out>"
    color = "color3f inputs:base_color.connect = </M/T.outputs:out>"
    given, nodes = f"float inputs:base = 1\n{color}", NUMBER
    if by == "weight":
        given = f"{weight}\ncolor3f inputs:base_color = (1, 0.5, 0.25)"
    elif by == "node":
        red = "color3f inputs:in1.connect = </M/F.outputs:out>"
        nodes += node("T", "ND_multiply_color3", f"{red}\n{TINT}")
    else:
        parts = ""
        for number, share in enumerate((1.0, 0.5, 0.25), 1):
            by_share = f"float inputs:in1.connect = </M/F.outputs:out>\nfloat inputs:in2 = {share}"
            nodes += node(f"P{number}", "ND_multiply_float", by_share, "float outputs:out")
            parts += f"float inputs:in{number}.connect = </M/P{number}.outputs:out>\n"
        nodes += node("T", "ND_combine3_color3", parts)
    surface, losses = read(folder, STANDARD, given, nodes)
    texture = surface.base_color
    assert isinstance(texture, Texture) and losses == ""
    expected = 0.2 * np.array([1.0, 0.5, 0.25])
    whole = load(texture, 3, (0.0, 1.0), np.eye(3))
    coded = load_picture(texture, 3, (0.0, 1.0), np.eye(3), {})
    for picture in (whole, coded):
        assert picture.lookup(np.zeros(2)) == pytest.approx(expected, abs=1e-3)


def test_displacement_is_told(folder: Path) -> None:
    given = "token outputs:mtlx:displacement.connect = </M/S.outputs:out>"
    assert "mtlx:displacement: nothing is moved" in read(folder, STANDARD, "", "", given)[1]


def test_nodes_in_a_circle_end(folder: Path) -> None:
    made = node("O", "ND_multiply_color3", "color3f inputs:in1.connect = </M/O.outputs:out>")
    surface, losses = read(
        folder, STANDARD, "color3f inputs:base_color.connect = </M/O.outputs:out>", made
    )
    assert losses and isinstance(surface.base_color, tuple)


SURFACES = ("standard_surface", "open_pbr_surface", "gltf_pbr", "UsdPreviewSurface")
NODES = tuple(
    """
    image_color3 image_float tiledimage_color3 UsdUVTexture constant_color3
    convert_float_color3 dot_color3 multiply_color3 divide_color3FA add_float subtract_vector2
    mix_color3 invert_float remap_color3 clamp_vector3 extract_color4 separate3_color3
    swizzle_color3_float combine3_vector3 normalmap place2d_vector2 rotate2d_vector2
    texcoord_vector2 geompropvalue_vector2 noise2d
    """.split()
)
NAMES = tuple(
    """
    in in1 in2 in3 fg bg mix value amount low high inlow inhigh outlow outhigh index channels
    scale texcoord st default uvtiling uvoffset realworldimagesize pivot rotate offset
    operationorder geomprop uaddressmode fallback
    """.split()
)
INPUTS = tuple(
    """
    base base_color base_weight metalness specular specular_IOR specular_ior specular_weight
    specular_roughness opacity geometry_opacity emission emission_color coat coat_weight
    coat_color coat_roughness transmission transmission_color transmission_weight thin_walled
    normal geometry_normal alpha alpha_mode alpha_cutoff emissive diffuseColor roughness ior
    displacement sheen subsurface_color opacityMode
    """.split()
)
VALUES = [
    (kind, value)
    for kind, _, value in (
        pair.strip().partition(" ")
        for pair in """
    float nan | float inf | float 0 | float 1 | float -3.5 | float 1e38 | int -2147483648 |
    bool 1 | string "rgba" | token "constant" | asset @a.png@ | asset @none.png@ | asset @@ |
    float2 (0, 2) | float3 (1, nan, 2) | color3f (0.2, 0.5, 0.7) | color3f (-1e30, 0, 1e30) |
    float4 (1, 2, 3, 4) | float[] [] | float[] [1, 2, 3, 4, 5, 6] |
    matrix4d ((1,0,0,0),(0,1,0,0),(0,0,1,0),(0,0,0,1)) | half 0.5 | double 2 | string ""
    """.split("|")
    )
]


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


# Every input that MaterialX itself knows.


def _inputs_of(kind: str) -> dict[str, str]:
    """The inputs of a surface in MaterialX's own library, with their types."""
    library = pytest.importorskip("MaterialX")
    document = library.createDocument()
    folders = library.getDefaultDataLibraryFolders()
    library.loadLibraries(folders, library.getDefaultDataSearchPath(), document)
    found = document.getNodeDef(kind).getActiveInputs()
    return {one.getName(): one.getType() for one in found}


_USD_TYPES = {"float": "float", "boolean": "bool", "integer": "int", "string": "string"}
_USD_TYPES |= {"color3": "color3f", "vector3": "float3"}
# Numbers that no input has by itself, and that are in no input's way.
_OTHER = {"float": "0.37", "boolean": "1", "integer": "1", "string": '"other"'}
_OTHER |= {"color3": "(0.37, 0.11, 0.23)", "vector3": "(0.37, 0.11, 0.23)"}


GLOW = dict.fromkeys(("emission", "emission_luminance", "emissive", "emission_color"), "0.5")


@pytest.mark.parametrize("kind", [STANDARD, OPEN_PBR, GLTF])
def test_every_input_of_materialx_changes_the_surface_or_is_told(folder: Path, kind: str) -> None:
    inputs = _inputs_of(kind)
    assert len(inputs) > 20
    # Parts that are not there say nothing, a mask alone has a cutoff, a glow needs a colour.
    there = dict.fromkeys(uber._MODELS[kind].parts.values(), "0.5") | GLOW
    silent: list[str] = []
    known: dict[str, PreviewSurface] = {}
    for name, of in inputs.items():
        beside = there | {"alpha_mode": "1" if name == "alpha_cutoff" else "2"}
        if name.endswith("thin_walled"):
            # Thin glass is clear.
            beside |= dict.fromkeys(("transmission", "transmission_weight"), "1")
        context = "".join(
            _said(inputs[key], key, value)
            for key, value in beside.items()
            if key in inputs and key != name
        )
        value = "0" if of == "boolean" else _OTHER[of]
        if context not in known:
            known[context] = read(folder, kind, context)[0]
        before = known[context]
        after, losses = read(folder, kind, context + _said(of, name, value))
        changes = before != after or f".{name}:" in losses
        if of == "boolean":
            # It may be on by itself, and what follows from it may be told.
            changes |= read(folder, kind, context + _said(of, name, "1")) != (after, losses)
        if not changes:
            silent.append(name)
    assert silent == []


def _said(kind: str, name: str, value: str) -> str:
    width = 3 if kind in ("color3", "vector3") and "(" not in value else 1
    whole = f"({', '.join([value] * 3)})" if width == 3 else value
    return f"{_USD_TYPES[kind]} inputs:{name} = {whole}\n"
