"""The library of materials as pictures: a sheet for each substance."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom, UsdShade

from openrooms_usd import claims, names
from openrooms_usd.description.substances import Substance
from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.geometry.pinhole import look_at
from openrooms_usd.library import textures
from openrooms_usd.library.pictures import write_exr
from openrooms_usd.library.textures import FAMILIES, family_of
from openrooms_usd.progress import Counted, Progress, silent
from openrooms_usd.rendering.contract import NO_OPTIONS
from openrooms_usd.rendering.folder import check_writable
from openrooms_usd.rendering.sheet import Tile, write_sheet
from openrooms_usd.scratch import scratch_folder
from openrooms_usd.showroom.photograph import photograph, photograph_settings
from openrooms_usd.showroom.sheet import DEFAULT_SAMPLES, DEFAULT_SIZE
from openrooms_usd.showroom.studio import EXPOSURE, softboxes
from openrooms_usd.usd.cameras import define_camera
from openrooms_usd.usd.files.layers import apply_metadata
from openrooms_usd.usd.light.lights import define_dome
from openrooms_usd.usd.places.frames import author_placement
from openrooms_usd.usd.shading.materials import PreviewSurface, Texture, define_preview_surface
from openrooms_usd.usd.shading.surfaces import NORMAL_BIAS, NORMAL_SCALE
from openrooms_usd.usd.shapes.meshes import define_mesh

# Of dielectrics in OpenRooms' model.
_F0: Final = 0.05
# In sizes of the material: the ball's radius, of which two repeats go around it; the floor to the
# left and right, in front, behind.
_RADIUS_SHARE: Final = 1.0 / math.pi
_FLOOR: Final = (-2.5, 2.5, -1.5, 6.0)
# Where the camera stands and looks, in sizes of the material; degrees.
_EYE: Final = (0.3, -1.75, 1.05)
_TARGET: Final = (-0.06, 0.0, 0.26)
_FOV_DEG: Final = 27.0
# Bright floors all around would burn out in the exposure of single objects.
_EXPOSURE_FACTOR: Final = 0.75
_SEGMENTS: Final = 96
_COLUMNS: Final = 7
# Texels of a picture's textures for each of its pixels, and at most.
_TEXELS_PER_PIXEL: Final = 4
_MOST_TEXELS: Final = 1024


def draw_material_sheets(
    folder: Path,
    substances: Sequence[Substance] = (),
    *,
    number: int = 0,
    size: int = DEFAULT_SIZE,
    samples: int = DEFAULT_SAMPLES,
    renderer: str = "mitsuba",
    options: Mapping[str, str] = NO_OPTIONS,
    denoise: bool = False,
    progress: Progress = silent,
) -> list[Path]:
    """Render every family on a ball and a floor, and tile the pictures: ``<substance>.png``.

    Equal arguments give equal bytes on the same backend.

    Args:
        folder: Where; it is made when it is missing.
        substances: Which; all where empty.
        number: Which material of each family.
        size: Pixels along each side of a picture.
        samples: Samples a pixel.
        renderer: A registered renderer.
        options: What is asked of the renderer, by the names that it declares.
        denoise: Whether to denoise the pictures.
        progress: Called with each finished family's name and the finished fraction.

    Returns:
        The files.

    Raises:
        MissingPackageError: The denoiser is asked for and not installed.
        OutputError: A file cannot be written.
        RenderError: The renderer cannot do it.
    """
    from openrooms_usd.rendering.opening import check_settings, open_for_rendering

    settings = photograph_settings(renderer, options, denoise=denoise, samples=samples, size=size)
    check_settings(settings)
    check_writable(folder)
    chosen = list(dict.fromkeys(substances)) or list(FAMILIES)
    files = [folder / f"{kind}.png" for kind in chosen]
    for file in files:
        claims.check_output(file)
    total, done = sum(len(FAMILIES[kind]) for kind in chosen), 0
    texels = min(_MOST_TEXELS, _TEXELS_PER_PIXEL * size)
    for kind, file in zip(chosen, files, strict=True):
        tiles: list[Tile] = []
        with scratch_folder() as scratch:
            shown = [Sample(name, number) for name in FAMILIES[kind]]
            stage = build_balls(shown, texels, scratch)
            opened = open_for_rendering(stage, settings)
            for sample in shown:
                picture = photograph(opened, ball_camera(sample))
                tiles.append((_caption(sample.name), picture))
                done += 1
                progress(Counted(sample.name, done, total), done / total)
        rows = [tiles[i : i + _COLUMNS] for i in range(0, len(tiles), _COLUMNS)]
        with claims.output(file):
            write_sheet(file, rows, below=True)
    return files


def _caption(name: str) -> str:
    family = family_of(name)
    return f"{name.replace('_', ' ')}\n{family.size:g} m"


# Everything is in proportion to the material's own size, so that a ball shows about one repeat of
# its textures and the floor shows how they repeat.
@dataclass(frozen=True)
class Sample:
    """A material to be shown.

    Attributes:
        name: Its family.
        number: Which of the family's materials.
    """

    name: str
    number: int

    @property
    def size(self) -> float:
        """The usual size of its textures, metres."""
        return textures.family_of(self.name).size


def build_balls(samples: Sequence[Sample], resolution: int, folder: Path) -> Usd.Stage:
    """A stage with every sample and a camera for each, `ball_camera`.

    Args:
        samples: What is shown.
        resolution: Texels along each side of the textures.
        folder: An empty folder for everything that the stage refers to.

    Raises:
        OutputError: The folder cannot be written.
    """
    layer = Sdf.Layer.CreateNew(str(folder / "samples.usda"))
    apply_metadata(layer)
    stage = Usd.Stage.Open(layer)
    UsdGeom.Xform.Define(stage, names.WORLD)
    x = 0.0
    for sample in samples:
        x -= _FLOOR[0] * sample.size
        _place(stage, sample, x, _material(stage, sample, resolution, folder))
        x += _FLOOR[1] * sample.size
    write_exr(folder / "softboxes.exr", softboxes())
    define_dome(stage, names.ENVIRONMENT, texture="./softboxes.exr")
    return stage


def ball_camera(sample: Sample) -> str:
    """The prim path of a sample's camera."""
    return f"{names.CAMERAS}/{sample.name}"


