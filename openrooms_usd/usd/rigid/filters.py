"""What of a stage passes through each other, as pairs of links."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import product
from typing import Final

from pxr import Sdf, Usd, UsdPhysics

from openrooms_usd.physics.world import Body, LinkName
from openrooms_usd.usd.rigid.shapes import ShapeReader

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
    called = named_links(bodies)
    for prim in stage.Traverse():
        if prim.IsA(UsdPhysics.CollisionGroup):
            reader.lose(prim.GetPath(), "skipped", _GROUP)
    order = {name: number for number, name in enumerate(called.values())}
    found = set()
    for here, there in _filtered_pairs(stage):
        ends = [_links(path, called, colliders) for path in (here, there)]
        for path, end in zip((here, there), ends, strict=True):
            if not end and not _of_one_body(here, there, called):
                reader.lose(path, "skipped", _SINGLE)
        for one, other in product(*ends):
            if one[0] != other[0]:
                first, second = sorted((one, other), key=order.__getitem__)
                found.add((first, second))
    return tuple(sorted(found, key=lambda pair: [order[link] for link in pair]))


def named_links(bodies: Iterable[Body]) -> dict[Sdf.Path, LinkName]:
    """The names of what the stage has a prim of, by its path."""
    every = ((body.name, link) for body in bodies for link in body.links)
    return {Sdf.Path(link.path): (body, link.name) for body, link in every if link.path}


def _filtered_pairs(stage: Usd.Stage) -> Iterator[tuple[Sdf.Path, Sdf.Path]]:
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
