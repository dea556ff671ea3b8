"""The lights step: one environment, and lamps as their emitting meshes.

Our pictures are lit by the mesh light. Blender and other programs ignore it and use the material,
whose ``emissiveColor`` has the same radiance. A program that supports both counts only the light,
because ``light:materialSyncMode`` is ``noMaterialResponse``.
"""

import hashlib
import json
import math
import re
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from pxr import Usd, UsdGeom

from openrooms_usd import atomic, names
from openrooms_usd.codedigest import code_digest
from openrooms_usd.colorimetry import luminance
from openrooms_usd.description.lights import (
    ConstantEnvironment,
    FileEnvironment,
    Lamp,
    SkyEnvironment,
)
from openrooms_usd.description.room import Room
from openrooms_usd.errors import StageError
from openrooms_usd.furniture import CATEGORIES
from openrooms_usd.library.pictures import write_exr
from openrooms_usd.library.styles.beams import BEAMS, beam_profile, lamp_kelvin, profile_text
from openrooms_usd.library.surroundings.environments import read_panorama, scaled_to_nits
from openrooms_usd.steps.base import StepContext, file_digest
from openrooms_usd.steps.layout.beyond import author_beyond_lamps
from openrooms_usd.steps.lights.daylight import author_portals, author_sky
from openrooms_usd.steps.lights.screens import author_screens
from openrooms_usd.untrusted import read_text
from openrooms_usd.usd.light.emitters import (
    flux_share,
    nits_from_lumen,
    world_area,
    world_from_prim,
)
from openrooms_usd.usd.light.glow import author_glow
from openrooms_usd.usd.light.lights import define_dome, define_mesh_light
from openrooms_usd.usd.light.profiles import Profile, parse_profile, shaping
from openrooms_usd.usd.light.shaping import define_shaping
from openrooms_usd.usd.places.frames import UPRIGHT, is_upright
from openrooms_usd.usd.semantics import read_label

# Of a lamp of an unknown category.
_DEFAULT_LUMEN: Final = 800.0
# UsdLux clamps the colour temperature of black bodies here.
_MAX_KELVIN: Final = 10_000.0


@dataclass(frozen=True)
class FoundLamp:
    """A lamp in the stage.

    Attributes:
        root: The object.
        bulbs: Its emitting meshes.
    """

    root: Usd.Prim
    bulbs: tuple[Usd.Prim, ...]


class LightsStep:
    """Writes ``/World/Lights``, and makes the lamps' bulbs emit."""

    name = "lights"
    reads: tuple[str, ...] = ("layout", "alignment", "materials")

    def inputs(self, room: Room, source: Path) -> Iterable[str]:
        """The panorama, if there is one, and the profiles of lamps."""
        environment = room.lights.environment
        if isinstance(environment, FileEnvironment):
            yield environment.file
        for lamp in room.lights.lamps.values():
            if lamp.profile is not None and lamp.profile not in BEAMS:
                yield lamp.profile

    def author(self, context: StepContext) -> None:
        """Write the environment and the lamps.

        Raises:
            DescriptionError: A lamp is named that is not there.
            InputError: The panorama cannot be read or does not hold radiance, or a profile is not
                an IES file.
            OutputError: The converted panorama cannot be written.
            StageError: A lamp's bulb has no area, or is inside an instance that stays one.
        """
        lamps = _lamps(context.stage)
        lacking = f"has no part {names.LIGHT_BULB} that can emit"
        context.check_named("lights.lamps", lamps, "so it is not lit", "lamp", lacking)
        UsdGeom.Scope.Define(context.stage, names.LIGHTS)
        environment = context.room.lights.environment
        if isinstance(environment, FileEnvironment):
            _author_panorama(context, environment)
        elif isinstance(environment, SkyEnvironment):
            author_sky(context, environment)
        else:
            _author_constant(context, environment)
        if not is_upright(context.stage.GetPrimAtPath(names.ENVIRONMENT)):
            context.notes.append(
                f"{names.EDITS} turns the sky without its last operation, so that it lies on its "
                f"side: end the xformOpOrder of {names.ENVIRONMENT} with {UPRIGHT!r}"
            )
        author_portals(context)
        author_beyond_lamps(context.stage)
        for name, lamp in lamps.items():
            _author_lamp(context, lamp, context.room.lights.lamps.get(name, Lamp()))
        author_screens(context)


def _author_constant(context: StepContext, environment: ConstantEnvironment) -> None:
    """A dome of one radiance: L = E / pi."""
    hue = np.array(environment.color)
    brightness = float(luminance(hue))
    nits = environment.illuminance / math.pi
    r, g, b = (hue * (nits / brightness if brightness > 0.0 else 0.0)).tolist()
    define_dome(context.stage, names.ENVIRONMENT, radiance=(r, g, b))


def _author_panorama(context: StepContext, environment: FileEnvironment) -> None:
    """A dome with a picture in nits that only this layer refers to."""
    source = context.input(environment.file)
    code = code_digest(__name__)
    key = [code, file_digest(source), environment.illuminance, environment.scale]
    digest = hashlib.sha256(json.dumps(key).encode()).hexdigest()[:8]
    stem = re.sub(r"[^A-Za-z0-9]+", "_", source.stem).strip("_")[:40] or "environment"
    file = f"{stem}_{digest}.exr"
    target = context.keep(file)
    if not target.is_file():
        pixels = read_panorama(str(source))
        nits = scaled_to_nits(
            pixels, str(source), illuminance=environment.illuminance, scale=environment.scale
        )
        # 32 bits: the sun is too bright for 16.
        write_exr(target, nits)
    define_dome(
        context.stage, names.ENVIRONMENT, texture=context.asset(file), rotation=environment.rotate
    )


