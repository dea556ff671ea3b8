"""Curved walls of RoomPlan: arcs in the wall's own frame, built by straight facets.

Apple documents the radius, two angles and, since iOS 17, the centre in the wall's x and z, but not
from which axis the angles are counted. So all are tried, and the one whose arc ends where the wall
ends is taken; which way they are counted makes no difference to an arc that is symmetric over its
wall.
"""

from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array
from orusd_scans.records import Node

SAGITTA_M: Final = 0.004
"""How far facets may stay behind the arc, metres."""

_MAX_RADIUS_M: Final = 1e4  # radii, metres; what is flatter is straight
_MAX_ARC_END_GAP_M: Final = 0.25  # how far an arc's ends may be from the wall's, metres
# What is left of a facet beside an opening in it, metres.
_BESIDE_OPENING_M: Final = 0.1


@dataclass(frozen=True, eq=False)
class Arc:
    """An arc in a wall's local x and z: ``center + radius (cos a, sin a)``.

    Attributes:
        center: (2,) metres.
        radius: Metres.
        start: Where it begins, radians.
        sweep: Its angle from there, radians; at most half a turn either way.
    """

    center: Array
    radius: float
    start: float
    sweep: float

    def points(self, angles: Array) -> Array:
        """(N, 2) the points at some angles."""
        return self.center + self.radius * np.column_stack([np.cos(angles), np.sin(angles)])

    def ends(self) -> Array:
        """(2, 2) where it begins and where it ends."""
        return self.points(np.array([self.start, self.start + self.sweep]))

    def turn(self, points: Array) -> Array:
        """(N,) parameters of points (N, 2) on the sweep: 0 at the start, 1 at the end."""
        x, z = (points - self.center).T
        middle = self.start + 0.5 * self.sweep
        off = np.angle(np.exp(1j * (np.arctan2(z, x) - middle)))
        return np.asarray(0.5 + off / self.sweep)

    def facets(self, openings: Array) -> Array:
        """The corners of the facets.

        Args:
            openings: (K, 3) middles in the wall's x and z, and widths, metres. Each gets one
                facet that is as wide as it needs, and that lies deeper than the others.

        Returns:
            (N, 2) from the start to the end.
        """
        spans = _joined([self._span(opening) for opening in openings])
        stops = np.clip(np.array([0.0, *np.ravel(spans), 1.0]), 0.0, 1.0)
        fine = 2.0 * np.arccos(1.0 - min(SAGITTA_M / self.radius, 1.0))
        parts = [stops[:1]]
        for i, (a, b) in enumerate(pairwise(stops)):
            count = 1 if i % 2 else int(np.ceil((b - a) * abs(self.sweep) / fine - 1e-9))
            parts.append(np.linspace(a, b, count + 1)[1:])
        turns = np.concatenate(parts)
        turns = turns[np.concatenate([[True], np.diff(turns) > 1e-6])]
        return self.points(self.start + turns * self.sweep)

    def _span(self, opening: Array) -> tuple[float, float]:
        """The interval of the sweep that the facet of an opening covers."""
        middle = float(self.turn(opening[None, :2])[0])
        half = np.arcsin(min((0.5 * opening[2] + _BESIDE_OPENING_M) / self.radius, 1.0)) / abs(
            self.sweep
        )
        return middle - half, middle + half


