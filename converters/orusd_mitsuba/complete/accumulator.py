"""Sums of the whole set of light channels, by light, one for each strand of a pixel's samples."""

from typing import Any, Final

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from openrooms_usd.arrays import Array, Floats
from orusd_mitsuba.complete.first_surface import FirstSurface

SUMS: Final = (
    "emission",
    "diffuse_direct",
    "diffuse_indirect",
    "rest_direct",
    "rest_indirect",
    "irradiance_direct",
    "irradiance_indirect",
    "unoccluded",
)
"""What is summed of every light."""

GUIDES: Final = ("albedo", "normal", "position", "nearness", "lobe_albedo", "lobe")
"""Sums over first surfaces, on request. They are Lambert's albedo, unit normal and position in
metres; the inverse distance along a cosine-distributed direction, per metre, and 1; what the
lobe reflects of even light. For the lobe they are its width in radian, the change with position
of what it meets, per metre, and 1."""

KINDS: Final[dict[str, tuple[str, ...]]] = {
    "emission": ("emission",),
    "direct": ("diffuse_direct", "rest_direct"),
    "indirect": ("diffuse_indirect", "rest_indirect"),
    "diffuse": ("diffuse_direct", "diffuse_indirect"),
    "specular": ("rest_direct", "rest_indirect"),
    "irradiance_direct": ("irradiance_direct",),
    "irradiance_indirect": ("irradiance_indirect",),
    "diffuse_indirect": ("diffuse_indirect",),
    "rest_indirect": ("rest_indirect",),
}
"""Pictures that there are once, and what is summed over all lights for them."""

# Of what rays meet nearer than that, metres, the distance counts as this.
_NEAREST_M: Final = 1e-3

OF_LIGHT: Final[dict[str, tuple[str, ...]]] = {
    "radiance": SUMS[:5],
    "irradiance_direct": ("irradiance_direct",),
    "irradiance_indirect": ("irradiance_indirect",),
    "unoccluded": ("unoccluded",),
    "diffuse_indirect": ("diffuse_indirect",),
    "rest_indirect": ("rest_indirect",),
}
"""Pictures that there are for every light, and what is summed for them."""

ONCE: Final = (*KINDS, "looked_up")
"""Pictures that there are once: `KINDS`, and the part of ``indirect`` that a cache had."""


class WholeAccumulator:
    """Sums by strand: zero at first. Each strand has places of its own, for any number of samples.

    No dataclass: Dr.Jit would carry its arrays through loops.

    Args:
        strands: How many there are.
        lights: How many lights; None adds them all as of the first.
        guided: Whether `GUIDES` are summed as well.

    Attributes:
        entries: (`rows_of` * 3 * strands) `SUMS` by light, what a cache had, and the guides.
    """

    def __init__(self, strands: int, lights: int | None, *, guided: bool = False) -> None:
        self.strands, self._by_light, self._guided = strands, lights is not None, guided
        # As variables, not as parts of the compiled code.
        self._stride = dr.opaque(mi.UInt32, strands)
        self._lights = dr.opaque(mi.UInt32, lights or 1)
        self.entries = dr.zeros(mi.Float, rows_of(lights, guided) * 3 * strands)

    def emitted(self, value: Any, light: Any, active: Any) -> None:
        """Add what the first surface emits, or the sky."""
        self._add("emission", light, value, active)

    def received(self, lux: Any, at: FirstSurface, kind: str, light: Any, active: Any) -> None:
        """Add irradiance, and what Lambert's reflection makes of it.

        Args:
            lux: Irradiance.
            at: What receives it.
            kind: ``direct`` or ``indirect``.
            light: Where it comes from, by number.
            active: Where there is any.
        """
        diffuse = at.albedo * lux * dr.inv_pi
        self._add(f"irradiance_{kind}", light, lux, active)
        self._add(f"diffuse_{kind}", light, diffuse, active)
        if at.undivided is not None:
            # What the rest has of it already.
            self._add(f"rest_{kind}", light, -diffuse, active & at.undivided)

    def reflected(self, value: Any, kind: str, light: Any, active: Any) -> None:
        """Add what the surface scatters otherwise; see `received`."""
        self._add(f"rest_{kind}", light, value, active)

    def unoccluded(self, lux: Any, light: Any, active: Any) -> None:
        """Add straight irradiance as if nothing stood in its way."""
        self._add("unoccluded", light, lux, active)

    def looked_up(self, value: Any, active: Any) -> None:
        """Add radiance that is sent to the camera, which a cache had."""
        self._add_to(len(SUMS) * self._lights, value, active)

    def guide(self, at: FirstSurface, meets: Any, distance: Any) -> None:
        """Add what first surfaces are like, if that is wanted.

        Args:
            at: The surfaces.
            meets: Where a direction by the cosine meets anything.
            distance: How far away, metres.
        """
        if self._guided:
            near = mi.Vector3f(_inverse(meets, distance), 1.0, 0.0)
            for name, value in zip(GUIDES, (at.albedo, at.normal, at.si.p, near), strict=False):
                self._add_guide(name, value, at.active)

    def guide_lobe(self, at: FirstSurface, meets: Any, distance: Any) -> None:
        """Add what their lobes are like, if that is wanted.

        Args:
            at: The surfaces.
            meets: Where a direction of the rest meets anything.
            distance: How far away, metres.
        """
        if self._guided:
            alone, albedo, width = at.lobe()
            # A mirrored ray turns with the place and with where it is seen from.
            change = _inverse(meets, distance) + dr.rcp(dr.maximum(at.si.t, _NEAREST_M))
            self._add_guide("lobe_albedo", albedo, alone)
            self._add_guide("lobe", mi.Vector3f(width, change, 1.0), alone)

    def _add_guide(self, name: str, value: Any, active: Any) -> None:
        self._add_to(len(SUMS) * self._lights + 1 + GUIDES.index(name), value, active)

    def _add(self, name: str, light: Any, value: Any, active: Any) -> None:
        self._add_to(
            SUMS.index(name) * self._lights + (light if self._by_light else 0), value, active
        )

    def _add_to(self, row: Any, value: Any, active: Any) -> None:
        strand = dr.arange(mi.UInt32, self.strands)
        for channel in range(3):
            place = (row * 3 + channel) * self._stride + strand
            dr.scatter_reduce(
                dr.ReduceOp.Add,
                self.entries,
                value[channel],
                place,
                active,
                mode=dr.ReduceMode.NoConflicts,
            )


