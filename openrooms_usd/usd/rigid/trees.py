"""The trees that joints make of links, and the joints that close loops in them."""

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from pxr import Sdf

from openrooms_usd.arrays import Array
from openrooms_usd.physics.world import LinkName, Loop
from openrooms_usd.usd.rigid.joints import Edge, positions
from openrooms_usd.usd.rigid.shapes import ShapeReader

# How far the points lie apart by which a loop holds a hinge, or the whole of two links, metres.
_ARM: Final = 0.1


@dataclass(frozen=True, eq=False)
class Link:
    """A rigid piece before it is put into a tree.

    Attributes:
        path: Its prim.
        moves: Whether it is a body of its own.
        frame: (4, 4) its rigid frame in the world.
    """

    path: Sdf.Path
    moves: bool
    frame: Array


@dataclass(frozen=True, eq=False)
class Tree:
    """Links that joints hold together.

    Attributes:
        links: The base first, each after its parent.
        joints: (parent, child, joint, whether body1 is the parent).
    """

    links: tuple[Sdf.Path, ...]
    joints: tuple[tuple[Sdf.Path, Sdf.Path, Edge, bool], ...]


def trees(
    links: Mapping[Sdf.Path, Link], edges: Sequence[Edge], roots: Collection[Sdf.Path]
) -> Iterator[Tree]:
    """Take links and joints apart into trees, each with its base.

    Args:
        links: In the order of the stage.
        edges: Joints between them, without loops.
        roots: Authored roots of articulations.
    """
    beside: dict[Sdf.Path, list[Edge]] = {path: [] for path in links}
    for edge in edges:
        for end in edge.links:
            beside[end].append(edge)
    children = {edge.links[1] for edge in edges}
    order = sorted(links, key=lambda path: (links[path].moves, path not in roots, path in children))
    found: dict[Sdf.Path, Tree] = {}
    taken: set[Sdf.Path] = set()
    for base in order:
        if base not in taken:
            tree = _grow_tree(base, beside)
            taken.update(tree.links)
            found[base] = tree
    yield from (found[path] for path in links if path in found)


def without_loops(
    links: Mapping[Sdf.Path, Link], edges: Sequence[Edge]
) -> tuple[list[Edge], list[Edge]]:
    """The joints that make trees, and those that close loops.

    What never moves counts as one. A loop is opened where the stage says so, else at a ball, else
    at a hinge, which points can replace, and of several at the last one.
    """
    group: dict[Sdf.Path, Sdf.Path] = {
        path: Sdf.Path.absoluteRootPath for path, link in links.items() if not link.moves
    }

    def top(path: Sdf.Path) -> Sdf.Path:
        while path in group:
            path = group[path]
        return path

    kept, closing = list[Edge](), list[Edge]()
    for edge in sorted(edges, key=lambda edge: (edge.excluded, -(_pins(edge) or 4))):
        first, second = (top(end) for end in edge.links)
        (closing if first == second else kept).append(edge)
        if first != second:
            # What never moves stays on top.
            low, high = sorted((first, second), key=lambda one: one.IsAbsoluteRootPath())
            group[low] = high
    order = {edge.path: number for number, edge in enumerate(edges)}
    kept.sort(key=lambda edge: order[edge.path])
    return kept, sorted(closing, key=lambda edge: order[edge.path])


def loops(
    links: Mapping[Sdf.Path, Link],
    edges: Sequence[Edge],
    called: Mapping[Sdf.Path, LinkName],
    reader: ShapeReader,
) -> Iterator[Loop]:
    """Joints that close loops, as pairs of points that stay together; losses are reported."""
    for edge in edges:
        pins = _pins(edge)
        if not pins:
            what = (
                "it closes a loop and slides, or turns about two axes: loops close only at points"
            )
            reader.lose(edge.path, "skipped", what)
            continue
        if any(np.isfinite(f.limits).any() or f.damping or f.drive for f in edge.freedoms):
            what = "it closes a loop: its limits, damping and drive are lost"
            reader.lose(edge.path, "approximated", what)
        frames = (links[edge.links[0]].frame, links[edge.links[1]].frame)
        positions(edge, frames, reader)
        at = frames[1] @ edge.anchors[1]
        arms = np.roll(np.eye(3), -edge.freedoms[0].axis if pins == 2 else 0, axis=0)
        away = np.array([np.zeros(3), *arms])[:pins] * _ARM
        points = away @ at[:3, :3].T + at[:3, 3]
        yield Loop(str(edge.path), (called[edge.links[0]], called[edge.links[1]]), points)


def _pins(edge: Edge) -> int:
    """By how many points two links that a joint joins stay together; 0 where none can say it."""
    slides = any(not freedom.turns for freedom in edge.freedoms)
    return {0: 3, 1: 2, 3: 1}.get(len(edge.freedoms), 0) if not slides else 0


def _grow_tree(base: Sdf.Path, beside: Mapping[Sdf.Path, Sequence[Edge]]) -> Tree:
    order, joints, waiting = [base], [], [base]
    while waiting:
        parent = waiting.pop(0)
        for edge in beside[parent]:
            backward = edge.links[1] == parent
            child = edge.links[0] if backward else edge.links[1]
            if child not in order:
                order.append(child)
                waiting.append(child)
                joints.append((parent, child, edge, backward))
    return Tree(tuple(order), tuple(joints))
