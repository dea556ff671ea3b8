"""MaterialX: what maps, by value; what does not, by name."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from openrooms_usd.errors import InputError, MissingPackageError
from openrooms_usd.library.ownmaterials import OwnMaterial, files_of, read_material
from openrooms_usd.library.pictures import write_png
from openrooms_usd.usd.shading.surfaces import NORMAL_BIAS, NORMAL_SCALE, f0_of

pytest.importorskip("MaterialX")
Read = Callable[..., OwnMaterial]


def number(name: str, value: Any, kind: str = "float", **more: str) -> str:
    extra = "".join(f' {key}="{text}"' for key, text in more.items())
    return f'<input name="{name}" type="{kind}" value="{value}"{extra}/>'


def link(name: str, kind: str, node: str, output: str = "") -> str:
    end = f' output="{output}"' if output else ""
    return f'<input name="{name}" type="{kind}" nodename="{node}"{end}/>'


def image(name: str, file: str, kind: str = "color3", node: str = "image", inner: str = "") -> str:
    space = ' colorspace="srgb_texture"' if kind == "color3" else ""
    source = f'<input name="file" type="filename" value="{file}"{space}/>'
    return f'<{node} name="{name}" type="{kind}">{source}{inner}</{node}>'


@pytest.fixture
def read(tmp_path: Path) -> Read:
    """Read a file with one material whose shader has the given inputs, beside other nodes."""
    (tmp_path / "maps").mkdir()
    for seed, name in enumerate(("a", "b", "n")):
        pixels = np.random.default_rng(seed).integers(0, 256, (4, 4, 3)).astype(np.uint8)
        write_png(tmp_path / f"maps/{name}.png", pixels, is_color=name == "a")

    def from_text(inputs: str, nodes: str = "", shader: str = "standard_surface") -> OwnMaterial:
        path = tmp_path / "m.mtlx"
        path.write_text(
            f'<?xml version="1.0"?><materialx version="1.38" colorspace="lin_rec709">{nodes}'
            f'<{shader} name="S" type="surfaceshader">{inputs}</{shader}>'
            '<surfacematerial name="Oak" type="material">'
            '<input name="surfaceshader" type="surfaceshader" nodename="S"/>'
            "</surfacematerial></materialx>"
        )
        return read_material(path, physical_size=1.0)

    return from_text


CONSTANTS = {
    "standard_surface": ("base_color", "metalness", "specular_roughness", "specular_IOR", "coat"),
    "open_pbr_surface": (
        "base_color",
        "base_metalness",
        "specular_roughness",
        "specular_ior",
        "coat_weight",
    ),
    "gltf_pbr": ("base_color", "metallic", "roughness", "ior", "clearcoat"),
    "UsdPreviewSurface": ("diffuseColor", "metallic", "roughness", "ior", "clearcoat"),
}


@pytest.mark.parametrize("shader", sorted(CONSTANTS))
def test_constants_of_every_shader(read: Read, shader: str) -> None:
    color, metallic, roughness, ior, coat = CONSTANTS[shader]
    material = read(
        number(color, "0.1, 0.2, 0.3", "color3")
        + number(metallic, 0.25)
        + number(roughness, 0.75)
        + number(ior, 1.4)
        + number(coat, 0.125),
        shader=shader,
    )
    surface = material.surface
    assert surface.base_color == pytest.approx((0.1, 0.2, 0.3))
    assert (surface.metallic, surface.roughness) == (0.25, 0.75)
    assert surface.ior == np.float32(1.4)
    assert surface.clearcoat == 0.125
    assert surface.f0 is None
    assert material.name == "Oak"
    assert material.losses == ()


@pytest.mark.parametrize(
    ("shader", "color", "metallic", "roughness"),
    [
        ("standard_surface", 0.8, 0.0, 0.2),
        ("open_pbr_surface", 0.8, 0.0, 0.3),
        ("gltf_pbr", 1.0, 1.0, 1.0),
        ("UsdPreviewSurface", 0.18, 0.0, 0.5),
    ],
)
def test_what_is_not_said_has_the_default_of_its_own_shader(
    read: Read, shader: str, color: float, metallic: float, roughness: float
) -> None:
    surface = read("", shader=shader).surface
    assert surface.base_color == pytest.approx((color,) * 3)
    assert (surface.metallic, surface.roughness) == (metallic, pytest.approx(roughness))


def test_weights_and_encoded_constants(read: Read) -> None:
    surface = read(
        number("base", 0.5)
        + number("specular", 0.25)
        + number("base_color", "0.5, 0.5, 0.02", "color3", colorspace="srgb_texture")
    ).surface
    middle = ((0.5 + 0.055) / 1.055) ** 2.4
    assert surface.base_color == pytest.approx((middle / 2, middle / 2, 0.02 / 12.92 / 2))
    assert f0_of(surface.ior) == pytest.approx(0.25 * 0.04)


def test_images_their_spaces_channels_and_arithmetic(read: Read) -> None:
    nodes = (
        image("A", "maps/a.png", node="tiledimage", inner=number("uvtiling", "3, 2", "vector2"))
        + image("B", "maps/b.png", "vector3")
        + f'<extract name="E" type="float">{link("in", "vector3", "B")}'
        + f"{number('index', 1, 'integer')}</extract>"
        + f'<invert name="I" type="float">{link("in", "float", "E")}</invert>'
        + f'<multiply name="M" type="float">{link("in1", "float", "I")}{number("in2", 0.5)}'
        + "</multiply>"
        + f'<separate3 name="P" type="multioutput">{link("in", "vector3", "B")}</separate3>'
    )
    surface = read(
        link("base_color", "color3", "A")
        + link("specular_roughness", "float", "M")
        + link("metalness", "float", "P", "outz"),
        nodes,
    ).surface
    base, rough, metal = surface.base_color, surface.roughness, surface.metallic
    assert (base.color_space, base.channel, base.uv_scale) == ("sRGB", "rgb", (3.0, 2.0))  # type: ignore[union-attr]
    assert (rough.color_space, rough.channel) == ("raw", "g")  # type: ignore[union-attr]
    # (1 - x) / 2 of the green channel.
    assert 0.3 * rough.scale[1] + rough.bias[1] == pytest.approx(0.35)  # type: ignore[union-attr]
    assert metal.channel == "b"  # type: ignore[union-attr]
    assert Path(base.file).name == "a.png"  # type: ignore[union-attr]


@pytest.mark.parametrize("strength", [1.0, 0.5])
def test_normal_maps(read: Read, strength: float) -> None:
    nodes = image("N", "maps/n.png", "vector3") + (
        f'<normalmap name="NM" type="vector3">{link("in", "vector3", "N")}'
        f"{number('scale', strength)}</normalmap>"
    )
    normal = read(link("normal", "vector3", "NM"), nodes).surface.normal
    expected = np.array([strength, strength, 1.0, 1.0])
    assert np.allclose(normal.scale, expected * NORMAL_SCALE)  # type: ignore[union-attr]
    assert np.allclose(normal.bias, expected * NORMAL_BIAS)  # type: ignore[union-attr]


def test_graphs_with_interfaces_and_prefixes(read: Read, tmp_path: Path) -> None:
    nodes = (
        '<nodegraph name="G" fileprefix="maps/">'
        '<input name="which" type="filename" value="b.png"/>'
        '<image name="A" type="float"><input name="file" type="filename" interfacename="which"/>'
        '</image><output name="o" type="float" nodename="A"/></nodegraph>'
    )
    surface = read(
        '<input name="specular_roughness" type="float" nodegraph="G" output="o"/>', nodes
    ).surface
    assert surface.roughness.file == str(tmp_path / "maps/b.png")  # type: ignore[union-attr]
    assert files_of(tmp_path / "m.mtlx") == [tmp_path / "m.mtlx", tmp_path / "maps/b.png"]


def test_a_stated_size_of_the_picture_in_the_world(read: Read, tmp_path: Path) -> None:
    inner = number(
        "realworldimagesize", "50, 25", "vector2", unittype="distance", unit="centimeter"
    ) + number("uvoffset", "0.5, 1", "vector2")
    base = read(
        link("base_color", "color3", "A"), image("A", "maps/a.png", node="tiledimage", inner=inner)
    )
    placed = read_material(tmp_path / "m.mtlx").in_metres("t").base_color
    assert placed.uv_scale == pytest.approx((2.0, 4.0))  # type: ignore[union-attr]
    # (st - offset) / size.
    assert placed.uv_translation == pytest.approx((-1.0, -4.0))  # type: ignore[union-attr]
    assert base.losses == ()


def test_place2d_is_the_transform_of_the_specification(read: Read) -> None:
    place = (
        '<texcoord name="T" type="vector2"/><place2d name="L" type="vector2">'
        f"{link('texcoord', 'vector2', 'T')}{number('scale', '2, 4', 'vector2')}"
        f"{number('rotate', 30)}{number('pivot', '0.5, 0.25', 'vector2')}"
        f"{number('offset', '0.1, -0.2', 'vector2')}</place2d>"
    )
    inner = link("texcoord", "vector2", "L")
    texture = read(
        link("base_color", "color3", "A"), place + image("A", "maps/a.png", inner=inner)
    ).surface.base_color
    st = np.array([0.7, 0.9])
    x, y = (st - (0.5, 0.25)) / (2, 4)
    c, s = np.cos(np.radians(30)), np.sin(np.radians(30))
    expected = np.array([c * x + s * y, -s * x + c * y]) - (0.1, -0.2) + (0.5, 0.25)
    assert np.allclose(texture.uv_matrix @ [*st, 1.0], [*expected, 1.0])  # type: ignore[union-attr]


def test_what_does_not_map_is_named(read: Read) -> None:
    nodes = (
        '<noise2d name="Grain" type="float"/>'
        + image("A", "maps/a.png")
        + image("B", "maps/b.png")
        + (
            f'<multiply name="Both" type="color3">{link("in1", "color3", "A")}'
            f"{link('in2', 'color3', 'B')}</multiply>"
        )
    )
    losses = " | ".join(
        read(
            link("metalness", "float", "Grain")
            + link("base_color", "color3", "Both")
            + number("sheen", 0.5)
            + number("transmission", 0.3)
            + number("subsurface", 0.1)
            + number("emission", 1.0),
            nodes,
        ).losses
    )
    lost = "noise2d", "Both.in2: ND_multiply_color3 of two textures", "transmission", "emission"
    for name in (*lost, "sheen", "subsurface"):
        assert name in losses


def test_clear_glass_is_a_pane_and_a_coat_dims_what_is_below(read: Read) -> None:
    glass = number("transmission", 1.0) + number("specular_roughness", 0.0)
    glass += number("thin_walled", "true", "boolean")
    material = read(glass + number("transmission_color", "0.5, 0.75, 1", "color3"))
    assert (material.surface.pane, material.losses) == ((0.5, 0.75, 1.0), ())
    coat = number("coat", 0.5) + number("coat_color", "1, 0, 0", "color3")
    assert read(coat).surface.base_color == pytest.approx((0.8, 0.4, 0.4))


def test_images_of_gltf(read: Read) -> None:
    color = number("color", "0.5, 0.25, 1, 1", "color4")
    nodes = (
        image("C", "maps/a.png", "color3", "gltf_colorimage", color).replace(
            'type="color3">', 'type="multioutput">'
        )
        + image("R", "maps/b.png", "float", "gltf_image", number("factor", 0.5))
        + image("N", "maps/n.png", "vector3", "gltf_normalmap")
    )
    inputs = link("base_color", "color3", "C", "outcolor") + link("normal", "vector3", "N")
    inputs += link("roughness", "float", "R") + link("occlusion", "float", "R")
    material = read(inputs, nodes, "gltf_pbr")
    maps = material.textures
    assert (maps["base_color"].scale, maps["base_color"].color_space) == ((0.5, 0.25, 1, 1), "sRGB")
    assert (maps["roughness"].channel, maps["roughness"].scale[0]) == ("r", 0.5)
    assert maps["occlusion"] == maps["roughness"]
    assert (maps["normal"].scale, maps["normal"].bias) == (NORMAL_SCALE, NORMAL_BIAS)
    assert material.losses == ()


def test_lobes_without_weight_and_defaults_are_not_named(read: Read) -> None:
    inputs = (
        number("coat", 0.0)
        + number("coat_color", "1, 0, 0", "color3")
        + number("sheen", 0.0)
        + number("sheen_color", "0, 1, 0", "color3")
        + number("specular_anisotropy", 0.0)
    )
    assert read(inputs).losses == ()


@pytest.mark.parametrize(("mode", "opacity", "threshold"), [(0, 1, 0), (1, 0.5, 0.4), (2, 0.5, 0)])
def test_alpha_of_gltf(read: Read, mode: int, opacity: float, threshold: float) -> None:
    inputs = number("alpha", 0.5) + number("alpha_mode", mode, "integer")
    surface = read(inputs + number("alpha_cutoff", 0.4), shader="gltf_pbr").surface
    assert (surface.opacity, surface.opacity_threshold) == (opacity, np.float32(threshold))


def test_other_surfaces_and_empty_documents_are_refused(read: Read, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="disney_principled"):
        read("", shader="disney_principled")
    (tmp_path / "empty.mtlx").write_text('<materialx version="1.39"/>')
    with pytest.raises(InputError, match="it has no surface"):
        read_material(tmp_path / "empty.mtlx")


@pytest.mark.parametrize("value", ["nan, 0, 0", "1e999, 0, 0"])
def test_values_that_are_no_numbers_are_refused(read: Read, value: str) -> None:
    with pytest.raises(InputError, match="not finite"):
        read(number("base_color", value, "color3"))


def test_cycles_end(read: Read) -> None:
    nodes = "".join(
        f'<dot name="{a}" type="float">{link("in", "float", b)}</dot>' for a, b in ("PQ", "QP")
    )
    assert read(link("specular_roughness", "float", "P"), nodes).surface.roughness == 0.2


def test_without_the_package_the_extra_is_named(
    read: Read, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    read("")
    monkeypatch.setitem(__import__("sys").modules, "MaterialX", None)
    with pytest.raises(MissingPackageError, match=r"openrooms-usd\[materialx\]"):
        read_material(tmp_path / "m.mtlx")


SHADER = (
    '<standard_surface name="S" type="surfaceshader">'
    '<input name="base_color" type="color3" {}/></standard_surface>'
)
IMAGE = '<image name="I" type="color3"><input name="file" type="filename" value="{}"/></image>'
INCLUDE = '<xi:include href="{}"/>'


def write(folder: Path, body: str, *, head: str = "", name: str = "m.mtlx") -> Path:
    folder.mkdir(exist_ok=True)
    path = folder / name
    space = 'xmlns:xi="http://www.w3.org/2001/XInclude"'
    path.write_text(
        f'<?xml version="1.0"?>{head}<materialx version="1.39" {space}>{body}</materialx>'
    )
    return path


def textured(folder: Path, file: str) -> Path:
    return write(folder, IMAGE.format(file) + SHADER.format('nodename="I"'))


ENTITIES = {
    "external": '<!DOCTYPE m [<!ENTITY x SYSTEM "file:///etc/passwd">]>',
    "laughs": '<!DOCTYPE m [<!ENTITY a "aa"><!ENTITY b "&a;&a;"><!ENTITY c "&b;&b;">]>',
    "plain": "<!DOCTYPE materialx>",
    "lower case": "<!doctype materialx>",
}


@pytest.mark.parametrize("kind", sorted(ENTITIES))
def test_entities_are_refused(tmp_path: Path, kind: str) -> None:
    path = write(tmp_path, SHADER.format('value="1,1,1"'), head=ENTITIES[kind])
    for read in (read_material, files_of):
        with pytest.raises(InputError, match="DOCTYPE or entities"):
            read(path)


def test_entities_in_another_encoding_are_refused(tmp_path: Path) -> None:
    path = write(tmp_path, "", head=ENTITIES["external"])
    path.write_bytes(path.read_text().encode("utf-16"))
    with pytest.raises(InputError, match="declares a DOCTYPE or entities"):
        read_material(path)


BROKEN = {
    "cut": "<materialx version='1.39'><image",
    "deep": "<materialx version='1.39'>" + "<a>" * 5000 + "</a>" * 5000 + "</materialx>",
    "no XML": "once upon a time",
    "nothing": "",
    "no MaterialX": "<html/>",
    "version": "<materialx version='one'/>",
}


@pytest.mark.parametrize("kind", sorted(BROKEN))
def test_broken_files_are_refused(tmp_path: Path, kind: str) -> None:
    path = tmp_path / "m.mtlx"
    path.write_text(BROKEN[kind])
    with pytest.raises(InputError):
        read_material(path)


def test_includes_below_the_folder_are_read(tmp_path: Path) -> None:
    write(tmp_path / "parts", SHADER.format('value="0.5, 0.25, 0.125"'), name="s.mtlx")
    path = write(tmp_path, INCLUDE.format("parts/s.mtlx"))
    assert read_material(path).surface.base_color == (0.5, 0.25, 0.125)
    assert files_of(path) == [path, tmp_path / "parts/s.mtlx"]


@pytest.mark.parametrize("absolute", [False, True])
def test_includes_outside_the_folder_are_refused(tmp_path: Path, absolute: bool) -> None:
    outside = write(tmp_path, SHADER.format('value="1,1,1"'), name="outside.mtlx")
    href = str(outside) if absolute else "../outside.mtlx"
    path = write(tmp_path / "inside", INCLUDE.format(href))
    with pytest.raises(InputError, match="lies outside its folder"):
        read_material(path)


def test_included_files_are_checked_too(tmp_path: Path) -> None:
    write(tmp_path, "", head=ENTITIES["laughs"], name="s.mtlx")
    with pytest.raises(InputError, match="DOCTYPE or entities"):
        read_material(write(tmp_path, INCLUDE.format("s.mtlx")))


def test_includes_that_include_each_other_end(tmp_path: Path) -> None:
    write(tmp_path, INCLUDE.format("m.mtlx"), name="s.mtlx")
    with pytest.raises(InputError, match="cycle"):
        read_material(write(tmp_path, INCLUDE.format("s.mtlx")))


def test_pictures_outside_the_folder_are_refused(tmp_path: Path) -> None:
    write_png(tmp_path / "secret.png", np.zeros((2, 2, 3), np.uint8), is_color=True)
    with pytest.raises(InputError, match=r"names \.\./secret\.png, which lies outside"):
        read_material(textured(tmp_path / "inside", "../secret.png"))
    (tmp_path / "inside/link.png").symlink_to(tmp_path / "secret.png")
    with pytest.raises(InputError, match="lies outside"):
        read_material(textured(tmp_path / "inside", "link.png"))


def test_the_users_own_pictures_may_be_absolute(tmp_path: Path) -> None:
    write_png(tmp_path / "mine.png", np.zeros((2, 2, 3), np.uint8), is_color=True)
    path = textured(tmp_path / "inside", str(tmp_path / "mine.png"))
    material = read_material(path)
    assert material.textures["base_color"].file == str(tmp_path / "mine.png")
    assert tmp_path / "mine.png" in files_of(path)


def test_missing_pictures_are_one_error_that_names_them(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"I\.file: .*lost\.png is missing") as caught:
        read_material(textured(tmp_path, "lost.png"))
    assert "copy them into the folder" in str(caught.value)


def test_tiles_of_pictures_are_left_out_and_named(tmp_path: Path) -> None:
    material = read_material(textured(tmp_path, "wood.&lt;UDIM&gt;.png"))
    assert material.textures == {}
    assert any("UDIM" in loss for loss in material.losses)


def test_a_grey_normal_map_is_left_out(tmp_path: Path) -> None:
    write_png(tmp_path / "n.png", np.full((4, 4), 200, np.uint8), is_color=False)
    body = (
        '<image name="I" type="vector3"><input name="file" type="filename" value="n.png"/></image>'
        '<normalmap name="N" type="vector3"><input name="in" type="vector3" nodename="I"/>'
        '</normalmap><standard_surface name="S" type="surfaceshader">'
        '<input name="normal" type="vector3" nodename="N"/></standard_surface>'
    )
    material = read_material(write(tmp_path, body))
    assert material.surface.normal == (0.0, 0.0, 1.0)
    assert any("n.png: left out" in loss for loss in material.losses)
