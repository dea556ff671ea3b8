"""`UsdLux.ShapingAPI` of a light: the profile, the cone and the focus that its radiance follows."""

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from pxr import Sdf, Usd, UsdLux

from openrooms_usd.arrays import Array
from openrooms_usd.colorimetry import luminance
from openrooms_usd.errors import InputError
from openrooms_usd.usd.arrays import number_of, vector_of
from openrooms_usd.usd.files.strayed import locate
from openrooms_usd.usd.light.emitters import (
    CylinderLight,
    DiskLight,
    Light,
    MeshLight,
    RectLight,
    SphereLight,
)
from openrooms_usd.usd.light.inputs import light_input
from openrooms_usd.usd.light.profiles import Profile, Shaping, read_profile, shaping
from openrooms_usd.usd.shading.textures import report_line

_STEP_DEG: Final = 0.25
# Steps in a cone, however narrow, and in the width of a focused beam.
_STEPS_IN_CONE: Final = 128
_STEPS_IN_BEAM: Final = 16
_MOST_STEPS: Final = 8192

EVEN: Final = Profile(np.array([0.0, 180.0]), np.array([0.0, 360.0]), np.ones((2, 2)))
"""Light that goes everywhere alike."""


@dataclass(frozen=True)
class Cone:
    """A cone about a light's axis, and the focus in it.

    Attributes:
        angle: Degrees from the axis beyond which nothing is sent.
        softness: The share of the angle over which light goes down to nothing, 0 to 1.
        focus: Exponent of the cosine to the axis.
        tint: What remains where the focus takes all, of 1.
    """

    angle: float = 180.0
    softness: float = 0.0
    focus: float = 0.0
    tint: float = 0.0

    @property
    def changes(self) -> bool:
        """Whether it makes anything of a light."""
        return self != Cone(tint=self.tint)

    def factor(self, polar: Array) -> Array:
        """What radiance is multiplied with at angles from the axis, degrees."""
        cosine = np.abs(np.cos(np.radians(polar)))
        focused = self.tint + (1.0 - self.tint) * cosine**self.focus
        start = self.angle * (1.0 - self.softness)
        if start >= self.angle:
            return np.where(polar <= self.angle, focused, 0.0)
        t = np.clip((polar - start) / (self.angle - start), 0.0, 1.0)
        return np.asarray(focused * (1.0 - t * t * (3.0 - 2.0 * t)))

    def of(self, profile: Profile) -> Profile:
        """A profile multiplied with the cone."""
        low, high = float(profile.polar[0]), min(float(profile.polar[-1]), self.angle)
        if not self.changes or high <= low:
            return profile if not self.changes else _dark(profile)
        polar = self._angles(profile, low, high)
        rows = np.stack([np.interp(polar, profile.polar, row) for row in profile.candela])
        return Profile(polar, profile.around, rows * self.factor(polar))

    def _angles(self, profile: Profile, low: float, high: float) -> Array:
        """Angles between which the product is as good as linear."""
        if self.softness == 0.0 and self.focus == 0.0:
            inner = profile.polar[(profile.polar > low) & (profile.polar < high)]
            return np.array([low, *inner, high])
        beam = math.degrees(1.0 / math.sqrt(max(self.focus, 1.0)))
        step = min(_STEP_DEG, (high - low) / _STEPS_IN_CONE, beam / _STEPS_IN_BEAM)
        return np.linspace(low, high, min(_MOST_STEPS, math.ceil((high - low) / step)) + 1)


def _dark(profile: Profile) -> Profile:
    return Profile(profile.polar, profile.around, np.zeros_like(profile.candela))


_SURFACES: Final = (MeshLight, RectLight, DiskLight, SphereLight, CylinderLight)
# Lights of which no more than a hemisphere is seen from anywhere, in which a right angle cuts
# nothing.
_ONE_SIDED: Final = (RectLight, DiskLight)
_AFAR: Final = {
    "ies": "inputs:shaping:ies:file: the light does not follow its IES profile",
    "cone": "inputs:shaping: the light ignores its cone and focus",
}
_WHEN: Final = Usd.TimeCode.EarliestTime()


