"""What is wrong with placed objects as bodies: penetration, walls, floating; from their meshes.

Independent of how the package places: surfaces are tested against each other by FCL. The depth of
a penetration is the shortest of a ladder of motions, along any of many directions, after which the
surfaces are free of each other. So what touches has no depth, and a chair between the legs of a
table none either.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from benchmarks.scan.scores import to_plan
from benchmarks.scan.truth import Cad, moved, pose_matrix
from openrooms_usd.arrays import Array
from openrooms_usd.geometry.raycast import RayCaster
from openrooms_usd.scan.results import FoundObject, FoundRoom

# Motions that are tried, metres; what none of them frees counts as twice the last.
LADDER: Final = (0.0005, 0.001, 0.002, 0.003, 0.005, 0.0075, 0.01, 0.02, 0.03, 0.05, 0.1)
# What counts as wrong, metres.
DEEP, INSIDE_WALL, ABOVE = 0.005, 0.01, 0.01
# A ray down to what an object stands on starts this much above its lowest points, metres.
START: Final = 0.03
# Lowest points are those within this height, metres; at most so many are looked at.
LOWEST, LOOKS = 0.02, 2000


@dataclass(frozen=True)
class Contacts:
    """What is wrong, after all objects of a room are where they were placed.

    Attributes:
        penetrations: (instance, other, metres) of all pairs deeper than nothing.
        in_walls: Metres that each instance reaches out of the room's outline.
        floating: Metres that each instance is above what carries it.
    """

    penetrations: tuple[tuple[int, int, float], ...]
    in_walls: Mapping[int, float]
    floating: Mapping[int, float]

    def summary(self) -> dict[str, Any]:
        """How many are wrong, and the worst."""
        depths = [depth for _, _, depth in self.penetrations]
        return {
            "pairs_deep": sum(depth > DEEP for depth in depths),
            "deepest": max(depths, default=0.0),
            "in_walls": sum(depth > INSIDE_WALL for depth in self.in_walls.values()),
            "deepest_in_wall": max(self.in_walls.values(), default=0.0),
            "floating": sum(gap > ABOVE for gap in self.floating.values()),
            "highest": max(self.floating.values(), default=0.0),
        }


def contacts(
    objects: Sequence[FoundObject],
    cads: Mapping[str, Cad],
    rooms: Sequence[FoundRoom],
    true: Sequence[FoundObject] = (),
) -> Contacts:
    """Measure the placed objects of a room.

    Args:
        objects: Their ``placed`` poses count, or else ``pose``.
        cads: Their meshes.
        rooms: The true rooms, their floors level.
        true: Where they stand in truth: what hangs there may hang, and what reaches into a
            window's recess there may reach as far.
    """
    bodies = [_Body(item, cads[item.cad]) for item in objects]
    models = {item.instance: _Body(item, cads[item.cad]) for item in true}
    pairs = [
        (a.instance, b.instance, depth)
        for i, a in enumerate(bodies)
        for b in bodies[i + 1 :]
        if (depth := penetration(a.points, a.faces, b.points, b.faces)) > 0.0
    ]
    in_walls, floating = {}, {}
    for body in bodies:
        model = models.get(body.instance, body)
        allowed = _out_of(model.points, rooms) if model is not body else 0.0
        in_walls[body.instance] = max(_out_of(body.points, rooms) - allowed, 0.0)
        beside = [other for number, other in models.items() if number != body.instance]
        hangs = bool(models) and _gap_below(model, beside, rooms) > ABOVE
        others = [other for other in bodies if other is not body]
        # A lamp on a cord hangs below its ceiling in truth, too.
        hung = max(_gap_beside(body, rooms) - _gap_beside(model, rooms), 0.0) if hangs else 0.0
        floating[body.instance] = hung if hangs else _gap_below(body, others, rooms)
    return Contacts(tuple(pairs), in_walls, floating)


class _Body:
    """An object's mesh where it is placed."""

    def __init__(self, item: FoundObject, cad: Cad) -> None:
        self.instance = item.instance
        used, faces = np.unique(cad.faces, return_inverse=True)
        self.points = moved(pose_matrix(item.placed or item.pose), cad.vertices[used])
        self.faces = faces.reshape(-1, 3)


