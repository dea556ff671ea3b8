"""The meshes of a composed room, read back from its USD stage."""

from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import fcl
import numpy as np
from pxr import Gf, Usd, UsdGeom


@dataclass(eq=False)
class Body:
    """A mesh in the world, and what it stands on."""

    name: str
    category: str
    points: np.ndarray  # (N, 3) world
    triangles: np.ndarray  # (T, 3)
    frame: np.ndarray  # (4, 4) world from object
    model: Any = field(repr=False, default=None)

    def __post_init__(self) -> None:
        if self.model is None:
            self.model = fcl.BVHModel()
            self.model.beginModel(len(self.triangles), len(self.points))
            self.model.addSubModel(self.points, self.triangles)
            self.model.endModel()

    @cached_property
    def low(self) -> np.ndarray:
        return self.points.min(axis=0)

    @cached_property
    def high(self) -> np.ndarray:
        return self.points.max(axis=0)

    def hits(self, other: "Body", offset: np.ndarray | None = None) -> bool:
        """Whether it meets another body, surfaces or insides, when it is moved by an offset."""
        move = np.zeros(3) if offset is None else offset
        if (self.low + move > other.high).any() or (self.high + move < other.low).any():
            return False
        mine = fcl.CollisionObject(self.model, fcl.Transform(move))
        theirs = fcl.CollisionObject(other.model, fcl.Transform())
        if fcl.collide(mine, theirs, fcl.CollisionRequest(), fcl.CollisionResult()):
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
    body: Body  # points in the leaf's own frame
    world: np.ndarray  # (4, 4) world from leaf, as authored
    open: float  # degrees, signed: as authored


@dataclass(eq=False)
class Scene:
    """A composed room."""

    objects: list[Body]
    room: list[Body]
    leaves: list[Leaf]
    approaches: list[tuple[str, np.ndarray, np.ndarray]]  # name, middle on the wall, inward
    widths: list[float]
    polygon: np.ndarray
    height: float
    windows: list[tuple[np.ndarray, float]]  # (4, 4) window from world, width


def read(path: Path) -> Scene:
    """Read the meshes of a composed room."""
    stage = Usd.Stage.Open(str(path))
    cache = UsdGeom.XformCache()
    furniture = stage.GetPrimAtPath("/World/Furniture")
    objects = [_body(prim, cache) for prim in furniture.GetChildren()] if furniture else []
    room = stage.GetPrimAtPath("/World/Room")
    openings = stage.GetPrimAtPath("/World/Room/Openings")
    shell = [_body(p, cache) for p in stage.GetPrimAtPath("/World/Room/Walls").GetChildren()]
    shell += [_body(stage.GetPrimAtPath(f"/World/Room/{n}"), cache) for n in ("Floor", "Ceiling")]
    if trim := stage.GetPrimAtPath("/World/Room/Trim"):
        meshes = [prim for prim in Usd.PrimRange(trim) if prim.IsA(UsdGeom.Mesh)]
        shell += [_body(prim, cache) for prim in meshes]
    scene = Scene(
        objects, shell, [], [], [],
        np.array(room.GetAttribute("openrooms:room:floor").Get(), dtype=float),
        float(room.GetAttribute("openrooms:room:height").Get()), [],
    )  # fmt: skip
    for prim in openings.GetChildren():
        _add_opening(scene, prim, cache)
    return scene


def _add_opening(scene: Scene, prim: Usd.Prim, cache: UsdGeom.XformCache) -> None:
    kind = prim.GetAttribute("openrooms:opening:kind").Get()
    width, height = (
        float(prim.GetAttribute(f"openrooms:opening:{k}").Get()) for k in ("width", "height")
    )
    frame, leaf = prim.GetChild("Frame"), prim.GetChild("Leaf")
    if frame:
        scene.room.append(_body(frame, cache))
    if leaf:
        matrix = _matrix(cache.GetLocalToWorldTransform(leaf))
        turn = leaf.GetAttribute("xformOp:rotateZ")
        body = _body(leaf, cache, local=True)
        scene.leaves.append(Leaf(prim.GetName(), body, matrix, float(turn.Get() if turn else 0.0)))
    middle = _matrix(cache.GetLocalToWorldTransform(prim))
    if kind == "window":
        scene.windows.append((np.linalg.inv(middle), width))
    if kind != "window" and middle[2, 3] - 0.5 * height < 0.1:
        scene.approaches.append((prim.GetName(), middle[:2, 3], -middle[:2, 1]))
        scene.widths.append(width)


def _matrix(m: Gf.Matrix4d) -> np.ndarray:
    return np.array(m).T


def _body(prim: Usd.Prim, cache: UsdGeom.XformCache, local: bool = False) -> Body:
    """All meshes below a prim as one, in the world (or in the prim's own frame)."""
    frame = _matrix(cache.GetLocalToWorldTransform(prim))
    points, triangles = _merged(prim, cache)
    cloud = points if local else points @ frame[:3, :3].T + frame[:3, 3]
    labels = prim.GetAttribute("semantics:labels:category")
    category = str(labels.Get()[0]) if labels and labels.Get() else ""
    return Body(prim.GetName(), category, cloud, triangles, frame)


def _merged(prim: Usd.Prim, cache: UsdGeom.XformCache) -> tuple[np.ndarray, np.ndarray]:
    """(N, 3) points in a prim's own frame and (T, 3) triangles of all meshes below it."""
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
            triangles.append(_fans(counts, indices) + count)
            count += len(p)
    return np.concatenate(points), np.concatenate(triangles)


def _fans(counts: np.ndarray, indices: np.ndarray) -> np.ndarray:
    """(T, 3) points of the triangles that fan out from the first corner of each face."""
    starts, fans = np.cumsum(counts) - counts, counts - 2
    first = np.repeat(starts, fans)
    step = np.arange(fans.sum()) - np.repeat(np.cumsum(fans) - fans, fans)
    return np.stack([indices[first], indices[first + step + 1], indices[first + step + 2]], axis=1)
