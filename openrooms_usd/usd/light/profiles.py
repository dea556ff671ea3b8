"""Intensity profiles of luminaires: IES LM-63 files, and what they do to a light.

ANSI/IES LM-63 (1991, 1995, 2002): a header, keywords in brackets, ``TILT=NONE``, ten numbers of the
lamp, three of the ballast, the vertical and the horizontal angles, and the candela of each plane in
turn. Of type C vertical angles run from 0 at the nadir to 180 at the zenith; planes that lie
symmetric to those in the file are left out of it.

UsdLux multiplies the luminance of a light with the profile in the direction in which the light
goes, in its own frame, whose -Z is the nadir.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from openrooms_usd.arrays import Array, Floats
from openrooms_usd.errors import InputError
from openrooms_usd.untrusted import read_text

_TITLES: Final = ("IESNA:LM-63-1995", "IESNA:LM-63-2002", "IESNA91")
_TYPE_C: Final = 1
_HEAD_NUMBERS: Final = 13
_MOST_ANGLES: Final = 2000
_MOST_VALUES: Final = 1_000_000
# Steps of a table, degrees: the first that all angles of a file are multiples of is exact.
_STEPS_DEG: Final = (90.0, 45.0, 30.0, 22.5, 15.0, 10.0, 7.5, 5.0, 2.5, 2.0, 1.0, 0.5, 0.25)
# Degrees that numbers of a file may lie beside a multiple.
_SAME_ANGLE_DEG: Final = 1e-6
# A profile that ends no higher above the nadir than this is one of a hemisphere, degrees: 0.1
# radian beyond a right angle, as in OpenUSD's own renderer.
_HEMISPHERE_UP_TO_DEG: Final = 90.0 + math.degrees(0.1)
# Directions over which what a surface sends out is summed.
_FLUX_STEP_DEG: Final = 0.5
_LEAST_FLUX_STEPS: Final = 64
_FLUX_AROUND: Final = 72


@dataclass(frozen=True, eq=False)
class Profile:
    """Luminous intensity by direction.

    Attributes:
        polar: (V,) degrees from the nadir, ascending; beyond the first and last nothing is sent.
        around: (H,) degrees about the axis from 0 to 360, ascending, counter-clockwise from +X as
            seen from the zenith.
        candela: (H, V) intensities, bilinear between.
    """

    polar: Array
    around: Array
    candela: Array

    def intensity(self, directions: ArrayLike) -> Array:
        """(..., ) candela along (..., 3) directions in the light's frame, whose -Z is the nadir."""
        polar, around = angles(np.asarray(directions, dtype=np.float64))
        row, across = _between(self.around, around)
        column, along = _between(self.polar, polar)
        near, far = (
            (1.0 - along) * self.candela[at, column] + along * self.candela[at, column + 1]
            for at in (row, row + 1)
        )
        inside = (polar >= self.polar[0]) & (polar <= self.polar[-1])
        return np.where(inside, (1.0 - across) * near + across * far, 0.0)

    @property
    def flux(self) -> float:
        """Lumen: the integral of the intensity over all directions, exact for what is bilinear."""
        t = np.radians(self.polar)
        a, b = self._ring_means[:-1], self._ring_means[1:]
        slope = (b - a) / np.diff(t)
        # The integral of a linear function times the sine.
        whole = a * np.cos(t[:-1]) - b * np.cos(t[1:]) + slope * np.diff(np.sin(t))
        return float(2.0 * math.pi * whole.sum())

    @property
    def _ring_means(self) -> Array:
        """(V,) candela, the mean around the axis."""
        weights = np.diff(self.around) / 720.0
        return np.asarray(weights @ (self.candela[:-1] + self.candela[1:]))

    @property
    def mean(self) -> float:
        """Candela: flux over the solid angle of the sphere, or of the hemisphere that it fills."""
        spread = self.polar[-1] - self.polar[0]
        return self.flux / (2.0 * math.pi * (1.0 if spread <= _HEMISPHERE_UP_TO_DEG else 2.0))

    def scaled(self, scale: float) -> "Profile":
        """The same with its vertical angles stretched, as UsdLux's ``angleScale`` says.

        Args:
            scale: By how much: from the nadir where it is above 0, from the zenith below 0.
        """
        if scale == 0.0:
            return self
        pivot = 0.0 if scale > 0.0 else 180.0
        polar = (self.polar - pivot) * abs(scale) + pivot
        if polar[0] >= 0.0 and polar[-1] <= 180.0:
            return replace(self, polar=polar)
        low, high = max(float(polar[0]), 0.0), min(float(polar[-1]), 180.0)
        kept = np.unique([low, *polar[(polar > low) & (polar < high)], high])
        rows = np.stack([np.interp(kept, polar, row) for row in self.candela])
        return Profile(kept, self.around, rows)


