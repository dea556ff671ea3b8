"""Every light of a stage: of its prims, of instances, and of what point instancers scatter."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any, Final

from pxr import Sdf, Usd, UsdGeom, UsdLux

from openrooms_usd.arrays import Array
from openrooms_usd.usd.light.emitters import Light
from openrooms_usd.usd.light.lightreader import read_light
from openrooms_usd.usd.places.frames import TIME, local_to_parent, local_to_world, world_from_stage
from openrooms_usd.usd.shapes.traversal import instances_of

Matrix = Array

_PROXIES: Final = Usd.TraverseInstanceProxies()
# Prototypes of point instancers may be mere overs or classes.
_PROTOTYPES: Final = Usd.TraverseInstanceProxies(Usd.PrimIsActive & Usd.PrimIsLoaded)
_SEEN: Final = (UsdGeom.Tokens.default_, UsdGeom.Tokens.render)


def read_lights(stage: Usd.Stage) -> list[Light]:
    """Every light of a stage that can be seen, those inside instances too.

    Args:
        stage: Any stage, with any up axis and unit.

    Returns:
        The lights in the order of the stage; those of unknown kinds as
        `UnknownLight`. One of a point instancer's prototypes is there
        for each instance, its path with the instance's number in brackets.
    """
    return list(_Search(stage).lights())


def is_light(prim: Usd.Prim) -> bool:
    """Whether a prim sends light: a portal only guides the sampling of a dome."""
    return bool(prim.HasAPI(UsdLux.LightAPI)) and not prim.IsA(UsdLux.PortalLight)


@dataclass(frozen=True, eq=False)
class _Instance:
    """Where a prototype of a point instancer stands.

    Attributes:
        path: Of the instance, with its number in brackets.
        root: The prototype.
        matrix: (4, 4) to the stage's frame, of the frame that the prototype stands in.
    """

    path: str
    root: Sdf.Path
    matrix: Matrix


class _Search:
    """Walks a stage; prototypes without lights are looked through once."""

    def __init__(self, stage: Usd.Stage) -> None:
        self._stage = stage
        self._cache = UsdGeom.XformCache(TIME)
        self._lit: dict[Sdf.Path, bool] = {}
        self._open: set[Sdf.Path] = set()
        self._shapes: set[Sdf.Path] = set()

    def lights(self) -> Iterator[Light]:
        walk = iter(Usd.PrimRange.Stage(self._stage))
        for prim in walk:
            if not prim.IsInstance():
                yield from self._own(prim, walk)
            elif self._has_lights(prim.GetPrototype()):
                inside = iter(Usd.PrimRange(prim, _PROXIES))
                for proxy in inside:
                    yield from self._own(proxy, inside)

    def _own(self, prim: Usd.Prim, walk: Any) -> Iterator[Light]:
        """What a prim shines itself; a walk does not go into point instancers."""
        if prim.IsA(UsdGeom.PointInstancer):
            walk.PruneChildren()
            if _is_seen(prim):
                matrix = local_to_world(prim, self._cache)
                yield from self._scattered(prim, str(prim.GetPath()), matrix)
        elif is_light(prim) and _is_seen(prim):
            yield read_light(prim)

    def _has_lights(self, prototype: Usd.Prim) -> bool:
        """Whether there is any light in what instances share, or a point instancer with some."""
        path = prototype.GetPath()
        if path not in self._lit:
            self._lit[path] = any(
                is_light(prim) or prim.IsA(UsdGeom.PointInstancer)
                for prim in Usd.PrimRange(prototype, _PROTOTYPES)
            )
        return self._lit[path]

    def _scattered(self, instancer: Usd.Prim, path: str, matrix: Matrix) -> Iterator[Light]:
        """The lights of a point instancer's prototypes, at all of its places."""
        targets = UsdGeom.PointInstancer(instancer).GetPrototypesRel().GetForwardedTargets()
        roots = [self._stage.GetPrimAtPath(target) for target in targets]
        lit = {number for number, root in enumerate(roots) if root and self._has_lights(root)}
        found = instances_of(UsdGeom.PointInstancer(instancer), len(targets)) if lit else ""
        if isinstance(found, str) or instancer.GetPath() in self._open:
            return
        self._open.add(instancer.GetPath())
        for number, which, place in found:
            if which in lit:
                root = roots[which]
                where = _Instance(f"{path}[{number}]", root.GetPath(), matrix @ place)
                yield from self._of_prototype(root, where)
        self._open.remove(instancer.GetPath())

    def _of_prototype(self, root: Usd.Prim, where: _Instance) -> Iterator[Light]:
        todo = [(root, where.matrix)]
        while todo:
            prim, above = todo.pop()
            image = UsdGeom.Imageable(prim)
            if image and image.GetVisibilityAttr().Get(TIME) == UsdGeom.Tokens.invisible:
                continue
            own, resets, _ = local_to_parent(prim, self._cache)
            matrix = own if resets else above @ own
            path = where.path + str(prim.GetPath())[len(str(where.root)) :]
            if prim.IsA(UsdGeom.PointInstancer):
                yield from self._scattered(prim, path, matrix)
                continue
            if is_light(prim) and _purpose(prim) in _SEEN:
                if not prim.IsA(UsdGeom.Gprim):
                    light = read_light(prim, world_from_stage(self._stage) @ matrix)
                    yield replace(light, path=path, source=str(prim.GetPath()))
                elif prim.GetPath() not in self._shapes:
                    # What a shape emits is read once: it is drawn wherever the shape is.
                    self._shapes.add(prim.GetPath())
                    yield read_light(prim)
            children = prim.GetFilteredChildren(_PROTOTYPES)
            todo += [(child, matrix) for child in reversed(children)]


def _is_seen(prim: Usd.Prim) -> bool:
    shown = UsdGeom.Imageable(prim)
    if not shown:
        return True
    return shown.ComputeVisibility(TIME) != UsdGeom.Tokens.invisible and _purpose(prim) in _SEEN


def _purpose(prim: Usd.Prim) -> str:
    shown = UsdGeom.Imageable(prim)
    return str(shown.ComputePurpose()) if shown else UsdGeom.Tokens.default_
