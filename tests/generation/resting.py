"""Does everything rest on something that can carry it? By contacts and middles of mass."""

from collections.abc import Iterator, Sequence

import numpy as np
from scipy.spatial import ConvexHull

from tests.generation.scenes import Body, Scene

TOUCH = 0.005  # metres
# How far below an object's lowest points the top that holds it may be, metres.
BELOW = 0.015
# What hangs by its rim in a hole of what carries it.
LET_IN = {("sink", "worktop"), ("hob", "worktop")}
# A rim lies on its worktop along this share of the thing's width and depth at least.
RIM = 0.8
# So little may reach beyond the edge of what carries it, and over pits in it, metres: the brim of
# a hat on a chair, a blanket on a duvet.
EDGE, PIT = 0.01, 0.02
# How far a worktop may reach from one unit to the next, and beyond the last one, metres.
SPAN, OVERHANG = 0.65, 0.3
# The widest half of a gap between slats over which things stand, metres, and how far from it on
# the underside of the thing there is something that a slat holds.
SLATS, HELD_NEAR = 0.015, 0.04
# What carries a thing that hangs is seen above this share of the thing's height.
HUNG_SHARE = 0.6
# What is turned from the upright by angles between these leans on something, degrees, and how
# near that is, metres.
LEANING, NEAR = (1.5, 60.0), 0.012
# What is built in, and whose foot is far heavier than the rest.
HELD = {"stairs", "floor_lamp"}
# In what has sides nothing tips: it leans on these, or on what is there.
VESSELS = {"basket", "bowl", "trash_bin"}
# Half of a contact's width, metres: round things stand on lines and points.
CONTACT = 0.001
# No more places on an underside than this are looked at.
MOST_POINTS = 600
# Points within a triangle, by its corners.
INNER = np.array([[4, 1, 1], [1, 4, 1], [1, 1, 4], [2, 2, 2], [3, 3, 0], [0, 3, 3]]) / 6.0
DOWN, UP = np.array([0.0, 0.0, -1.0]), np.array([0.0, 0.0, 1.0])


def floating(scene: Scene, supports: dict[str, str], hanging: frozenset[str]) -> Iterator[str]:
    """What touches nothing that could carry it, or would fall from what it touches."""
    named = {body.name: body for body in scene.objects}
    for body in scene.objects:
        on = supports[body.name]
        step = TOUCH * {"ceiling": UP, "wall": body.frame[:3, 1]}.get(on, DOWN)
        below = [named[on]] if on in named else scene.room
        held_by = [other for other in below if body.hits(other, step)]
        if not held_by:
            yield f"{body.name} does not touch {on}"
        elif body.name in hanging:
            if on in named and not _hangs(body, named[on]):
                yield f"{body.name} does not hang on {on}"
        elif body.category == "worktop":
            others = [o for o in scene.objects if o is not body and body.hits(o, step)]
            yield from _spans(body, others)
        elif on in named and (body.category, named[on].category) in LET_IN:
            if not _hangs_by_its_rim(body, named[on]):
                yield f"the rim of {body.name} does not lie on {on}"
        elif on not in ("wall", "ceiling"):
            yield from _stands(body, held_by[0] if on in named else None, scene)


def _stands(body: Body, support: Body | None, scene: Scene) -> Iterator[str]:
    """Whether a body stands on an object, or on the floor (None), and does not tip.

    Rugs give way. All that is lowest on a body has its support below it, or, between slats, on
    both sides; in a stack of its own kind it may reach over the one below. Its middle of mass is
    over what it stands on; if it is not, it leans on something.
    """
    on = support.name if support else "floor"
    base = _underside(body)
    held = over(base, support) if support else np.ones(len(base), dtype=bool)
    soft = support is not None and support.category == "rug"
    stack = support is not None and support.category == body.category
    within = support is not None and support.category in VESSELS and not stack
    if support and not (held.all() or soft or stack or _carried(base, held, support)):
        yield f"{body.name} stands over the edge of {on}"
    elif not (
        soft
        or body.category in HELD
        or within
        or within_hull(middle_of_mass(body)[:2], _contacts(base[held], body, support))
        or (_leans(body) and _leant_on(body, scene))
    ):
        yield f"{body.name} would tip over on {on}"


