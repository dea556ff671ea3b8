"""Reads any UsdPhysics stage as bodies, links, joints and shapes for engines.

The front end is USD's own parser, which knows how bodies, colliders and joints are found, also
inside instances, and the standard's own rules for masses.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import product
from typing import Any, Final, TypeVar

import numpy as np
from numpy.typing import NDArray
from pxr import Kind, Sdf, Usd, UsdPhysics

from openrooms_usd import names
from openrooms_usd.arrays import Array
from openrooms_usd.errors import StageError
from openrooms_usd.geometry.rotations import inverse
from openrooms_usd.geometry.triangulation import TriangleMesh
from openrooms_usd.physics.world import Body, LinkName, Shape, Visual, World
from openrooms_usd.physics.world import Link as WorldLink
from openrooms_usd.usd.rigid.joints import (
    KINDS,
    UNKNOWN_KINDS,
    Edge,
    Link,
    Tree,
    damping_of,
    friction_of,
    joint_axis,
    joint_of,
    limits_of,
    pose,
    trees,
)
from openrooms_usd.usd.rigid.masses import read_mass
from openrooms_usd.usd.rigid.shapes import Frames, ShapeReader, safe
from openrooms_usd.usd.semantics import read_label
from openrooms_usd.usd.shapes.meshes import read_meshes

_Type = UsdPhysics.ObjectType
_SHAPES: Final = tuple(getattr(_Type, name) for name in _Type.names if name.endswith("Shape"))
# Until USD 26 the parser had the first of these names alone.
_PARSE: Final = (
    getattr(UsdPhysics, "UsdPhysicsLoadStageFromPrimRange", None)
    or UsdPhysics.LoadUsdPhysicsFromRange
)


def read_world(stage: Usd.Stage, place: object = None) -> World:
    """Read the physics of a stage, ours or a foreign one.

    What moves is a body with RigidBodyAPI that is enabled and not kinematic. What collides and does
    not move belongs to a fixed body: that of the nearest component or subcomponent, or else of the
    prim below the stage's default prim. Joints make one body of what they join, as a tree. Links of
    one body are not meant to collide with each other, nor are pairs of FilteredPairsAPI.

    Args:
        stage: The composed stage.
        place: What people call it, for messages; its root layer where nothing else is said.

    Returns:
        Everything in metres, kilograms and radians with Z up; scales and mirrors are in the points.

    Raises:
        StageError: The stage has no physics.
        InputError: A mass is negative, a body has neither mass nor volume, or joints make a loop.
    """
    found = _PARSE(stage, [Sdf.Path.absoluteRootPath])
    parsed = {kind: list(zip(*rows, strict=True)) for kind, rows in found.items()}
    if not any(parsed.get(kind) for kind in (_Type.RigidBody, *_SHAPES)):
        raise StageError(
            "this stage says nothing of physics: it has no rigid bodies and no colliders",
            place=place or stage.GetRootLayer().identifier,
            remedy="write `physics: {}` into the description and compose again; to a stage of"
            " another program apply UsdPhysics schemas",
        )
    return _Reading(stage, parsed).world()


@dataclass
class _Content:
    """A link under construction."""

    shapes: list[Shape] = field(default_factory=list)
    solids: dict[Sdf.Path, Sequence[TriangleMesh]] = field(default_factory=dict)
    visuals: list[Visual] = field(default_factory=list)


class _Reading:
    def __init__(self, stage: Usd.Stage, parsed: Mapping[Any, list[tuple[Sdf.Path, Any]]]) -> None:
        self.stage = stage
        self.parsed = parsed
        self.frames = Frames(stage)
        self.reader = ShapeReader(self.frames)
        self.moving = {
            path
            for path, desc in parsed.get(_Type.RigidBody, ())
            if desc.rigidBodyEnabled and not desc.kinematicBody
        }
        self.links: dict[Sdf.Path, Link] = {}
        self.content: dict[Sdf.Path, _Content] = {}
        self.anchored: set[Sdf.Path] = set()
        self.inverses: dict[Sdf.Path, Array] = {}

    def world(self) -> World:
        for path in self.moving:
            self._add(path, moves=True)
        self._read_colliders()
        edges = list(self._edges())
        self._read_visuals()
        order = {path: number for number, path in enumerate(self.frames.ordered(self.links))}
        links = {path: self.links[path] for path in sorted(self.links, key=order.__getitem__)}
        roots = [p for _, d in self.parsed.get(_Type.Articulation, ()) for p in d.rootPrims]
        taken: set[str] = set()
        bodies = [self._body(tree, taken) for tree in trees(links, edges, roots)]
        for loss in self.seen.losses:
            self.reader.lose(*loss)
        gravity = self.frames.gravity([desc for _, desc in self.parsed.get(_Type.Scene, ())])
        colliders = {path: content.solids for path, content in self.content.items()}
        apart = read_filters(self.stage, bodies, colliders, self.reader)
        return World(tuple(bodies), gravity, tuple(self.reader.losses.values()), apart)

    def _add(self, path: Sdf.Path, *, moves: bool) -> Sdf.Path:
        if path not in self.links:
            self.links[path] = Link(path, moves, self.frames.rigid(path))
            self.content[path] = _Content()
        return path

    def _into(self, path: Sdf.Path) -> Array:
        """(4, 4) from the world to the rigid frame of a link."""
        if path not in self.inverses:
            self.inverses[path] = inverse(self.links[path].frame)
        return self.inverses[path]

    def _holder(self, path: Sdf.Path) -> Sdf.Path:
        """The link that a prim belongs to: the nearest that moves, else a fixed one."""
        for prefix in reversed(path.GetPrefixes()):
            if prefix in self.moving:
                return prefix
        return self._add(self._owner(path), moves=False)

    def _owner(self, path: Sdf.Path) -> Sdf.Path:
        for prefix in reversed(path.GetPrefixes()):
            kind = Usd.ModelAPI(self.stage.GetPrimAtPath(prefix)).GetKind()
            if Kind.Registry.IsA(kind, Kind.Tokens.component) or (
                Kind.Registry.IsA(kind, Kind.Tokens.subcomponent)
            ):
                return prefix
        prefixes = path.GetPrefixes()
        top = self.stage.GetDefaultPrim()
        below = 1 if top and prefixes[0] == top.GetPath() and len(prefixes) > 1 else 0
        return prefixes[below]

    def _read_colliders(self) -> None:
        for kind in _SHAPES:
            for path, desc in self.parsed.get(kind, ()):
                if not desc.collisionEnabled:
                    continue
                if desc.rigidBody in self.moving:
                    holder = desc.rigidBody
                else:
                    holder = self._add(self._owner(path), moves=False)
                into = self._into(holder)
                read = self.reader.collider(path, desc, into)
                self.content[holder].shapes += read.shapes
                self.content[holder].solids[path] = read.solids

    def _read_visuals(self) -> None:
        self.seen = read_meshes(self.stage, outside=False)
        for placed in self.seen:
            holder = self._holder(placed.prim.GetPath())
            into = self._into(holder)
            self.content[holder].visuals += self.reader.visuals(placed, into)

    def _edges(self) -> Iterator[Edge]:
        for kind, what in UNKNOWN_KINDS.items():
            for path, _ in self.parsed.get(kind, ()):
                self.reader.lose(path, "skipped", f"{what}: no hinge, rail or fixed joint")
        for kind, motion in KINDS.items():
            for path, desc in self.parsed.get(kind, ()):
                if not desc.jointEnabled:
                    self.reader.lose(path, "skipped", "it is disabled")
                    continue
                ends = [desc.body0, desc.body1]
                if not any(end in self.moving for end in ends):
                    self.reader.lose(path, "skipped", "nothing that moves is joined by it")
                elif motion == "fixed" and desc.rel0.isEmpty != desc.rel1.isEmpty:
                    self.anchored.update(end for end in ends if end in self.moving)
                else:
                    yield self._edge(path, motion, desc)

    def _edge(self, path: Sdf.Path, motion: Any, desc: Any) -> Edge:
        ends = []
        for body, rel, position, orientation in (
            (desc.body0, desc.rel0, desc.localPose0Position, desc.localPose0Orientation),
            (desc.body1, desc.rel1, desc.localPose1Position, desc.localPose1Orientation),
        ):
            anchor = pose(self.frames, position, orientation)
            if body in self.moving:
                ends.append((body, anchor))
                continue
            # What a joint names need not be there, or be a prim.
            named = rel if rel.IsPrimPath() and self.stage.GetPrimAtPath(rel) else path
            fixed = self._add(self._owner(named), moves=False)
            # The standard gives what holds on to nothing that moves in the stage's own frame.
            held = self.frames.rigid(body) if body else self.frames.placed(np.eye(4))
            ends.append((fixed, inverse(self.links[fixed].frame) @ held @ anchor))
        return Edge(
            path,
            motion,
            (ends[0][0], ends[1][0]),
            (ends[0][1], ends[1][1]),
            joint_axis(desc),
            limits_of(self.frames, motion, desc),
            damping_of(self.frames, motion, desc),
            friction_of(self.frames, motion, path),
        )

    def _body(self, tree: Tree, taken: set[str]) -> Body:
        base = self.links[tree.links[0]]
        root = self._owner(base.path) if len(tree.links) > 1 else base.path
        fixed = not base.moves or base.path in self.anchored
        called = unique_names([safe(path.name) for path in tree.links])
        named = dict(zip(tree.links, called, strict=True))
        frames, joints = {base.path: np.eye(4)}, []
        labels = unique_names([safe(edge.path.name) for _, _, edge, _ in tree.joints])
        for label, (parent, child, edge, backward) in zip(labels, tree.joints, strict=True):
            ends = (self.links[edge.links[0]], self.links[edge.links[1]])
            told = (label, named[parent], named[child])
            joint, frames[child] = joint_of(edge, backward, ends, told, self.reader)
            joints.append(joint)
        into = inverse(base.frame)
        links = [
            self._link(path, named[path], into, frames[path], fixed and path == base.path)
            for path in tree.links
        ]
        prim = self.stage.GetPrimAtPath(root)
        category = read_label(prim, names.CATEGORY) or ""
        name = unique(safe(root.name), taken)
        return Body(name, str(root), base.frame, tuple(links), tuple(joints), fixed, category)

    def _link(
        self, path: Sdf.Path, name: str, body_from_world: Array, at: Array, held: bool
    ) -> WorldLink:
        link, content, back = self.links[path], self.content[path], inverse(at)
        mass = None
        if link.moves and not held:
            drawn = [visual.mesh for visual in content.visuals]
            mass = read_mass(self.reader, path, content.solids, drawn).transformed(back)
        return WorldLink(
            name,
            str(path),
            body_from_world @ link.frame @ at,
            mass,
            tuple(distinct([shifted(shape, back) for shape in content.shapes])),
            tuple(distinct([shifted(visual, back) for visual in content.visuals])),
        )


Item = TypeVar("Item", Shape, Visual)


def shifted(item: Item, back: NDArray[np.float64]) -> Item:
    """A shape or a visual in a frame that has the same axes."""
    if not back[:3, 3].any():
        return item
    return replace(item, mesh=replace(item.mesh, points=item.mesh.points + back[:3, 3]))


def distinct(items: Sequence[Item]) -> list[Item]:
    """The same, with a number behind names that repeat."""
    called = unique_names([item.name for item in items])
    return [
        item if item.name == name else replace(item, name=name)
        for item, name in zip(items, called, strict=True)
    ]


def unique_names(wanted: Sequence[str]) -> list[str]:
    """The names, with a number behind those that repeat."""
    taken: set[str] = set()
    return [unique(name, taken) for name in wanted]


def unique(name: str, taken: set[str]) -> str:
    """A name that is not taken yet; it is taken then."""
    found, number = name, 0
    while found in taken:
        number += 1
        found = f"{name}_{number}"
    taken.add(found)
    return found


_SINGLE: Final = "single shapes of it pass through others: these formats know whole links alone"
_GROUP: Final = "it filters a group: only FilteredPairsAPI is read"


def read_filters(
    stage: Usd.Stage,
    bodies: Sequence[Body],
    colliders: Mapping[Sdf.Path, Iterable[Sdf.Path]],
    reader: ShapeReader,
) -> tuple[tuple[LinkName, LinkName], ...]:
    """Links of different bodies that shall not collide.

    A prim stands for all links at and below it, or for the link whose only colliders are at and
    below it.

    Args:
        stage: The composed stage.
        bodies: What was read from it.
        colliders: Of each link, by its prim.
        reader: Receives what is left out.

    Returns:
        Each pair once, in the order of the bodies.
    """
    called = {Sdf.Path(link.path): (body.name, link.name) for body in bodies for link in body.links}
    for prim in stage.Traverse():
        if prim.IsA(UsdPhysics.CollisionGroup):
            reader.lose(prim.GetPath(), "skipped", _GROUP)
    order = {name: number for number, name in enumerate(called.values())}
    found = {}
    for here, there in _said(stage):
        ends = [_links(path, called, colliders) for path in (here, there)]
        for path, end in zip((here, there), ends, strict=True):
            if not end and not _of_one_body(here, there, called):
                reader.lose(path, "skipped", _SINGLE)
        for one, other in product(*ends):
            if one[0] != other[0]:
                first, second = sorted((one, other), key=order.__getitem__)
                found[first, second] = order[first], order[second]
    return tuple(sorted(found, key=found.__getitem__))


def _said(stage: Usd.Stage) -> Iterator[tuple[Sdf.Path, Sdf.Path]]:
    for prim in stage.Traverse(Usd.TraverseInstanceProxies()):
        if prim.HasAPI(UsdPhysics.FilteredPairsAPI):
            for target in UsdPhysics.FilteredPairsAPI(prim).GetFilteredPairsRel().GetTargets():
                yield prim.GetPath(), target


def _links(
    path: Sdf.Path,
    called: Mapping[Sdf.Path, LinkName],
    colliders: Mapping[Sdf.Path, Iterable[Sdf.Path]],
) -> list[LinkName]:
    below = [name for link, name in called.items() if link.HasPrefix(path)]
    holder = _holder(path, called)
    if below or holder is None:
        return below
    whole = all(collider.HasPrefix(path) for collider in colliders[holder])
    return [called[holder]] if whole else []


def _of_one_body(here: Sdf.Path, there: Sdf.Path, called: Mapping[Sdf.Path, LinkName]) -> bool:
    holders = [_holder(path, called) for path in (here, there)]
    return len({called[holder][0] if holder else "" for holder in holders}) == 1


def _holder(path: Sdf.Path, called: Mapping[Sdf.Path, LinkName]) -> Sdf.Path | None:
    """The link that a prim belongs to."""
    prefixes = path.GetPrefixes()
    return next((prefix for prefix in reversed(prefixes) if prefix in called), None)
