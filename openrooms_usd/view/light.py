"""What pages get of lightmaps: every lamp and opening at every moment by itself, and the skies.

Numbers are half floats in units of a scale that is given beside them, since the sun's lux are
beyond what half floats reach.
"""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, Final

import numpy as np
from pxr import Sdf, Usd, UsdLux

from openrooms_usd.arrays import Array, Floats
from openrooms_usd.errors import InputError
from openrooms_usd.rendering.bake.layer import LIGHT_IRRADIANCE, LIGHT_NAMES, LIGHTS
from openrooms_usd.rendering.scene.lamps import environment
from openrooms_usd.usd.light.emitters import DomeLight
from openrooms_usd.usd.light.lights import read_lights, read_portals
from openrooms_usd.usd.places.frames import TIME
from openrooms_usd.usd.shading.textures import read_texture
from openrooms_usd.view.moments import Moment, atlases_of

# The brightest value becomes this; half floats end at 65504.
_LARGEST: Final = 32768.0
_MOST_SKY_COLUMNS: Final = 1024
# What WebGL 2 has at least of layers of a texture.
_MOST_LAYERS: Final = 256
# The default colour temperature of daylight: that of the sky's white.
_DAYLIGHT_K: Final = 6504.0
_LAMP_K: Final = 2700.0


def light_of(
    moments: Sequence[Moment],
) -> tuple[dict[str, Any] | None, dict[str, Callable[[], bytes]]]:
    """The state of the light for a page, and the resources that hold it; None without lightmaps.

    ``layers`` says of each layer of the lightmaps which light it is of, at which moment.

    Args:
        moments: The room in the light of each, with lightmaps of the same surfaces.

    Raises:
        InputError: Lightmaps are of different sizes, or too many.
    """
    atlases = [atlases_of(moment.stage) for moment in moments]
    if not all(atlases):
        return None, {}
    lights: dict[str, dict[str, Any]] = {}
    layers = []
    for number, (moment, prims) in enumerate(zip(moments, atlases, strict=True)):
        for light in _lights(moment.stage, prims[0]):
            lights.setdefault(light["name"], light)
            layers.append([list(lights).index(light["name"]), number])
    if len(layers) > _MOST_LAYERS:
        raise InputError(
            f"{len(layers)} lightmaps, one for each light and moment, are too many for a browser",
            place=moments[0].file,
            remedy=f"show fewer moments: up to {_MOST_LAYERS} lightmaps",
        )
    told: dict[str, Any] = {
        "moments": [moment.name for moment in moments],
        "lights": list(lights.values()),
        "layers": layers,
        "atlases": {},
        "skies": [],
    }
    resources: dict[str, Callable[[], bytes]] = {}
    for number, prim in enumerate(atlases[0]):
        maps = _maps(prim.GetPath(), moments)
        name, scale = f"light_{number}.half", _scale(maps)
        height, width = maps[0].shape[:2]
        lit = np.maximum.reduce([one.max(axis=2) for one in maps]) > 0
        told["atlases"][str(prim.GetPath())] = {
            "resource": name,
            "size": [width, height],
            "scale": scale,
            "texels": int(lit.sum()),
            "sums": [one[lit].sum(axis=0, dtype=np.float64).tolist() for one in maps],
        }
        resources[name] = partial(_packed, np.stack(maps), scale)
    for number, moment in enumerate(moments):
        if sky := _sky(moment.stage):
            pixels, world_from_sky = sky
            name, scale = f"sky_{number}.half", _scale([pixels])
            told["skies"].append(
                {
                    "resource": name,
                    "size": [pixels.shape[1], pixels.shape[0]],
                    "scale": scale,
                    "world_from_sky": world_from_sky.tolist(),
                    "moment": number,
                }
            )
            resources[name] = partial(_packed, pixels, scale)
    return told, resources