def _underside(body: Body) -> np.ndarray:
    """(N, 3) what is lowest on a body: corners, and points on faces between them."""
    corners = body.points[body.triangles]
    level = body.low[2] + TOUCH
    corners = corners[corners[..., 2].min(axis=1) < level]
    points = np.concatenate([corners.reshape(-1, 3), *(INNER @ corners)])
    points = points[points[:, 2] < level]
    return np.asarray(points[:: 1 + len(points) // MOST_POINTS])


def _contacts(held: np.ndarray, body: Body, support: Body | None) -> np.ndarray:
    """(N, 2) where a body stands: what of it is held, and corners of what holds it below it."""
    if support is None:
        return held[:, :2]
    tops = support.points[np.abs(support.points[:, 2] - body.low[2]) < TOUCH]
    return np.concatenate([held, tops[over(tops, body, TOUCH)]])[:, :2]


def middle_of_mass(body: Body) -> np.ndarray:
    """(3,) of a body of closed parts; of its surface where these hold nothing."""
    a, b, c = np.moveaxis(body.points[body.triangles] - body.points[0], 1, 0)
    volumes = np.einsum("ij,ij->i", a, np.cross(b, c))
    if volumes.sum() < 6e-9:
        volumes = np.linalg.norm(np.cross(b - a, c - a), axis=1)
        return np.asarray(body.points[0] + volumes @ ((a + b + c) / 3.0) / volumes.sum())
    return np.asarray(body.points[0] + volumes @ ((a + b + c) / 4.0) / volumes.sum())


def within_hull(place: np.ndarray, points: np.ndarray) -> bool:
    """Whether (2,) a place is within the convex hull of (N, 2) contacts, each a small square."""
    if not len(points):
        return False
    corners = CONTACT * np.array([(1, 1), (1, -1), (-1, 1), (-1, -1)])
    sides = ConvexHull((points[:, None] + corners).reshape(-1, 2)).equations
    return bool((sides[:, :2] @ place + sides[:, 2] <= 0.0).all())


def _carried(base: np.ndarray, held: np.ndarray, support: Body) -> bool:
    """Whether all places that nothing holds are at an edge, over a pit or between two slats.

    Args:
        base: (N, 3) the lowest places of a body.
        held: (N,) which of them are held.
        support: What carries it.
    """
    gaps, kept = base[~held], base[held]
    if not len(kept):
        return False
    away = np.linalg.norm(gaps[:, None, :2] - kept[None, :, :2], axis=2).min(axis=1)
    least = np.where([within_hull(gap, kept[:, :2]) for gap in gaps[:, :2]], PIT, EDGE)
    gaps, away = gaps[away > least], away[away > least]
    ways = SLATS * support.frame[:3, :2].T
    sides = [[over(gaps + sign * way, support) for sign in (1, -1)] for way in ways]
    between = np.array(sides).all(axis=1).any(axis=0)
    return bool((between & (away < HELD_NEAR)).all())


def _leans(body: Body) -> bool:
    turned = np.degrees(np.arccos(np.clip(body.frame[2, 2], -1.0, 1.0)))
    return bool(LEANING[0] < turned < LEANING[1])


def _leant_on(body: Body, scene: Scene) -> bool:
    """Whether there is something on the side to which a body leans."""
    way = np.array([*body.frame[:2, 2], 0.0])
    step = NEAR * way / np.linalg.norm(way)
    others = [other for other in (*scene.objects, *scene.room) if other is not body]
    return any(body.hits(other, step) for other in others)


def _hangs_by_its_rim(body: Body, slab: Body) -> bool:
    """Whether what looks down in the outline of a let-in thing lies on the slab all around."""
    corners = body.points[body.triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.maximum(np.linalg.norm(normals, axis=1), 1e-30)
    down = corners[(normals[:, 2] / lengths < -0.5)]
    points = np.concatenate([down.reshape(-1, 3), *(INNER @ down)])
    points = points[np.abs(points[:, 2] - slab.high[2]) < TOUCH]
    held = points[over(points, slab, TOUCH)]
    if not len(held) or not within_hull(middle_of_mass(body)[:2], held[:, :2]):
        return False
    own = (held - body.frame[:3, 3]) @ body.frame[:3, :2]
    whole = (body.points - body.frame[:3, 3]) @ body.frame[:3, :2]
    return bool((np.ptp(own, axis=0) >= RIM * np.ptp(whole, axis=0)).all())


def _spans(slab: Body, units: Sequence[Body]) -> Iterator[str]:
    """Where a worktop reaches too far from what holds it."""
    own = (slab.points - slab.frame[:3, 3]) @ slab.frame[:3, 0]
    spans = sorted(
        (float(along.min()), float(along.max()))
        for along in ((unit.points - slab.frame[:3, 3]) @ slab.frame[:3, 0] for unit in units)
    )
    reached = float(own.min())
    for number, (begin, end) in enumerate(spans):
        if begin - reached > (SPAN if number else OVERHANG):
            yield f"{slab.name} is held by nothing along {begin - reached:.2f} m"
        reached = max(reached, end)
    if float(own.max()) - reached > OVERHANG:
        yield f"{slab.name} is held by nothing along {own.max() - reached:.2f} m"


def _hangs(body: Body, support: Body) -> bool:
    """Whether the edge or hook that carries a body is within its bounds, near its top."""
    low, high = body.low + 0.001, body.high - 0.001
    low[2] += HUNG_SHARE * (body.high[2] - body.low[2])
    ends = np.roll(support.triangles, -1, axis=1)
    steps = np.linspace(0.0, 1.0, 9)[:, None, None, None]
    points = support.points[support.triangles] * (1.0 - steps) + support.points[ends] * steps
    return bool(((points > low) & (points < high)).all(axis=-1).any())


def over(base: np.ndarray, support: Body, near: float = BELOW) -> np.ndarray:
    """(N,) which of (N, 3) points have something of a support close above or below them."""
    if not len(base):
        return np.zeros(0, dtype=bool)
    corners = support.points[support.triangles]
    least, most = base.min(axis=0) - near, base.max(axis=0) + near
    there = (corners.min(axis=1) <= most) & (corners.max(axis=1) >= least)
    a, b, c = np.moveaxis(corners[there.all(axis=1)], 1, 0)
    e, f = b - a, c - a
    across = e[:, 0] * f[:, 1] - e[:, 1] * f[:, 0]
    px, py = base[:, None, 0] - a[:, 0], base[:, None, 1] - a[:, 1]
    with np.errstate(divide="ignore", invalid="ignore"):
        v = (px * f[:, 1] - py * f[:, 0]) / across
        w = (e[:, 0] * py - e[:, 1] * px) / across
        hit = (v >= -1e-6) & (w >= -1e-6) & (v + w <= 1.0 + 1e-6) & (across != 0.0)
        height = a[:, 2] + v * e[:, 2] + w * f[:, 2]
        held = hit & (np.abs(height - base[:, 2:3]) < near)
    return np.asarray(held.any(axis=1))
