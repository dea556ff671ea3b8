"""The physics stage: gravity, bodies, collision shapes and joints.

The physics of an object is a layer of its own, which its root references above its asset and its
look, so that repeats go on sharing a prototype; see `objects`. That of the room's shell is
written where it is.
"""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Final

from pxr import Sdf, Usd, UsdGeom

from openrooms_usd import names
from openrooms_usd.categories import registry
from openrooms_usd.codedigest import code_digest
from openrooms_usd.description.nearest import did_you_mean
from openrooms_usd.description.physics import Physics
from openrooms_usd.description.room import Room
from openrooms_usd.errors import DescriptionError
from openrooms_usd.stages.base import StageContext
from openrooms_usd.stages.physics.ahead import search_ahead
from openrooms_usd.stages.physics.assets import RigidAsset
from openrooms_usd.stages.physics.authoring import author_physics
from openrooms_usd.stages.physics.colliders import AssetColliders, searches_of
from openrooms_usd.stages.physics.objects import Objects, search_colliders
from openrooms_usd.stages.physics.room import author_room, read_room
from openrooms_usd.usd.bodies import define_scene
from openrooms_usd.usd.layers import apply_metadata, export, is_deactivated, split_arrays

BODIES: Final = "bodies"


class PhysicsStage:
    """Writes ``/World/Physics``, ``/World/Room/Physics``, and bodies over everything else."""

    name = "physics"
    reads: tuple[str, ...] = ("layout", "alignment", "materials")

    def inputs(self, room: Room, source: Path) -> Iterable[str]:
        """None: everything is in the stage."""
        return ()

    def author(self, context: StageContext) -> None:
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
        _check_names(context, section, [root.GetName() for root in roots])
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


def _check_names(context: StageContext, section: Physics, known: Sequence[str]) -> None:
    """Refuse objects that are not there."""
    for name in section.objects:
        if name in known:
            continue
        if is_deactivated(context.stage, f"{names.FURNITURE}/{name}"):
            context.notes.append(f"{name}: deactivated, so it has no physics")
            continue
        raise DescriptionError(
            f"there is no object {name!r}{did_you_mean(name, known)}",
            place=f"physics.objects.{name}",
            remedy=f"there are: {', '.join(known[:30]) or 'none'}",
        )


def _code() -> str:
    """Of the code that bodies hang on; how parts are made stands in the records of categories."""
    return code_digest(__name__, *registry.modules())


def _files(
    context: StageContext, assets: Iterable[RigidAsset]
) -> tuple[dict[int, str], dict[Path, RigidAsset]]:
    """The layer of each asset by its ``id``, and those that are still to be written."""
    code = _code()
    wanted: dict[int, str] = {}
    missing: dict[Path, RigidAsset] = {}
    for asset in assets:
        file = f"{BODIES}/{asset.title}_{asset.digest(code)}.usda"
        wanted[id(asset)] = file
        target = context.keep(file)
        arrays = context.keep(f"{file.removesuffix('.usda')}.usdc")
        if not (target.is_file() and arrays.is_file()):
            missing.setdefault(target, asset)
    return wanted, missing


def _publish(context: StageContext, missing: Mapping[Path, RigidAsset]) -> None:
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
    context: StageContext,
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
                    # Bodies below an instance are none to the standard.
                    prim.instanceable = False
