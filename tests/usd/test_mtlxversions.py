"""Documents of older versions of MaterialX are what MaterialX's own upgrade makes of them."""

from pathlib import Path
from xml.etree import ElementTree

import MaterialX
import numpy as np
import pytest
from pxr import Usd, UsdShade

from openrooms_usd.colorimetry import linear_from_srgb
from openrooms_usd.imagefile import write
from openrooms_usd.rendering.scene.pictures import load
from openrooms_usd.usd.shading.materialreader import read_preview_surface
from openrooms_usd.usd.shading.mtlxlayers import MATERIALS, layer_of
from openrooms_usd.usd.shading.surfaces import PreviewSurface, Texture

PIXEL = (40, 120, 250, 90)
DOCUMENT = """<?xml version="1.0"?>
<materialx version="1.38">
  <nodegraph name="NG">
    <image name="packed" type="color4">
      <input name="file" type="filename" value="packed.png"/>
    </image>
    <constant name="four" type="color4">
      <input name="value" type="color4" value="0.1, 0.2, 0.3, 0.4"/>
    </constant>
    {nodes}
  </nodegraph>
  <standard_surface name="S" type="surfaceshader">
    {inputs}
  </standard_surface>
  <surfacematerial name="M" type="material">
    <input name="surfaceshader" type="surfaceshader" nodename="S"/>
  </surfacematerial>
</materialx>"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    pixels = np.full((2, 2, 4), PIXEL, np.uint8)
    write(tmp_path / "packed.png", pixels, "uint8", {"oiio:UnassociatedAlpha": 1})
    return tmp_path


def surface_of(text: str, folder: Path) -> tuple[PreviewSurface, tuple[str, ...]]:
    layer = layer_of(ElementTree.fromstring(text), str(folder / "a.mtlx"))
    stage = Usd.Stage.Open(layer)
    return read_preview_surface(UsdShade.Material(stage.GetPrimAtPath(f"{MATERIALS}/M")))


def upgraded(text: str) -> str:
    """The same in the words of today, by MaterialX itself."""
    document = MaterialX.createDocument()
    MaterialX.readFromXmlString(document, text)
    assert document.getVersionString() == "1.39"
    found: str = MaterialX.writeToXmlString(document)
    assert "channels" not in found
    return found


def shown(value: object, channels: int) -> np.ndarray:
    if isinstance(value, Texture):
        return load(value, channels, (0.0, 10.0), np.eye(3)).pixels[0, 0]
    return np.atleast_1d(np.asarray(value))


def out(kind: str, channels: str, node: str = "packed") -> str:
    return f'<output name="o" type="{kind}" nodename="{node}" channels="{channels}"/>'


def swizzled(kind: str, channels: str, node: str = "packed") -> str:
    return f"""<swizzle name="s" type="{kind}">
      <input name="in" type="color4" nodename="{node}"/>
      <input name="channels" type="string" value="{channels}"/>
    </swizzle>
    <output name="o" type="{kind}" nodename="s"/>"""


ROUGH = '<input name="specular_roughness" type="float" nodegraph="NG" output="o"/>'
COLOR = '<input name="base_color" type="color3" nodegraph="NG" output="o"/>'
SCALED = """<multiply name="m" type="{kind}">
      <input name="in1" type="{kind}" nodename="packed" channels="{channels}"/>
      <input name="in2" type="{kind}" value="{by}"/>
    </multiply>
    <output name="o" type="{kind}" nodename="m"/>"""
# What nodes and inputs say, with the channels that are then seen and their factors.
CASES = {
    **{f"{c} of an output": (out("float", c), ROUGH, c, (1.0,)) for c in "rgba"},
    **{f"{c} of a swizzle": (swizzled("float", c), ROUGH, c, (1.0,)) for c in "rgba"},
    **{
        f"{c} of {where.__name__}": (where("color3", c), COLOR, c, (1.0,) * 3)
        for c in ("rgb", "bgr", "rrr", "gbr", "ggr")
        for where in (out, swizzled)
    },
    "an input of a node": (
        SCALED.format(kind="float", channels="b", by="0.5"), ROUGH, "b", (0.5,),
    ),
    **{
        f"a tint of {c}": (
            SCALED.format(kind="color3", channels=c, by="0.5, 0.25, 0.125"),
            COLOR, c, (0.5, 0.25, 0.125),
        )
        for c in ("bgr", "rrr", "ggr")
    },
    "an input of the surface": (
        '<output name="o" type="color4" nodename="packed"/>',
        ROUGH.replace("/>", ' channels="g"/>'), "g", (1.0,),
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", CASES)
def test_channels_are_what_materialx_makes_of_them(folder: Path, case: str) -> None:
    nodes, inputs, channels, factors = CASES[case]
    text = DOCUMENT.format(nodes=nodes, inputs=inputs)
    surface, losses = surface_of(text, folder)
    today, others = surface_of(upgraded(text), folder)
    assert (surface, losses) == (today, others)
    assert losses == ()
    field = "roughness" if inputs.startswith(ROUGH[:20]) else "base_color"
    value = getattr(surface, field)
    # A colour file of which nobody says any space is sRGB, but for its alpha.
    encoded = np.array(PIXEL) / 255.0
    linear = dict(zip("rgba", [*linear_from_srgb(encoded[:3]), encoded[3]], strict=True))
    if isinstance(value, Texture) and value.color_space == "raw":
        linear = dict(zip("rgba", encoded, strict=True))
    expected = [linear[name] * factor for name, factor in zip(channels, factors, strict=True)]
    assert shown(value, len(channels)) == pytest.approx(expected, abs=1e-3)


@pytest.mark.parametrize(
    ("channels", "expected"), [("rgb", (0.1, 0.2, 0.3)), ("ar1", (0.4, 0.1, 1.0))]
)
def test_channels_of_numbers(folder: Path, channels: str, expected: tuple[float, ...]) -> None:
    for nodes in (out("color3", channels, "four"), swizzled("color3", channels, "four")):
        text = DOCUMENT.format(nodes=nodes, inputs=COLOR)
        surface, losses = surface_of(text, folder)
        assert surface.base_color == pytest.approx(expected) and losses == ()
        assert surface == surface_of(upgraded(text), folder)[0]


def test_what_no_picture_holds_is_told(folder: Path) -> None:
    text = DOCUMENT.format(nodes=swizzled("color3", "r01"), inputs=COLOR)
    _, losses = surface_of(text, folder)
    assert len(losses) == 1 and "no single picture" in losses[0]


OLD = """<?xml version="1.0"?>
<materialx version="1.37">
  <nodegraph name="NG">
    <image name="packed" type="color3">
      <parameter name="file" type="filename" value="packed.png"/>
    </image>
    <output name="o" type="color3" nodename="packed"/>
  </nodegraph>
  <material name="M">
    <shaderref name="S" {node}>
      <bindinput name="base_color" type="color3" nodegraph="NG" output="o"/>
      <bindinput name="metalness" type="float" value="0.75"/>
      <bindinput name="specular_roughness" type="float" value="0.125"/>
    </shaderref>
  </material>
</materialx>"""


@pytest.mark.parametrize(
    "node", ['node="standard_surface"', 'nodedef="ND_standard_surface_surfaceshader"']
)
def test_materials_with_references_to_shaders(folder: Path, node: str) -> None:
    text = OLD.format(node=node)
    surface, losses = surface_of(text, folder)
    assert losses == ()
    assert (surface.metallic, surface.roughness) == (0.75, 0.125)
    assert isinstance(surface.base_color, Texture)
    if "nodedef" not in node:
        # What a definition is of, MaterialX finds in its library alone.
        assert surface == surface_of(upgraded(text), folder)[0]
