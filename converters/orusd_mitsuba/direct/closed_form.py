"""Irradiance of triangles that emit evenly, in closed form, for arrays of points at once.

Lambert's contour sum (J. H. Lambert, Photometria, 1760; D. R. Baum et al., SIGGRAPH 1989): a
polygon of radiance L gives E = L/2 sum_k theta_k n . u_k, where theta_k is the angle that edge k is
seen under and u_k the unit normal of the plane through it and the point. Only what lies above the
horizon counts, so the polygon is clipped there first. Where a triangle looks small the terms of the
sum cancel in single precision; the midpoints of its edges then do, to the fourth order of its size.
"""

from typing import Any, Final

import drjit as dr
import mitsuba as mi

# A triangle whose edges are shorter than this, relative to its distance, looks small.
_SMALL_EDGE_PER_DISTANCE: Final = 0.03
_NOT_ZERO: Final = 1e-30
# What is nearer to a triangle's plane, relative to the numbers that say where it is, is in it: they
# are in single precision, and a lamp does not shine on itself.
_IN_PLANE_HEIGHT_PER_SIZE: Final = 2.0**-22


def factor(corners: tuple[Any, Any, Any], at: Any, cosine: Any, horizon: Any) -> Any:
    """Lux for a radiance of 1 nit: pi where the triangle is all that is above the horizon.

    Args:
        corners: Three points, counter-clockwise seen from the side that emits.
        at: Where it is received.
        cosine: Unit vector that the incidence is measured from; zero where nothing is received.
        horizon: A second unit vector: what is behind it does not count either.
    """
    a, b, c = (corner - at for corner in corners)
    normal = dr.cross(b - a, c - a)
    longest = dr.maximum(
        dr.squared_norm(b - a), dr.maximum(dr.squared_norm(c - b), dr.squared_norm(a - c))
    )
    nearest = dr.minimum(dr.squared_norm(a), dr.minimum(dr.squared_norm(b), dr.squared_norm(c)))
    flat = _IN_PLANE_HEIGHT_PER_SIZE * (dr.norm(at) + dr.sqrt(longest))
    facing = dr.dot(normal, a) < -flat * dr.norm(normal)
    small = longest < _SMALL_EDGE_PER_DISTANCE * _SMALL_EDGE_PER_DISTANCE * nearest
    by_contour = _contour(_above(a, b, c, horizon), cosine)
    found = dr.select(small, _quadrature(a, b, c, cosine, horizon), by_contour)
    return dr.select(facing, dr.maximum(found, 0.0), 0.0)


def _above(a: Any, b: Any, c: Any, normal: Any) -> tuple[Any, Any, Any, Any]:
    """What of a triangle is on the front side of a plane through 0: four corners, some alike."""
    ha, hb, hc = (dr.dot(normal, corner) for corner in (a, b, c))
    above = [height > 0.0 for height in (ha, hb, hc)]
    count = sum(dr.select(flag, mi.UInt32(1), mi.UInt32(0)) for flag in above)
    # Turned so that one that is alone on its side comes first.
    alone = count == 1
    by_second = (above[1] == alone) & (above[0] != alone) & (above[2] != alone)
    by_third = (above[2] == alone) & (above[0] != alone) & (above[1] != alone)

    def turned(x: Any, y: Any, z: Any) -> Any:
        return dr.select(by_second, y, dr.select(by_third, z, x))

    p, q, r = turned(a, b, c), turned(b, c, a), turned(c, a, b)
    hp, hq, hr = turned(ha, hb, hc), turned(hb, hc, ha), turned(hc, ha, hb)
    pq = p + (q - p) * _share(hp, hq)
    pr = p + (r - p) * _share(hp, hr)
    whole, none = count == 3, count == 0
    corners = (
        dr.select(whole | alone, p, pq),
        dr.select(alone, pq, q),
        dr.select(alone, pr, r),
        dr.select(whole | alone, dr.select(alone, pr, r), pr),
    )
    first, second, third, fourth = (dr.select(none, p, corner) for corner in corners)
    return first, second, third, fourth


def _contour(corners: tuple[Any, ...], normal: Any) -> Any:
    """The contour sum of a convex polygon, clipped at the horizon of ``normal``.

    Of each edge the part above the horizon counts. The edge that closes the clipped polygon lies in
    the horizon and counts with its whole angle.
    """
    total = mi.Float(0.0)
    leaving, entering, cut = mi.Vector3f(0.0), mi.Vector3f(0.0), mi.Bool(False)
    for first, last in zip(corners, (*corners[1:], corners[0]), strict=True):
        h0, h1 = dr.dot(normal, first), dr.dot(normal, last)
        meeting = first + (last - first) * _share(h0, h1)
        down, up = (h0 > 0.0) & (h1 <= 0.0), (h0 <= 0.0) & (h1 > 0.0)
        leaving, entering = dr.select(down, meeting, leaving), dr.select(up, meeting, entering)
        cut |= down
        begin, end = dr.select(up, meeting, first), dr.select(down, meeting, last)
        part = _angle_normal(begin, end, normal)
        total += dr.select((h0 > 0.0) | (h1 > 0.0), part, 0.0)
    closing = dr.atan2(dr.norm(dr.cross(leaving, entering)), dr.dot(leaving, entering))
    # Seen from the point the corners run counter-clockwise, seen along the normal clockwise.
    return 0.5 * (dr.select(cut, closing, 0.0) - total)


def _angle_normal(first: Any, last: Any, normal: Any) -> Any:
    """The angle between two vectors times the normal's part along their plane's normal."""
    cross = dr.cross(first, last)
    sine = dr.norm(cross)
    angle = dr.atan2(sine, dr.dot(first, last))
    return dr.dot(normal, cross) * angle / dr.maximum(sine, _NOT_ZERO)


def _quadrature(a: Any, b: Any, c: Any, cosine: Any, horizon: Any) -> Any:
    area = 0.5 * dr.cross(b - a, c - a)
    total = mi.Float(0.0)
    for point in (0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)):
        squared = dr.squared_norm(point)
        seen = dr.maximum(dr.dot(cosine, point), 0.0) * dr.maximum(-dr.dot(area, point), 0.0)
        value = seen / dr.maximum(dr.square(squared), _NOT_ZERO)
        total += dr.select(dr.dot(horizon, point) > 0.0, value, 0.0)
    return total / 3.0


def _share(h0: Any, h1: Any) -> Any:
    """Where between two heights is 0, from 0 to 1."""
    change = h0 - h1
    share = h0 / dr.select(change == 0.0, 1.0, change)
    return dr.clip(share, 0.0, 1.0)
