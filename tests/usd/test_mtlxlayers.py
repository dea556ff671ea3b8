"""Files of MaterialX that stages refer to: what their materials say, without USD's own plugin."""

import shutil
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import Usd, UsdShade

from openrooms_usd.description.rendering import RenderSettings
from openrooms_usd.exporters import convert_stage
from openrooms_usd.imagefile import write_png
from openrooms_usd.rendering import render_stage
from openrooms_usd.usd.files.layers import open_stage
from openrooms_usd.usd.shading.materialreader import read_preview_surface
from openrooms_usd.usd.shading.mtlxlayers import read_mtlx_layers
from openrooms_usd.usd.shading.surfaces import PreviewSurface, Texture

BOARD = """<?xml version="1.0"?>
<materialx version="1.38" colorspace="lin_rec709" fileprefix="tex/">
  <nodegraph name="NG_board">
    <input name="strength" type="float" value="0.5"/>
    <image name="color" type="color3">
      <input name="file" type="filename" value="board.png" colorspace="srgb_texture"/>
    </image>
    <image name="plain" type="color3">
      <input name="file" type="filename" value="board.png"/>
    </image>
    <image name="rough" type="float">
      <input name="file" type="filename" value="board.png"/>
    </image>
    <multiply name="dim" type="float">
      <input name="in1" type="float" nodename="rough"/>
      <input name="in2" type="float" interfacename="strength"/>
    </multiply>
    <output name="color_output" type="color3" nodename="color"/>
    <output name="plain_output" type="color3" nodename="plain"/>
    <output name="rough_output" type="float" nodename="dim"/>
  </nodegraph>
  <standard_surface name="SR_board" type="surfaceshader">
    <input name="base" type="float" value="1.0"/>
    <input name="base_color" type="color3" nodegraph="NG_board" output="color_output"/>
    <input name="specular_roughness" type="float" nodegraph="NG_board" output="rough_output"/>
    <input name="emission" type="float" value="2.0"/>
    <input name="emission_color" type="color3" nodegraph="NG_board" output="plain_output"/>
    <input name="subsurface" type="float" value="0.2"/>
  </standard_surface>
  <constant name="red" type="color3"><input name="value" type="color3" value="0.8, 0.1, 0.1"/>
  </constant>
  <open_pbr_surface name="SR_red" type="surfaceshader">
    <input name="base_color" type="color3" nodename="red"/>
    <input name="base_metalness" type="float" value="1"/>
    <input name="geometry_thin_walled" type="boolean" value="false"/>
  </open_pbr_surface>
  <surfacematerial name="M_board" type="material">
    <input name="surfaceshader" type="surfaceshader" nodename="SR_board"/>
  </surfacematerial>
  <surfacematerial name="M_red" type="material">
    <input name="surfaceshader" type="surfaceshader" nodename="SR_red"/>
  </surfacematerial>
</materialx>
"""
STAGE = """#usda 1.0
(
    upAxis = "Z"
    metersPerUnit = 1
)
def Xform "Set"
{
    def Scope "Looks" (prepend references = @./looks.mtlx@</MaterialX/Materials>)
    {
    }
    def Cube "Board" (prepend apiSchemas = ["MaterialBindingAPI"])
    {
        rel material:binding = </Set/Looks/M_board>
    }
    def Cube "Red" (prepend apiSchemas = ["MaterialBindingAPI"])
    {
        rel material:binding = </Set/Looks/M_red>
        double3 xformOp:translate = (3, 0, 0)
        uniform token[] xformOpOrder = ["xformOp:translate"]
    }
}
"""


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    """A stage, its MaterialX file, and a picture in a folder of its own."""
    folder = tmp_path / "set"
    (folder / "tex").mkdir(parents=True)
    (folder / "looks.mtlx").write_text(BOARD)
    write_png(folder / "tex/board.png", np.full((4, 4, 3), 128, np.uint8))
    (folder / "stage.usda").write_text(STAGE)
    return folder / "stage.usda"


