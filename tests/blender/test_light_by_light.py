"""What each kind of light does in Cycles, beside what it does in our renderer: one light at a time.

Both follow as many scatterings and clamp nothing. Surfaces are plain and diffuse, so that only the
light can differ; the room of the example has its own PreviewSurfaces.
"""

from pathlib import Path
from typing import Any, Final

import numpy as np
import OpenImageIO
import pytest
from numpy.typing import NDArray
from pxr import Sdf, Usd, UsdGeom, UsdLux, UsdShade

from openrooms_usd import names
from openrooms_usd.channels import numbered
from openrooms_usd.colorimetry import luminance
from openrooms_usd.rendering import RenderRequest
from openrooms_usd.usd.light.lights import define_dome, define_mesh_light
from tests.blender.conftest import Blender
from tests.opening import open_with
from tests.small import Stage

pytestmark = pytest.mark.slow

SIZE: Final = (64, 48)
SAMPLES: Final = 256
# Scatterings between a light and the camera; Cycles does not count the first one.
BOUNCES: Final = 6
# Pixels along a side of the blocks whose means are compared.
BLOCK: Final = 16
# What Blender's World is called among the lights.
SKY: Final = "sky"
NITS: Final = 1000.0
# What is brighter is seen to emit itself.
BRIGHT_NITS: Final = 1500.0

Array = NDArray[Any]


