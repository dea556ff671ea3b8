"""Who stands above what: through instances, and through point instancers, whatever is in them."""

from collections.abc import Iterator, Sequence

from pxr import Usd, UsdGeom

from openrooms_usd.usd.places.frames import TIME

Stand = tuple[str, Usd.Prim]
"""A place, and the prim that stands there."""


Key = tuple[str, int, str]


def above(path: str) -> str:
    """The place above one: of an instance of a point instancer the instancer, else the parent's."""
    return path[: path.rindex("[")] if path.endswith("]") else path.rpartition("/")[0]


class Ancestry:
    """The prims of a stage by the places where they stand.

    A place is a prim's path, in which point instancers add the numbers of their instances in
    brackets: ``/World/Scatter[3]/seat``.
    """

    def __init__(self, stage: Usd.Stage) -> None:
        self._stage = stage
        self._known: dict[str, tuple[Stand, ...]] = {"": ()}
        self._which: dict[str, Sequence[int]] = {}

    def of(self, place: str) -> tuple[Stand, ...]:
        """What stands at a place and above it, the nearest first; nothing where nothing stands.

        The parents of a prototype stand above it as far as they are below the instancer; others
        come last: they hold the prototype, and not its instances.
        """
        higher = above(place)
        if higher not in self._known:
            self._known[higher] = self.of(higher)
        outer = self._known[higher]
        if not place.endswith("]"):
            prim = self._child(outer[0][1], place) if outer else self._stage.GetPrimAtPath(place)
            return ((place, prim), *outer) if prim else ()
        prototype = self._prototype(place, outer)
        if not prototype:
            return ()
        instancer = outer[0][1].GetPath()
        inner, others = [(place, prototype)], []
        for parent in _parents(prototype):
            if parent.GetPath().HasPrefix(instancer):
                inner += [(place, parent)] if parent.GetPath() != instancer else []
            elif not instancer.HasPrefix(parent.GetPath()):
                others.append((place, parent))
        return (*inner, *outer, *others)

    def shared(self, place: str) -> tuple[Key, str]:
        """What a place has in common with others, and where the instance begins that it is in.

        Places of equal keys are in instances of one point instancer that show the same, with the
        same prims; the other text is empty where no point instancer made the place.
        """
        head, bracket, tail = place.rpartition("[")
        if not bracket:
            return (place, 0, ""), ""
        number, _, rest = tail.partition("]")
        instancer = UsdGeom.PointInstancer(self.of(head)[0][1]) if head not in self._which else None
        if instancer:
            self._which[head] = instancer.GetProtoIndicesAttr().Get(TIME)
        return (head, self._which[head][int(number)], rest), f"{head}[{number}]"

    def _child(self, parent: Usd.Prim, place: str) -> Usd.Prim:
        path = parent.GetPath().AppendChild(place.rpartition("/")[2])
        return self._stage.GetPrimAtPath(path)

    def _prototype(self, place: str, outer: tuple[Stand, ...]) -> Usd.Prim | None:
        """The root of what an instance of a point instancer is."""
        instancer = UsdGeom.PointInstancer(outer[0][1]) if outer else None
        if not instancer:
            return None
        (_, which, _), _ = self.shared(place)
        targets = instancer.GetPrototypesRel().GetForwardedTargets()
        return self._stage.GetPrimAtPath(targets[which])


def _parents(prim: Usd.Prim) -> Iterator[Usd.Prim]:
    while not (prim := prim.GetParent()).IsPseudoRoot():
        yield prim