def _lamps(stage: Usd.Stage) -> dict[str, FoundLamp]:
    """The objects that have an emitting part, by name."""
    furniture = stage.GetPrimAtPath(names.FURNITURE)
    found = {}
    for root in furniture.GetChildren() if furniture else ():
        prims = Usd.PrimRange(root, Usd.TraverseInstanceProxies())
        bulbs = tuple(
            prim
            for prim in prims
            if prim.IsA(UsdGeom.Mesh) and read_label(prim, names.PART) == names.LIGHT_BULB
        )
        if bulbs:
            found[root.GetName()] = FoundLamp(root, bulbs)
    return found


def _author_lamp(context: StepContext, lamp: FoundLamp, wanted: Lamp) -> None:
    """Let the bulbs emit; the lamp's flux is shared by their areas."""
    root, place = lamp.root, lamp.root.GetPath()
    area = sum(world_area(bulb) for bulb in lamp.bulbs)
    if area <= 0.0:
        raise StageError("the lamp's bulb has no area", place=place)
    paths = [bulb.GetPath() for bulb in lamp.bulbs]
    file = None
    if wanted.profile is not None:
        profile, file = _kept_profile(context, wanted.profile, wanted.beam)
        area = _shining_area(lamp, profile)
        if area <= 0.0:
            raise StageError(
                "the lamp's bulb emits nothing in the directions of its profile", place=place
            )
    emission = _emission(context, root, wanted, area)
    _open_instance(context.stage, root)
    for path in paths:
        define_mesh_light(context.stage.OverridePrim(path), **emission)
        if file is not None:
            define_shaping(context.stage.OverridePrim(path), file)
    context.notes.extend(author_glow(context.stage, place, paths))


def _kept_profile(context: StepContext, wanted: str, beam: float | None) -> tuple[Profile, str]:
    """A profile, and the asset path of the file that holds it."""
    known = next((name for name in BEAMS if name == wanted), None)
    if known is None:
        source = context.input(wanted)
        text = read_text(source, "table")
        profile, stem = parse_profile(text, str(source)), source.stem
    else:
        profile, stem = beam_profile(known, beam), known
        text = profile_text(profile, known)
    stem = re.sub(r"[^A-Za-z0-9]+", "_", stem).strip("_")[:40] or "profile"
    file = f"{stem}_{hashlib.sha256(text.encode()).hexdigest()[:8]}.ies"
    target = context.keep(file)
    if not target.is_file():
        atomic.write_text(target, text)
    return profile, context.asset(file)


def _shining_area(lamp: FoundLamp, profile: Profile) -> float:
    """The area of the lamp's bulbs that would send as much, if it would emit like Lambert."""
    return sum(
        world_area(bulb) * flux_share(bulb, shaping(profile, world_from_prim(bulb), normalize=True))
        for bulb in lamp.bulbs
    )


def _emission(context: StepContext, root: Usd.Prim, wanted: Lamp, area: float) -> dict[str, Any]:
    """The luminance and the hue of a lamp's bulbs, as `define_mesh_light` takes them."""
    if wanted.radiance is not None:
        nits = float(luminance(np.array(wanted.radiance)))
        color = tuple(value / nits for value in wanted.radiance) if nits > 0.0 else None
        return {"nits": nits if wanted.on else 0.0, "color": color}
    lumen = _usual_lumen(root) if wanted.lumen is None else wanted.lumen
    nits = nits_from_lumen(lumen, area) if wanted.on else 0.0
    if wanted.color is not None:
        return {"nits": nits, "color": _hue(wanted.color)}
    kelvin = wanted.kelvin or _drawn_kelvin(context, root.GetName())
    if kelvin > _MAX_KELVIN:
        context.notes.append(f"{root.GetName()}: UsdLux clamps {kelvin:g} K to {_MAX_KELVIN:g} K")
    return {"nits": nits, "kelvin": kelvin}


def _hue(color: tuple[float, float, float]) -> tuple[float, float, float]:
    """A colour of luminance 1."""
    r, g, b = (np.array(color) / luminance(np.array(color))).tolist()
    return r, g, b


def _open_instance(stage: Usd.Stage, root: Usd.Prim) -> None:
    """Make a lamp no instance: what is written below an instance is lost."""
    path = root.GetPath()
    if root.IsInstance():
        stage.OverridePrim(path).SetInstanceable(False)
    if stage.GetPrimAtPath(path).IsInstance():
        raise StageError(
            "the lamp is an instance, so no layer can change its bulb",
            place=path,
            remedy=f"set instanceable = false on it in {names.LAYERS}/{names.EDITS}.usda",
        )


def _drawn_kelvin(context: StepContext, name: str) -> float:
    sold = lamp_kelvin(context.room.room)
    return float(round(context.rng("lights", name).uniform(min(sold), max(sold))))


def _usual_lumen(root: Usd.Prim) -> float:
    spec = CATEGORIES.get(read_label(root, names.CATEGORY) or "")
    return (spec and spec.lumen) or _DEFAULT_LUMEN