def _maps(atlas: Sdf.Path, moments: Sequence[Moment]) -> list[Floats]:
    """The lightmaps of all lights at all moments."""
    maps: list[Floats] = []
    for moment in moments:
        prim = moment.stage.GetPrimAtPath(atlas)
        assets = prim.GetAttribute(LIGHT_IRRADIANCE).Get(TIME) if prim else None
        maps += [_read(asset) for asset in assets or ()]
        if not assets or len({one.shape for one in maps}) > 1:
            raise InputError(
                "its lightmaps differ in size from those of other moments",
                place=moment.file,
                remedy="bake all moments with the same --texel and --max-texels",
            )
    return maps


def _sky(stage: Usd.Stage) -> tuple[Floats, Array] | None:
    """(H, W, 3) nits of the surroundings, and the (3, 3) rotation to the world from them."""
    dome = next((one for one in read_lights(stage) if isinstance(one, DomeLight)), None)
    if dome is None:
        return None
    seen = environment(dome)[0]
    return _smaller(seen.pixels), seen.world_from_light


def _lights(stage: Usd.Stage, atlas: Usd.Prim) -> list[dict[str, Any]]:
    """Names, kinds, prims and colour temperatures, in the order of the lightmaps."""
    targets = list(atlas.GetRelationship(LIGHTS).GetTargets())
    portals = {portal.path: portal for portal in read_portals(stage)}
    found: list[dict[str, Any]] = []
    for name in atlas.GetAttribute(LIGHT_NAMES).Get(TIME):
        # Names are those of the prims, with a number where two are alike; light from elsewhere
        # has no prim.
        path = targets[0] if targets and str(name).startswith(targets[0].name) else None
        targets = targets[1:] if path else targets
        prim = stage.GetPrimAtPath(path) if path else None
        kind = "elsewhere" if not prim else "opening" if prim.IsA(UsdLux.PortalLight) else "lamp"
        kelvin = _kelvin(prim) if kind == "lamp" else _DAYLIGHT_K
        said: dict[str, Any] = {
            "name": str(name),
            "kind": kind,
            "path": str(path or ""),
            "kelvin": kelvin,
        }
        if portal := portals.get(said["path"]):
            # What is seen through it is as bright as it is set.
            inwards = np.linalg.inv(portal.world_from_portal)
            said |= {"portal_from_world": inwards.tolist()}
            said |= {"half": [portal.width / 2.0, portal.height / 2.0]}
        found.append(said)
    return found


def _kelvin(lamp: Usd.Prim) -> float:
    """The colour temperature of a lamp's first part that has one."""
    for prim in Usd.PrimRange(lamp, Usd.TraverseInstanceProxies()):
        light = UsdLux.LightAPI(prim) if prim.HasAPI(UsdLux.LightAPI) else None
        if light and light.GetEnableColorTemperatureAttr().Get(TIME):
            return float(light.GetColorTemperatureAttr().Get(TIME))
    return _LAMP_K


def _read(asset: Sdf.AssetPath) -> Floats:
    """(H, W, 3) lux, the first row on top."""
    return np.nan_to_num(read_texture(str(asset.resolvedPath or asset.path))[..., :3])


def _scale(maps: list[Floats]) -> float:
    """A power of two, so that the same lux round to the same numbers beside whatever others."""
    brightest = max(float(one.max()) for one in maps)
    return float(2.0 ** np.ceil(np.log2(max(brightest / _LARGEST, 1e-12))))


def _packed(pixels: Floats, scale: float) -> bytes:
    """(..., 3) as half floats with a fourth one of nought: readers want four."""
    padded = np.zeros((*pixels.shape[:-1], 4), "<f2")
    padded[..., :3] = pixels / np.float32(scale)
    return padded.tobytes()


def _smaller(pixels: Floats) -> Floats:
    """Means of blocks, so that there are few enough columns."""
    step = -(-pixels.shape[1] // _MOST_SKY_COLUMNS)
    rows, columns = (side // step for side in pixels.shape[:2])
    if step == 1 or not rows:
        return pixels
    cut = pixels[: rows * step, : columns * step].reshape(rows, step, columns, step, 3)
    return np.asarray(cut.mean(axis=(1, 3)), np.float32)
