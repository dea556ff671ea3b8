"""The walk over a stage's surfaces: transforms, visibility, purpose, instances."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np
from pxr import Sdf, Tf, Usd, UsdGeom

from openrooms_usd.arrays import Array
from openrooms_usd.usd.arrays import array_of, flattened, integers
from openrooms_usd.usd.places.frames import TIME, local_to_parent
from openrooms_usd.usd.shapes.gprims import GprimSurface, read_surface

if TYPE_CHECKING:
    from openrooms_usd.usd.shapes.subdivided import Topologies

Tints = tuple[tuple[str, tuple[float, ...]], ...]

TINTS: Final[Mapping[str, int]] = {"displayColor": 3, "displayOpacity": 1}
"""Primvars that an instancer may have for each of its instances, and how wide they are."""

# Of more different ones the values are rounded to so many steps.
_MOST_TINTS: Final = 128
_TINT_STEPS: Final = 4

# Nothing to draw is below these.
_BARREN: Final = frozenset({"Material", "NodeGraph", "Shader", "GeomSubset"})

# Point instancers may take prototypes that are mere overs or classes.
_PROTOTYPES: Final = Usd.PrimIsActive & Usd.PrimIsLoaded


@dataclass(frozen=True, eq=False, slots=True)
class DrawnSurface:
    """A surface somewhere below the root of a walk; paths start with a slash, or are empty.

    Attributes:
        path: Where it stands, relative to the root.
        prim: Its prim, relative to the root.
        matrix: (4, 4) to the root's frame.
        surface: What there is to draw.
        anchored: Whether ``matrix`` leads to the stage's frame, whatever is above the root.
        foreign: Whether ``prim`` is a path of the stage, whatever is above the root.
        tints: What point instancers say of this one of their instances, by primvar (`TINTS`).
    """

    path: str
    prim: str
    matrix: Array
    surface: GprimSurface
    anchored: bool = False
    foreign: bool = False
    tints: Tints = ()


@dataclass(frozen=True, eq=False, slots=True)
class _Scope:
    """What a walk below one root has in common."""

    origin: str  # stripped from the paths of prims
    home: str  # stripped from the paths where they stand
    predicate: object
    foreign: bool = False  # whether the prims lie outside the root

    def at(self, target: str) -> "_Scope":
        """Of a prototype of a point instancer; instances may take one from outside their root."""
        foreign = self.foreign or not target.startswith(f"{self.origin}/")
        return _Scope("" if foreign else self.origin, target, _PROTOTYPES, foreign)


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
        self._surfaces: dict[str, GprimSurface] = {}
        self._prototypes: dict[tuple[str, str], list[DrawnSurface]] = {}
        self._open: set[str] = set()
        self._topologies: Topologies | None = None

    def stage(self, stage: Usd.Stage) -> list[DrawnSurface]:
        """Every surface of a stage, in its order, relative to the stage's root."""
        scope = _Scope("", "", Usd.PrimDefaultPredicate)
        children = stage.GetPseudoRoot().GetFilteredChildren(scope.predicate)
        return self._parts(children, scope, UsdGeom.Imageable.PurposeInfo())

    def _parts(
        self, prims: Iterable[Usd.Prim], scope: _Scope, purpose: UsdGeom.Imageable.PurposeInfo
    ) -> list[DrawnSurface]:
        parts: list[DrawnSurface] = []
        todo = [_Node(prim, np.eye(4), purpose, False) for prim in reversed(list(prims))]
        while todo:
            node, wrong = self._placed(todo.pop())
            if node is None:
                continue
            if wrong:
                path = str(node.prim.GetPath())
                lost = GprimSurface(None, losses=(("approximated", wrong),))
                parts.append(
                    DrawnSurface(
                        path[len(scope.home) :], path[len(scope.origin) :], node.matrix, lost
                    )
                )
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

    def _placed(self, node: _Node) -> tuple[_Node | None, str]:
        """The node with its own transform and purpose, and what is wrong with the transform.

        None where nothing below it is seen.
        """
        prim, purpose = node.prim, node.purpose
        if prim.GetTypeName() in _BARREN or prim.GetPath() == self._without:
            return None, ""
        imageable = UsdGeom.Imageable(prim)
        if imageable:
            if imageable.GetVisibilityAttr().Get(TIME) == UsdGeom.Tokens.invisible:
                return None, ""
            purpose = imageable.ComputePurposeInfo(purpose)
        own, resets, wrong = local_to_parent(prim, self._cache)
        placed = own if resets else node.matrix @ own
        return _Node(prim, placed, purpose, node.anchored or resets), wrong

    def _own(self, node: _Node, scope: _Scope) -> list[DrawnSurface]:
        if not node.prim.IsA(UsdGeom.Gprim) or node.purpose.purpose not in self._purposes:
            return []
        path = str(node.prim.GetPath())
        if path not in self._surfaces:
            self._surfaces[path] = self._read(node.prim)
        stands, prim = path[len(scope.home) :], path[len(scope.origin) :]
        surface = self._surfaces[path]
        return [DrawnSurface(stands, prim, node.matrix, surface, node.anchored, scope.foreign)]

    def _read(self, prim: Usd.Prim) -> GprimSurface:
        if self._topologies is None and _may_be_refined(prim):
            # It is imported here, since most stages have none and scipy is slow to import.
            from openrooms_usd.usd.shapes.subdivided import Topologies

            self._topologies = Topologies()
        return read_surface(prim, bare=self._bare, topologies=self._topologies)

    def _instance(self, node: _Node, scope: _Scope) -> list[DrawnSurface]:
        path = str(node.prim.GetPath())
        return _repeated(
            self._prototype(node.prim.GetPrototype(), node.purpose),
            path[len(scope.home) :],
            path[len(scope.origin) :],
            node,
            node.matrix,
            foreign=scope.foreign,
        )

    def _prototype(
        self, prototype: Usd.Prim, purpose: UsdGeom.Imageable.PurposeInfo
    ) -> list[DrawnSurface]:
        root = str(prototype.GetPath())
        key = root, purpose.GetInheritablePurpose()
        if key not in self._prototypes:
            scope = _Scope(root, root, Usd.PrimDefaultPredicate)
            children = prototype.GetFilteredChildren(scope.predicate)
            self._prototypes[key] = self._parts(children, scope, purpose)
        return self._prototypes[key]

    def _scattered(self, node: _Node, scope: _Scope) -> list[DrawnSurface]:
        """A point instancer's prototypes at all of its places."""
        path = str(node.prim.GetPath())
        instancer = UsdGeom.PointInstancer(node.prim)
        stands, prim = path[len(scope.home) :], path[len(scope.origin) :]
        targets = instancer.GetPrototypesRel().GetForwardedTargets()
        found = instances_of(instancer, len(targets))
        if isinstance(found, str) or path in self._open:
            reason = found if isinstance(found, str) else "a prototype contains its own instancer"
            lost = GprimSurface(None, losses=(("skipped", reason),))
            return [DrawnSurface(stands, prim, node.matrix, lost, foreign=scope.foreign)]
        self._open.add(path)
        groups = [
            self._parts(
                filter(None, [node.prim.GetStage().GetPrimAtPath(target)]),
                scope.at(str(target)),
                node.purpose,
            )
            for target in targets
        ]
        self._open.remove(path)
        parts: list[DrawnSurface] = []
        tints, told = _tints(instancer, len(integers(instancer.GetProtoIndicesAttr())))
        if told:
            lost = GprimSurface(None, losses=(("approximated", told),))
            parts.append(DrawnSurface(stands, prim, node.matrix, lost, foreign=scope.foreign))
        for number, which, place in found:
            parts += _repeated(
                groups[which],
                f"{stands}[{number}]",
                "",
                node,
                node.matrix @ place,
                tints=tints[number] if tints else (),
            )
        return parts