def penetration(a: Array, a_faces: Any, b: Array, b_faces: Any) -> float:
    """The shortest motion of one surface that frees it of the other, metres.

    Args:
        a: (N, 3) points of one.
        a_faces: (F, 3) rows of them.
        b: (M, 3) points of the other.
        b_faces: (G, 3) rows of them.
    """
    low, high = np.maximum(a.min(0), b.min(0)), np.minimum(a.max(0), b.max(0))
    if (high < low).any():
        return 0.0
    import fcl  # type: ignore[import-untyped, unused-ignore]

    # Only what is near the common box can meet, however far it moves.
    reach = LADDER[-1]
    models = []
    for points, faces in ((a, a_faces), (b, b_faces)):
        corners = points[faces]
        near = (corners.max(1) > low - reach).all(1) & (corners.min(1) < high + reach).all(1)
        kept = corners[near]
        if not len(kept):
            return 0.0
        model = fcl.BVHModel()
        model.beginModel(3 * len(kept), len(kept))
        model.addSubModel(kept.reshape(-1, 3), np.arange(3 * len(kept)).reshape(-1, 3))
        model.endModel()
        models.append(fcl.CollisionObject(model))
    request = fcl.CollisionRequest()

    def meets(motion: Array) -> bool:
        models[0].setTranslation(motion)
        return bool(fcl.collide(models[0], models[1], request, fcl.CollisionResult()))

    if not meets(np.zeros(3)):
        return 0.0
    for step in LADDER:
        if any(not meets(step * way) for way in _WAYS):
            return step
    return 2 * LADDER[-1]


def _ways() -> Array:
    """(26, 3) unit vectors to the faces, edges and corners of a cube: axes first."""
    grid = np.stack(np.meshgrid(*[(-1.0, 0.0, 1.0)] * 3, indexing="ij"), -1).reshape(-1, 3)
    grid = grid[np.abs(grid).sum(1) > 0]
    grid = grid[np.argsort(np.abs(grid).sum(1), kind="stable")]
    return np.asarray(grid / np.linalg.norm(grid, axis=1, keepdims=True))


_WAYS: Final = _ways()


def _out_of(points: Array, rooms: Sequence[FoundRoom]) -> float:
    """How far the farthest point is outside of the outline of the room that it is most in."""
    import shapely

    return min(
        float(
            shapely.distance(
                shapely.Polygon(to_plan(room.corners, room)), shapely.points(to_plan(points, room))
            ).max()
        )
        for room in rooms
    )


def _home(body: _Body, rooms: Sequence[FoundRoom]) -> tuple[FoundRoom, Array]:
    """The room that an object is in, and the heights of its points above the floor."""
    room = min(rooms, key=lambda r: _out_of(body.points, [r]))
    return room, (body.points - room.point) @ _up(room)


def _up(room: FoundRoom) -> Array:
    return np.asarray(room.normal / np.linalg.norm(room.normal))


def _gap_beside(body: _Body, rooms: Sequence[FoundRoom]) -> float:
    """How far the nearest wall is away, or the ceiling; 0 where the object reaches into it."""
    import shapely

    room, heights = _home(body, rooms)
    ring = shapely.LinearRing(to_plan(room.corners, room))
    outline = shapely.MultiPoint(to_plan(body.points, room)).convex_hull
    above = np.inf if room.ceiling is None else max(room.ceiling - float(heights.max()), 0.0)
    return min(float(ring.distance(outline)), above)


def _gap_below(body: _Body, others: Sequence[_Body], rooms: Sequence[FoundRoom]) -> float:
    """How far down the first thing below an object is; 0 where the object is sunk into it."""
    room, heights = _home(body, rooms)
    low = body.points[heights < heights.min() + LOWEST]
    low = low[np.linspace(0, len(low) - 1, min(len(low), LOOKS)).astype(int)]
    ground = max(float(heights.min()), 0.0)
    near = [other for other in others if _near(body.points, other.points)]
    if not near:
        return ground
    sizes = np.cumsum([0, *[len(other.points) for other in near]])
    faces = [other.faces + start for other, start in zip(near, sizes[:-1], strict=True)]
    caster = RayCaster(np.concatenate([o.points for o in near]), np.concatenate(faces))
    down = np.broadcast_to(-_up(room), low.shape)
    hits = caster.first_hit(low + START * _up(room), down)
    return min(ground, max(float(hits.distance.min()) - START, 0.0))


def _near(a: Array, b: Array) -> bool:
    """Whether the boxes of two sets of points meet, give or take what is looked at."""
    reach = 0.3
    return bool((a.min(0) < b.max(0) + reach).all() and (b.min(0) < a.max(0) + reach).all())
