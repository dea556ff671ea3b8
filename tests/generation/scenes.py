"""The meshes of a composed room, read back from its USD stage."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import fcl
import numpy as np
from pxr import Gf, Usd, UsdGeom


@dataclass(eq=False)
class Form:
    """A mesh in a frame of its own; everything that is built alike shares one.

    Attributes:
        points: (N, 3) metres.
        triangles: (T, 3) indices of points.
    """

    points: np.ndarray
    triangles: np.ndarray

    @cached_property
    def model(self) -> Any:
        """The tree of its triangles."""
        model = fcl.BVHModel()
        model.beginModel(len(self.triangles), len(self.points))
        model.addSubModel(self.points, self.triangles)
        model.endModel()
        return model


@dataclass(eq=False)
class Body:
    """A mesh in the world.

    Attributes:
        name: Its prim's name.
        category: What it is; empty for parts of the room.
        form: Its mesh.
        frame: (4, 4) world from object, rigid.
    """

    name: str
    category: str
    form: Form
    frame: np.ndarray

    @cached_property
    def points(self) -> np.ndarray:
        """(N, 3) in the world, metres."""
        return np.asarray(self.form.points @ self.frame[:3, :3].T + self.frame[:3, 3])

    @property
    def triangles(self) -> np.ndarray:
        """(T, 3) indices of points."""
        return self.form.triangles

    @cached_property
    def low(self) -> np.ndarray:
        """(3,) its least coordinates, metres."""
        return np.asarray(self.points.min(axis=0))

    @cached_property
    def high(self) -> np.ndarray:
        """(3,) its greatest coordinates, metres."""
        return np.asarray(self.points.max(axis=0))

    def moved(self, offset: np.ndarray) -> "Body":
        """The same elsewhere."""
        frame = self.frame.copy()
        frame[:3, 3] += offset
        return Body(self.name, self.category, self.form, frame)

    def solid(self, offset: np.ndarray | None = None) -> Any:
        """It as FCL takes it, moved by an offset."""
        place = self.frame[:3, 3] + (0.0 if offset is None else offset)
        return fcl.CollisionObject(self.form.model, fcl.Transform(self.frame[:3, :3], place))

    def meets(self, solid: Any) -> bool:
        """Whether its surface meets that of something else."""
        return bool(fcl.collide(self.solid(), solid, fcl.CollisionRequest(), fcl.CollisionResult()))

    def hits(self, other: "Body", offset: np.ndarray | None = None) -> bool:
        """Whether it meets another body, surfaces or insides, when it is moved by an offset."""
        move = np.zeros(3) if offset is None else offset
        if (self.low + move > other.high).any() or (self.high + move < other.low).any():
            return False
        if other.meets(self.solid(move)):
            return True
        return other.holds(self.points[0] + move) or self.holds(other.points[0] - move)

    def holds(self, point: np.ndarray) -> bool:
        """Whether a point is inside, by its winding number (van Oosterom & Strackee 1983)."""
        if (point < self.low).any() or (point > self.high).any():
            return False
        a, b, c = np.moveaxis(self.points[self.triangles] - point, 1, 0)
        la, lb, lc = (np.linalg.norm(v, axis=1) for v in (a, b, c))
        over = np.einsum("ij,ij->i", a, np.cross(b, c))
        under = la * lb * lc + np.einsum("ij,ij->i", a, b) * lc
        under += np.einsum("ij,ij->i", b, c) * la + np.einsum("ij,ij->i", c, a) * lb
        return float(np.arctan2(over, under).sum()) / (2.0 * np.pi) > 0.5


@dataclass(eq=False)
class Leaf:
    """A door's leaf in the frame of its hinge, and the hinge as it stands in the world."""

    name: str
    body: Body  # in the leaf's own frame
    world: np.ndarray  # (4, 4) world from leaf, as authored
    open: float  # degrees, signed: as authored


@dataclass(eq=False)
class Opening:
    """A hole in a wall.

    Attributes:
        name: Its prim's name.
        kind: ``door``, ``window`` or ``opening``.
        frame: (4, 4) world from opening: its middle, X along the wall, Y out of the room.
        width: Metres.
        height: Metres.
    """

    name: str
    kind: str
    frame: np.ndarray
    width: float
    height: float

    @property
    def sill(self) -> float:
        """Height of its lower edge, metres."""
        return float(self.frame[2, 3]) - 0.5 * self.height

    @property
    def walked(self) -> bool:
        """Whether people go through."""
        return self.kind != "window" and self.sill < 0.1

    @property
    def middle(self) -> np.ndarray:
        """(2,) in the plan."""
        return np.asarray(self.frame[:2, 3])

    @property
    def inward(self) -> np.ndarray:
        """(2,) into the room."""
        return np.asarray(-self.frame[:2, 1])


