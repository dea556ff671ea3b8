"""Which light a contribution of a path comes from, by number, and what lies on its way.

Lamps come first, then openings, then whatever else there is. Light of the surroundings belongs to
the opening through which it came in: of all rectangles that a path crosses outwards, the one that
is nearest to the sky. What comes in past all of them, through an open ceiling for instance, is
``elsewhere``.
"""

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.rendering.scene.arrays import Patch
from openrooms_usd.rendering.scene.lights import counted, is_linked
from openrooms_usd.rendering.scene.sources import GRAZING_COS, Source
from openrooms_usd.usd.light.lights import Portal
from orusd_mitsuba.transport.panes import Panes


class LightIndex:
    """Looks up the numbers of lights for arrays of shapes and rays.

    Args:
        sources: What `sources_of` found.
        built: The Mitsuba scene, its shapes in the order of the scene's patches.
        origin: (3,) the point of the world that is Mitsuba's origin.
        panes: The clear panes that rays cross.
        patches: Those of the scene, where some lamps do not light all of them.

    Attributes:
        panes: See above; None where there are none.
    """

    def __init__(
        self,
        sources: Sequence[Source],
        built: Any,
        origin: Array,
        panes: Panes | None = None,
        patches: Sequence[Patch] = (),
    ) -> None:
        self._patches = patches
        self.panes = panes
        self._sources = sources
        self._built = built
        self._origin = origin

    @property
    def count(self) -> int:
        """How many lights there are, `ELSEWHERE` included."""
        return len(self._sources)

    @property
    def elsewhere(self) -> int:
        """The index that stands for no light."""
        return self.count - 1

    @cached_property
    def _by_shape(self) -> Any:
        """The light of each registered shape; `elsewhere` where it emits nothing."""
        shapes = [registered(mi.ShapePtr(shape)) for shape in self._built.shapes()]
        numbers = np.concatenate([np.zeros(0, np.uint32), *shapes])
        table = np.full(int(numbers.max(initial=0)) + 1, self.elsewhere, dtype=np.uint32)
        for light, source in enumerate(self._sources):
            table[numbers[list(source.patches)]] = light
        return mi.UInt32(table)

    @property
    def is_linked(self) -> bool:
        """Whether there are surfaces that a lamp does not light as much as others."""
        return is_linked(self._patches)

    def lit(self, light: Any, shape: Any, active: Any) -> Any:
        """What of a light counts on a shape: 0 where light linking leaves it out."""
        if not self.is_linked:
            return mi.Float(1.0)
        table, shapes = self._numbers_of_shapes
        number: Any = dr.reinterpret_array(mi.UInt32, shape)
        return dr.gather(mi.Float, table, light * shapes + number, active)

    @cached_property
    def _numbers_of_shapes(self) -> tuple[Any, Any]:
        """Of each light and registered shape, and how many shapes there are."""
        numbers = [int(registered(mi.ShapePtr(shape))[0]) for shape in self._built.shapes()]
        table = np.ones((self.count, max(numbers, default=0) + 1), dtype=np.float32)
        for light, source in enumerate(self._sources):
            lamps = [self._patches[row] for row in source.patches]
            for number, patch in zip(numbers, self._patches, strict=False):
                if lamps:
                    table[light, number] = max(counted(lamp, patch) for lamp in lamps)
        return mi.Float(table.ravel()), dr.opaque(mi.UInt32, table.shape[1])

    @cached_property
    def _rectangles(self) -> list[tuple[Any, "Rectangle"]]:
        return [
            (dr.opaque(mi.UInt32, light), Rectangle(source.portal, self._origin))
            for light, source in enumerate(self._sources)
            if source.portal is not None
        ]

    def through(self, ray: Any, active: Any, end: Any = dr.inf) -> Any:
        """What comes along rays through the panes that they cross: a colour, 1 without panes."""
        if self.panes is None:
            return mi.Color3f(1.0)
        return self.panes.through(ray, end, active)

    def unblocked(self, si: Any, to: Any, active: Any) -> Any:
        """What comes of light samples to surfaces: a colour, 0 where anything stands in the way.

        Args:
            si: The surfaces.
            to: The samples.
            active: Which of them are wanted: those that would bring anything.
        """
        ray = si.spawn_ray_to(to.p)
        free = active & ~self._built.ray_test(ray, active)
        return dr.select(free, self.through(ray, free), 0.0)

    def meet_panes(
        self, ray: Any, end: Any, sampler: Any, active: Any, mirrors: Any
    ) -> tuple[Any, Any, Any, Any]:
        """Let rays go through panes or be mirrored by one; see `Panes.meet`."""
        if self.panes is None:
            return mi.Color3f(1.0), mi.Bool(False), ray, end
        return self.panes.meet(ray, end, sampler, active, mirrors)  # type: ignore[no-any-return]

    def of_shape(self, shape: Any, active: Any) -> Any:
        """The light that a shape is part of."""
        number: Any = dr.reinterpret_array(mi.UInt32, shape)
        return dr.gather(mi.UInt32, self._by_shape, number, active)

    def crossed(self, origin: Any, direction: Any, length: Any, before: Any) -> Any:
        """The opening that a ray leaves through last, ``before`` where it leaves through none.

        Args:
            origin: Where the ray begins.
            direction: Its unit direction.
            length: Where it ends; infinite for the sky.
            before: What the path has crossed nearer to the camera.
        """
        found, farthest = mi.UInt32(before), mi.Float(-1.0)
        for light, rectangle in self._rectangles:
            t, inside = rectangle.meet(origin, direction)
            through = inside & (t < length) & (t > farthest)
            found = dr.select(through, light, found)
            farthest = dr.select(through, t, farthest)
        return found


class Rectangle:
    """A portal as numbers of the active variant, opaque: no kernel is compiled for each room."""

    def __init__(self, portal: Portal, origin: Array) -> None:
        world = portal.world_from_portal
        self._center = mi.Point3f((world[:3, 3] - origin).tolist())
        self._right, self._up, self._outwards = (
            mi.Vector3f(axis) for axis in world[:3, :3].T.tolist()
        )
        self._half = mi.Float(0.5 * portal.width), mi.Float(0.5 * portal.height)
        self._area = mi.Float(portal.width * portal.height)
        dr.make_opaque(self._center, self._right, self._up, self._outwards, self._half, self._area)

    def facing(self, direction: Any) -> Any:
        """Its area as seen from outside along a direction to the sky; 0 from inside."""
        return self._area * dr.maximum(dr.dot(direction, self._outwards), 0.0)

    def point(self, sample: Any) -> Any:
        """A point on it, uniform by area."""
        right, up = self._half
        across, along = (2.0 * sample.x - 1.0) * right, (2.0 * sample.y - 1.0) * up
        return self._center + self._right * across + self._up * along

    def meet(self, origin: Any, direction: Any) -> tuple[Any, Any]:
        """Where a ray meets the plane, and whether it leaves through the rectangle there."""
        cosine = dr.dot(direction, self._outwards)
        outwards = cosine > GRAZING_COS
        t = dr.dot(self._center - origin, self._outwards) / dr.select(outwards, cosine, 1.0)
        at = origin + direction * t - self._center
        right, up = self._half
        within = (dr.abs(dr.dot(at, self._right)) <= right) & (dr.abs(dr.dot(at, self._up)) <= up)
        return t, outwards & within & (t >= 0.0)


def registered(shapes: Any) -> Any:
    """The numbers under which Dr.Jit knows shapes."""
    numbers: Any = dr.reinterpret_array(mi.UInt32, shapes)
    return np.asarray(numbers.numpy())
