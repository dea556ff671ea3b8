"""The physics step: gravity, bodies, collision shapes and joints.

The physics of an object is a layer of its own, which its root references above its asset and its
look, so that repeats go on sharing a prototype; see `objects`. That of the room's shell is
written where it is.

Nothing of it moves but the leaves of doors and windows.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import numpy as np
from pxr import Sdf, Usd, UsdGeom, UsdShade

from openrooms_usd import names
from openrooms_usd.codedigest import code_digest
from openrooms_usd.description.room import Room
from openrooms_usd.furniture import registry
from openrooms_usd.geometry.triangulation import TriangleMesh
from openrooms_usd.library.friction import friction_of
from openrooms_usd.library.friction.references import SUBSTANCES
from openrooms_usd.library.styles.assignment.kinds import kind_of
from openrooms_usd.physics.components import Part
from openrooms_usd.physics.panels import panel_pieces, slab_pieces
from openrooms_usd.steps.base import StepContext
from openrooms_usd.steps.materials.appearance import texels
from openrooms_usd.steps.physics.ahead import search_ahead
from openrooms_usd.steps.physics.cache import cached_shapes
from openrooms_usd.steps.physics.colliders import (
    AssetColliders,
    Collider,
    LinkColliders,
    searches_of,
)
from openrooms_usd.steps.physics.layers import pass_layers
from openrooms_usd.steps.physics.objects import Objects, author_physics, search_colliders
from openrooms_usd.steps.physics.parts import RigidAsset, RigidLink, Solid, Substance
from openrooms_usd.usd.bodies import define_scene
from openrooms_usd.usd.files.layers import apply_metadata, export, split_arrays
from openrooms_usd.usd.semantics import read_label
from openrooms_usd.usd.shading.materialreader import read_preview_surface

BODIES: Final = "bodies"
# A level floor or ceiling is treated as convex: no seam stops sliding objects, nothing is beyond.
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


def author_room(context: StepContext, room: BuiltIn) -> None:
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


def _author_shell(context: StepContext, room: RigidAsset) -> None:
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


def _shapes(context: StepContext, room: RigidAsset, solid: Solid) -> list[TriangleMesh]:
    """The convex pieces of a surface of the shell."""
    prim = context.stage.GetPrimAtPath(Sdf.Path(names.ROOM).AppendPath(solid.path))
    category = read_label(prim, names.CATEGORY)
    if category in _LEVEL:
        return slab_pieces(solid.mesh)
    exact = panel_pieces(solid.mesh) if category == "wall" else []
    if exact:
        return exact
    part = Part(solid.name, solid.mesh.points, solid.mesh.triangles)
    found = cached_shapes([part], room.settings.shapes, room.settings.tolerance)
    return [shape.mesh for shape in found.shapes]


def _with_floor_friction(context: StepContext, solid: Solid) -> Solid:
    """A floor with the mean of its friction map; any other surface as it is."""
    if Sdf.Path(names.ROOM).AppendPath(solid.path) != Sdf.Path(names.FLOOR):
        return solid
    made = tuple(_with_texture_friction(context.stage, substance) for substance in solid.substances)
    return replace(solid, substances=made)


def _with_texture_friction(stage: Usd.Stage, made: Substance) -> Substance:
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


class PhysicsStep:
    """Writes ``/World/Physics``, ``/World/Room/Physics``, and bodies over everything else."""

    name = "physics"
    reads: tuple[str, ...] = ("layout", "alignment", "materials")

    def inputs(self, room: Room, source: Path) -> Iterable[str]:
        """None: everything is in the stage."""
        return ()

    def author(self, context: StepContext) -> None:
        """Compute the physics of all objects, publish that of equal ones once, and reference it.

        A room whose description has no ``physics`` gets an empty layer.

        Raises:
            DescriptionError: An object is named that is not there.
            OutputError: A layer cannot be written.
        """
        section = context.room.physics
        if section is None:
            return
        furniture = context.stage.GetPrimAtPath(names.FURNITURE)
        roots = list(furniture.GetChildren()) if furniture else []
        known = [root.GetName() for root in roots]
        context.check_named("physics.objects", known, "so it has no physics")
        UsdGeom.Scope.Define(context.stage, names.PHYSICS)
        define_scene(context.stage, names.PHYSICS_SCENE, section.gravity)
        objects = Objects(section)
        found = objects.read(context.stage, roots)
        room = read_room(context.stage, objects)
        files, missing = _files(context, [asset for asset, _ in found])
        new = (*(room.openings if room else ()), *missing.values())
        search_ahead([each for asset in new for each in searches_of(asset)], context.workers)
        if room:
            author_room(context, room)
        _publish(context, missing)
        _reference(context, found, files)
        pass_layers(context.stage, roots)


def _code(category: str) -> str:
    """Of the code that a body hangs on; how its parts are made stands in its category's record."""
    kind = kind_of(category)
    known = (registry.module_of(kind),) if kind in registry.BUILT else ()
    return code_digest(__name__, *known)


def _files(
    context: StepContext, assets: Iterable[RigidAsset]
) -> tuple[dict[int, str], dict[Path, RigidAsset]]:
    """The layer of each asset by its ``id``, and those that are still to be written."""
    wanted: dict[int, str] = {}
    missing: dict[Path, RigidAsset] = {}
    for asset in assets:
        file = f"{BODIES}/{asset.title}_{asset.digest(_code(asset.category))}.usda"
        wanted[id(asset)] = file
        target = context.keep(file)
        arrays = context.keep(f"{file.removesuffix('.usda')}.usdc")
        if not (target.is_file() and arrays.is_file()):
            missing.setdefault(target, asset)
    return wanted, missing


def _publish(context: StepContext, missing: Mapping[Path, RigidAsset]) -> None:
    """Write the layers of assets, but of those that have no shapes."""
    made = search_colliders(context, missing.values())
    for target, asset in missing.items():
        if id(asset) in made:
            _write(target, asset, made[id(asset)])


def _write(target: Path, asset: RigidAsset, made: AssetColliders) -> None:
    """A light text layer, and its long arrays beside it."""
    layer = Sdf.Layer.CreateAnonymous(".usda")
    apply_metadata(layer)
    stage = Usd.Stage.Open(layer)
    title = "".join(word.capitalize() for word in asset.category.split("_")) or "Object"
    root = stage.OverridePrim(f"/{title}")
    stage.SetDefaultPrim(root)
    author_physics(stage, root.GetPath(), asset, made)
    # A stage would look for the sublayer as soon as it is named.
    del root, stage
    arrays = split_arrays(layer) or _empty()
    beside = target.with_suffix(".usdc")
    export(arrays, beside)
    layer.subLayerPaths.append(f"./{beside.name}")
    export(layer, target)


def _empty() -> Sdf.Layer:
    layer = Sdf.Layer.CreateAnonymous(".usdc")
    apply_metadata(layer)
    return layer


def _reference(
    context: StepContext,
    found: Iterable[tuple[RigidAsset, Sequence[Sdf.Path]]],
    files: Mapping[int, str],
) -> None:
    """Let each root reference its physics, above all else: thousands in one change."""
    layer = context.stage.GetEditTarget().GetLayer()
    with Sdf.ChangeBlock():
        for asset, members in found:
            file = files[id(asset)]
            if not (context.folder / file).is_file():
                continue
            for path in members:
                prim = Sdf.CreatePrimInLayer(layer, path)
                prim.referenceList.Prepend(Sdf.Reference(context.asset(file)))
                if len(asset.links) > 1:
                    # The standard ignores bodies below an instance.
                    prim.instanceable = False
