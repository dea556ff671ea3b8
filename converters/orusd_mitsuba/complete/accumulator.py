"""Sums of the whole set of light channels, one for each strand of a pixel's samples."""

from typing import Any, Final

import drjit as dr
import mitsuba as mi

from orusd_mitsuba.complete.first_surface import FirstSurface

KINDS: Final = (
    "emission",
    "direct",
    "indirect",
    "diffuse",
    "specular",
    "irradiance_direct",
    "irradiance_indirect",
)
"""Sums that there are once: what the picture is made of, and what its surfaces receive."""

OF_LIGHT: Final = ("radiance", "irradiance_direct", "irradiance_indirect", "unoccluded")
"""Sums that there are for every light."""


class WholeAccumulator:
    """Sums by strand: zero at first. Each strand has places of its own, for any number of samples.

    No dataclass: Dr.Jit would carry its arrays through loops.

    Args:
        strands: How many there are.
        lights: How many lights; None where sums by light are not wanted.

    Attributes:
        entries: (rows * 3 * strands) `KINDS`, then each of `OF_LIGHT` for all lights.
    """

    def __init__(self, strands: int, lights: int | None) -> None:
        self.strands = strands
        # As variables, not as parts of the compiled code.
        self._stride = dr.opaque(mi.UInt32, strands)
        self._lights = None if lights is None else dr.opaque(mi.UInt32, lights)
        self.entries = dr.zeros(mi.Float, rows_of(lights) * 3 * strands)

    def emitted(self, value: Any, light: Any, active: Any) -> None:
        """Add what the first surface emits, or the sky."""
        self._add("emission", value, active)
        self._add_of("radiance", light, value, active)

    def received(self, lux: Any, at: FirstSurface, kind: str, light: Any, active: Any) -> None:
        """Add irradiance, and what Lambert's reflection makes of it.

        Args:
            lux: Irradiance.
            at: What receives it.
            kind: ``direct`` or ``indirect``.
            light: Where it comes from, by number.
            active: Where there is any.
        """
        self._add(f"irradiance_{kind}", lux, active)
        self._add_of(f"irradiance_{kind}", light, lux, active)
        diffuse = at.albedo * lux * dr.inv_pi
        self._add("diffuse", diffuse, active)
        if at.undivided is None:
            self._sent(diffuse, kind, light, active)
        else:
            self._sent(diffuse, kind, light, active & ~at.undivided)
            self._add("specular", -diffuse, active & at.undivided)

    def reflected(self, value: Any, kind: str, light: Any, active: Any) -> None:
        """Add what the surface scatters otherwise; see `received`."""
        self._add("specular", value, active)
        self._sent(value, kind, light, active)

    def _sent(self, value: Any, kind: str, light: Any, active: Any) -> None:
        self._add(kind, value, active)
        self._add_of("radiance", light, value, active)

    def unoccluded(self, lux: Any, light: Any, active: Any) -> None:
        """Add straight irradiance as if nothing stood in its way."""
        self._add_of("unoccluded", light, lux, active)

    def _add(self, name: str, value: Any, active: Any) -> None:
        self._scatter(mi.UInt32(KINDS.index(name)), value, active)

    def _add_of(self, name: str, light: Any, value: Any, active: Any) -> None:
        if self._lights is not None:
            row = len(KINDS) + OF_LIGHT.index(name) * self._lights + light
            self._scatter(row, value, active)

    def _scatter(self, row: Any, value: Any, active: Any) -> None:
        strand = dr.arange(mi.UInt32, self.strands)
        for channel in range(3):
            place = (row * 3 + channel) * self._stride + strand
            dr.scatter_reduce(
                dr.ReduceOp.Add, self.entries, value[channel], place, active,
                mode=dr.ReduceMode.NoConflicts,
            )  # fmt: skip


def rows_of(lights: int | None) -> int:
    """How many pictures the sums make."""
    return len(KINDS) + len(OF_LIGHT) * (lights or 0)


class Received:
    """Receives the light that a cosine's direction brings: `path_tracing.Accumulator`.

    Args:
        sums: Where it is filed.
        at: What receives it.
        kind: ``direct`` or ``indirect``.
    """

    def __init__(self, sums: WholeAccumulator, at: FirstSurface, kind: str) -> None:
        self._sums, self._at, self._kind = sums, at, kind

    def add(self, value: Any, light: Any, scatterings: Any, active: Any) -> None:
        """Add radiance that arrives, divided by its density over that of the cosine."""
        self._sums.received(dr.pi * value, self._at, self._kind, light, active)


class Reflected:
    """Receives the light that a direction of the rest brings: `path_tracing.Accumulator`.

    Args:
        sums: Where it is filed.
        kind: ``direct`` or ``indirect``.
    """

    def __init__(self, sums: WholeAccumulator, kind: str) -> None:
        self._sums, self._kind = sums, kind

    def add(self, value: Any, light: Any, scatterings: Any, active: Any) -> None:
        """Add radiance that is sent to the camera."""
        self._sums.reflected(value, self._kind, light, active)