def _may_be_refined(prim: Usd.Prim) -> bool:
    mesh = UsdGeom.Mesh(prim)
    return bool(mesh) and mesh.GetSubdivisionSchemeAttr().Get(TIME) != UsdGeom.Tokens.none


def _repeated(
    parts: list[DrawnSurface],
    path: str,
    prim: str,
    node: _Node,
    placed: Array,
    *,
    foreign: bool = False,
    tints: Tints = (),
) -> list[DrawnSurface]:
    """The parts of a prototype where one instance of it stands."""
    if not parts:
        return []
    matrices = placed @ np.array([part.matrix for part in parts])
    return [
        DrawnSurface(
            path + part.path,
            part.prim if part.foreign else prim + part.prim,
            part.matrix if part.anchored else own,
            part.surface,
            part.anchored or node.anchored,
            part.foreign or foreign,
            part.tints or tints,
        )
        for part, own in zip(parts, matrices, strict=True)
    ]


def _tints(instancer: UsdGeom.PointInstancer, count: int) -> tuple[list[Tints], str]:
    """What the instancer says of each of its instances, if anything, and what was approximated."""
    found: list[list[tuple[str, tuple[float, ...]]]] = []
    told = ""
    for name, width in TINTS.items():
        primvar = UsdGeom.PrimvarsAPI(instancer).GetPrimvar(name)
        values = array_of(
            flattened(primvar) if primvar else None, np.float64, width if width > 1 else None
        )
        if len(values) == count > 1 and np.isfinite(values).all():
            rows = np.clip(values.reshape(count, width), 0.0, 1.0)
            if len(np.unique(rows, axis=0)) > _MOST_TINTS:
                # Each is a surface of its own, and instances of one share their triangles.
                rows = np.round(rows * _TINT_STEPS) / _TINT_STEPS
                told = f"primvars:{name} of its instances are rounded to {_TINT_STEPS} steps"
            found.append([(name, tuple(row)) for row in rows.tolist()])
    return [tuple(row) for row in zip(*found, strict=True)] if found else [], told