def _joined(spans: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """Sorted spans; overlapping ones are merged, those beside the arc left out."""
    joined: list[tuple[float, float]] = []
    for low, high in sorted(span for span in spans if span[0] < 1.0 and span[1] > 0.0):
        if joined and low < joined[-1][1]:
            joined[-1] = (joined[-1][0], max(high, joined[-1][1]))
        else:
            joined.append((low, high))
    return joined


def read_curve(node: Node, notes: list[str]) -> Arc | None:
    """The arc of a wall's ``curve``.

    Args:
        node: Its value: ``radius``, ``startAngle`` and ``endAngle``, perhaps ``center``.
        notes: Receives a sentence when something was guessed, or nothing fits.

    Returns:
        The arc, or None when the wall is as good as straight, or nothing is known of the arc.

    Raises:
        InputError: A number is not valid, or absurd.
    """
    radius, start, end = (node.get(key) for key in ("radius", "startAngle", "endAngle"))
    if radius is None or start is None or end is None:
        notes.append(f"{node.path} lacks its radius or an angle: the wall is built straight")
        return None
    length = float(radius.numbers(1, 1e9)[0])
    if length <= 0.0:
        raise radius.error("the radius of a curved wall is not positive")
    sweep = float(np.angle(np.exp(1j * (_angle(end) - _angle(start)))))
    if length > _MAX_RADIUS_M or abs(sweep) < 1e-3:
        return None
    center = node.get("center")
    where = None if center is None else center.numbers(2, _MAX_RADIUS_M)
    arc = _placed(where, length, _angle(start), sweep)
    if arc is None:
        notes.append(f"{node.path} does not end where its wall ends: the wall is built straight")
    elif where is None:
        notes.append(f"{node.path} has no centre: the middle between its ends is the wall's")
    return arc


def _angle(node: Node) -> float:
    """An angle in radians: a ``Measurement<UnitAngle>``, or a bare number of radians.

    A measurement is written with its value and its unit, whose converter leads to degrees.
    """
    if not isinstance(node.value, dict):
        return float(node.numbers(1, 1e4)[0])
    value = float(node.need("value").numbers(1, 1e6)[0])
    unit = node.get("unit")
    converter = unit.get("converter") if unit else None
    factor = converter.get("coefficient") if converter else None
    if factor is not None:
        return float(np.radians(value * factor.numbers(1, 1e6)[0]))
    symbol = unit.get("symbol") if unit else None
    return value if symbol is not None and symbol.value == "rad" else float(np.radians(value))


def _placed(center: Array | None, radius: float, start: float, sweep: float) -> Arc | None:
    """The arc whose chord lies along the wall's x, whatever the angles are counted from."""
    arcs = []
    for quarter in range(4):
        begin = start + 0.5 * np.pi * quarter
        middle = begin + 0.5 * sweep
        inward = -np.cos(0.5 * sweep) * radius * np.array([np.cos(middle), np.sin(middle)])
        arcs.append(Arc(inward if center is None else center, radius, begin, sweep))
    # To the millimetre: among equals the first, which is the plainest reading, is taken.
    best = min(arcs, key=lambda arc: round(_misfit(arc), 3))
    return best if _misfit(best) < _MAX_ARC_END_GAP_M else None


def _misfit(arc: Arc) -> float:
    """The distance of an arc's ends from the wall's ends, metres.

    The origin of the wall's frame is in the middle of the chord or of the arc.
    """
    half = arc.radius * abs(np.sin(0.5 * arc.sweep))
    ends = arc.ends()
    ends = ends[np.argsort(ends[:, 0])]
    middle = arc.points(np.array([arc.start + 0.5 * arc.sweep]))[0]
    off = float(np.abs(ends[:, 0] - [-half, half]).max())
    level = abs(float(ends[1, 1] - ends[0, 1]))
    return off + level + min(float(np.abs(ends[:, 1]).max()), float(np.linalg.norm(middle)))


def fitted_arc(points: Array) -> Arc | None:
    """The arc nearest to points (N, 2) in a wall's x and z; None where they lie on a line.

    Least squares: ``x^2 + z^2 = 2 a x + 2 b z + c`` is linear in its unknowns.
    """
    A = np.column_stack([2.0 * points, np.ones(len(points))])
    (a, b, c), _, rank, _ = np.linalg.lstsq(A, (points**2).sum(axis=1), rcond=None)
    radius = float(np.sqrt(max(c + a * a + b * b, 0.0)))
    if rank < 3 or not 0.0 < radius < _MAX_RADIUS_M:
        return None
    center = np.array([a, b])
    x, z = (points - center).T
    middle = float(np.angle(np.exp(1j * np.arctan2(z, x)).mean()))
    off = np.angle(np.exp(1j * (np.arctan2(z, x) - middle)))
    return Arc(center, radius, middle + float(off.min()), float(np.ptp(off)))