@dataclass(frozen=True, eq=False)
class Shaping:
    """How the radiance of a light in the world changes with the direction.

    Attributes:
        factors: (H, V) float32, what it is multiplied with: V steps up from ``first_deg``, and H
            about the axis from 0 to 360 degrees.
        first_deg: The angle from the nadir of the first column; beyond the first and the last
            nothing is sent.
        last_deg: That of the last column.
        light_from_world: (3, 3) turns directions of the world into the light's frame.
    """

    factors: Floats
    first_deg: float
    last_deg: float
    light_from_world: Array

    def factor(self, directions: ArrayLike) -> Array:
        """(...,) what the radiance along (..., 3) directions of the world is multiplied with."""
        height, width = self.factors.shape
        table = Profile(
            np.linspace(self.first_deg, self.last_deg, width),
            np.linspace(0.0, 360.0, height),
            self.factors.astype(np.float64),
        )
        return table.intensity(np.asarray(directions, dtype=np.float64) @ self.light_from_world.T)

    def turned(self, rotation: Array) -> "Shaping":
        """The same after a (3, 3) rotation of the light in the world."""
        return replace(self, light_from_world=self.light_from_world @ rotation.T)

    def mean_over(self, normals: Array, areas: Array) -> float:
        """What the flux of a surface is multiplied with, if it would emit like Lambert.

        Args:
            normals: (N, 3) unit normals of its faces, in the world.
            areas: (N,) of these, square metres.
        """
        spread = self.last_deg - self.first_deg
        steps = max(_LEAST_FLUX_STEPS, round(spread / _FLUX_STEP_DEG))
        edges = np.radians(np.linspace(self.first_deg, self.last_deg, steps + 1))
        middle = 0.5 * (edges[1:] + edges[:-1])
        solid = (np.cos(edges[:-1]) - np.cos(edges[1:])) * 2.0 * math.pi / _FLUX_AROUND
        phi = 2.0 * math.pi * (np.arange(_FLUX_AROUND) + 0.5) / _FLUX_AROUND
        inner = normals @ self.light_from_world.T
        total = 0.0
        for polar, weight in zip(middle, solid, strict=True):
            sine, down = math.sin(polar), np.full(_FLUX_AROUND, -math.cos(polar))
            ways = np.column_stack([sine * np.cos(phi), sine * np.sin(phi), down])
            factors = self.factor(ways @ np.linalg.inv(self.light_from_world).T)
            if factors.any():
                total += weight * float(areas @ np.maximum(inner @ ways.T, 0.0) @ factors)
        whole = math.pi * float(areas.sum())
        return total / whole if whole > 0.0 else 0.0


def shaping(
    profile: Profile,
    world_from_light: Array,
    *,
    normalize: bool,
    scale: float = 0.0,
    cut: Callable[[Profile], Profile] = lambda profile: profile,
) -> Shaping:
    """What a profile makes of a light, as UsdLux has it.

    Args:
        profile: The profile.
        world_from_light: (3, 3) or (4, 4), the light's frame.
        normalize: Whether intensities count relative to their mean over all directions.
        scale: UsdLux's ``angleScale``.
        cut: What else is made of the profile: the light's cone and focus.
    """
    power = profile.mean if normalize else 1.0
    found = cut(profile.scaled(scale))
    height, width = _samples(found.around), _samples(found.polar)
    polar = np.linspace(found.polar[0], found.polar[-1], width)
    around = np.linspace(0.0, 360.0, height)
    rows = np.stack([np.interp(polar, found.polar, row) for row in found.candela])
    table = np.stack([np.interp(around, found.around, column) for column in rows.T], axis=1)
    factors = (table / power if power > 0.0 else np.zeros_like(table)).astype(np.float32)
    M = world_from_light[:3, :3]
    u, _, vt = np.linalg.svd(M)
    return Shaping(factors, float(polar[0]), float(polar[-1]), np.asarray((u @ vt).T))


def read_profile(path: Path) -> Profile:
    """Read an IES file.

    Raises:
        InputError: It cannot be read, or is not an LM-63 file of type C photometry without tilt.
    """
    return parse_profile(read_text(path, "table"), str(path))


