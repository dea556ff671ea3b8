"""Sound materials of the user's own: folders of pictures, MaterialX, pictures, panoramas."""

from functools import partial
from pathlib import Path

from tests.fuzz.kinds import AGAIN, TINY, Kind, planting_out
from tests.fuzz.pictures import panorama, ramp, write_picture

_MTLX = """\
<?xml version="1.0"?>
<materialx version="1.38" colorspace="lin_rec709">
  <nodegraph name="NG">
    <image name="color" type="color3">
      <input name="file" type="filename" value="maps/color.png" colorspace="srgb_texture"/>
      <input name="texcoord" type="vector2" nodename="st"/>
    </image>
    <texcoord name="st" type="vector2"/>
    <image name="bump" type="vector3">
      <input name="file" type="filename" value="maps/normal.png"/>
    </image>
    <normalmap name="nm" type="vector3">
      <input name="in" type="vector3" nodename="bump"/>
      <input name="scale" type="float" value="1.0"/>
    </normalmap>
    <multiply name="tint" type="color3">
      <input name="in1" type="color3" nodename="color"/>
      <input name="in2" type="color3" value="0.9, 0.8, 0.7"/>
    </multiply>
    <output name="out_color" type="color3" nodename="tint"/>
    <output name="out_normal" type="vector3" nodename="nm"/>
  </nodegraph>
  <standard_surface name="S" type="surfaceshader">
    <input name="base_color" type="color3" nodegraph="NG" output="out_color"/>
    <input name="normal" type="vector3" nodegraph="NG" output="out_normal"/>
    <input name="metalness" type="float" value="0"/>
    <input name="specular_roughness" type="float" value="0.4"/>
    <input name="specular_IOR" type="float" value="1.5"/>
  </standard_surface>
  <surfacematerial name="Oak" type="material">
    <input name="surfaceshader" type="surfaceshader" nodename="S"/>
  </surfacematerial>
</materialx>
"""


def _plant_folder(folder: Path) -> None:
    inner = folder / "in/Wood"
    write_picture(inner / "Wood_Color.png", ramp())
    write_picture(inner / "Wood_Roughness.jpg", ramp())
    write_picture(inner / "Wood_NormalGL.png", ramp() | 128)
    write_picture(inner / "Wood_Metalness.tif", ramp(depth=1))
    write_picture(inner / "Wood_Displacement.exr", panorama())
    (inner / "Wood.license").write_text("CC0-1.0\n")
    (inner / "notes.txt").write_text("bought somewhere\n")


def _plant_mtlx(folder: Path) -> None:
    inner = folder / "in"
    write_picture(inner / "maps/color.png", ramp())
    write_picture(inner / "maps/normal.png", ramp() | 128)
    (inner / "m.mtlx").write_text(_MTLX)


def _material(name: str, folder: Path) -> object:
    from openrooms_usd.library.ownmaterials import files_of, read_material

    files_of(folder / "in" / name)
    return read_material(folder / "in" / name)


def _plant_pictures(folder: Path) -> None:
    for ending in ("png", "jpg", "tif", "exr", "hdr", "tga", "bmp", "webp"):
        pixels = panorama() if ending in ("exr", "hdr") else ramp()
        write_picture(folder / f"in/{ending}/x_color.{ending}", pixels)
    write_picture(folder / "in/piz/x_color.exr", panorama(16), compression="piz")


def _pixels(name: str, folder: Path) -> object:
    from openrooms_usd.usd.shading.textures import color_space, read_codes, read_texture

    file = str(folder / f"in/{name}/x_color.{'exr' if name == 'piz' else name}")
    return color_space(file), read_codes(file), read_texture(file).shape


def _plant_panorama(folder: Path) -> None:
    write_picture(folder / "in/sky.exr", panorama())
    write_picture(folder / "in/sky.hdr", panorama())


_FLOOR = TINY + ", floor: {file: %s, size: 1}}\n"
_SKY = TINY + "}\nlights: {environment: {from: file, file: %s, illuminance: 5000}}\n"
_USED = f"""\
furniture:
  objects:
    - {{category: chair, at: [1, 1], file: a.obj, size: [0.5, 0.5, 0.9]}}
{TINY}, floor: {{file: Wood, size: 1}}, annotations: {{chair: ann.txt}}}}
lights: {{environment: {{file: sky.exr, illuminance: 5000}}}}
"""


def _plant_used(folder: Path) -> None:
    """A room that names files of every kind."""
    _plant_folder(folder)
    _plant_panorama(folder)
    (folder / "in/a.obj").write_text(
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\n"
    )
    (folder / "in/ann.txt").write_text("0 0\n")


_PICTURES = ("png", "jpg", "tif", "exr", "hdr", "tga", "bmp", "webp", "piz")
KINDS = (
    Kind("material.folder", _plant_folder, ((1, partial(_material, "Wood")),), share=3),
    Kind(
        "material.composed",
        planting_out(_plant_folder, _FLOOR % "Wood"),
        ((1, f"{AGAIN}materials"),),
        ("in/Wood/*",),
        share=1,
    ),
    Kind(
        "material.mtlx",
        _plant_mtlx,
        ((1, partial(_material, "m.mtlx")),),
        needs=("MaterialX",),
        share=6,
    ),
    Kind(
        "picture",
        _plant_pictures,
        tuple((1, partial(read, name)) for name in _PICTURES for read in (_material, _pixels)),
        share=5,
    ),
    Kind(
        "panorama",
        planting_out(_plant_panorama, _SKY % "sky.exr"),
        ((1, f"{AGAIN}lights"),),
        ("in/sky.*",),
        share=2,
    ),
    Kind(
        "room.files",
        planting_out(_plant_used, _USED),
        tuple((1, f"{AGAIN}{step}") for step in ("furniture", "materials", "lights")),
        ("in/room.yaml",),
        share=3,
    ),
)
