"""Is a composed room sound? An independent check on the meshes of its USD stage.

Nothing here knows how rooms are generated. Triangle meshes are read back from the composed stage
and compared by the collision library FCL (python-fcl): two objects penetrate each other by no more
than a depth if moving one of them by that much, in one of some directions, sets it free. That is
the definition of penetration depth, and exact for triangle soups; boxes are only used to leave out
pairs that are far apart.
"""

from collections.abc import Callable, Iterator, Sequence
from typing import Any

import fcl
import numpy as np
from scipy import ndimage

from tests.generate.scenes import Body, Leaf, Scene

DEEPEST = 0.005  # metres
CELL = 0.025
PATH = 0.6  # width of the narrowest path, metres
APPROACH = 0.6  # how deep the floor before a door must be free, metres
HEADROOM = (0.06, 1.9)
# What people must be able to come near to, and how near, metres.
USED = {
    "bed", "sofa", "desk", "wardrobe", "dresser", "refrigerator", "stove", "oven", "toilet",
    "bathtub", "kitchen_unit", "dishwasher",
    "sink", "washing_machine", "bookshelf", "cabinet", "file_cabinet", "stairs", "fireplace",
}  # fmt: skip
NEAR = 0.9
# A sofa may have its table before it: then that is what people come near to.
NEAR_SOFA = 1.5
# How far below an object's lowest points the top that holds it may be, metres.
BELOW = 0.015
# What hangs in a hole of what carries it.
LET_IN = {("sink", "worktop"), ("hob", "worktop")}
# How deep things may stand in the hole of a window, metres.
REVEAL = 0.1
# How much of what lies on several others must have something below it.
LAID = 0.8
# The widest half of a gap between slats over which things stand, metres.
SLATS = 0.015
# How things lie that hang, by the records.
HUNG = {"draped", "hung"}
# What carries a thing that hangs is seen above this share of the thing's height.
HUNG_SHARE = 0.6
# In a stack the middle of each is at least so far within what holds it, metres.
MIDDLE = 0.01
# Points within a triangle, by its corners.
INNER = np.array([[4, 1, 1], [1, 4, 1], [1, 1, 4], [2, 2, 2], [3, 3, 0], [0, 3, 3]]) / 6.0
DIRECTIONS = np.concatenate([np.eye(3), -np.eye(3)])


def violations(
    scene: Scene, supports: dict[str, str], hanging: frozenset[str] = frozenset()
) -> list[str]:
    """Everything that is wrong with a room, one sentence each.

    Args:
        scene: The room.
        supports: What carries each object: ``floor``, ``ceiling``, ``wall`` or another's name.
        hanging: The objects that hang over an edge or from a hook, by their description.
    """
    return [
        *_penetrations(scene), *_outside(scene), *_floating(scene, supports, hanging),
        *_swings(scene),
        *_blocked(scene),
    ]  # fmt: skip


def _pairs(scene: Scene) -> Iterator[tuple[Body, Body]]:
    bodies = [*scene.objects, *scene.room]
    low, high = np.array([b.low for b in bodies]), np.array([b.high for b in bodies])
    for i, body in enumerate(scene.objects):
        near = (low[i + 1 :] < high[i]).all(axis=1) & (high[i + 1 :] > low[i]).all(axis=1)
        for j in np.flatnonzero(near).tolist():
            yield body, bodies[i + 1 + j]


def _penetrations(scene: Scene) -> Iterator[str]:
    for a, b in _pairs(scene):
        if a.hits(b) and not _freed(a, b):
            yield f"{a.name} penetrates {b.name} by more than {1000 * DEEPEST:g} mm"


def _freed(a: Body, b: Body) -> bool:
    own = [a.frame[:3, i] * s for i in (0, 1) for s in (1, -1)]
    other = [b.frame[:3, i] * s for i in (0, 1) for s in (1, -1)]
    return any(not a.hits(b, DEEPEST * d) for d in (*DIRECTIONS[[2, 5]], *own, *other))


def _outside(scene: Scene) -> Iterator[str]:
    """Corners beyond a wall's inner face, below the floor or above the ceiling."""
    corners = scene.polygon
    ahead = np.roll(corners, -1, axis=0) - corners
    for body in scene.objects:
        points = body.points
        for window, width in scene.windows:  # on its sill, in the wall
            x, y, _ = (points @ window[:3, :3].T + window[:3, 3]).T
            points = points[(np.abs(x) > 0.5 * width) | (y < 0.0) | (y > REVEAL)]
        plan = points[:, :2]
        inside = _inside(corners, plan)
        if not inside.all():
            out = plan[~inside]
            away = out[:, None] - corners
            t = np.clip((away * ahead).sum(2) / (ahead**2).sum(1), 0.0, 1.0)
            far = np.linalg.norm(away - t[..., None] * ahead, axis=2).min(axis=1).max()
            if far > DEEPEST:
                yield f"{body.name} is {1000 * far:.0f} mm outside of the room"
        if body.low[2] < -DEEPEST or body.high[2] > scene.height + DEEPEST:
            yield f"{body.name} is below the floor or above the ceiling"


