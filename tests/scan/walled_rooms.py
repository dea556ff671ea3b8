"""Points of rooms of known size, with doors and windows of known place, for tests."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from openrooms_usd.arrays import Array, Ints, Mask
from openrooms_usd.scan.openings.cellcounts import WallFace, faces_of
from openrooms_usd.scan.points.cloud import Cloud

HEIGHT = 2.6
CORNERS = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [0.0, 3.0]])
SENSOR_ORIGINS = np.array([[x, y, 1.5] for x in (1.0, 2.0, 3.0) for y in (1.0, 2.0)])
SPACING = 0.02
WALL, FLOOR, DOOR, WINDOW, CURTAIN = 1, 2, 8, 9, 16


@dataclass(frozen=True)
class Sheet:
    """A rectangle of points before or behind a wall, or a hole in it.

    Attributes:
        wall: Its number.
        x: From and to, along the wall to the right seen from inside, metres.
        z: From and to, metres.
        depth: Outwards from the wall's face, metres; None: nothing but a hole.
        label: Of the points.
        cuts: Whether the wall has a hole there.
    """

    wall: int
    x: tuple[float, float]
    z: tuple[float, float]
    depth: float | None = None
    label: int = WALL
    cuts: bool = True

    def covers(self, x: Array, z: Array) -> Mask:
        return (x > self.x[0]) & (x < self.x[1]) & (z > self.z[0]) & (z < self.z[1])


def frame_of(
    wall: int, x: tuple[float, float], z: tuple[float, float], *, depth: float, label: int
) -> list[Sheet]:
    """A hole with bars of six centimetres around it, behind the wall's face."""
    (left, right), (low, high) = x, z
    w = 0.06
    parts = [
        ((left, left + w), z),
        ((right - w, right), z),
        ((left, right), (low, low + w)),
        ((left, right), (high - w, high)),
    ]
    bars = [Sheet(wall, px, pz, depth, label, cuts=False) for px, pz in parts]
    return [Sheet(wall, x, z), *bars]


def casing_of(wall: int, x: tuple[float, float], top: float, proud: float) -> list[Sheet]:
    """Boards of seven centimetres around a door, that stand out into the room."""
    (left, right), w = x, 0.07
    parts = [
        ((left - w, left), (0.0, top + w)),
        ((right, right + w), (0.0, top + w)),
        ((left, right), (top, top + w)),
    ]
    return [Sheet(wall, px, pz, -proud, DOOR) for px, pz in parts]


def room(
    sheets: Sequence[Sheet] = (),
    *,
    labels: bool = True,
    noise: float = 0.003,
    corners: Array = CORNERS,
    missing: Sequence[int] = (),
) -> Cloud:
    """A scan of a room with sheets in its walls; its floor goes on behind holes that reach it."""
    random = np.random.default_rng(7)
    parts = [_floor(corners, sheets)]
    for face in faces_of(corners):
        if face.number not in missing:
            parts += _wall(face, [s for s in sheets if s.wall == face.number])
    points, normals, label = (np.concatenate(column) for column in zip(*parts, strict=True))
    points = points + noise * random.standard_normal((len(points), 1)) * normals
    return Cloud(
        points,
        normals=normals.astype(np.float32),
        label=label.astype(np.int32) if labels else None,
        sensor_origins=SENSOR_ORIGINS,
    )


Part = tuple[Array, Array, Ints]


def _grid(x: tuple[float, float], z: tuple[float, float]) -> tuple[Array, Array]:
    along = np.arange(x[0] + SPACING / 2, x[1], SPACING)
    up = np.arange(z[0] + SPACING / 2, z[1], SPACING)
    return tuple(axis.ravel() for axis in np.meshgrid(along, up))


def _wall(face: WallFace, sheets: Sequence[Sheet]) -> list[Part]:
    x, z = _grid((0.0, face.length), (0.0, HEIGHT))
    whole = np.ones(len(x), dtype=bool)
    for sheet in sheets:
        whole &= ~(sheet.covers(x, z) & sheet.cuts)
    parts = [_sheet(face, x[whole], z[whole], 0.0, WALL)]
    filled = [
        _sheet(face, *_grid(sheet.x, sheet.z), sheet.depth, sheet.label)
        for sheet in sheets
        if sheet.depth is not None
    ]
    return parts + filled


def _sheet(face: WallFace, x: Array, z: Array, depth: float, label: int) -> Part:
    points = face.to_level(np.column_stack([x, np.full(len(x), depth), z]))
    normals = np.tile([*-face.outward, 0.0], (len(x), 1))
    return points, normals, np.full(len(x), label)


def _floor(corners: Array, sheets: Sequence[Sheet]) -> Part:
    low, high = corners.min(axis=0), corners.max(axis=0)
    plan = [np.column_stack(_grid((low[0], high[0]), (low[1], high[1])))]
    faces = faces_of(corners)
    for sheet in sheets:
        if sheet.depth is None and sheet.z[0] == 0.0:
            x, y = _grid(sheet.x, (0.0, 1.0))
            plan.append(faces[sheet.wall].to_level(np.column_stack([x, y, 0 * x]))[:, :2])
    points = np.concatenate(plan)
    ground = np.column_stack([points, np.zeros(len(points))])
    return ground, np.tile([0.0, 0.0, 1.0], (len(ground), 1)), np.full(len(ground), FLOOR)
