"""Sums of what each light sends straight, one for each light path."""

from typing import Any

import drjit as dr
import mitsuba as mi


class DirectAccumulator:
    """Sums by path and light: occluded, unoccluded, and in closed form.

    No dataclass: Dr.Jit would carry its arrays through loops.

    Args:
        paths: How many paths there are.
        lights: How many lights.
        closed: How many of them have a closed form.
    """

    def __init__(self, paths: int, lights: int, closed: int) -> None:
        self.paths, self.lights = paths, lights
        self._stride, self._planes = (dr.opaque(mi.UInt32, count) for count in (paths, lights))
        self.entries = dr.zeros(mi.Float, (2 * lights + closed) * 3 * paths)

    def add(self, light: Any, value: Any, seen: Any, active: Any) -> None:
        """Add what a light sends, and that times the part which arrives."""
        self._add(light, value * seen, active)
        self._add(light + self._planes, value, active)

    def add_closed(self, number: Any, value: Any, active: Any) -> None:
        """Add what a light sends by its closed form; ``number`` counts those that have one."""
        self._add(number + 2 * self._planes, value, active)

    def dim(self, plane: int, factor: Any) -> None:
        """Multiply what one plane has with a factor of each path."""
        slot = dr.arange(mi.UInt32, self.paths)
        for channel in range(3):
            place = dr.opaque(mi.UInt32, (3 * plane + channel) * self.paths) + slot
            dr.scatter(self.entries, factor * dr.gather(mi.Float, self.entries, place), place)

    def green(self, plane: int) -> Any:
        """(paths,) the green of one plane."""
        place = dr.opaque(mi.UInt32, (3 * plane + 1) * self.paths)
        return dr.gather(mi.Float, self.entries, place + dr.arange(mi.UInt32, self.paths))

    def _add(self, plane: Any, value: Any, active: Any) -> None:
        slot = dr.arange(mi.UInt32, self.paths)
        for channel in range(3):
            place = (plane * 3 + channel) * self._stride + slot
            dr.scatter_reduce(
                dr.ReduceOp.Add,
                self.entries,
                value[channel],
                place,
                active,
                mode=dr.ReduceMode.NoConflicts,
            )