def _inside(corners: np.ndarray, points: np.ndarray) -> np.ndarray:
    x, y = points.T
    (x0, y0), (x1, y1) = corners.T, np.roll(corners, -1, axis=0).T
    with np.errstate(divide="ignore", invalid="ignore"):
        meets = x0 + (y[:, None] - y0) * (x1 - x0) / (y1 - y0)
    crossed = ((y0 > y[:, None]) != (y1 > y[:, None])) & (x[:, None] < meets)
    return crossed.sum(axis=1) % 2 == 1


def _floating(
    scene: Scene, supports: dict[str, str], hanging: frozenset[str]
) -> Iterator[str]:  # fmt: skip
    """What touches nothing that could carry it when it is moved towards that by the tolerance."""
    named = {body.name: body for body in scene.objects}
    for body in scene.objects:
        on = supports[body.name]
        step = {"ceiling": DIRECTIONS[2], "wall": body.frame[:3, 1]}.get(on, DIRECTIONS[5])
        below = [named[on]] if on in named else scene.room
        if not any(body.hits(other, DEEPEST * step) for other in below):
            yield f"{body.name} does not touch {on}"
        elif body.category == "worktop":
            # It lies on all units of a row.
            units = [other for other in scene.objects if other != body]
            if _length_held(body, [u for u in units if body.hits(u, DEEPEST * step)]) < LAID:
                yield f"{body.name} lies on too little"
        elif (body.category, named[on].category if on in named else "") in LET_IN:
            continue  # by its rim, which is what touches
        elif body.name in hanging:
            if on in named and not _hangs(body, named[on]):
                yield f"{body.name} does not hang on {on}"
        elif on in named and not _stands(body, named[on]):
            yield f"{body.name} stands over the edge of {on}"


def _stands(body: Body, support: Body) -> bool:
    """Whether a body stands on its support with all of its lowest points.

    Rugs give way, and over a gap between slats there is something on both sides. In a stack of its
    own kind it may reach over the one below, if its middle and most of its lower side do not.
    """
    if support.category == "rug":
        return True
    base, held = _held(body, support)
    if held.all() or _between_slats(base[~held], support).all():
        return True
    if body.category != support.category:
        return False
    corners = body.points[body.triangles]
    shares = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]),
                            axis=1)  # fmt: skip
    points, shares = np.concatenate(INNER @ corners), np.repeat(shares, len(INNER))
    low = points[:, 2] < body.low[2] + DEEPEST
    base, held = _held(body, support, points[low], len(points))
    if not held.any():
        return False
    (x0, y0), (x1, y1) = base[held, :2].min(axis=0), base[held, :2].max(axis=0)
    x, y = 0.5 * (body.low + body.high)[:2]
    within = x0 + MIDDLE < x < x1 - MIDDLE and y0 + MIDDLE < y < y1 - MIDDLE
    return bool(within and shares[low] @ held > 0.5 * shares[low].sum())


def _between_slats(base: np.ndarray, support: Body) -> np.ndarray:
    """Which places have something of a support just beside them, on opposite sides."""
    ways = SLATS * support.frame[:3, :2].T
    sides = [[_over(base + sign * way, support) for sign in (1, -1)] for way in ways]
    return np.asarray(np.array(sides).all(axis=1).any(axis=0))


def _hangs(body: Body, support: Body) -> bool:
    """Whether the edge or hook that carries a body is within its bounds, near its top."""
    low, high = body.low + 0.001, body.high - 0.001
    low[2] += HUNG_SHARE * (body.high[2] - body.low[2])
    ends = np.roll(support.triangles, -1, axis=1)
    steps = np.linspace(0.0, 1.0, 9)[:, None, None, None]
    points = support.points[support.triangles] * (1.0 - steps) + support.points[ends] * steps
    return bool(((points > low) & (points < high)).all(axis=-1).any())


def _length_held(body: Body, units: Sequence[Body]) -> float:
    """The share of a body's length along its own X that has one of some others below it."""
    own = (body.points - body.frame[:3, 3]) @ body.frame[:3, 0]
    at = np.linspace(own.min(), own.max(), 200)
    spans = [(unit.points - body.frame[:3, 3]) @ body.frame[:3, 0] for unit in units]
    held = [(at >= span.min()) & (at <= span.max()) for span in spans]
    return float(np.any(held, axis=0).mean()) if held else 0.0


