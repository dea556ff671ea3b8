"""A new picture from the parts of an old one: light is linear, so each lamp can be turned.

A render with the channel ``radiance_i`` holds what every light causes with all bounces. Their
weighted sum is the picture in which the lights have these weights.
"""

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

import numpy as np

from openrooms_usd import claims, names
from openrooms_usd.arrays import Array, Floats
from openrooms_usd.errors import InputError
from openrooms_usd.imagefile import write_png
from openrooms_usd.rendering import exr
from openrooms_usd.rendering.folder import LIGHTS_FILE, MANIFEST
from openrooms_usd.rendering.manifest import write_json
from openrooms_usd.rendering.previews import preview
from openrooms_usd.rendering.reading import RenderedScene, RenderedView, read_render
from openrooms_usd.rendering.scene.lights import LightRecord
from openrooms_usd.spelling import did_you_mean
from openrooms_usd.version import __version__

FILES: Final = {"radiance": "radiance.exr", "preview": "radiance.png"}
# What UsdLux defines colour temperatures for.
_KELVIN: Final = (1000.0, 10000.0)


@dataclass(frozen=True)
class Relighting:
    """How lights shall be, those that are not named as they were.

    Attributes:
        scales: By the light's name, what its radiance is multiplied by; 0 turns it off.
        kelvin: By the light's name, its new colour temperature at the same luminance.
    """

    scales: Mapping[str, float] = field(default_factory=dict)
    kelvin: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Relit:
    """A view with its lights turned.

    Attributes:
        radiance: (height, width, 3) nits, as the channel ``radiance``.
        factors: (3,) by the light's name: what its red, green and blue were multiplied by.
        exposure: What pictures for people multiply it by; None fits it to the picture.
        manifest: What is said of it, as plain data.
    """

    radiance: Floats
    factors: Mapping[str, Array]
    exposure: float | None
    manifest: dict[str, Any]

    def __repr__(self) -> str:
        height, width = self.radiance.shape[:2]
        said = (f"{name} x {factor.round(3).tolist()}" for name, factor in self.factors.items())
        return f"Relit({width}x{height}: {', '.join(said)})"


def relight(view: Path, out: Path, relighting: Relighting) -> dict[str, Any]:
    """Write the picture of a view with its lights turned.

    ``out`` receives ``radiance.exr``, ``radiance.png`` (exposed as the view) and ``manifest.json``,
    which says what became of every light.

    Args:
        view: The folder of a view in a finished render, or a render that has only one.
        out: The folder to write.
        relighting: How lights shall be.

    Returns:
        The manifest.

    Raises:
        InputError: It is not a view, has no light channels, or a light cannot be changed as asked.
        OutputError: The folder cannot be written, or holds what is not ours.
    """
    return write_relit(out, relit_view(view, relighting))


def relit_view(view: Path, relighting: Relighting) -> Relit:
    """The picture of a view with its lights turned.

    Args:
        view: The folder of a view in a finished render, or a render that has only one.
        relighting: How lights shall be.

    Raises:
        InputError: It is not a view, has no light channels, or a light cannot be changed as asked.
    """
    scene, seen = _open(view)
    factors = light_factors(scene.lights, relighting, view)
    # Pixels may hold any number, NaN and infinity.
    with np.errstate(over="ignore", invalid="ignore"):
        pixels = relit(_contributions(scene, seen), factors)
    named = {light.name: factors[light.number] for light in scene.lights}
    entry = _entry(scene, seen, relighting, factors)
    return Relit(pixels, named, seen.entry.exposure, entry)


def write_relit(out: Path, picture: Relit) -> dict[str, Any]:
    """Write a relit picture; see `relight`.

    Returns:
        The manifest.

    Raises:
        OutputError: The folder cannot be written, or holds what is not ours.
    """
    with np.errstate(over="ignore", invalid="ignore"):
        shown = preview("radiance", picture.radiance, picture.exposure)
    entry = picture.manifest | {"preview_shows": shown.shows}
    with claims.refilling(out, ".orusd.relight.sha256") as refill:
        exr.write_rgb(refill.folder / FILES["radiance"], picture.radiance)
        write_png(refill.folder / FILES["preview"], shown.pixels)
        write_json(refill.folder / MANIFEST, entry)
    return entry


def relit(contributions: Mapping[int, Floats], factors: Mapping[int, Array]) -> Floats:
    """The sum of what the lights cause, each times its factor.

    Args:
        contributions: (height, width, 3) by the light's number.
        factors: (3,) by the light's number.
    """
    total = np.zeros(next(iter(contributions.values())).shape, dtype=np.float64)
    for number, pixels in sorted(contributions.items()):
        if factors[number].any():
            total += factors[number] * pixels
    return total.astype(np.float32)