def _inverse(meets: Any, distance: Any) -> Any:
    """Per metre; a ray that begins in a crease would count for all others."""
    return dr.select(meets, dr.rcp(dr.maximum(distance, _NEAREST_M)), 0.0)


def rows_of(lights: int | None, guided: bool = False) -> int:
    """How many sums there are."""
    return len(SUMS) * (lights or 1) + 1 + guided * len(GUIDES)


def pictures_of(lights: int | None, guided: bool = False) -> int:
    """How many pictures are made of them: `ONCE`, each of `OF_LIGHT` for all lights, `GUIDES`."""
    return len(ONCE) + len(OF_LIGHT) * (lights or 0) + guided * len(GUIDES)


def pictures(sums: Floats, lights: int | None) -> Floats:
    """Those pictures.

    Args:
        sums: (`rows_of`, ...) the means over samples.
        lights: How many lights; None where they were all added as of the first.
    """
    sums, known, guides = np.split(sums, np.cumsum([len(SUMS) * (lights or 1), 1]))
    by_light = sums.reshape(len(SUMS), lights or 1, *sums.shape[1:])
    whole = by_light.sum(axis=1, dtype=np.float64)
    once = [_sum_of(whole, names) for names in KINDS.values()]
    # Rounding alone can make them negative, where Lambert's reflection was taken off and put back.
    for name in ("direct", "indirect"):
        np.maximum(once[[*KINDS].index(name)], 0.0, out=once[[*KINDS].index(name)])
    each = [] if lights is None else [_sum_of(by_light, names) for names in OF_LIGHT.values()]
    lit = [np.stack(once), known, *(np.maximum(values, 0.0) for values in each)]
    found = np.concatenate([*lit, guides])
    return np.asarray(found, dtype=np.float32)


def _sum_of(values: NDArray[Any], names: tuple[str, ...]) -> Array:
    rows = [SUMS.index(name) for name in names]
    return np.asarray(values[rows].sum(axis=0, dtype=np.float64))


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

    def looked_up(self, value: Any, active: Any) -> None:
        """Add what a cache had of that; where the surface is undivided the rest has it."""
        if self._at.undivided is not None:
            active = active & ~self._at.undivided
        self._sums.looked_up(self._at.albedo * value, active)


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

    def looked_up(self, value: Any, active: Any) -> None:
        """Add what a cache had of that."""
        self._sums.looked_up(value, active)


class Mirrored:
    """Receives what the camera sees mirrored in panes: `path_tracing.Accumulator`.

    Args:
        sums: Where it is filed.
    """

    def __init__(self, sums: WholeAccumulator) -> None:
        self._sums = sums

    def add(self, value: Any, light: Any, scatterings: Any, active: Any) -> None:
        """Add radiance that is sent to the camera; the pane has scattered it last."""
        once = scatterings <= 1
        self._sums.reflected(value, "direct", light, active & once)
        self._sums.reflected(value, "indirect", light, active & ~once)

    def looked_up(self, value: Any, active: Any) -> None:
        """Add what a cache had of that."""
        self._sums.looked_up(value, active)


class SplitAccumulator:
    """Receives the light of one of both kinds of directions: `path_tracing.Accumulator`.

    Args:
        which: Where the direction is one of the rest.
        rest: What receives that.
        cosine: What receives the others.
    """

    def __init__(self, which: Any, rest: Reflected, cosine: Received) -> None:
        self._which, self._rest, self._cosine = which, rest, cosine

    def add(self, value: Any, light: Any, scatterings: Any, active: Any) -> None:
        """Add radiance to one of them."""
        self._rest.add(value, light, scatterings, active & self._which)
        self._cosine.add(value, light, scatterings, active & ~self._which)

    def looked_up(self, value: Any, active: Any) -> None:
        """Add what a cache had of that."""
        self._rest.looked_up(value, active & self._which)
        self._cosine.looked_up(value, active & ~self._which)