def _held(
    body: Body, support: Body, points: np.ndarray | None = None, most: int = 64
) -> tuple[np.ndarray, np.ndarray]:
    """A body's lowest points, and which of them have something of a support close below them."""
    points = body.points if points is None else points
    base = points[points[:, 2] < body.low[2] + DEEPEST]
    base = base[:: 1 + len(base) // most]
    return base, _over(base, support)


def _over(base: np.ndarray, support: Body) -> np.ndarray:
    """Which points have something of a support close below them."""
    a, b, c = np.moveaxis(support.points[support.triangles], 1, 0)
    e, f = b - a, c - a
    across = e[:, 0] * f[:, 1] - e[:, 1] * f[:, 0]
    px, py = base[:, None, 0] - a[:, 0], base[:, None, 1] - a[:, 1]
    with np.errstate(divide="ignore", invalid="ignore"):
        v = (px * f[:, 1] - py * f[:, 0]) / across
        w = (e[:, 0] * py - e[:, 1] * px) / across
        over = (v >= -1e-6) & (w >= -1e-6) & (v + w <= 1.0 + 1e-6) & (across != 0.0)
        height = a[:, 2] + v * e[:, 2] + w * f[:, 2]
        held = over & (np.abs(height - base[:, 2:3]) < BELOW)
    return np.asarray(held.any(axis=1))


def _swings(scene: Scene) -> Iterator[str]:
    """Doors that cannot be opened to a right angle from closed."""
    for leaf in scene.leaves:
        sense = leaf.open if leaf.open else _sense(leaf, scene)
        for angle in np.arange(0.0, 90.1, 3.0):
            turn = np.eye(4)
            c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle)) * np.sign(sense)
            turn[:2, :2] = [[c, -s], [s, c]]
            closed = np.eye(4)
            c, s = np.cos(np.radians(-leaf.open)), np.sin(np.radians(-leaf.open))
            closed[:2, :2] = [[c, -s], [s, c]]
            m = leaf.world @ closed @ turn
            moved = fcl.CollisionObject(leaf.body.model, fcl.Transform(m[:3, :3], m[:3, 3]))
            cloud = leaf.body.points @ m[:3, :3].T + m[:3, 3]
            low, high = cloud.min(axis=0), cloud.max(axis=0)
            hit = next((o.name for o in scene.objects
                        if (o.low < high).all() and (o.high > low).all() and fcl.collide(
                            moved, fcl.CollisionObject(o.model, fcl.Transform()),
                            fcl.CollisionRequest(), fcl.CollisionResult())), None)  # fmt: skip
            if hit:
                yield f"{leaf.name} meets {hit} at {angle:g} degrees"
                break


def _sense(leaf: Leaf, scene: Scene) -> float:
    """+1 or -1: a leaf whose far end lies to +x of its hinge opens inwards (to -y) clockwise.

    The leaf's hinge stands before the wall that it swings to: inwards where it is inside.
    """
    reach = leaf.body.points[:, 0]
    far = 1.0 if abs(reach.max()) > abs(reach.min()) else -1.0
    inwards = bool(_inside(scene.polygon, leaf.world[:2, 3][None])[0])
    return -far if inwards else far


def _blocked(scene: Scene) -> Iterator[str]:
    """Approaches that are not free, and floor that cannot be reached."""
    for (name, middle, inward), width in zip(scene.approaches, scene.widths, strict=True):
        yield from _approach(scene, name, middle, inward, width)
    free, origin = free_floor(scene)
    labels, _ = ndimage.label(free)
    found = set()
    for name, middle, inward in scene.approaches:
        i, j = np.round((middle + (0.5 * PATH + 0.1) * inward - origin) / CELL).astype(int)
        near = labels[max(j - 3, 0) : j + 4, max(i - 3, 0) : i + 4]
        found.add(int(near.max(initial=0)))
        if not near.any():
            yield f"nobody can stand before {name}"
    if len(found) > 1:
        yield "some doors are cut off from others"
    if len(found) == 1:
        yield from _unreachable(scene, labels == found.pop(), origin)