def parse_profile(text: str, place: str) -> Profile:
    """A profile from the text of an IES file.

    Args:
        text: Of LM-63-1991, 1995 or 2002.
        place: The file's name, for messages.

    Raises:
        InputError: The text is not an LM-63 file of type C photometry without tilt.
    """
    lines = text.splitlines()
    title = lines[0].strip() if lines else ""
    if not title.startswith(_TITLES):
        raise _refusal(f"its first line is not one of {', '.join(_TITLES)}", place)
    tilts = [row for row, line in enumerate(lines) if line.strip().upper().startswith("TILT=")]
    if not tilts:
        raise _refusal("it has no line TILT=", place)
    tilt = lines[tilts[0]].strip()[5:].strip()
    if tilt.upper() != "NONE":
        raise _refusal(f"TILT={tilt[:40]} is not supported", place, "give a file with TILT=NONE")
    words = " ".join(lines[tilts[0] + 1 :]).replace(",", " ").split()
    try:
        numbers = np.array([float(word) for word in words[: _MOST_VALUES + 1]])
    except ValueError as error:
        raise _refusal(f"it has text among its numbers: {str(error)[-60:]}", place) from error
    if len(numbers) < _HEAD_NUMBERS or not np.isfinite(numbers).all():
        raise _refusal("its numbers end too early or are not finite", place)
    multiplier, counts, kind = numbers[2], numbers[3:5], numbers[5]
    if kind != _TYPE_C:
        raise _refusal(f"photometry of type {kind:g} is not supported; type C is 1", place)
    if (counts != np.round(counts)).any() or counts.min() < 1 or counts.max() > _MOST_ANGLES:
        raise _refusal(f"{counts[0]:g} x {counts[1]:g} angles are not plausible", place)
    vertical, planes = int(counts[0]), int(counts[1])
    wanted = _HEAD_NUMBERS + vertical + planes + vertical * planes
    if len(numbers) != wanted:
        raise _refusal(f"it has {len(numbers)} numbers, but its angles need {wanted}", place)
    polar, around, flat = np.split(numbers[_HEAD_NUMBERS:], [vertical, vertical + planes])
    # Of the ballast: its factor and a factor of old files for photometry, 1 today.
    candela = flat.reshape(planes, vertical) * multiplier * numbers[10] * numbers[11]
    ends = (polar[0] in (0.0, 90.0)) and (polar[-1] in (90.0, 180.0))
    if vertical < 2 or (np.diff(polar) <= 0.0).any() or not ends:
        raise _refusal("its vertical angles do not ascend from 0 or 90 to 90 or 180 degrees", place)
    if (np.diff(around) <= 0.0).any() or (candela < 0.0).any():
        raise _refusal("its horizontal angles do not ascend, or an intensity is below 0", place)
    unfolded = _unfolded(around, candela)
    if unfolded is None:
        raise _refusal(
            f"planes from {around[0]:g} to {around[-1]:g} degrees are not of type C", place
        )
    return Profile(polar, *unfolded)


def _refusal(
    reason: str, place: str, remedy: str = "give an IES LM-63 file of type C"
) -> InputError:
    return InputError(reason, place=place, remedy=remedy)


def angles(directions: Array) -> tuple[Array, Array]:
    """Degrees from -Z, and about it from +X, 0 to 360, of (..., 3) directions."""
    x, y, z = np.moveaxis(directions, -1, 0)
    return np.degrees(np.arctan2(np.hypot(x, y), -z)), np.degrees(np.arctan2(y, x)) % 360.0


def _unfolded(around: Array, candela: Array) -> tuple[Array, Array] | None:
    """All planes from 0 to 360 degrees from those in a file; None where it has others."""
    first, last = float(around[0]), float(around[-1])
    if len(around) == 1:
        return (np.array([0.0, 360.0]), np.repeat(candela, 2, axis=0)) if first == 0.0 else None
    if (first, last) == (90.0, 270.0):
        # Each plane has its mirror image about the plane through both.
        turned = np.concatenate([180.0 - around[:0:-1], around[:-1]])
        rows = np.concatenate([candela[:0:-1], candela[:-1]])
        at = np.unique([0.0, *(turned % 360.0), 360.0])
        columns = [np.interp(at, turned, column, period=360.0) for column in rows.T]
        return at, np.stack(columns, axis=1)
    if first != 0.0:
        return None
    while last < 360.0:
        if last not in (90.0, 180.0):
            return None
        around = np.concatenate([around, 2.0 * last - around[-2::-1]])
        candela = np.concatenate([candela, candela[-2::-1]])
        last *= 2.0
    return (around, candela) if last == 360.0 else None


def _between(places: Array, values: Array) -> tuple[NDArray[np.intp], Array]:
    """The interval of ascending places that values lie in, and how far."""
    row = np.clip(np.searchsorted(places, values, side="right") - 1, 0, len(places) - 2)
    low, high = places[row], places[row + 1]
    return row, np.clip((values - low) / (high - low), 0.0, 1.0)


def _samples(places: Array) -> int:
    """How many even steps, and one, hold all places; at most a quarter of a degree apart."""
    offsets = places - places[0]
    last = float(offsets[-1])
    if np.ptp(np.diff(places)) < _SAME_ANGLE_DEG:
        return len(places)
    for step in _STEPS_DEG:
        if np.abs(offsets / step - np.round(offsets / step)).max() * step < _SAME_ANGLE_DEG:
            return round(last / step) + 1
    return max(2, math.ceil(last / _STEPS_DEG[-1]) + 1)