def light_factors(
    lights: Sequence[LightRecord], relighting: Relighting, place: Path
) -> dict[int, Array]:
    """(3,) what each light's red, green and blue are multiplied by, by its number.

    Args:
        lights: Those of the render.
        relighting: How they shall be.
        place: The view, for messages.

    Raises:
        InputError: A light is unknown, was off, or cannot have what is wanted.
    """
    known = {light.name: light for light in lights}
    for name in (*relighting.scales, *relighting.kelvin):
        _check_light(name, known, place)
    return {
        light.number: _scale(relighting.scales.get(name, 1.0), name, place)
        * _tint(light, relighting.kelvin.get(name), place)
        for name, light in known.items()
    }


def blackbody(kelvin: float) -> Array:
    """(3,) scene-linear Rec.709 of a black body, luminance 1, as UsdLux colours its lights."""
    from pxr import UsdLux

    from openrooms_usd.colorimetry import luminance

    color = np.array(UsdLux.BlackbodyTemperatureAsRgb(kelvin), dtype=np.float64)
    return np.asarray(color / luminance(color))


def _check_light(name: str, known: Mapping[str, LightRecord], place: Path) -> None:
    if name not in known:
        raise InputError(
            f"no light is named {name!r}{did_you_mean(name, known)}",
            place=place,
            remedy=f"there are: {', '.join(known) or 'none'}",
        )
    if not known[name].on:
        raise InputError(
            f"the light {name!r} was off when this was rendered, so its contribution is not known",
            place=place,
            remedy="turn it on in the room, render again with --channels radiance_i, and relight",
        )


def _scale(scale: float, name: str, place: Path) -> Array:
    if not 0.0 <= scale < np.inf:
        raise InputError(
            f"the light {name!r} cannot be {scale} times as bright",
            place=place,
            remedy="give off, on, or a number that is not negative",
        )
    return np.full(3, scale)


def _tint(light: LightRecord, wanted: float | None, place: Path) -> Array:
    if wanted is None:
        return np.ones(3)
    name, was = light.name, light.kelvin
    if was is None:
        raise InputError(
            f"the light {name!r} has no colour temperature",
            place=place,
            remedy="choose a light with kelvin in the manifest",
        )
    low, high = _KELVIN
    if not low <= wanted <= high:
        raise InputError(
            f"{wanted:g} K is not between {low:g} and {high:g} K", place=name, remedy="such as 2700"
        )
    before, after = blackbody(was), blackbody(wanted)
    if np.any((before <= 0.0) & (after > 0.0)):
        raise InputError(
            f"at {was:g} K the light {name!r} lacks a primary that {wanted:g} K needs",
            place=place,
            remedy="render again with the other colour temperature",
        )
    return np.divide(after, before, out=np.zeros(3), where=before > 0.0)


def _open(view: Path) -> tuple[RenderedScene, RenderedView]:
    inside = os.path.lexists(view / MANIFEST)
    scene = read_render(view if inside else view.absolute().parent)
    if not inside and view.absolute().name in scene.views:
        return scene, scene.views[view.absolute().name]
    if inside and len(scene.views) == 1:
        return scene, next(iter(scene.views.values()))
    raise InputError(
        "this render has several views" if inside else "this is not a view of the render",
        place=view,
        remedy=f"give one: {', '.join(str(scene.folder / name) for name in scene.views)}",
    )


def _contributions(scene: RenderedScene, view: RenderedView) -> Mapping[int, Floats]:
    found = view.lights.get("radiance", {})
    missing = [light.name for light in scene.lights if light.number not in found]
    if missing or not found:
        raise InputError(
            f"the view does not have the contributions of {', '.join(missing) or 'the lights'}",
            place=view.folder / LIGHTS_FILE,
            remedy="render again with --channels radiance_i among them",
        )
    unknown = found.keys() - {light.number for light in scene.lights}
    if unknown:
        raise InputError(
            f"the view has the contribution of light {min(unknown)}, which is not in the manifest",
            place=view.folder / LIGHTS_FILE,
            remedy="render again",
        )
    return found


def _entry(
    scene: RenderedScene, view: RenderedView, relighting: Relighting, factors: Mapping[int, Array]
) -> dict[str, Any]:
    lights = [
        {
            "number": light.number,
            "name": light.name,
            "scale": relighting.scales.get(light.name, 1.0),
            "kelvin": relighting.kelvin.get(light.name, light.kelvin),
            "factor": factors[light.number].tolist(),
        }
        for light in scene.lights
    ]
    kept = {"camera", "resolution", "K", "world_from_camera", "exposure"}
    return {
        "generator": f"{names.CREATOR} {__version__}",
        "view": view.name,
        "stage": scene.manifest.stage,
        "seed": scene.manifest.seed,
        "lights": lights,
        "files": FILES,
        **view.entry.model_dump(include=kept),
    }
