"""What UsdLux's cone and focus make of a light: its radiance by the angle from its axis.

``UsdLux.ShapingAPI``: beyond ``cone:angle`` nothing is sent; over the outer part of it, whose share
is ``cone:softness``, the light goes down by a smooth step in the angle. The focus multiplies with
``|cos|^focus``, and where there is a tint, mixes that in where the light is lost.
"""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.usd.profiles import Profile

Array = NDArray[np.float64]

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