def _place(stage: Usd.Stage, sample: Sample, x: float, material: UsdShade.Material) -> None:
    root = f"{names.WORLD}/{sample.name}"
    author_placement(UsdGeom.Xform.Define(stage, root).GetPrim(), Gf.Vec3d(x, 0.0, 0.0), 0.0)
    for name, mesh in (("ball", _ball(sample.size)), ("floor", _floor(sample.size))):
        prim = define_mesh(stage, f"{root}/{name}", mesh).GetPrim()
        UsdShade.MaterialBindingAPI.Apply(prim).Bind(material)
    eye, target = (np.array(at) * sample.size + [x, 0.0, 0.0] for at in (_EYE, _TARGET))
    define_camera(
        stage,
        ball_camera(sample),
        world_from_camera=look_at(eye, target),
        fov_degrees=_FOV_DEG,
        resolution=(1, 1),
        exposure=_EXPOSURE_FACTOR * EXPOSURE,
    )


def _material(stage: Usd.Stage, sample: Sample, resolution: int, folder: Path) -> UsdShade.Material:
    order = textures.Material(sample.name, sample.number, resolution=resolution)
    textures.cached(order, folder, sample.name)
    repeat = 1.0 / sample.size
    maps = {
        item: Texture(
            f"./{sample.name}_{item}.png",
            "rgb" if item in ("albedo", "normal") else "r",
            "sRGB" if item == "albedo" else "raw",
            scale=NORMAL_SCALE if item == "normal" else Texture.scale,
            bias=NORMAL_BIAS if item == "normal" else Texture.bias,
            uv_scale=(repeat, repeat),
        )
        for item in textures.rendered_maps(sample.name)
    }
    even = textures.family_of(sample.name).metallic
    surface = PreviewSurface(
        base_color=maps["albedo"],
        roughness=maps["roughness"],
        normal=maps["normal"],
        metallic=maps["metallic"] if even is None else even,
        f0=_F0,
    )
    return define_preview_surface(stage, f"{names.MATERIALS}/{sample.name}", surface)


def _ball(size: float) -> Mesh:
    """A ball whose poles lie at its left and right, where they are not seen. Grain runs upwards."""
    radius, rows, columns = _RADIUS_SHARE * size, _SEGMENTS // 2, _SEGMENTS
    lean = np.linspace(0.0, math.pi, rows + 1)[:, None]
    turn = np.linspace(-0.5 * math.pi, 1.5 * math.pi, columns + 1)
    normal = np.stack(
        [-np.cos(lean) + 0.0 * turn, -np.sin(lean) * np.cos(turn), np.sin(lean) * np.sin(turn)],
        axis=-1,
    ).reshape(-1, 3)
    st = np.stack(np.broadcast_arrays(lean * radius, turn * radius), axis=-1).reshape(-1, 2)
    first = np.arange(rows)[:, None] * (columns + 1) + np.arange(columns)
    faces = np.stack([first, first + columns + 1, first + columns + 2, first + 1], axis=-1)
    corners = faces.reshape(-1).astype(np.int32)
    return Mesh(
        points=normal * radius + [0.0, 0.0, radius],
        counts=np.full(faces.size // 4, 4, np.int32),
        indices=corners,
        normals=normal[corners].astype(np.float32),
        st=st[corners].astype(np.float32),
    )


def _floor(size: float) -> Mesh:
    left, right, front, back = (size * side for side in _FLOOR)
    corners = np.array([(left, front), (right, front), (right, back), (left, back)])
    return Mesh(
        points=np.column_stack([corners, np.zeros(4)]),
        counts=np.array([4], np.int32),
        indices=np.arange(4, dtype=np.int32),
        normals=np.tile(np.array([0.0, 0.0, 1.0], np.float32), (4, 1)),
        st=corners.astype(np.float32),
    )