def read_shaping(prim: Usd.Prim, light: Light) -> tuple[Shaping | None, tuple[str, ...]]:
    """What a light's profile, cone and focus make of it, and what was lost.

    Args:
        prim: The light.
        light: The same as plain data.
    """
    cone, losses = _read_cone(prim, light)
    file = _value(prim, "ies:file", None)
    if not isinstance(light, _SURFACES):
        authored = {"ies": file, "cone": cone.changes}
        return None, tuple(why for name, why in _AFAR.items() if authored[name])
    profile, lost = _read_profile(_shaping_input(prim, "ies:file"), file)
    if profile is None and not cone.changes:
        return None, (*losses, *lost)
    normalize = profile is not None and bool(_value(prim, "ies:normalize", False))
    scale = number_of(_value(prim, "ies:angleScale", 0.0)) or 0.0
    found = shaping(
        profile or EVEN,
        light.world_from_light,
        normalize=normalize,
        scale=scale if profile else 0.0,
        cut=cone.of,
    )
    return found, (*losses, *lost)


def _read_cone(prim: Usd.Prim, light: Light) -> tuple[Cone, list[str]]:
    """The cone and the focus; an angle that is not authored cuts nothing, unless it is soft."""
    losses: list[str] = []
    angle, softness, focus = (
        _finite(_shaping_input(prim, name), losses)
        for name in ("cone:angle", "cone:softness", "focus")
    )
    softness = min(max(softness or 0.0, 0.0), 1.0)
    if angle is None:
        angle = 90.0 if softness else 180.0
    hue = vector_of(_value(prim, "focusTint", None), 3)
    tint = np.zeros(3) if hue is None else np.clip(np.nan_to_num(hue), 0.0, 1.0)
    focus = max(focus or 0.0, 0.0)
    if focus and np.ptp(tint) > 0.0:
        losses.append("inputs:shaping:focusTint: its hue is left out")
    angle = min(max(angle, 0.0), 180.0)
    if softness == 0.0 and angle >= 90.0 and isinstance(light, _ONE_SIDED):
        angle = 180.0
    return Cone(angle, softness, focus, float(luminance(tint)) if focus else 0.0), losses


def _finite(attribute: Usd.Attribute, losses: list[str]) -> float | None:
    """The authored number."""
    if not attribute or not attribute.HasAuthoredValue():
        return None
    value = attribute.Get(_WHEN)
    found = number_of(value)
    if value is None or (found is not None and np.isfinite(found)):
        return found
    what = "no number" if found is None else "not finite"
    losses.append(f"{attribute.GetName()}: {value} is {what}; it is left out")
    return None


def _read_profile(attribute: Usd.Attribute, file: Any) -> tuple[Profile | None, tuple[str, ...]]:
    if not isinstance(file, Sdf.AssetPath) or not file.path:
        return None, ()
    found, lost = locate(attribute, file)
    losses = (f"its IES profile {lost}",) if lost else ()
    try:
        return read_profile(Path(found)) if found else None, losses
    except InputError as error:
        return None, (*losses, report_line(error), "it shines evenly")


def define_shaping(prim: Usd.Prim, file: str) -> None:
    """Let a light follow an IES profile, which changes where its light goes.

    Args:
        prim: The light, or an over where it shall be.
        file: Asset path of the profile.
    """
    api = UsdLux.ShapingAPI.Apply(prim)
    api.CreateShapingIesFileAttr(Sdf.AssetPath(file))
    api.CreateShapingIesNormalizeAttr(True)


def _value(prim: Usd.Prim, name: str, default: Any) -> Any:
    attribute = _shaping_input(prim, name)
    value = attribute.Get(_WHEN) if attribute else None
    return default if value is None else value


def _shaping_input(prim: Usd.Prim, name: str) -> Usd.Attribute:
    return light_input(prim, f"inputs:shaping:{name}")
