"""UsdPreviewSurface: what is authored is read back, and foreign networks never break the reader."""

import cmath
import math
from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, UsdShade, UsdUtils

from openrooms_usd.errors import InputError
from openrooms_usd.usd.shading import textures
from openrooms_usd.usd.shading.materialreader import read_preview_surface
from openrooms_usd.usd.shading.materials import (
    PreviewSurface,
    Texture,
    bound_material,
    bound_subsets,
    define_preview_surface,
)
from openrooms_usd.usd.shading.surfaces import UvTransform, f0_of, ior_of

TYPES = Sdf.ValueTypeNames


def write_picture(path: Path, pixels: np.ndarray, kind: str = "uint8") -> str:
    spec = OpenImageIO.ImageSpec(pixels.shape[1], pixels.shape[0], pixels.shape[2], kind)
    spec.attribute("oiio:UnassociatedAlpha", 1)
    file = OpenImageIO.ImageOutput.create(str(path))
    assert file.open(str(path), spec) and file.write_image(pixels) and file.close()
    return str(path)


@pytest.fixture
def png(tmp_path: Path) -> str:
    pixels = np.arange(24, dtype=np.uint8).reshape(2, 4, 3) * 10
    return write_picture(tmp_path / "colors.png", pixels)


@pytest.fixture
def stage() -> Usd.Stage:
    return Usd.Stage.CreateInMemory()


def shader(stage: Usd.Stage, path: str, kind: str) -> UsdShade.Shader:
    node = UsdShade.Shader.Define(stage, path)
    node.CreateIdAttr(kind)
    return node


def surface(stage: Usd.Stage) -> tuple[UsdShade.Material, UsdShade.Shader]:
    material = UsdShade.Material.Define(stage, "/M")
    node = shader(stage, "/M/S", "UsdPreviewSurface")
    material.CreateSurfaceOutput().ConnectToSource(node.CreateOutput("surface", TYPES.Token))
    return material, node


def textured(stage: Usd.Stage, file: str, output: str = "rgb") -> UsdShade.Output:
    """A UsdUVTexture whose coordinates are the primvar ``UVMap``."""
    reader = shader(stage, "/M/R", "UsdPrimvarReader_float2")
    reader.CreateInput("varname", TYPES.String).Set("UVMap")
    node = shader(stage, "/M/T", "UsdUVTexture")
    node.CreateInput("file", TYPES.Asset).Set(file)
    node.CreateInput("sourceColorSpace", TYPES.Token).Set("sRGB")
    node.CreateInput("st", TYPES.Float2).ConnectToSource(
        reader.CreateOutput("result", TYPES.Float2)
    )
    kind = TYPES.Float3 if output == "rgb" else TYPES.Float
    return node.CreateOutput(output, kind)


def test_what_is_authored_is_read_back(stage: Usd.Stage, png: str) -> None:
    texture = Texture(
        png,
        "rgb",
        "sRGB",
        scale=(0.5, 0.5, 0.5, 1.0),
        bias=(0.25, 0.0, 0.0, 0.0),
        wrap_s="clamp",
        wrap_t="mirror",
        primvar="UVMap",
        uv_scale=(2.0, 4.0),
        uv_rotation=90.0,
        uv_translation=(0.5, -0.25),
        fallback=(1.0, 0.0, 0.0, 1.0),
    )
    normal = Texture(png, scale=(2.0, 2.0, 2.0, 1.0), bias=(-1.0, -1.0, -1.0, 0.0))
    given = PreviewSurface(
        base_color=texture,
        metallic=0.25,
        roughness=Texture(png, "g"),
        specular=(0.5, 0.25, 0.125),
        opacity=Texture(png, "a"),
        opacity_threshold=0.5,
        opacity_mode="presence",
        ior=1.25,
        emissive=(1.0, 2.0, 3.0),
        normal=normal,
        clearcoat=0.5,
        clearcoat_roughness=0.25,
        occlusion=Texture(png, "b"),
    )
    material = define_preview_surface(stage, "/M", given)
    assert read_preview_surface(material) == (given, ())