def looks(file: Path) -> tuple[Usd.Stage, dict[str, tuple[PreviewSurface, tuple[str, ...]]]]:
    stage = open_stage(file)
    read_mtlx_layers(stage)
    found = {
        prim.GetName(): read_preview_surface(UsdShade.Material(prim))
        for prim in stage.Traverse()
        if prim.IsA(UsdShade.Material)
    }
    return stage, found


def test_materials_are_what_the_file_says(scene: Path) -> None:
    stage, found = looks(scene)
    assert not stage.GetCompositionErrors()
    board, lost = found["M_board"]
    picture = str(scene.parent / "tex/board.png")
    assert isinstance(board.base_color, Texture) and isinstance(board.roughness, Texture)
    assert (board.base_color.file, board.base_color.color_space) == (picture, "sRGB")
    # By the interface of its graph; numbers are never decoded.
    assert board.roughness.scale[0] == 0.5
    assert (board.roughness.channel, board.roughness.color_space) == ("r", "raw")
    # A colour of which nobody says more is of the document's space.
    assert isinstance(board.emissive, Texture)
    assert (board.emissive.color_space, board.emissive.scale[:3]) == ("raw", (2.0, 2.0, 2.0))
    assert [text.rpartition("/")[2] for text in lost] == ["SR_board.subsurface: it is left out"]
    red, lost = found["M_red"]
    assert red.base_color == pytest.approx((0.8, 0.1, 0.1)) and red.metallic == 1.0
    assert lost == ()


def test_files_stay_as_they_are(scene: Path) -> None:
    before = {path: path.read_bytes() for path in scene.parent.rglob("*") if path.is_file()}
    stage, _ = looks(scene)
    assert not stage.GetRootLayer().permissionToSave
    del stage
    after = {path: path.read_bytes() for path in scene.parent.rglob("*") if path.is_file()}
    assert after == before
    # Who opens it next reads the files anew.
    assert open_stage(scene).GetCompositionErrors()


def test_they_are_found_behind_other_layers_and_in_instances(scene: Path) -> None:
    top = scene.parent / "top.usda"
    top.write_text(
        '#usda 1.0\ndef "A" (instanceable = true; prepend payload = @./stage.usda@</Set>) {}\n'
        'def "B" (instanceable = true; prepend references = @./stage.usda@</Set>) {}\n'
    )
    stage = open_stage(top)
    read_mtlx_layers(stage)
    assert not stage.GetCompositionErrors()
    for place in ("/A/Board", "/B/Board"):
        api = UsdShade.MaterialBindingAPI(stage.GetPrimAtPath(place))
        surface, _ = read_preview_surface(api.ComputeBoundMaterial()[0])
        assert isinstance(surface.base_color, Texture)


def test_a_whole_file_is_its_default_prim(scene: Path) -> None:
    text = STAGE.replace("</MaterialX/Materials>", "").replace("Looks/M_", "Looks/Materials/M_")
    scene.write_text(text)
    assert set(looks(scene)[1]) == {"M_board", "M_red"}


def test_packages_hold_them_too(scene: Path, tmp_path: Path) -> None:
    package = tmp_path / "set.usdz"
    with zipfile.ZipFile(package, "w", zipfile.ZIP_STORED) as archive:
        for name in ("stage.usda", "looks.mtlx", "tex/board.png"):
            # What a package holds begins at multiples of 64 bytes.
            info = zipfile.ZipInfo(name)
            start = archive.fp.tell() + 30 + len(name)  # type: ignore[union-attr]
            info.extra = b"\x86\x19" + ((-start - 4) % 64).to_bytes(2, "little")
            info.extra += bytes((-start - 4) % 64)
            archive.writestr(info, (scene.parent / name).read_bytes())
    shutil.rmtree(scene.parent)
    stage, found = looks(package)
    assert not stage.GetCompositionErrors()
    surface = found["M_board"][0]
    assert isinstance(surface.base_color, Texture)
    assert surface.base_color.file == f"{package}[tex/board.png]"


