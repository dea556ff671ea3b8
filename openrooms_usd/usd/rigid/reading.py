"""Reads any UsdPhysics stage as bodies, links, joints and shapes for engines.

The front end is USD's own parser, which knows how bodies, colliders and joints are found, also
inside instances, and the standard's own rules for masses.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, Final, TypeVar

import numpy as np
from pxr import Kind, Sdf, Usd, UsdPhysics

from openrooms_usd.arrays import Array
from openrooms_usd.errors import StageError
from openrooms_usd.geometry.rotations import inverse
from openrooms_usd.geometry.triangulation import TriangleMesh
from openrooms_usd.physics.mass import MassProperties
from openrooms_usd.physics.world import Body, Joint, Shape, Visual, World
from openrooms_usd.physics.world import Link as WorldLink
from openrooms_usd.usd.rigid.filters import named_links, read_filters
from openrooms_usd.usd.rigid.joints import (
    KINDS,
    UNKNOWN_KINDS,
    Edge,
    Freedom,
    freedoms_of,
    friction_of,
    is_loose,
    joints_of,
    pose,
)
from openrooms_usd.usd.rigid.masses import read_mass
from openrooms_usd.usd.rigid.shapes import Frames, ShapeReader, safe
from openrooms_usd.usd.rigid.trees import Link, Tree, loops, trees, without_loops
from openrooms_usd.usd.semantics import read_category
from openrooms_usd.usd.shapes.meshes import read_meshes

_Type = UsdPhysics.ObjectType
_STILL: Final = "it joins no moving body"
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
        InputError: A mass is negative, or a body has neither mass nor volume.
    """
    found = _PARSE(stage, [Sdf.Path.absoluteRootPath])
    parsed = {kind: list(zip(*rows, strict=True)) for kind, rows in found.items()}
    if not any(parsed.get(kind) for kind in (_Type.RigidBody, *_SHAPES)):
        raise StageError(
            "this stage has no physics: no rigid bodies and no colliders",
            place=place or stage.GetRootLayer().identifier,
            remedy="write `physics: {}` into the description and compose again; for other stages "
            "apply UsdPhysics schemas",
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
        self.moves_as = {
            path: desc
            for path, desc in parsed.get(_Type.RigidBody, ())
            if desc.rigidBodyEnabled and not desc.kinematicBody
        }
        self.moving = set(self.moves_as)
        self.links: dict[Sdf.Path, Link] = {}
        self.content: dict[Sdf.Path, _Content] = {}
        self.anchored: set[Sdf.Path] = set()
        self.inverses: dict[Sdf.Path, Array] = {}

    def world(self) -> World:
        for path in self.moving:
            self._add(path, moves=True)
        self._read_colliders()
        found = list(self._edges())
        self._read_visuals()
        self.links |= {path: replace(self.links[path], moves=False) for path in self.anchored}
        order = {path: number for number, path in enumerate(self.frames.ordered(self.links))}
        links = {path: self.links[path] for path in sorted(self.links, key=order.__getitem__)}
        edges, closing = without_loops(links, list(self._moving(found, links)))
        roots = [p for _, d in self.parsed.get(_Type.Articulation, ()) for p in d.rootPrims]
        taken: set[str] = set()
        bodies = [self._body(tree, taken) for tree in trees(links, edges, roots)]
        for loss in self.seen.losses:
            self.reader.lose(*loss)
        gravity = self.frames.gravity([desc for _, desc in self.parsed.get(_Type.Scene, ())])
        colliders = {path: content.solids for path, content in self.content.items()}
        apart = read_filters(self.stage, bodies, colliders, self.reader)
        called = named_links(bodies)
        closed = tuple(loops(links, closing, called, self.reader))
        known = {*apart, *(pair[::-1] for pair in apart)}
        pairs = (loop.links for loop in closed if loop.links[0][0] != loop.links[1][0])
        apart += tuple(pair for pair in dict.fromkeys(pairs) if pair not in known)
        return World(tuple(bodies), gravity, tuple(self.reader.losses.values()), apart, closed)

    def _moving(self, edges: Iterable[Edge], links: Mapping[Sdf.Path, Link]) -> Iterator[Edge]:
        """Joints of what is not anchored at both ends."""
        for edge in edges:
            if any(links[end].moves for end in edge.links):
                yield edge
            else:
                self.reader.lose(edge.path, "skipped", _STILL)

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
                self.reader.lose(path, "skipped", f"{what}: not a hinge, rail, ball or fixed joint")
        for kind in KINDS:
            for path, desc in self.parsed.get(kind, ()):
                if not desc.jointEnabled:
                    self.reader.lose(path, "skipped", "it is disabled")
                    continue
                ends = [desc.body0, desc.body1]
                if not any(end in self.moving for end in ends):
                    self.reader.lose(path, "skipped", _STILL)
                    continue
                freedoms = freedoms_of(self.frames, kind, desc, self.reader)
                if is_loose(freedoms):
                    self.reader.lose(path, "skipped", "it leaves every direction free")
                elif not freedoms and desc.rel0.isEmpty != desc.rel1.isEmpty:
                    self.anchored.update(end for end in ends if end in self.moving)
                else:
                    yield self._edge(path, freedoms, desc)

    def _edge(self, path: Sdf.Path, freedoms: tuple[Freedom, ...], desc: Any) -> Edge:
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
            is_there = rel.IsPrimPath() and self.stage.GetPrimAtPath(rel)
            if rel and not is_there:
                lost = f"it joins {rel}, which is missing: it is fixed to the world"
                self.reader.lose(path, "approximated", lost)
            named = rel if is_there else path
            fixed = self._add(self._owner(named), moves=False)
            # The standard gives what holds on to nothing that moves in the stage's own frame.
            held = self.frames.rigid(body) if body else self.frames.placed(np.eye(4))
            ends.append((fixed, inverse(self.links[fixed].frame) @ held @ anchor))
        return Edge(
            path,
            (ends[0][0], ends[1][0]),
            (ends[0][1], ends[1][1]),
            freedoms,
            friction_of(self.frames, path, freedoms),
            desc.excludeFromArticulation,
        )

    def _body(self, tree: Tree, taken: set[str]) -> Body:
        base = self.links[tree.links[0]]
        root = self._owner(base.path) if len(tree.links) > 1 else base.path
        called = unique_names([safe(path.name) for path in tree.links])
        named = dict(zip(tree.links, called, strict=True))
        joined = self._joined(tree, named)
        into, fixed = inverse(base.frame), not base.moves
        links = [
            self._link(path, named[path], into, joined[path][1] if path in joined else np.eye(4))
            for path in tree.links
        ]
        steps = {named[path]: joints for path, (joints, _) in joined.items()}
        links = [one for link in links for one in with_between(link, steps.get(link.name, ()))]
        joints = [joint for found in steps.values() for joint in found]
        above = map(self.stage.GetPrimAtPath, reversed(root.GetPrefixes()))
        category = read_category(above) or ""
        name = unique(safe(root.name), taken)
        velocity = self._velocity(base.path)
        place, path = base.frame, str(root)
        return Body(name, path, place, tuple(links), tuple(joints), fixed, category, velocity)

    def _joined(
        self, tree: Tree, named: Mapping[Sdf.Path, str]
    ) -> dict[Sdf.Path, tuple[list[Joint], Array]]:
        """The joints above each link but the base, and its frame in its rigid frame."""
        found = {}
        labels = unique_names([safe(edge.path.name) for _, _, edge, _ in tree.joints])
        used = {*named.values(), *labels}
        moves = {tree.links[0]: self._velocity(tree.links[0])}
        for label, (parent, child, edge, backward) in zip(labels, tree.joints, strict=True):
            frames = (self.links[edge.links[0]].frame, self.links[edge.links[1]].frame)
            told = (label, named[parent], named[child])
            fresh = partial(unique, taken=used)
            joints, at = joints_of(edge, backward, frames, told, fresh, self.reader)
            turn = self.links[child].frame[:3, :3]
            said = self._velocity(child)
            # What says nothing moves as its parent does.
            moves[child] = said if any(way.any() for way in said) else moves[parent]
            linear, angular = np.subtract(moves[child], moves[parent])
            ways = (linear if joint.kind == "rail" else angular for joint in joints)
            speeds = [
                float(way @ turn @ joint.axis) for way, joint in zip(ways, joints, strict=True)
            ]
            found[child] = [replace(j, speed=v) for j, v in zip(joints, speeds, strict=True)], at
        return found

    def _velocity(self, path: Sdf.Path) -> tuple[Array, Array]:
        """What a body says of its first velocity along its parent's axes, m/s and rad/s."""
        desc = self.moves_as.get(path) if self.links[path].moves else None
        if desc is None or not (any(desc.linearVelocity) or any(desc.angularVelocity)):
            return np.zeros(3), np.zeros(3)
        axes = self.frames.world(self.stage.GetPrimAtPath(path).GetParent())[:3, :3]
        linear = axes @ np.array(desc.linearVelocity, dtype=np.float64)
        turn = axes / np.linalg.norm(axes, axis=0)
        return linear, turn @ np.radians(np.array(desc.angularVelocity, dtype=np.float64))

    def _link(self, path: Sdf.Path, name: str, body_from_world: Array, at: Array) -> WorldLink:
        link, content, back = self.links[path], self.content[path], inverse(at)
        mass = None
        if link.moves:
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


# What is between two joints of one child weighs this share of it.
_BETWEEN_SHARE: Final = 1e-5


def with_between(link: WorldLink, joints: Sequence[Joint]) -> Iterator[WorldLink]:
    """A link after the light ones that stand between the joints above it."""
    for joint in joints[:-1]:
        assert link.mass is not None
        light = _BETWEEN_SHARE * link.mass.mass
        round_ = _BETWEEN_SHARE * np.trace(link.mass.inertia) / 3.0 * np.eye(3)
        mass = MassProperties(light, np.zeros(3), round_)
        yield WorldLink(joint.child, "", link.body_from_link, mass, between=True)
    yield link


Item = TypeVar("Item", Shape, Visual)


def shifted(item: Item, back: Array) -> Item:
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