def test_defaults_author_nothing(stage: Usd.Stage) -> None:
    material = define_preview_surface(stage, "/M", PreviewSurface())
    assert not UsdShade.Shader(stage.GetPrimAtPath("/M/Surface")).GetInputs()
    assert read_preview_surface(material) == (PreviewSurface(), ())


def test_authored_networks_satisfy_the_core_validators(stage: Usd.Stage, png: str) -> None:
    from pxr import UsdValidation

    texture = Texture(png, uv_scale=(2.0, 2.0))
    normal = Texture(png, scale=(2.0, 2.0, 2.0, 1.0), bias=(-1.0, -1.0, -1.0, 0.0))
    UsdGeom.SetStageUpAxis(stage, "Z")
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    root = UsdGeom.Xform.Define(stage, "/World").GetPrim()
    stage.SetDefaultPrim(root)
    define_preview_surface(stage, "/World/M", PreviewSurface(base_color=texture, normal=normal))
    registry = UsdValidation.ValidationRegistry()
    errors = UsdValidation.ValidationContext(registry.GetOrLoadAllValidators()).Validate(stage)
    assert [error.GetMessage() for error in errors] == []


def test_uv_transform_scales_then_rotates_then_translates() -> None:
    rng = np.random.default_rng(5)
    for _ in range(20):
        scale, offset = rng.uniform(-3, 3, 2), rng.uniform(-3, 3, 2)
        degrees = float(rng.uniform(-400, 400))
        s, t = rng.uniform(-2, 2, 2)
        # The same by complex numbers: multiply by exp(i angle) to rotate counter-clockwise.
        point = complex(s * scale[0], t * scale[1]) * cmath.exp(1j * math.radians(degrees))
        expected = point + complex(*offset)
        matrix = UvTransform(tuple(scale), degrees, tuple(offset)).matrix
        assert matrix @ [s, t, 1.0] == pytest.approx([expected.real, expected.imag, 1.0])


def test_chained_transforms_act_in_the_order_of_the_chain(stage: Usd.Stage, png: str) -> None:
    material, node = surface(stage)
    output = textured(stage, png)
    node.CreateInput("diffuseColor", TYPES.Color3f).ConnectToSource(output)
    near, far = (
        shader(stage, "/M/Near", "UsdTransform2d"),
        shader(stage, "/M/Far", "UsdTransform2d"),
    )
    near.CreateInput("scale", TYPES.Float2).Set(Gf.Vec2f(2, 3))
    near.CreateInput("translation", TYPES.Float2).Set(Gf.Vec2f(1, 0))
    far.CreateInput("rotation", TYPES.Float).Set(90.0)
    far.CreateInput("translation", TYPES.Float2).Set(Gf.Vec2f(0, 5))
    reader = UsdShade.Shader(stage.GetPrimAtPath("/M/R"))
    far.CreateInput("in", TYPES.Float2).ConnectToSource(reader.GetOutput("result"))
    near.CreateInput("in", TYPES.Float2).ConnectToSource(far.CreateOutput("result", TYPES.Float2))
    texture = UsdShade.Shader(stage.GetPrimAtPath("/M/T"))
    texture.GetInput("st").ConnectToSource(near.CreateOutput("result", TYPES.Float2))
    read, losses = read_preview_surface(material)
    assert isinstance(read.base_color, Texture)
    # (s, t) -> far: (-t, s + 5) -> near: (-2 t + 1, 3 s + 15). By hand.
    assert read.base_color.uv_matrix @ [0.5, 0.25, 1.0] == pytest.approx([0.5, 16.5, 1.0])
    assert losses == ()
    far.GetInput("rotation").Set(45.0)
    assert "skew" in read_preview_surface(material)[1][0]


