"""Links of one body that overlap at rest do not collide: what the standard must be told.

A joint keeps what it joins apart, but not two drawers of one cabinet, and a joint to what never
moves keeps nothing apart from the colliders there.
"""

from collections.abc import Iterator
from itertools import combinations

from pxr import Sdf, Usd, UsdPhysics

from openrooms_usd.physics.world import Body, World
from openrooms_usd.usd.bodies import keep_apart


def keep_siblings_apart(flat: Sdf.Layer, world: World) -> None:
    """Apply FilteredPairsAPI to the links of every body that has joints.

    Args:
        flat: The layer, which is changed.
        world: What was read from the stage that it shows.
    """
    stage = Usd.Stage.Open(flat)
    for body in world.bodies:
        # Robots are bodies that the stage does not show.
        paths = (Sdf.Path(link.path) for link in body.links if link.path)
        links = [path for path in paths if stage.GetPrimAtPath(path)]
        for one, other in combinations(links, 2):
            # What holds another comes first in a body, and what moves says it.
            keep_apart(stage.GetPrimAtPath(other), _colliding(stage, one, body))


def _colliding(stage: Usd.Stage, path: Sdf.Path, body: Body) -> Iterator[Sdf.Path]:
    """A body that moves, or the colliders of one that does not."""
    prim = stage.GetPrimAtPath(path)
    if prim.HasAPI(UsdPhysics.RigidBodyAPI):
        yield path
        return
    below = {Sdf.Path(link.path) for link in body.links if link.path} - {path}
    walk = iter(Usd.PrimRange(prim, Usd.TraverseInstanceProxies()))
    for found in walk:
        if found.GetPath() in below:
            walk.PruneChildren()
        elif found.HasAPI(UsdPhysics.CollisionAPI):
            yield found.GetPath()
