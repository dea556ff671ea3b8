"""Can people walk? Doors open, the floor before them is free, and all that is used is reached."""

from collections.abc import Iterator

import fcl
import numpy as np
from scipy import ndimage

from tests.generation.plans import inside
from tests.generation.scenes import Body, Leaf, Opening, Scene

CELL = 0.025
PATH = 0.6  # width of the narrowest path, metres
APPROACH = 0.6  # how deep the floor before a door must be free, metres
HEADROOM = (0.06, 1.9)
# What people must be able to come near to, and how near, metres.
USED = set(
    (
        "bed sofa desk wardrobe dresser refrigerator stove oven toilet bathtub kitchen_unit "
        "dishwasher sink washing_machine bookshelf cabinet file_cabinet stairs fireplace"
    ).split()
)
NEAR = 0.9
# A sofa may have its table before it: then that is what people come near to.
NEAR_SOFA = 1.5


def swings(scene: Scene) -> Iterator[str]:
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
            moved = Body(leaf.name, "", leaf.body.form, m)
            near = (
                o
                for o in scene.objects
                if (o.low < moved.high).all() and (o.high > moved.low).all()
            )
            hit = next((o.name for o in near if o.meets(moved.solid())), None)
            if hit:
                yield f"{leaf.name} meets {hit} at {angle:g} degrees"
                break


def _sense(leaf: Leaf, scene: Scene) -> float:
    """+1 or -1: a leaf whose far end lies to +x of its hinge opens inwards (to -y) clockwise.

    The leaf's hinge stands before the wall that it swings to: inwards where it is inside.
    """
    reach = leaf.body.points[:, 0]
    far = 1.0 if abs(reach.max()) > abs(reach.min()) else -1.0
    inwards = bool(inside(scene.polygon, leaf.world[:2, 3][None])[0])
    return -far if inwards else far


def blocked(scene: Scene) -> Iterator[str]:
    """Approaches that are not free, and floor that cannot be reached."""
    ways = [opening for opening in scene.openings if opening.walked]
    for way in ways:
        yield from _approach(scene, way)
    room, origin = free_floor(scene)
    free = room >= 0.5 * PATH - CELL
    labels, _ = ndimage.label(free)
    found = set()
    for way in ways:
        place = way.middle + (0.5 * PATH + 0.1) * way.inward
        i, j = np.round((place - origin) / CELL).astype(int)
        near = labels[max(j - 3, 0) : j + 4, max(i - 3, 0) : i + 4]
        found.add(int(near.max(initial=0)))
        if not near.any():
            yield f"nobody can stand before {way.name}"
    if len(found) > 1:
        yield "some doors are cut off from others"
    if len(found) == 1:
        reachable = labels == found.pop()
        if not reachable[np.unravel_index(room.argmax(), room.shape)]:
            yield "the widest free floor is cut off from the doors"
        yield from _unreachable(scene, reachable, origin)


def _approach(scene: Scene, way: Opening) -> Iterator[str]:
    depth, high = APPROACH - 0.02, HEADROOM[1] - HEADROOM[0]
    box = fcl.Box(way.width - 0.1, depth, high)
    x, y = way.middle + (0.02 + 0.5 * depth) * way.inward
    across = np.array([way.inward[1], -way.inward[0]])
    turn = np.column_stack([[*across, 0.0], [*way.inward, 0.0], [0.0, 0.0, 1.0]])
    turn[:, 0] *= np.sign(np.linalg.det(turn))
    place = fcl.Transform(turn, np.array([x, y, HEADROOM[0] + 0.5 * high]))
    there = fcl.CollisionObject(box, place)
    for body in scene.objects:
        if body.low[2] > HEADROOM[1] or body.high[2] < HEADROOM[0]:
            continue
        if body.meets(there):
            yield f"{body.name} stands before {way.name}"


def free_floor(scene: Scene) -> tuple[np.ndarray, np.ndarray]:
    """(H, W) how far cells of the floor are from all obstacles, and the middle of the first."""
    low, high = scene.polygon.min(axis=0), scene.polygon.max(axis=0)
    shape = np.ceil((high - low) / CELL).astype(int)[::-1]
    x = low[0] + CELL * (np.arange(shape[1]) + 0.5)
    y = low[1] + CELL * (np.arange(shape[0]) + 0.5)
    grid = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    free = inside(scene.polygon, grid).reshape(shape)
    # The large ones first: what lies on them then takes nothing more away.
    for body in sorted(scene.objects, key=lambda o: -np.prod((o.high - o.low)[:2])):
        if body.high[2] > HEADROOM[0] and body.low[2] < HEADROOM[1]:
            (i0, j0), (i1, j1) = (
                np.maximum(np.floor((side[:2] - low) / CELL).astype(int), 0)
                for side in (body.low, body.high)
            )
            if free[j0 : j1 + 1, i0 : i1 + 1].any():
                _stamp(free, body, low)
    away = ndimage.distance_transform_edt(np.pad(free, 1))[1:-1, 1:-1] * CELL
    return away, low + 0.5 * CELL


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
