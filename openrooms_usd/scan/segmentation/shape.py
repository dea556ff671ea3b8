"""The shape of a piece of furniture: its box, its tops, its seat and back, its closed sides."""

from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array, Mask
from openrooms_usd.geometry.rotations import in_plan
from openrooms_usd.scan.points.surfels import VOXEL_M
from openrooms_usd.scan.registration.surroundings import Walls

_LEVEL_COS: Final = 0.85
# Quantiles that bound a piece, without outliers.
_INSIDE_QUANTILES: Final = (0.01, 0.99)
# A box along the walls may be this much larger than the smallest one.
_ALONG_WALLS_FACTOR: Final = 1.15
_TURN_STEP_DEG: Final = 3.0
# Pieces that begin lower stand on the floor: feet are hidden, or were taken for the floor. Metres.
_STANDS_M: Final = 0.3
# So do plates at the height of seats and tables, whose thin legs were not scanned: where they
# begin and end, metres.
_PLATE_M: Final = (0.66, 0.9)
# Level surfels within this height are one layer, metres.
_LAYER_M: Final = 0.05
# Width of the strip along a side that is its face, or in which a back stands: metres, and as part
# of the box.
_FACE_M: Final = 0.1
_BACK_SHARE: Final = 0.4
_SEAT_M: Final = (0.28, 0.6)
_ABOVE_SEAT_M: Final = 0.15


@dataclass(frozen=True, eq=False)
class SegmentShape:
    """A piece in the frame of its box.

    Attributes:
        points: (N, 3) in that frame: the middle of the base at the origin, z up, metres.
        level: (N,) which of them lie on horizontal surfaces.
        size: (3,) along the box's own axes: the long side, the short side, the height.
        base: (3,) the middle of the base in the room, metres.
        lowest: Where its points begin above the floor, metres: the base may be lower.
        yaw: Of the long side, radians.
        to_wall: Metres from the nearest wall to the side that faces it; infinite far from walls.
        brightness: Of its colours: median, from 0 to 1; NaN without colours.
    """

    points: Array
    level: Mask
    size: Array
    base: Array
    lowest: float
    yaw: float
    to_wall: float
    brightness: float

    @property
    def long(self) -> float:
        """The longer level side, metres."""
        return float(self.size[0])

    @property
    def short(self) -> float:
        """The shorter level side, metres."""
        return float(self.size[1])

    @property
    def bottom(self) -> float:
        """Metres above the floor."""
        return float(self.base[2])

    @property
    def height(self) -> float:
        """From its bottom to its highest point, metres."""
        return float(self.size[2])

    @cached_property
    def layers(self) -> tuple[tuple[float, float], ...]:
        """Heights of horizontal layers, and the part of the footprint that each spans."""
        found = []
        for low in np.arange(-_LAYER_M, self.height + _LAYER_M, _LAYER_M):
            z = self.points[:, 2]
            some = self.points[self.level & (z >= low) & (z < low + 2.0 * _LAYER_M)]
            share = _hull_area(some[:, :2]) / max(self.long * self.short, 1e-6)
            found.append((float(np.median(some[:, 2])) if len(some) else low, min(share, 1.0)))
        shares = np.array([0.0, *(share for _, share in found), 0.0])
        peak = (shares[1:-1] >= shares[:-2]) & (shares[1:-1] > shares[2:])
        return tuple(layer for layer, high in zip(found, peak, strict=True) if high)

    @property
    def top(self) -> tuple[float, float]:
        """Height of the layer that covers most of the footprint, and its part."""
        return max(self.layers, key=lambda layer: layer[1], default=(0.0, 0.0))

    @property
    def seat(self) -> tuple[float, float]:
        """The same of those at the height of seats."""
        seats = [s for s in self.layers if _SEAT_M[0] < s[0] + self.bottom < _SEAT_M[1]]
        return max(seats, key=lambda layer: layer[1], default=(0.0, 0.0))

    @cached_property
    def backed(self) -> tuple[float, float, float]:
        """How what rises above the seat stands along one side.

        Returns:
            The part of it that stands there, the part of that side's length that it covers, and
            1.0 where the side is a long one, else 0.0.
        """
        seat, _ = self.seat
        above = self.points[self.points[:, 2] > seat + _ABOVE_SEAT_M]
        if seat == 0.0 or len(above) < 4:
            return 0.0, 0.0, 0.0
        best = (0.0, 0.0, 0.0)
        for axis, sign in ((1, 1.0), (1, -1.0), (0, 1.0), (0, -1.0)):
            depth = 0.5 - sign * above[:, axis] / self.size[axis]
            behind = above[depth < _BACK_SHARE]
            if not len(behind):
                continue
            across = behind[:, 1 - axis]
            cells = len(np.unique(np.floor(across / VOXEL_M)))
            wide = min(cells * VOXEL_M / float(self.size[1 - axis]), 1.0)
            part = len(behind) / len(above)
            if part * wide > best[0] * best[1]:
                best = (part, wide, float(axis == 1))
        return best

    def closed(self, low: float, high: float) -> float:
        """The part of its most closed side that is a surface, between two heights."""
        return max(self._faces(low, high))

    def _faces(self, low: float, high: float) -> list[float]:
        z = self.points[:, 2]
        band = self.points[(z > low) & (z < high)]
        shares = []
        for axis, sign in ((1, 1.0), (1, -1.0), (0, 1.0), (0, -1.0)):
            length = float(self.size[1 - axis])
            strip = min(_FACE_M, 0.3 * float(self.size[axis]))
            near = band[0.5 * self.size[axis] - sign * band[:, axis] < strip]
            cells = np.unique(np.floor(near[:, [1 - axis, 2]] / VOXEL_M).astype(np.int64), axis=0)
            shares.append(len(cells) * VOXEL_M**2 / max(length * (high - low), 1e-6))
        return shares