@pytest.mark.parametrize("declared", ["", ' xmlns:xi="http://www.w3.org/2001/XInclude"'])
def test_included_files_stand_where_they_are_included(scene: Path, declared: str) -> None:
    folder = scene.parent
    (folder / "parts").mkdir()
    inner = BOARD.replace('fileprefix="tex/"', 'fileprefix="../tex/"')
    (folder / "parts/inner.mtlx").write_text(inner)
    (folder / "looks.mtlx").write_text(
        f'\n <materialx version="1.38"{declared}><xi:include href="parts/inner.mtlx"/></materialx>'
    )
    assert {"M_board", "M_red"} == set(looks(scene)[1])


@pytest.mark.parametrize(
    "text",
    [
        '<?xml version="1.0"?><!DOCTYPE x [<!ENTITY a "b">]><materialx version="1.38"/>',
        "<materialx version='1.38'>",
        "no xml at all",
        "",
        '<materialx xmlns:xi="http://www.w3.org/2001/XInclude"><xi:include href="looks.mtlx"/>'
        "</materialx>",
    ],
    ids=["entities", "open", "none", "empty", "itself"],
)
def test_what_cannot_be_read_stays_an_error_of_composition(scene: Path, text: str) -> None:
    (scene.parent / "looks.mtlx").write_text(text)
    stage, found = looks(scene)
    assert len(stage.GetCompositionErrors()) == 1 or not found


@pytest.mark.parametrize(
    "value", ["red, green, blue", "1, 2", "", "nan, nan, nan", "1e400, 0, 0"], ids=str
)
def test_odd_values_are_none(scene: Path, value: str) -> None:
    (scene.parent / "looks.mtlx").write_text(BOARD.replace("0.8, 0.1, 0.1", value))
    red = looks(scene)[1]["M_red"][0]
    assert np.isfinite(np.array(red.base_color)).all()


def test_connections_to_nothing_are_none(scene: Path) -> None:
    text = BOARD.replace('nodename="red"', 'nodename="green"')
    text = text.replace('nodename="rough"', 'nodename="smooth"')
    (scene.parent / "looks.mtlx").write_text(text)
    found = looks(scene)[1]
    assert found["M_red"][0].base_color == pytest.approx((0.8, 0.8, 0.8))
    assert not isinstance(found["M_board"][0].roughness, Texture)


def test_colors_of_meshes_are_read_by_their_name(scene: Path) -> None:
    text = BOARD.replace('<constant name="red"', '<geompropvalue name="red"')
    text = text.replace('name="value" type="color3"', 'name="default" type="color3"')
    named = '<input name="geomprop" type="string" value="dye"/></geompropvalue>'
    (scene.parent / "looks.mtlx").write_text(text.replace("</constant>", named))
    red, lost = looks(scene)[1]["M_red"]
    assert red.painted == (("base_color", "dye"),) and not lost
    assert red.base_color == pytest.approx((0.8, 0.1, 0.1))


def test_renders_and_conversions_show_them(scene: Path, tmp_path: Path) -> None:
    asked = RenderSettings(resolution=(32, 24), renderer="preview", channels=["base_color"])
    summary = render_stage(scene, tmp_path / "out", asked)
    assert not [row for row in summary.report.rows if "mtlx" in row[2]]
    report = convert_stage(scene, tmp_path / "scene/scene.xml")
    assert not [row for row in report.rows if "looks.mtlx" in row[2]]
    text = (tmp_path / "scene/scene.xml").read_text()
    assert "bitmap" in text and str(tmp_path) not in text


def test_the_published_chess_set(real: Any) -> None:
    """Of the asset working group, where it is at hand: 19 files of MaterialX, 16 materials."""
    folder = real("usd_wg/OpenChessSet")
    _, found = looks(folder / "chess_set.usda")
    assert len(found) > 10
    assert all(isinstance(surface.base_color, Texture) for surface, _ in found.values())
