"""Furniture of plain boxes, posed as an alignment would, and an independent check by FCL."""

from collections.abc import Sequence
from typing import Any

import fcl
import numpy as np
from scipy.spatial.transform import Rotation

from openrooms_usd.scan.models.cad import CadModel
from openrooms_usd.scan.placement.correcting import Placement
from openrooms_usd.scan.results import FoundObject, FoundRoom, Pose
from tests.scan.alignment_cases import BOX_FACES

SQUARE = [[0, 0], [4, 0], [4, 3], [0, 3]]
Block = tuple[float, float, float, float, float, float]


def blocks(*rows: Block) -> tuple[np.ndarray, np.ndarray]:
    """Vertices and faces of boxes given by least and greatest x, y, z."""
    corners = np.indices((2, 2, 2)).reshape(3, -1).T
    boxes = [np.array(row).reshape(3, 2) for row in rows]
    points = np.concatenate([box[np.arange(3), corners] for box in boxes])
    return points, np.concatenate([BOX_FACES + 8 * k for k in range(len(boxes))])


def _legs(x: float, y: float, high: float, width: float = 0.05) -> list[Block]:
    rows = []
    for a, b in ((-1, -1), (-1, 1), (1, -1), (1, 1)):
        x0, x1 = sorted((a * x, a * (x - width)))
        y0, y1 = sorted((b * y, b * (y - width)))
        rows.append((x0, x1, y0, y1, 0.0, high))
    return rows


# Feet on the ground at the origin, backs to +y.
SHAPES: dict[str, list[Block]] = {
    "table": [(-0.6, 0.6, -0.4, 0.4, 0.7, 0.74), *_legs(0.6, 0.4, 0.7)],
    "chair": [
        (-0.22, 0.22, -0.22, 0.22, 0.42, 0.46),
        (-0.22, 0.22, 0.18, 0.22, 0.46, 0.95),
        *_legs(0.22, 0.22, 0.42, 0.04),
    ],
    "bookshelf": [
        (-0.5, -0.48, -0.15, 0.15, 0.0, 1.2),
        (0.48, 0.5, -0.15, 0.15, 0.0, 1.2),
        *((-0.48, 0.48, -0.15, 0.15, z, z + 0.02) for z in (0.05, 0.45, 0.85, 1.18)),
    ],
    "box": [(-0.12, 0.12, -0.1, 0.1, 0.0, 0.25)],
    "table_lamp": [
        (-0.08, 0.08, -0.08, 0.08, 0.0, 0.03),
        (-0.01, 0.01, -0.01, 0.01, 0.03, 0.4),
        (-0.12, 0.12, -0.12, 0.12, 0.3, 0.5),
    ],
    "picture": [(-0.3, 0.3, -0.012, 0.012, -0.2, 0.2)],
    "ceiling_lamp": [(-0.01, 0.01, -0.01, 0.01, -0.5, 0.0), (-0.15, 0.15, -0.15, 0.15, -0.7, -0.5)],
    "wardrobe": [(-0.6, 0.6, -0.3, 0.3, 0.0, 2.0)],
    "counter": [(-0.3, 0.3, -0.3, 0.3, 0.0, 0.9)],
    "television": [(-0.5, 0.5, -0.03, 0.03, 0.0, 0.6)],
    "floor_lamp": [(-0.15, 0.15, -0.15, 0.15, 0.0, 0.03), (-0.02, 0.02, -0.02, 0.02, 0.03, 1.6)],
    # Two wings around a corner that is free.
    "sofa": [(-1.0, 1.0, 0.2, 1.0, 0.0, 0.45), (0.2, 1.0, -1.0, 0.2, 0.0, 0.45)],
    "rug": [(-0.8, 0.8, -0.5, 0.5, 0.0, 0.012)],
}
MODELS = {name: CadModel(name, name, *blocks(*rows)) for name, rows in SHAPES.items()}


def found(
    number: int, shape: str, at: Sequence[float], yaw: float = 0.0, tilt: float = 0.0, **more: Any
) -> FoundObject:
    """An object at a place, turned about the vertical and then tilted about x; degrees."""
    turn = Rotation.from_euler("x", tilt, degrees=True) * Rotation.from_euler(
        "z", yaw, degrees=True
    )
    pose = Pose(
        np.array(at, dtype=float), turn.as_quat(canonical=True, scalar_first=True), np.ones(3)
    )
    values = {"residual": 0.01, "coverage": 0.6} | more
    return FoundObject(number, shape, shape, pose, **values)


def room(corners: Sequence[Sequence[float]] = SQUARE, ceiling: float | None = 2.5) -> FoundRoom:
    """A room on the floor z = 0."""
    plan = np.array(corners, dtype=float)
    level = np.column_stack([plan, np.zeros(len(plan))])
    return FoundRoom(np.array([0.0, 0.0, 1.0]), np.zeros(3), level, ceiling=ceiling)


def points(item: FoundObject) -> np.ndarray:
    """(V, 3) the vertices of an object where it was placed, or else measured."""
    pose = item.placed or item.pose
    turn = Rotation.from_quat(pose.rotation, scalar_first=True).as_matrix()
    return (MODELS[item.cad].vertices * pose.scale) @ turn.T + pose.translation


def meets(a: FoundObject, b: FoundObject, shift: Sequence[float] = (0.0, 0.0, 0.0)) -> bool:
    """Whether the surfaces of two objects cross when the first is shifted."""
    solids = []
    for item, offset in ((a, shift), (b, (0.0, 0.0, 0.0))):
        model = fcl.BVHModel()
        cloud, faces = points(item), MODELS[item.cad].faces
        model.beginModel(len(faces), len(cloud))
        model.addSubModel(cloud, faces)
        model.endModel()
        solids.append(fcl.CollisionObject(model, fcl.Transform(np.array(offset, dtype=float))))
    return bool(fcl.collide(*solids, fcl.CollisionRequest(), fcl.CollisionResult()))


def overlaps(items: Sequence[FoundObject], depth: float = 0.005) -> list[tuple[int, int]]:
    """Pairs that no shift by a depth along an axis of the world sets free."""
    steps = depth * np.concatenate([np.eye(3), -np.eye(3)])
    return [
        (a.instance, b.instance)
        for i, a in enumerate(items)
        for b in items[:i]
        if meets(a, b) and all(meets(a, b, step.tolist()) for step in steps)
    ]


def outside(item: FoundObject, home: FoundRoom) -> float:
    """How far an object reaches beyond the walls, metres, by its vertices and middles of edges."""
    import shapely

    cloud, faces = points(item)[:, :2], MODELS[item.cad].faces
    t = np.linspace(0.0, 1.0, 101)[:, None, None]
    edges = np.concatenate([cloud[faces], cloud[np.roll(faces, 1, axis=1)]]).reshape(2, -1, 2)
    dense = (edges[0] + t * (edges[1] - edges[0])).reshape(-1, 2)
    return float(
        shapely.distance(shapely.Polygon(home.corners[:, :2]), shapely.points(dense)).max()
    )


def shifts(result: Placement) -> dict[int, np.ndarray]:
    """How far each instance was moved, (3,) metres."""
    return {
        item.instance: item.placed.translation - item.pose.translation
        for item in result.objects
        if item.placed is not None
    }