def lamp_room(path: Path) -> Stage:
    """A grey box of 4 m with a window towards -Y, and a camera that sees neither it nor a lamp."""
    made = Stage(path=path)
    made.stage.SetDefaultPrim(UsdGeom.Xform.Define(made.stage, names.WORLD).GetPrim())
    grey = made.material(f"{names.WORLD}/Looks/grey", base_color=(0.6, 0.5, 0.4), roughness=1.0)
    corners = np.array([(x, y, z) for z in (-2, 2) for y in (-2, 2) for x in (-2, 2)])
    hole = np.array([(-0.8, -2, -0.5), (0.8, -2, -0.5), (-0.8, -2, 1.1), (0.8, -2, 1.1)])
    faces = [[0, 1, 3, 2], [4, 6, 7, 5], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    around = [[0, 8, 9, 1], [1, 9, 11, 5], [5, 11, 10, 4], [4, 10, 8, 0]]
    # No corner is shared: where a file gives no normals Blender takes the mean of those around.
    points = np.concatenate([corners, hole])[[*faces, *around]].reshape(-1, 3)
    quads = np.arange(len(points)).reshape(-1, 4)
    made.mesh(f"{names.WORLD}/Room", points, quads, material=grey)
    made.camera((0.5, -1.8, 0.9), (-0.3, 2, -0.6), path=f"{names.WORLD}/eye", fov=70.0)
    return made


def lit_by_lamps(path: Path) -> Usd.Stage:
    """One lamp of each kind out of sight, at the ceiling; and the sky."""
    made = lamp_room(path)

    def lamp(kind: Any, name: str, x: float, y: float, **inputs: Any) -> None:
        light = kind.Define(made.stage, f"{names.WORLD}/{name}")
        light.CreateIntensityAttr(NITS)
        for key, value in inputs.items():
            getattr(light, f"Create{key}Attr")(value)
        UsdGeom.Xformable(light).AddTranslateOp().Set((x, y, 1.7))

    lamp(UsdLux.SphereLight, "sphere", 0.0, -1.0, Radius=0.1)
    warm = {"EnableColorTemperature": True, "ColorTemperature": 2700.0}
    lamp(UsdLux.SphereLight, "warm", 0.0, -1.2, Radius=0.1, **warm)
    day = warm | {"ColorTemperature": 6500.0}
    lamp(UsdLux.SphereLight, "day", 0.0, -1.2, Radius=0.1, Exposure=1.0, **day)
    lamp(UsdLux.SphereLight, "flux", 0.3, -1.0, Radius=0.1, Normalize=True)
    lamp(UsdLux.DiskLight, "disk", 1.0, -1.0, Radius=0.2)
    lamp(UsdLux.RectLight, "rect", -1.0, -1.0, Width=0.5, Height=0.3, Color=(1.0, 0.5, 0.25))
    glow = made.material(f"{names.WORLD}/Looks/glow", base_color=(0, 0, 0), emissive=(NITS,) * 3)
    # Closed, for in Blender what glows does so on both sides.
    bulb = made.box(f"{names.WORLD}/bulb", 0.2, material=glow)
    UsdGeom.Xformable(bulb).AddTranslateOp().Set((1.3, -1.3, 1.7))
    define_mesh_light(bulb.GetPrim(), nits=NITS)
    define_dome(made.stage, f"{names.WORLD}/sky", radiance=(NITS, NITS, 2 * NITS))
    made.stage.Save()
    return made.stage


def lit_by_suns(path: Path) -> Usd.Stage:
    """A sun of so many nits, and one of so many lux."""
    made = lamp_room(path)
    for name, is_lux in (("nits", False), ("lux", True)):
        light = UsdLux.DistantLight.Define(made.stage, f"{names.WORLD}/{name}")
        light.CreateIntensityAttr(NITS)
        light.CreateAngleAttr(1.0)
        light.CreateNormalizeAttr(is_lux)
        UsdGeom.Xformable(light).AddRotateXYZOp().Set((60.0, 0.0, 0.0))
    made.stage.Save()
    return made.stage


def lights_in(stage: Usd.Stage) -> list[str]:
    return [prim.GetName() for prim in stage.Traverse() if prim.HasAPI(UsdLux.LightAPI)]


def theirs_of(blender: Blender, scene: Path, lights: list[str], **job: Any) -> dict[str, Array]:
    """Cycles' picture for each light alone; the sky's is that of Blender's World."""
    pictures = {name: str(scene.parent / f"cycles_{name}.exr") for name in lights}
    told = {"camera": "eye", "samples": SAMPLES, "size": SIZE, "bounces": BOUNCES - 1} | job
    blender("alone", scene, lights=pictures, **told)
    return {
        name: np.asarray(OpenImageIO.ImageBuf(file).get_pixels(OpenImageIO.FLOAT)[..., :3])
        for name, file in pictures.items()
    }


def ours_of(stage: Usd.Stage, light: str) -> Array:
    """Our picture where all other lights are not active."""
    mitsuba = pytest.importorskip("orusd_mitsuba")
    alone = Usd.Stage.Open(stage.GetRootLayer(), Sdf.Layer.CreateAnonymous())
    alone.SetEditTarget(alone.GetSessionLayer())
    for name in lights_in(stage):
        alone.GetPrimAtPath(f"{names.WORLD}/{name}").SetActive(name == light)
    width, height = SIZE
    request = RenderRequest(
        f"{names.WORLD}/eye",
        ("radiance",),
        width=width,
        height=height,
        samples=SAMPLES,
        bounces=BOUNCES,
    )
    view = open_with(mitsuba.MitsubaRenderer(), alone, {"bsdf": "preview"}).render(request)
    return np.asarray(view.images["radiance"].pixels)


def blocks(picture: Array) -> Array:
    """Means of the blocks of a picture, of each component."""
    width, height = SIZE
    cut = picture.reshape(height // BLOCK, BLOCK, width // BLOCK, BLOCK, 3)
    return np.asarray(cut.mean(axis=(1, 3)))


def mean(picture: Array) -> Array:
    return np.asarray(picture.mean(axis=(0, 1)))


def test_each_kind_of_light_is_as_bright_in_cycles(blender: Blender, tmp_path: Path) -> None:
    """Within 1 % in the mean, and 6 % in each of twelve blocks; whatever its colour is."""
    stage = lit_by_lamps(tmp_path / "lamps.usda")
    lights = lights_in(stage)
    assert len(lights) == 8
    theirs = theirs_of(blender, tmp_path / "lamps.usda", lights)
    for name in lights:
        ours = ours_of(stage, name)
        np.testing.assert_allclose(mean(theirs[name]), mean(ours), rtol=0.01, err_msg=name)
        np.testing.assert_allclose(blocks(theirs[name]), blocks(ours), rtol=0.06, err_msg=name)


def test_blender_takes_suns_for_brighter(blender: Blender, tmp_path: Path) -> None:
    """Its importer says why not: strength times 4 whatever the unit, and twice the angle."""
    stage = lit_by_suns(tmp_path / "suns.usda")
    theirs = theirs_of(blender, tmp_path / "suns.usda", lights_in(stage))
    for name, factor in (("nits", 16.0), ("lux", 4.0)):
        ours = ours_of(stage, name)
        np.testing.assert_allclose(mean(theirs[name]), factor * mean(ours), rtol=0.01)


def diffuse_alone(scene: Path, target: Path) -> Path:
    """A room whose surfaces keep their colours and have no lobe besides; its panes are air."""
    stage = Usd.Stage.Open(str(scene))
    stage.SetEditTarget(stage.GetSessionLayer())
    for prim in stage.Traverse():
        # What is below an instance cannot be changed.
        if prim.IsInstance():
            prim.SetInstanceable(False)
    for prim in stage.Traverse():
        shader = UsdShade.Shader(prim)
        if shader and shader.GetIdAttr().Get() == "UsdPreviewSurface":
            for name, value in (("ior", 1.0), ("roughness", 1.0), ("metallic", 0.0)):
                made = shader.CreateInput(name, Sdf.ValueTypeNames.Float)
                made.DisconnectSource()
                made.Set(value)
            shader.CreateInput("normal", Sdf.ValueTypeNames.Normal3f).DisconnectSource()
            material = prim.GetParent()
            if material.GetAttribute(names.MATERIAL_PANE).HasAuthoredValue():
                material.GetAttribute(names.MATERIAL_PANE).Set((1.0, 1.0, 1.0))
                shader.GetInput("opacity").Set(0.0)
    stage.Export(str(target))
    return target


def room_light_by_light(scene: Path, camera: str) -> dict[str, Array]:
    """`radiance_i` of a room by its lamps' objects, and of all openings together the sky."""
    mitsuba = pytest.importorskip("orusd_mitsuba")
    width, height = SIZE
    stage = Usd.Stage.Open(str(scene))
    opened = open_with(mitsuba.MitsubaRenderer(), stage, {"bsdf": "preview"})
    request = RenderRequest(
        f"{names.CAMERAS}/{camera}",
        ("radiance_i",),
        width=width,
        height=height,
        samples=SAMPLES,
        bounces=BOUNCES,
    )
    images = opened.render(request).images
    found: dict[str, Array] = {SKY: np.zeros((height, width, 3))}
    for light in opened.lights:
        name = light.path.rpartition("/")[2] if light.kind == "lamp" else SKY
        found[name] = found.get(name, 0.0) + images[numbered("radiance_i", light.number)].pixels
    return found


# Of the mean, and of the blocks: the sum of what they differ by over the sum of what they are. A
# lamp in a shade sends most of its light by reflection, and so both pictures have noise; curtains
# scatter what they let through, and have an opacity in Blender.
CLOSE: Final = {SKY: (0.015, 0.03), "ceiling_lamp_0": (0.015, 0.03)}
SHADED: Final = (0.06, 0.12)
# So of the lamps that the camera sees least of, nits: single seeds of ours differ by a tenth.
FAINT: Final = (0.3, 0.5)
FAINT_NITS: Final = 2.0


def seen_alike(ours: Array, theirs: Array) -> tuple[Array, Array]:
    """Blocks of what is lit: what emits is seen as it is, and would hide all else."""
    lit = np.maximum(luminance(ours), luminance(theirs)) < BRIGHT_NITS
    return blocks(ours * lit[..., None]), blocks(theirs * lit[..., None])


@pytest.mark.parametrize(
    ("room", "camera", "close"),
    [("example", "overview", CLOSE), pytest.param("bedroom", "view_0", {}, marks=pytest.mark.long)],
)
def test_lamps_and_sky_of_a_room_light_it_alike(
    blender: Blender,
    request: pytest.FixtureRequest,
    tmp_path: Path,
    room: str,
    camera: str,
    close: dict[str, tuple[float, float]],
) -> None:
    out = request.getfixturevalue(room)
    scene = diffuse_alone(out / "scene.usda", tmp_path / "diffuse.usda")
    ours = room_light_by_light(scene, camera)
    theirs = theirs_of(blender, scene, list(ours), camera=camera)
    assert len(ours) >= 3
    for name, picture in ours.items():
        usual = SHADED if luminance(mean(picture)) > FAINT_NITS else FAINT
        in_mean, in_blocks = close.get(name, usual)
        a, b = seen_alike(picture, theirs[name])
        np.testing.assert_allclose(mean(b), mean(a), rtol=in_mean, err_msg=name)
        assert np.abs(b - a).sum() <= in_blocks * a.sum(), name


@pytest.mark.long
def test_what_shines_besides_reflecting_diffusely_takes_its_light_from_it_in_cycles(
    blender: Blender, example: Path
) -> None:
    """The same with the room's own PreviewSurfaces: every light is a little darker there."""
    ours = room_light_by_light(example / "scene.usda", "overview")
    theirs = theirs_of(blender, example / "scene.usda", list(ours), camera="overview")
    for name, picture in ours.items():
        a, b = seen_alike(picture, theirs[name])
        ratio = float(luminance(mean(b)) / luminance(mean(a)))
        assert 0.75 < ratio < 0.95, (name, ratio)
