"""The physics of the room itself: floor, ceiling, walls around their openings, frames and leaves.

Nothing of it moves but the leaves of doors and windows.
"""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from pxr import Sdf, Usd, UsdShade

from openrooms_usd import names
from openrooms_usd.geometry.triangulation import TriangleMesh
from openrooms_usd.library.friction import friction_of
from openrooms_usd.library.friction.references import SUBSTANCES
from openrooms_usd.physics.components import Part
from openrooms_usd.physics.panels import panel_pieces, slab_hull
from openrooms_usd.stages.base import StageContext
from openrooms_usd.stages.materials.appearance import texels
from openrooms_usd.stages.physics.assets import RigidAsset
from openrooms_usd.stages.physics.authoring import author_physics
from openrooms_usd.stages.physics.cache import cached_shapes
from openrooms_usd.stages.physics.colliders import Collider, LinkColliders
from openrooms_usd.stages.physics.objects import Objects, search_colliders
from openrooms_usd.stages.physics.parts import RigidLink, Solid, Substance
from openrooms_usd.usd.materialreader import read_preview_surface
from openrooms_usd.usd.semantics import read_label

# A floor and a ceiling are treated as convex: no seam stops sliding objects, and nothing is beyond.
_LEVEL: Final = frozenset({"floor", "ceiling"})
# Parts of openings that are thinner than what shapes are true to.
_BOARDS: Final = frozenset({"casing", "threshold"})
_DECIMALS: Final = 3


@dataclass(frozen=True, eq=False)
class BuiltIn:
    """What is of the building.

    Attributes:
        shell: Walls, floor and ceiling, and their openings with them.
        openings: What stands in the openings, one by one.
    """

    shell: RigidAsset
    openings: tuple[RigidAsset, ...]


def read_room(stage: Usd.Stage, objects: Objects) -> BuiltIn | None:
    """The room without its furniture; None where a stage has none."""
    room = Sdf.Path(names.ROOM)
    if not stage.GetPrimAtPath(room):
        return None
    openings = stage.GetPrimAtPath(names.OPENINGS)
    paths = [prim.GetPath() for prim in openings.GetChildren()] if openings else []
    assets = [_bare(_built_in(objects.asset(stage, path, room))) for path in paths]
    found = tuple(asset for asset in assets if any(link.solids for link in asset.links))
    return BuiltIn(_built_in(objects.asset(stage, room, room)), found)


def author_room(context: StageContext, room: BuiltIn) -> None:
    """Write colliders of the shell, and bodies of what moves in its openings."""
    made = search_colliders(context, room.openings)
    _author_shell(context, room.shell)
    for asset in room.openings:
        if id(asset) in made:
            author_physics(context.stage, asset.root, asset, made[id(asset)], Sdf.Path(names.ROOM))


def _built_in(asset: RigidAsset) -> RigidAsset:
    """Frames are static and stay open: one hull of a frame would fill it."""
    return replace(asset, fixed=True, settings=replace(asset.settings, shapes="auto"))


def _bare(opening: RigidAsset) -> RigidAsset:
    """An opening without the thin boards around it, which carry nothing."""
    links = tuple(
        replace(link, solids=tuple(solid for solid in link.solids if solid.name not in _BOARDS))
        for link in opening.links
    )
    return replace(opening, links=links)


def _author_shell(context: StageContext, room: RigidAsset) -> None:
    # So are boards along the walls and tiles.
    apart = tuple(
        f"{path.removeprefix(names.ROOM + '/')}/" for path in (names.OPENINGS, names.TRIM)
    )
    solids = [
        _with_floor_friction(context, solid)
        for link in room.links
        if link.joint is None
        for solid in link.solids
        if not solid.path.startswith(apart)
    ]
    colliders = [
        Collider(f"{_name(solid)}_{number}", shape, solid)
        for solid in solids
        for number, shape in enumerate(_shapes(context, room, solid))
    ]
    link = LinkColliders(RigidLink(".", tuple(solids)), tuple(colliders), ())
    shell = replace(room, links=(link.link,))
    author_physics(context.stage, room.root, shell, (link,), room.root)


def _name(solid: Solid) -> str:
    """A surface's own name; what lies beyond an opening has its whole path, to differ."""
    beyond = f"{names.BEYOND.removeprefix(names.ROOM + '/')}/"
    return solid.path.replace("/", "_") if solid.path.startswith(beyond) else solid.name


def _shapes(context: StageContext, room: RigidAsset, solid: Solid) -> list[TriangleMesh]:
    """The convex pieces of a surface of the shell."""
    prim = context.stage.GetPrimAtPath(Sdf.Path(names.ROOM).AppendPath(solid.path))
    category = read_label(prim, names.CATEGORY)
    if category in _LEVEL:
        return [slab_hull(solid.mesh)]
    exact = panel_pieces(solid.mesh) if category == "wall" else []
    if exact:
        return exact
    part = Part(solid.name, solid.mesh.points, solid.mesh.triangles)
    found = cached_shapes([part], room.settings.shapes, room.settings.tolerance)
    return [shape.mesh for shape in found.shapes]


def _with_floor_friction(context: StageContext, solid: Solid) -> Solid:
    """A floor with the mean of its friction map; any other surface as it is."""
    if Sdf.Path(names.ROOM).AppendPath(solid.path) != Sdf.Path(names.FLOOR):
        return solid
    made = tuple(_meant(context.stage, substance) for substance in solid.substances)
    return replace(solid, substances=made)


def _meant(stage: Usd.Stage, made: Substance) -> Substance:
    prim = stage.GetPrimAtPath(made.material) if made.material else None
    if prim is None or made.physics is None or made.category not in SUBSTANCES:
        return made
    surface, _ = read_preview_surface(UsdShade.Material(prim))
    found = friction_of(made.category, *texels(surface))
    # All texels have the same size on the floor.
    static, dynamic = (
        round(float(np.mean(values)), _DECIMALS) for values in (found.static, found.dynamic)
    )
    known = replace(made.physics, static_friction=static, dynamic_friction=dynamic)
    return Substance(None, "floor", known)