_UNFIT: Final = "positions, orientations or scales do not fit protoIndices"


def has_whole_rows(
    instancer: UsdGeom.PointInstancer, count: int, when: Usd.TimeCode = TIME
) -> bool:
    """Whether there are turns and factors for all of so many instances, or none.

    USD itself reads on behind the end of arrays that are shorter.
    """
    turns = instancer.GetOrientationsfAttr(), instancer.GetOrientationsAttr()
    return all(
        len(array_of(attribute.Get(when), np.float64, width)) in (0, count)
        for attribute, width in (*((one, 4) for one in turns), (instancer.GetScalesAttr(), 3))
    )


def instances_of(
    instancer: UsdGeom.PointInstancer, prototypes: int
) -> list[tuple[int, int, Array]] | str:
    """(number, prototype, (4, 4) to the instancer's frame) of what is seen, or what is wrong.

    Args:
        instancer: It.
        prototypes: How many prototypes it has.
    """
    indices = integers(instancer.GetProtoIndicesAttr())
    if not len(indices):
        return "the point instancer has no instances"
    if indices.min() < 0 or indices.max() >= prototypes:
        return "protoIndices refer to prototypes that do not exist"
    if not has_whole_rows(instancer, len(indices)):
        return _UNFIT
    try:
        placed = instancer.ComputeInstanceTransformsAtTime(
            TIME, TIME, UsdGeom.PointInstancer.ExcludeProtoXform, UsdGeom.PointInstancer.IgnoreMask
        )
    except Tf.ErrorException:
        placed = None
    if placed is None or len(placed) != len(indices):
        return _UNFIT
    matrices = np.asarray(placed, dtype=np.float64).swapaxes(1, 2)
    mask = instancer.ComputeMaskAtTime(TIME) or [True] * len(indices)
    if len(mask) != len(indices):
        return "ids do not fit protoIndices"
    rows = zip(indices.tolist(), matrices, mask, strict=True)
    return [(number, *row[:2]) for number, row in enumerate(rows) if row[2]]