def shape_of(points: Array, normals: Array, walls: Walls, brightness: float) -> SegmentShape:
    """The shape of a piece.

    Args:
        points: (N, 3) its surfels, floor at z = 0.
        normals: (N, 3) of these.
        walls: Of the room.
        brightness: See `SegmentShape`.
    """
    base, size, yaw, lowest = upright_box(points, walls)
    local = (points - base) @ _about_z(yaw)
    return SegmentShape(
        local,
        np.abs(normals[:, 2]) > _LEVEL_COS,
        size,
        base,
        lowest,
        yaw,
        _to_wall(base, size, yaw, walls),
        brightness,
    )


def upright_box(points: Array, walls: Walls) -> tuple[Array, Array, float, float]:
    """The upright box around points, along the walls where these allow it, and down to the floor.

    Args:
        points: (N, 3) floor at z = 0, metres.
        walls: Of the room.

    Returns:
        The middle of its base (3,), its long side, its short side and its height (3,), the yaw of
        the long side, and where the points begin above the floor, metres.
    """
    yaw, low, high = _rectangle(points, walls)
    lowest, top = np.quantile(points[:, 2], _INSIDE_QUANTILES)
    plate = lowest < _PLATE_M[0] and top < _PLATE_M[1]
    bottom = 0.0 if lowest < _STANDS_M or plate else lowest
    base = np.array([*(in_plan(yaw) @ (0.5 * (low + high))), bottom])
    return base, np.maximum([*(high - low), top - bottom], 0.02), yaw, float(lowest)


def _hull_area(points: Array) -> float:
    """Area of the convex hull of points (N, 2): what stands on a top hides parts of it."""
    import shapely

    return float(shapely.MultiPoint(points).convex_hull.area) if len(points) > 2 else 0.0


def _about_z(yaw: float) -> Array:
    turn = np.eye(3)
    turn[:2, :2] = in_plan(yaw)
    return turn


def _rectangle(points: Array, walls: Walls) -> tuple[float, Array, Array]:
    """Yaw of the long side and bounds of the smallest rectangle, along the walls if they allow."""

    def bounds(yaw: float) -> tuple[float, float, Array, Array]:
        low, high = np.quantile(points[:, :2] @ in_plan(yaw), _INSIDE_QUANTILES, axis=0)
        return float(np.prod(np.maximum(high - low, 0.02))), yaw, low, high

    along = walls.ends - walls.starts
    straight = np.unique(np.round(np.mod(np.arctan2(along[:, 1], along[:, 0]), 0.5 * np.pi), 3))
    free = min(map(bounds, np.deg2rad(np.arange(0.0, 90.0, _TURN_STEP_DEG))), key=lambda b: b[0])
    walled = min(map(bounds, straight), key=lambda b: b[0], default=free)
    _, yaw, low, high = walled if walled[0] < _ALONG_WALLS_FACTOR * free[0] else free
    if high[0] - low[0] < high[1] - low[1]:
        _, yaw, low, high = bounds(yaw + 0.5 * np.pi)
    return float(yaw), low, high


def _to_wall(base: Array, size: Array, yaw: float, walls: Walls) -> float:
    """Metres from the side of a box that is nearest to a wall before it."""
    turn, nearest = in_plan(yaw), np.inf
    for start, end, inward in zip(walls.starts, walls.ends, walls.normals, strict=True):
        along = (end - start) / max(float(np.linalg.norm(end - start)), 1e-9)
        station = float((base[:2] - start) @ along)
        if not 0.0 < station < float(np.linalg.norm(end - start)):
            continue
        reach = 0.5 * float(np.abs(turn.T @ inward) @ size[:2])
        depth = float((base[:2] - start) @ inward)
        if depth > 0.0:
            nearest = min(nearest, abs(depth - reach))
    return nearest
