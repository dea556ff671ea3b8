"""The walk over a stage's surfaces: transforms, visibility, purpose, instances."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from pxr import Sdf, Tf, Usd, UsdGeom

from openrooms_usd.usd.frames import TIME, matrix
from openrooms_usd.usd.gprims import Surface, read_surface

Array = NDArray[np.float64]

# Nothing to draw is below these.
_BARREN: Final = frozenset({"Material", "NodeGraph", "Shader", "GeomSubset"})

# Point instancers may take prototypes that are mere overs or classes.
_PROTOTYPES: Final = Usd.PrimIsActive & Usd.PrimIsLoaded


@dataclass(frozen=True, eq=False, slots=True)
class Part:
    """A surface somewhere below the root of a walk; paths start with a slash, or are empty.

    Attributes:
        path: Where it stands, relative to the root.
        prim: Its prim, relative to the root.
        matrix: (4, 4) to the root's frame.
        surface: What there is to draw.
        anchored: Whether ``matrix`` leads to the stage's frame, whatever is above the root.
    """

    path: str
    prim: str
    matrix: Array
    surface: Surface
    anchored: bool = False


@dataclass(frozen=True, eq=False, slots=True)
class _Scope:
    """What a walk below one root has in common."""

    origin: str  # stripped from the paths of prims
    home: str  # stripped from the paths where they stand
    predicate: object


@dataclass(frozen=True, eq=False, slots=True)
class _Node:
    """A prim that is still to be visited, with what it inherits."""

    prim: Usd.Prim
    matrix: Array
    purpose: UsdGeom.Imageable.PurposeInfo
    anchored: bool


class Walk:
    """Gathers surfaces; each prototype is walked and read once.

    Args:
        purposes: Which ``purpose`` is drawn.
        bare: Whether normals and texture coordinates are left out.
        without: A prim that is left out in silence, with all below it.
    """

    def __init__(
        self, purposes: Sequence[str], *, bare: bool = False, without: str | None = None
    ) -> None:
        self._bare = bare
        self._without = None if without is None else Sdf.Path(without)
        self._purposes = frozenset(purposes)
        self._cache = UsdGeom.XformCache(TIME)
        self._surfaces: dict[str, Surface] = {}
        self._prototypes: dict[tuple[str, str], list[Part]] = {}
        self._open: set[str] = set()

    def stage(self, stage: Usd.Stage) -> list[Part]:
        """Every surface of a stage, in its order, relative to the stage's root."""
        scope = _Scope("", "", Usd.PrimDefaultPredicate)
        children = stage.GetPseudoRoot().GetFilteredChildren(scope.predicate)
        return self._parts(children, scope, UsdGeom.Imageable.PurposeInfo())

    def _parts(
        self, prims: Iterable[Usd.Prim], scope: _Scope, purpose: UsdGeom.Imageable.PurposeInfo
    ) -> list[Part]:
        parts: list[Part] = []
        todo = [_Node(prim, np.eye(4), purpose, False) for prim in reversed(list(prims))]
        while todo:
            node = self._placed(todo.pop())
            if node is None:
                continue
            if node.prim.IsInstance():
                parts += self._instance(node, scope)
            elif node.prim.IsA(UsdGeom.PointInstancer):
                parts += self._scattered(node, scope)
            else:
                parts += self._own(node, scope)
                children = node.prim.GetFilteredChildren(scope.predicate)
                todo += [
                    _Node(child, node.matrix, node.purpose, node.anchored)
                    for child in reversed(children)
                ]
        return parts

    def _placed(self, node: _Node) -> _Node | None:
        """The node with its own transform and purpose; None where nothing below it is seen."""
        prim, purpose = node.prim, node.purpose
        if prim.GetTypeName() in _BARREN or prim.GetPath() == self._without:
            return None
        imageable = UsdGeom.Imageable(prim)
        if imageable:
            if imageable.GetVisibilityAttr().Get(TIME) == UsdGeom.Tokens.invisible:
                return None
            purpose = imageable.ComputePurposeInfo(purpose)
        local, resets = self._cache.GetLocalTransformation(prim)
        own = matrix(local)
        placed = own if resets else node.matrix @ own
        return _Node(prim, placed, purpose, node.anchored or resets)

    def _own(self, node: _Node, scope: _Scope) -> list[Part]:
        if not node.prim.IsA(UsdGeom.Gprim) or node.purpose.purpose not in self._purposes:
            return []
        path = str(node.prim.GetPath())
        if path not in self._surfaces:
            self._surfaces[path] = read_surface(node.prim, bare=self._bare)
        stands, prim = path[len(scope.home) :], path[len(scope.origin) :]
        return [Part(stands, prim, node.matrix, self._surfaces[path], node.anchored)]

    def _instance(self, node: _Node, scope: _Scope) -> list[Part]:
        path = str(node.prim.GetPath())
        return _repeated(
            self._prototype(node.prim.GetPrototype(), node.purpose),
            path[len(scope.home) :],
            path[len(scope.origin) :],
            node,
            node.matrix,
        )

    def _prototype(self, prototype: Usd.Prim, purpose: UsdGeom.Imageable.PurposeInfo) -> list[Part]:
        root = str(prototype.GetPath())
        key = root, purpose.GetInheritablePurpose()
        if key not in self._prototypes:
            scope = _Scope(root, root, Usd.PrimDefaultPredicate)
            children = prototype.GetFilteredChildren(scope.predicate)
            self._prototypes[key] = self._parts(children, scope, purpose)
        return self._prototypes[key]

    def _scattered(self, node: _Node, scope: _Scope) -> list[Part]:
        """A point instancer's prototypes at all of its places."""
        path = str(node.prim.GetPath())
        instancer = UsdGeom.PointInstancer(node.prim)
        stands, prim = path[len(scope.home) :], path[len(scope.origin) :]
        targets = instancer.GetPrototypesRel().GetForwardedTargets()
        found = _places(instancer, len(targets))
        if isinstance(found, str) or path in self._open:
            reason = found if isinstance(found, str) else "a prototype contains its own instancer"
            lost = Surface(None, losses=(("skipped", reason),))
            return [Part(stands, prim, node.matrix, lost)]
        self._open.add(path)
        groups = [
            self._parts(
                filter(None, [node.prim.GetStage().GetPrimAtPath(target)]),
                _Scope(scope.origin, str(target), _PROTOTYPES),
                node.purpose,
            )
            for target in targets
        ]
        self._open.remove(path)
        parts: list[Part] = []
        for number, which, place in found:
            parts += _repeated(groups[which], f"{stands}[{number}]", "", node, node.matrix @ place)
        return parts