def _approach(
    scene: Scene, name: str, middle: np.ndarray, inward: np.ndarray, width: float
) -> Iterator[str]:
    depth, high = APPROACH - 0.02, HEADROOM[1] - HEADROOM[0]
    box = fcl.Box(width - 0.1, depth, high)
    x, y = middle + (0.02 + 0.5 * depth) * inward
    across = np.array([inward[1], -inward[0]])
    turn = np.column_stack([[*across, 0.0], [*inward, 0.0], [0.0, 0.0, 1.0]])
    turn[:, 0] *= np.sign(np.linalg.det(turn))
    place = fcl.Transform(turn, np.array([x, y, HEADROOM[0] + 0.5 * high]))
    there = fcl.CollisionObject(box, place)
    for body in scene.objects:
        if body.low[2] > HEADROOM[1] or body.high[2] < HEADROOM[0]:
            continue
        mesh = fcl.CollisionObject(body.model, fcl.Transform())
        if fcl.collide(mesh, there, fcl.CollisionRequest(), fcl.CollisionResult()):
            yield f"{body.name} stands before {name}"


def free_floor(scene: Scene, path: float = PATH) -> tuple[np.ndarray, np.ndarray]:
    """(H, W) cells where somebody can stand with this much room, and the middle of the first."""
    low, high = scene.polygon.min(axis=0), scene.polygon.max(axis=0)
    shape = np.ceil((high - low) / CELL).astype(int)[::-1]
    x = low[0] + CELL * (np.arange(shape[1]) + 0.5)
    y = low[1] + CELL * (np.arange(shape[0]) + 0.5)
    grid = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    free = _inside(scene.polygon, grid).reshape(shape)
    for body in scene.objects:
        if body.high[2] > HEADROOM[0] and body.low[2] < HEADROOM[1]:
            _stamp(free, body, low)
    away = ndimage.distance_transform_edt(np.pad(free, 1))[1:-1, 1:-1] * CELL
    return away >= 0.5 * path - CELL, low + 0.5 * CELL


def _stamp(free: np.ndarray, body: Body, low: np.ndarray) -> None:
    """Take away the cells below triangles at the height of a person, by points spread over them."""
    corners = body.points[body.triangles]
    z = corners[..., 2]
    corners = corners[(z.max(1) > HEADROOM[0]) & (z.min(1) < HEADROOM[1])][..., :2]
    if not len(corners):
        return
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(1)
    for steps in np.unique(np.ceil(longest / CELL).astype(int)):
        some = corners[np.ceil(longest / CELL).astype(int) == steps]
        ticks = np.linspace(0.0, 1.0, int(steps) + 1)
        u, v = (side.ravel() for side in np.meshgrid(ticks, ticks))
        u, v = u[u + v <= 1.0 + 1e-9], v[u + v <= 1.0 + 1e-9]
        p = some[:, None, 0] + u[:, None] * (some[:, None, 1] - some[:, None, 0])
        p = p + v[:, None] * (some[:, None, 2] - some[:, None, 0])
        cells = np.floor((p.reshape(-1, 2) - low) / CELL).astype(int)
        cells = cells[(cells >= 0).all(1) & (cells < free.shape[::-1]).all(1)]
        free[cells[:, 1], cells[:, 0]] = False


def _unreachable(scene: Scene, reachable: np.ndarray, origin: np.ndarray) -> Iterator[str]:
    rows, columns = np.nonzero(reachable)
    places = origin + CELL * np.column_stack([columns, rows])
    for body in scene.objects:
        if body.category in USED and body.low[2] < 0.1:
            inverse = np.linalg.inv(body.frame)
            local = places @ inverse[:2, :2].T + inverse[:2, 3]
            own = (body.points - body.frame[:3, 3]) @ body.frame[:3, :3]
            half = np.abs(own).max(axis=0)[:2]
            away = np.maximum(np.abs(local) - half, 0.0)
            near = NEAR_SOFA if body.category == "sofa" else NEAR
            if np.linalg.norm(away, axis=1).min(initial=9.0) > near:
                yield f"nobody can come near to {body.name}"


def described_supports(rows: Sequence[Any], usual: Callable[[str], str]) -> dict[str, str]:
    """What carries each object of a description; ``usual`` says it for a category."""
    return {row.name: row.on or usual(row.category) for row in rows}


def described_hanging(
    rows: Sequence[Any], lies: Callable[[str], Sequence[Any]]
) -> frozenset[str]:  # fmt: skip
    """What hangs, of a description: ``lies`` says how a category lies.

    A thing of a style that hangs and never stands hangs wherever it is.
    """
    return frozenset(
        row.name
        for row in rows
        if _poses(row.style, lies(row.category)) and _poses(row.style, lies(row.category)) <= HUNG
    )


def _poses(style: str | None, lies: Sequence[Any]) -> set[str]:
    return {row.pose for row in lies if style in (row.styles or (style,))}