@dataclass(eq=False)
class Scene:
    """A composed room.

    Attributes:
        objects: Furniture and all that lies about.
        room: Walls, floor, ceiling, frames and panes.
        trim: Boards along walls and around openings; a part of the room.
        leaves: Of doors.
        openings: In walls.
        polygon: (N, 2) inner corners, metres.
        height: Metres.
    """

    objects: list[Body]
    room: list[Body]
    trim: list[Body]
    leaves: list[Leaf]
    openings: list[Opening]
    polygon: np.ndarray
    height: float


def read(path: Path) -> Scene:
    """Read the meshes of a composed room."""
    stage = Usd.Stage.Open(str(path))
    cache = UsdGeom.XformCache()
    forms: dict[Any, Form] = {}
    furniture = stage.GetPrimAtPath("/World/Furniture")
    objects = [_body(p, cache, forms) for p in furniture.GetChildren()] if furniture else []
    room = stage.GetPrimAtPath("/World/Room")
    shell = [_body(p, cache) for p in stage.GetPrimAtPath("/World/Room/Walls").GetChildren()]
    shell += [_body(stage.GetPrimAtPath(f"/World/Room/{n}"), cache) for n in ("Floor", "Ceiling")]
    boards = stage.GetPrimAtPath("/World/Room/Trim")
    trim = [_body(p, cache) for p in Usd.PrimRange(boards) if p.IsA(UsdGeom.Mesh)] if boards else []
    scene = Scene(
        objects,
        [*shell, *trim],
        trim,
        [],
        [],
        np.array(room.GetAttribute("openrooms:room:floor").Get(), dtype=float),
        float(room.GetAttribute("openrooms:room:height").Get()),
    )
    for prim in stage.GetPrimAtPath("/World/Room/Openings").GetChildren():
        _add_opening(scene, prim, cache)
    return scene


def _add_opening(scene: Scene, prim: Usd.Prim, cache: UsdGeom.XformCache) -> None:
    kind = prim.GetAttribute("openrooms:opening:kind").Get()
    width, height = (
        float(prim.GetAttribute(f"openrooms:opening:{k}").Get()) for k in ("width", "height")
    )
    frame = _matrix(cache.GetLocalToWorldTransform(prim))
    scene.openings.append(Opening(prim.GetName(), kind, frame, width, height))
    fixed = [part for part in prim.GetChildren() if part.GetName() != "Leaf"]
    for part in (p for root in fixed for p in Usd.PrimRange(root) if p.IsA(UsdGeom.Mesh)):
        body = _body(part, cache)
        body.name = f"{prim.GetName()}_{part.GetName()}"
        scene.room.append(body)
    if leaf := prim.GetChild("Leaf"):
        matrix = _matrix(cache.GetLocalToWorldTransform(leaf))
        turn = leaf.GetAttribute("xformOp:rotateZ")
        body = Body(leaf.GetName(), "", _merged(leaf, cache), np.eye(4))
        scene.leaves.append(Leaf(prim.GetName(), body, matrix, float(turn.Get() if turn else 0.0)))


def _matrix(m: Gf.Matrix4d) -> np.ndarray:
    return np.array(m).T


def _body(prim: Usd.Prim, cache: UsdGeom.XformCache, forms: dict[Any, Form] | None = None) -> Body:
    """All meshes below a prim as one."""
    known = {} if forms is None else forms
    key = prim.GetPrototype().GetPath() if prim.IsInstance() else prim.GetPath()
    if key not in known:
        known[key] = _merged(prim, cache)
    labels = prim.GetAttribute("semantics:labels:category")
    category = str(labels.Get()[0]) if labels and labels.Get() else ""
    frame = _matrix(cache.GetLocalToWorldTransform(prim))
    return Body(prim.GetName(), category, known[key], frame)


def _merged(prim: Usd.Prim, cache: UsdGeom.XformCache) -> Form:
    """All meshes below a prim, in its own frame."""
    inverse = np.linalg.inv(_matrix(cache.GetLocalToWorldTransform(prim)))
    points, triangles, count = [], [], 0
    for below in Usd.PrimRange(prim, Usd.TraverseInstanceProxies()):
        if below.IsA(UsdGeom.Mesh):
            mesh = UsdGeom.Mesh(below)
            p = np.array(mesh.GetPointsAttr().Get(), dtype=float)
            m = inverse @ _matrix(cache.GetLocalToWorldTransform(below))
            points.append(p @ m[:3, :3].T + m[:3, 3])
            counts = np.array(mesh.GetFaceVertexCountsAttr().Get())
            indices = np.array(mesh.GetFaceVertexIndicesAttr().Get())
            triangles.append(fans(counts, indices) + count)
            count += len(p)
    return Form(np.concatenate(points), np.concatenate(triangles))


def fans(counts: np.ndarray, indices: np.ndarray) -> np.ndarray:
    """(T, 3) points of the triangles that fan out from the first corner of each face."""
    starts, each = np.cumsum(counts) - counts, counts - 2
    first = np.repeat(starts, each)
    step = np.arange(each.sum()) - np.repeat(np.cumsum(each) - each, each)
    return np.stack([indices[first], indices[first + step + 1], indices[first + step + 2]], axis=1)