def _repeated(parts: list[Part], path: str, prim: str, node: _Node, placed: Array) -> list[Part]:
    """The parts of a prototype where one instance of it stands."""
    if not parts:
        return []
    matrices = placed @ np.array([part.matrix for part in parts])
    return [
        Part(
            path + part.path,
            prim + part.prim,
            part.matrix if part.anchored else own,
            part.surface,
            part.anchored or node.anchored,
        )
        for part, own in zip(parts, matrices, strict=True)
    ]


def _places(
    instancer: UsdGeom.PointInstancer, prototypes: int
) -> list[tuple[int, int, Array]] | str:
    """(number, prototype, (4, 4) to the instancer's frame) of what is seen, or what is wrong."""
    indices = np.asarray(instancer.GetProtoIndicesAttr().Get(TIME) or [], dtype=np.int64)
    if not len(indices):
        return "the point instancer has no instances"
    if indices.min() < 0 or indices.max() >= prototypes:
        return "protoIndices refer to prototypes that do not exist"
    try:
        placed = instancer.ComputeInstanceTransformsAtTime(
            TIME,
            TIME,
            UsdGeom.PointInstancer.ExcludeProtoXform,
            UsdGeom.PointInstancer.IgnoreMask,
        )
    except Tf.ErrorException:
        placed = None
    if placed is None or len(placed) != len(indices):
        return "positions, orientations or scales do not fit protoIndices"
    matrices = np.asarray(placed, dtype=np.float64).swapaxes(1, 2)
    mask = instancer.ComputeMaskAtTime(TIME) or [True] * len(indices)
    rows = zip(indices.tolist(), matrices, mask, strict=True)
    return [(number, *row[:2]) for number, row in enumerate(rows) if row[2]]
