"""Doubtful values of cameras and lights: they are used as authored, and reported.

The usual cause is a unit: millimetres of a lens where USD counts tenths of a scene unit, stops
where a factor is meant.
"""

import math
from collections.abc import Iterator, Sequence
from typing import Final

import numpy as np
from pxr import Usd

from openrooms_usd.colorimetry import luminance
from openrooms_usd.errors import StageError
from openrooms_usd.usd.cameras import ORTHOGRAPHIC, read_camera
from openrooms_usd.usd.light.emitters import DistantLight, Light
from openrooms_usd.usd.places.frames import TIME, meters_per_unit
from openrooms_usd.usd.rendersettings import stage_resolution

DOUBT: Final = " is probably a mistake: "
"""What stands in each sentence."""

# The largest lenses that people carry have openings of 8 cm.
_MOST_LENS_M: Final = 0.1
_LEAST_FIELD_DEG: Final = 1.0
_MOST_FIELD_DEG: Final = 170.0
# Stops: night by the moon, with a dark lens, and the disk of the sun.
_MOST_STOPS: Final = 14.0
_LEAST_STOPS: Final = -34.0
# The disk of the sun seen from space has 2e9 nits.
_MOST_NITS: Final = 1e9
_MILLIMETRE: Final = 1e-3


def camera_doubts(prim: Usd.Prim) -> Iterator[str]:
    """What is hardly meant of a camera, one sentence each.

    Args:
        prim: A ``UsdGeom.Camera``.
    """
    width, height = stage_resolution(prim.GetStage())
    try:
        seen = read_camera(prim, width, height)
    except StageError:
        # Who asks for its picture reads why there is none.
        return
    if seen.projection != ORTHOGRAPHIC:
        if seen.lens_radius > _MOST_LENS_M:
            yield f"a lens of {seen.lens_radius:.3g} m radius{DOUBT}{_lens(prim)}"
        field = 2.0 * math.degrees(math.atan(0.5 * width / float(seen.K[0, 0])))
        if not _LEAST_FIELD_DEG <= field <= _MOST_FIELD_DEG:
            yield f"a field of view of {field:.3g} degrees{DOUBT}{_field(prim)}"
    if (exposure := seen.exposure) is not None:
        stops = math.log2(exposure) if 0.0 < exposure < math.inf else math.inf
        if not _LEAST_STOPS <= stops <= _MOST_STOPS:
            factor = f"an exposure that multiplies nits by {exposure:.3g}"
            yield f"{factor}{DOUBT}it is in stops, and rooms need about -7"


def _show(prim: Usd.Prim, name: str) -> str:
    return f"{name} {prim.GetAttribute(name).Get(TIME):g}"


def _lens(prim: Usd.Prim) -> str:
    focal = prim.GetAttribute("focalLength").Get(TIME)
    metres = meters_per_unit(prim.GetStage())
    factor = _MILLIMETRE / (0.1 * metres)
    return (
        f"{_show(prim, 'focalLength')} is in tenths of a scene unit of {metres:g} m, and with "
        f"{_show(prim, 'fStop')} nearly everything is out of focus. For millimetres write "
        f"{factor * focal:g} and the apertures times {factor:g}, for sharp pictures fStop 0"
    )


def _field(prim: Usd.Prim) -> str:
    optics = f"{_show(prim, 'focalLength')} and {_show(prim, 'horizontalAperture')}"
    return f"{optics} are of one unit, or give --field-of-view"


def light_doubts(light: Light) -> Iterator[str]:
    """What is hardly meant of a light with a surface or of a dome, one sentence each."""
    if isinstance(light, DistantLight):
        return
    nits = float(np.max(light.radiance, initial=0.0))
    if nits >= _MOST_NITS:
        shown = f"a light of {float(luminance(light.radiance)):.3g} nit"
        yield f"{shown}{DOUBT}it is as bright as the disk of the sun, see its intensity"


def dark_doubt(lights: Sequence[Light]) -> str:
    """That all lights of a stage are off; empty where one is on, or there is none."""
    if not lights or any(np.any(light.radiance) for light in lights):
        return ""
    return f"a stage whose lights all have 0 nit{DOUBT}pictures are black where nothing else glows"