def test_node_graphs_and_interface_inputs_are_followed(stage: Usd.Stage, png: str) -> None:
    material, node = surface(stage)
    rough = material.CreateInput("rough", TYPES.Float)
    rough.Set(0.75)
    node.CreateInput("roughness", TYPES.Float).ConnectToSource(rough)
    graph = UsdShade.NodeGraph.Define(stage, "/M/Graph")
    inner = graph.CreateInput("picture", TYPES.Asset)
    outer = material.CreateInput("picture", TYPES.Asset)
    outer.Set(png)
    inner.ConnectToSource(outer)
    texture = shader(stage, "/M/Graph/T", "UsdUVTexture")
    texture.CreateInput("file", TYPES.Asset).ConnectToSource(inner)
    texture.CreateInput("sourceColorSpace", TYPES.Token).Set("raw")
    out = graph.CreateOutput("color", TYPES.Color3f)
    out.ConnectToSource(texture.CreateOutput("rgb", TYPES.Float3))
    node.CreateInput("diffuseColor", TYPES.Color3f).ConnectToSource(out)
    read, losses = read_preview_surface(material)
    assert read.roughness == pytest.approx(0.75)
    assert isinstance(read.base_color, Texture) and read.base_color.file == png
    assert len(losses) == 1 and "st is assumed" in losses[0]


@pytest.mark.parametrize("output", ["r", "g", "b", "a"])
def test_channels(stage: Usd.Stage, png: str, output: str) -> None:
    material, node = surface(stage)
    node.CreateInput("metallic", TYPES.Float).ConnectToSource(textured(stage, png, output))
    texture = read_preview_surface(material)[0].metallic
    assert isinstance(texture, Texture)
    assert (texture.channel, texture.primvar, texture.color_space) == (output, "UVMap", "sRGB")


def test_a_number_takes_the_first_channel_of_a_color(stage: Usd.Stage, png: str) -> None:
    material, node = surface(stage)
    node.CreateInput("metallic", TYPES.Float).ConnectToSource(textured(stage, png, "rgb"))
    texture = read_preview_surface(material)[0].metallic
    assert isinstance(texture, Texture) and texture.channel == "r"


def test_specular_workflow(stage: Usd.Stage) -> None:
    material, node = surface(stage)
    node.CreateInput("specularColor", TYPES.Color3f).Set(Gf.Vec3f(0.5, 0.5, 0.5))
    assert read_preview_surface(material)[0].specular is None
    node.CreateInput("useSpecularWorkflow", TYPES.Int).Set(1)
    assert read_preview_surface(material)[0].specular == (0.5, 0.5, 0.5)
    node.GetInput("specularColor").GetAttr().Clear()
    assert read_preview_surface(material)[0].specular == (0.0, 0.0, 0.0)


