"""Opinions about what parts are made of and what lights send, in a layer of their own."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray
from pxr import Gf, Sdf, Usd, UsdGeom, UsdLux

from openrooms_usd import atomic, names
from openrooms_usd.appearance.directions import ELEVATIONS
from openrooms_usd.arrays import Array
from openrooms_usd.colorimetry import luminance
from openrooms_usd.library.pictures import write_exr
from openrooms_usd.usd.light.glow import author_glow
from openrooms_usd.usd.light.lights import define_dome, define_mesh_light
from openrooms_usd.usd.shading.binding import bind, open_instances
from openrooms_usd.usd.shading.materials import bound_material, define_preview_surface
from openrooms_usd.usd.shading.surfaces import PreviewSurface, Texture

SCOPE: Final = "Appearance"
"""What holds the materials, below the root prim."""

_SKY_ROWS: Final = 128
_DIGITS: Final = 5


@dataclass(frozen=True, eq=False)
class PartLook:
    """What a part is made of.

    Attributes:
        path: Its prim.
        name: Of its material.
        color: (3,) linear base colour.
        roughness: Perceptual.
        metallic: 0 or 1.
        texture: A picture of the base colour; None: one colour everywhere.
    """

    path: str
    name: str
    color: Array
    roughness: float
    metallic: float
    texture: Texture | None = None


def write_opinions(
    stage: Path,
    layer: Path,
    looks: Sequence[PartLook],
    lamps: Mapping[str, Array],
    sky: Array,
    picture: Path,
    asset: str,
) -> list[str]:
    """Write the layer, and the picture of the surroundings beside it.

    Args:
        stage: What the opinions are about; it stays as it is.
        layer: The file to write.
        looks: Of parts.
        lamps: (3,) nits by the prim of each emitting mesh.
        sky: (elevations, 3) nits at `ELEVATIONS`.
        picture: The file to write of the surroundings.
        asset: How the layer refers to it.

    Returns:
        What could not be written, a sentence each.
    """
    notes: list[str] = []
    root = Sdf.Layer.CreateAnonymous(".usda")
    own = Sdf.Layer.CreateAnonymous(layer.suffix)
    root.subLayerPaths = [own.identifier, str(stage.absolute())]
    opened_stage = Usd.Stage.Open(root)
    opened_stage.SetEditTarget(own)
    base = opened_stage.GetDefaultPrim() or next(iter(opened_stage.GetPseudoRoot().GetChildren()))
    if base:
        own.defaultPrim = base.GetName()
    home = base.GetPath().AppendChild(SCOPE)
    UsdGeom.Scope.Define(opened_stage, home)
    for look in looks:
        _author_look(opened_stage, home, look)
    for path, radiance in lamps.items():
        notes += _author_lamp(opened_stage, path, radiance)
    if sky.max() > 0.0:
        write_exr(picture, panorama_of(sky))
        _author_sky(opened_stage, home, asset)
    with atomic.replacing(layer) as beside:
        own.Export(str(beside))
    return notes


def panorama_of(sky: Array) -> NDArray[np.float32]:
    """(H, 2 H, 3) nits, latitude-longitude, of radiance at `ELEVATIONS`."""
    elevation = 90.0 - 180.0 * (np.arange(_SKY_ROWS) + 0.5) / _SKY_ROWS
    rows = np.stack([np.interp(elevation, ELEVATIONS, sky[:, c]) for c in range(3)], axis=-1)
    return np.repeat(rows[:, None], 2 * _SKY_ROWS, axis=1).astype(np.float32)


def material_names(paths: Iterable[str]) -> dict[str, str]:
    """A name for the material of each part, different for each."""
    found: dict[str, str] = {}
    taken: set[str] = set()
    for path in sorted(paths):
        plain = path.strip("/").partition("/")[2].replace("/", "_") or path.strip("/")
        name, number = plain, 1
        while name in taken:
            name, number = f"{plain}_{number}", number + 1
        taken.add(name)
        found[path] = name
    return found


def _author_look(stage: Usd.Stage, home: Sdf.Path, look: PartLook) -> None:
    prim = stage.GetPrimAtPath(look.path)
    former = bound_material(prim)
    red, green, blue = (round(float(value), _DIGITS) for value in look.color)
    surface = PreviewSurface(
        base_color=(red, green, blue) if look.texture is None else look.texture,
        roughness=round(look.roughness, 3),
        metallic=look.metallic,
    )
    material = define_preview_surface(stage, home.AppendChild(look.name), surface)
    if former:
        _keep_physics(former.GetPrim(), material.GetPrim())
    open_instances(stage, [prim.GetPath()])
    bind(stage.OverridePrim(prim.GetPath()), material)


def _keep_physics(former: Usd.Prim, material: Usd.Prim) -> None:
    """Copy what a material says beside its looks: friction, density, what it is made of."""
    for schema in former.GetAppliedSchemas():
        material.AddAppliedSchema(schema)
    skipped = {names.MATERIAL_TRANSMISSION, names.MATERIAL_F0, names.MATERIAL_PANE}
    for attribute in former.GetAuthoredAttributes():
        name = attribute.GetName()
        if name.startswith(("physics:", "openrooms:")) and name not in skipped:
            value = attribute.Get()
            if value is not None:
                made = material.CreateAttribute(name, attribute.GetTypeName(), custom=False)
                made.Set(value)


def _author_lamp(stage: Usd.Stage, path: str, radiance: Array) -> list[str]:
    prim = stage.GetPrimAtPath(path)
    open_instances(stage, [prim.GetPath()])
    over = stage.OverridePrim(prim.GetPath())
    nits = float(luminance(radiance))
    hue = radiance / nits if nits > 0.0 else np.ones(3)
    red, green, blue = (round(float(value), _DIGITS) for value in hue)
    if prim.HasAPI(UsdLux.MeshLightAPI):
        define_mesh_light(over, nits=round(nits, 3), color=(red, green, blue))
        UsdLux.LightAPI(over).CreateEnableColorTemperatureAttr(False)
        group = Sdf.Path(names.FURNITURE)
        above = [p for p in prim.GetPath().GetPrefixes() if p.GetParentPath() == group]
        return list(author_glow(stage, above[0], [prim.GetPath()])) if above else []
    return [f"{path}: only lights that are meshes are changed"]


def _author_sky(stage: Usd.Stage, home: Sdf.Path, picture: str) -> None:
    domes = [prim for prim in stage.Traverse() if prim.IsA(UsdLux.DomeLight)]
    path = domes[0].GetPath() if domes else home.AppendChild("Environment")
    if not domes:
        define_dome(stage, path, texture=picture)
        return
    dome = UsdLux.DomeLight(stage.OverridePrim(path))
    dome.CreateIntensityAttr(1.0)
    dome.CreateExposureAttr(0.0)
    dome.CreateColorAttr(Gf.Vec3f(1.0))
    dome.CreateEnableColorTemperatureAttr(False)
    dome.CreateTextureFileAttr(picture)
    dome.CreateTextureFormatAttr(UsdLux.Tokens.latlong)