def test_a_picture_of_many_inputs_is_opened_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Until its file is another."""
    file = tmp_path / "orm.png"
    write_picture(file, np.zeros((2, 2, 3), np.uint8))
    rough, metal = (Texture(str(file), channel) for channel in "gb")
    stage, packed = Usd.Stage.CreateInMemory(), PreviewSurface(roughness=rough, metallic=metal)
    material = define_preview_surface(stage, "/M", packed)
    opened: list[str] = []
    real = textures._opened

    def counted(path: str) -> Any:
        opened.append(path)
        return real(path)

    monkeypatch.setattr(textures, "_opened", counted)
    assert read_preview_surface(material)[1] == () and opened == [str(file)]
    file.write_bytes(b"none")
    assert "cannot be read" in read_preview_surface(material)[1][0]


@pytest.mark.parametrize(
    ("channels", "kind", "suffix", "expected"),
    [
        (3, "uint8", "png", "sRGB"),
        (4, "uint8", "png", "sRGB"),
        (1, "uint8", "png", "raw"),
        (3, "uint16", "png", "raw"),
        (3, "float", "exr", "raw"),
    ],
)
def test_auto_color_space(
    stage: Usd.Stage, tmp_path: Path, channels: int, kind: str, suffix: str, expected: str
) -> None:
    file = write_picture(tmp_path / f"a.{suffix}", np.zeros((2, 2, channels), np.float32), kind)
    material, node = surface(stage)
    node.CreateInput("diffuseColor", TYPES.Color3f).ConnectToSource(textured(stage, file))
    UsdShade.Shader(stage.GetPrimAtPath("/M/T")).GetInput("sourceColorSpace").Set("auto")
    texture = read_preview_surface(material)[0].base_color
    assert isinstance(texture, Texture) and texture.color_space == expected


def test_usual_mistakes_with_normal_maps_are_mended_and_named(stage: Usd.Stage, png: str) -> None:
    material, node = surface(stage)
    node.CreateInput("normal", TYPES.Normal3f).ConnectToSource(textured(stage, png))
    read, losses = read_preview_surface(material)
    assert isinstance(read.normal, Texture)
    assert read.normal.color_space == "raw"
    assert (read.normal.scale[:3], read.normal.bias[:3]) == ((2.0,) * 3, (-1.0,) * 3)
    assert len(losses) == 2


def test_missing_pictures_leave_the_fallback(stage: Usd.Stage) -> None:
    material, node = surface(stage)
    node.CreateInput("diffuseColor", TYPES.Color3f).ConnectToSource(textured(stage, "/no/such.png"))
    read, losses = read_preview_surface(material)
    assert read.base_color == PreviewSurface.base_color
    assert "/no/such.png is missing" in losses[0]
    texture = UsdShade.Shader(stage.GetPrimAtPath("/M/T"))
    texture.CreateInput("fallback", TYPES.Float4).Set(Gf.Vec4f(1, 0.5, 0.25, 1))
    assert read_preview_surface(material)[0].base_color == (1.0, 0.5, 0.25)
    for channel, expected in zip("rgba", (1.0, 0.5, 0.25, 1.0), strict=True):
        output = texture.CreateOutput(channel, TYPES.Float)
        node.CreateInput("roughness", TYPES.Float).ConnectToSource(output)
        assert read_preview_surface(material)[0].roughness == expected
    texture.GetInput("file").Set("/no/<UDIM>.png")
    assert "UDIM" in read_preview_surface(material)[1][0]


@pytest.mark.filterwarnings("ignore")
def test_nothing_that_a_file_holds_raises(stage: Usd.Stage, png: str) -> None:
    assert read_preview_surface(UsdShade.Material())[1] == ("there is no material",)
    bare = UsdShade.Material.Define(stage, "/Bare")
    assert "no surface shader" in read_preview_surface(bare)[1][0]
    material, node = surface(stage)
    node.CreateInput("diffuseColor", TYPES.Color3f).Set(Gf.Vec3f(math.nan, 0, 0))
    node.CreateInput("roughness", TYPES.String).Set("rough")
    node.CreateInput("ior", TYPES.Float).Set(math.inf)
    node.CreateInput("displacement", TYPES.Float).Set(1.0)
    other = shader(stage, "/M/Other", "ND_noise2d_float")
    node.CreateInput("metallic", TYPES.Float).ConnectToSource(
        other.CreateOutput("out", TYPES.Float)
    )
    read, losses = read_preview_surface(material)
    assert read == PreviewSurface()
    assert len(losses) == 5
    node.CreateIdAttr("ND_disney_principled")
    assert "is not UsdPreviewSurface" in read_preview_surface(material)[1][0]


def test_primvars_of_numbers_have_a_fallback(stage: Usd.Stage) -> None:
    material, node = surface(stage)
    reader = shader(stage, "/M/R", "UsdPrimvarReader_float")
    reader.CreateInput("varname", TYPES.String).Set("wear")
    reader.CreateInput("fallback", TYPES.Float).Set(0.25)
    node.CreateInput("metallic", TYPES.Float).ConnectToSource(
        reader.CreateOutput("result", TYPES.Float)
    )
    read, losses = read_preview_surface(material)
    assert read.metallic == 0.25 and read.painted == (("metallic", "wear"),) and not losses
    node.CreateInput("clearcoat", TYPES.Float).ConnectToSource(
        reader.CreateOutput("result", TYPES.Float)
    )
    _, losses = read_preview_surface(material)
    assert "UsdPrimvarReader_float cannot drive it" in losses[0]


def test_transforms_in_a_circle_end(stage: Usd.Stage, png: str) -> None:
    material, node = surface(stage)
    node.CreateInput("diffuseColor", TYPES.Color3f).ConnectToSource(textured(stage, png))
    loop = shader(stage, "/M/Loop", "UsdTransform2d")
    result = loop.CreateOutput("result", TYPES.Float2)
    loop.CreateInput("in", TYPES.Float2).ConnectToSource(result)
    UsdShade.Shader(stage.GetPrimAtPath("/M/T")).GetInput("st").ConnectToSource(result)
    assert isinstance(read_preview_surface(material)[0].base_color, Texture)


def test_pictures_inside_packages(tmp_path: Path, png: str) -> None:
    source = Usd.Stage.CreateNew(str(tmp_path / "a.usda"))
    material = define_preview_surface(
        source, "/M", PreviewSurface(base_color=Texture("./colors.png", color_space="sRGB"))
    )
    source.SetDefaultPrim(material.GetPrim())
    source.Save()
    assert UsdUtils.CreateNewUsdzPackage(str(tmp_path / "a.usda"), str(tmp_path / "a.usdz"))
    stage = Usd.Stage.Open(str(tmp_path / "a.usdz"))
    texture = read_preview_surface(UsdShade.Material(stage.GetPrimAtPath("/M")))[0].base_color
    assert isinstance(texture, Texture) and texture.file.endswith("a.usdz[colors.png]")
    expected = np.arange(24).reshape(2, 4, 3) * 10 / 255
    np.testing.assert_allclose(textures.read_texture(texture.file), expected, atol=1e-6)
    assert textures.texture_size(texture.file) == (4, 2)
    with pytest.raises(InputError, match="no such file in the package"):
        textures.read_texture(f"{tmp_path}/a.usdz[other.png]")


def test_alpha_is_not_multiplied_into_the_color(tmp_path: Path) -> None:
    pixels = np.full((2, 2, 4), 200, np.uint8)
    pixels[..., 3] = 100
    read = textures.read_texture(write_picture(tmp_path / "a.png", pixels))
    np.testing.assert_allclose(read[0, 0] * 255, [200, 200, 200, 100], atol=1e-3)


def test_unreadable_pictures_are_refused(tmp_path: Path, png: str) -> None:
    with pytest.raises(InputError, match="no such file"):
        textures.read_texture(str(tmp_path / "none.png"))
    (tmp_path / "text.png").write_text("no picture")
    with pytest.raises(InputError, match="picture"):
        textures.read_texture(str(tmp_path / "text.png"))
    noise = np.random.default_rng(0).integers(0, 255, (64, 64, 3), np.uint8)
    whole = Path(write_picture(tmp_path / "whole.png", noise)).read_bytes()
    (tmp_path / "half.png").write_bytes(whole[: len(whole) // 2])
    with pytest.raises(InputError, match="unreadable"):
        textures.read_texture(str(tmp_path / "half.png"))


def test_bindings_of_meshes_subsets_and_instances(stage: Usd.Stage) -> None:
    model = UsdGeom.Xform.Define(stage, "/Model").GetPrim()
    whole = define_preview_surface(stage, "/Model/Whole", PreviewSurface())
    part = define_preview_surface(stage, "/Model/Part", PreviewSurface())
    mesh = UsdGeom.Mesh.Define(stage, "/Model/Mesh")
    mesh.CreateFaceVertexCountsAttr([3, 3, 3])
    assert bound_material(mesh.GetPrim()) is None
    api = UsdShade.MaterialBindingAPI.Apply(mesh.GetPrim())
    api.Bind(whole)
    subset = api.CreateMaterialBindSubset("some", [0, 2])
    UsdShade.MaterialBindingAPI.Apply(subset.GetPrim()).Bind(part)
    copy = stage.DefinePrim("/Copy")
    copy.GetReferences().AddInternalReference(model.GetPath())
    copy.SetInstanceable(True)
    for path in ("/Model", "/Copy"):
        prim = stage.GetPrimAtPath(f"{path}/Mesh")
        bound = bound_material(prim)
        assert bound is not None and bound.GetPath().name == "Whole"
        [(faces, material)] = bound_subsets(prim)
        assert faces.tolist() == [0, 2] and material.GetPath().name == "Part"


def test_bindings_by_strength_purpose_and_collection(stage: Usd.Stage) -> None:
    materials = {
        name: define_preview_surface(stage, f"/Looks/{name}", PreviewSurface())
        for name in ("Weak", "Own", "Full", "Preview", "Set", "Strong")
    }
    parent = UsdGeom.Xform.Define(stage, "/Parent").GetPrim()
    child = UsdGeom.Cube.Define(stage, "/Parent/Group/Child").GetPrim()
    above, own = (UsdShade.MaterialBindingAPI.Apply(prim) for prim in (parent, child))

    def bound() -> str:
        found = bound_material(child)
        return found.GetPath().name if found else ""

    assert bound() == ""
    own.Bind(materials["Preview"], materialPurpose=UsdShade.Tokens.preview)
    assert bound() == "Preview"
    above.Bind(materials["Weak"])
    assert bound() == "Weak"
    own.Bind(materials["Own"])
    assert bound() == "Own"
    own.Bind(materials["Preview"], materialPurpose=UsdShade.Tokens.preview)
    assert bound() == "Own"
    own.Bind(materials["Full"], materialPurpose=UsdShade.Tokens.full)
    assert bound() == "Full"
    for relationship in own.GetDirectBindingRel("full"), own.GetDirectBindingRel():
        child.RemoveProperty(relationship.GetName())
    collection = Usd.CollectionAPI.Apply(parent, "some")
    collection.CreateIncludesRel().AddTarget(child.GetPath())
    above.Bind(collection, materials["Set"])
    assert bound() == "Set"
    collection.CreateExcludesRel().AddTarget(child.GetPath())
    assert bound() == "Weak"
    own.Bind(materials["Own"])
    above.Bind(materials["Strong"], UsdShade.Tokens.strongerThanDescendants)
    assert bound() == "Strong"


def test_openrooms_reflectance_is_kept_and_shown_by_an_index_of_refraction() -> None:
    stage = Usd.Stage.CreateInMemory()
    material = define_preview_surface(stage, "/Paint", PreviewSurface(f0=0.05))
    assert "OpenRoomsMaterialAPI" in material.GetPrim().GetPrimTypeInfo().GetAppliedAPISchemas()
    shader = UsdShade.Shader(stage.GetPrimAtPath("/Paint/Surface"))
    assert shader.GetInput("ior").Get() == pytest.approx(1.576, abs=5e-4)
    assert f0_of(ior_of(0.05)) == pytest.approx(0.05)
    surface, losses = read_preview_surface(material)
    assert surface.f0 == pytest.approx(0.05) and not losses
    material.GetPrim().GetAttribute("openrooms:material:f0").Set(1.5)
    surface, losses = read_preview_surface(material)
    assert surface.f0 is None and any("f0" in loss for loss in losses)
    plain = define_preview_surface(stage, "/Plain", PreviewSurface())
    assert not plain.GetPrim().GetAttribute("openrooms:material:f0")
    assert read_preview_surface(plain)[0].f0 is None
