"""A stage as one flat USD file with its pictures, for engines that read UsdPhysics.

Isaac Sim (PhysX) and Newton find everything with ``UsdPhysics.LoadUsdPhysicsFromRange``. PhysX
averages coefficients unless told otherwise; here both surfaces ask to be multiplied, and have the
root of what they are, so that a pair has the geometric mean. Collisions between links of one body
are turned off. Dry friction of joints is said in Newton's word, which PhysX reads too, in
articulations.
"""

import hashlib
import re
from collections.abc import Iterator
from itertools import combinations
from pathlib import Path, PurePosixPath
from typing import Any, Final

from pxr import Ar, Sdf, Usd, UsdPhysics

from openrooms_usd import atomic, claims, names
from openrooms_usd.errors import InputError
from openrooms_usd.physics import pair
from openrooms_usd.physics.world import Body, World
from openrooms_usd.usd.bodies import keep_apart
from openrooms_usd.usd.files import layers
from openrooms_usd.usd.places.frames import stated_metres
from openrooms_usd.usd.shading.textures import local_file
from orusd_urdf.checking import check_world
from orusd_urdf.looks import Loss
from orusd_urdf.naming import Names

# What USD calls the prototypes of instances in a flattened layer, numbered as it happened to find
# them, which differs between runs.
_PROTOTYPE: Final = re.compile(r"\bFlattened_Prototype_\d+\b")

# What cannot stay inside an instance.
_OPEN: Final = (UsdPhysics.RigidBodyAPI, UsdPhysics.CollisionAPI)


def flattened(stage: Usd.Stage) -> Sdf.Layer:
    """One layer with everything; instances stay, but those in which something moves or collides.

    Engines write poses where bodies are, and cannot write inside an instance; PhysX finds no
    friction in one (ovphysx 0.7: bindings are not published at the paths of instances' content).

    Args:
        stage: Any stage; it is not changed.
    """
    session = Sdf.Layer.CreateAnonymous(".usda")
    session.TransferContent(stage.GetSessionLayer())
    copy = Usd.Stage.Open(stage.GetRootLayer(), session, stage.GetPathResolverContext())
    copy.SetEditTarget(session)
    while instances := {_outermost(prim) for prim in _hidden(copy)}:
        for path in sorted(instances):
            copy.GetPrimAtPath(path).SetInstanceable(False)
    return ordered(copy.Flatten(addSourceFileComment=False))


def ordered(flat: Sdf.Layer) -> Sdf.Layer:
    """The same layer with prototypes numbered by their first use, and fields by their names.

    Flattening leaves fields in the order of addresses in memory, which a binary file would keep.
    """
    numbers = {name: f"Flattened_Prototype_{i}" for i, name in enumerate(_prototypes(flat), 1)}
    text = _PROTOTYPE.sub(lambda match: numbers.get(match[0], match[0]), flat.ExportToString())
    read = _read(text)
    result = Sdf.Layer.CreateAnonymous(".usda")
    for key in read.pseudoRoot.ListInfoKeys():
        result.pseudoRoot.SetInfo(key, read.pseudoRoot.GetInfo(key))
    shown = [prim.path for prim in read.rootPrims if prim.name not in numbers.values()]
    for path in [*shown, *(Sdf.Path(f"/{name}") for name in numbers.values())]:
        Sdf.CopySpec(read, path, result, path)
    return _read(result.ExportToString())


def _read(text: str) -> Sdf.Layer:
    layer = Sdf.Layer.CreateAnonymous(".usda")
    layer.ImportFromString(text)
    return layer


def _prototypes(flat: Sdf.Layer) -> list[str]:
    """Their names in the order in which the scene, and then they themselves, use them."""
    found: dict[str, None] = {}
    waiting = [prim for prim in flat.rootPrims if not _PROTOTYPE.fullmatch(prim.name)]
    while waiting:
        new = [name for prim in waiting for name in _uses(prim) if name not in found]
        found |= dict.fromkeys(new)
        waiting = [flat.GetPrimAtPath(f"/{name}") for name in dict.fromkeys(new)]
    return list(found)


def _uses(prim: Sdf.PrimSpec) -> Iterator[str]:
    for reference in prim.referenceList.GetAddedOrExplicitItems():
        name = str(reference.primPath).lstrip("/")
        if not reference.assetPath and _PROTOTYPE.fullmatch(name):
            yield name
    for child in prim.nameChildren:
        yield from _uses(child)


def _hidden(stage: Usd.Stage) -> Iterator[Usd.Prim]:
    for prim in stage.Traverse(Usd.TraverseInstanceProxies()):
        if prim.IsInstanceProxy() and any(map(prim.HasAPI, _OPEN)):
            yield prim


def _outermost(prim: Usd.Prim) -> Sdf.Path:
    while prim.IsInstanceProxy():
        prim = prim.GetParent()
    return prim.GetPath()


_TEXTURES: Final = "textures"
# What a flat file no longer has: the assets that it was made of.
_ASSET_INFO: Final = ("identifier", "payloadAssetDependencies")


def gather_files(layer: Sdf.Layer, folder: Path) -> list[Loss]:
    """Copy what inputs of shaders and lights name to ``textures``, and refer to it relatively.

    Other paths of files lead to where the stage came from, and are left out.

    Args:
        layer: A flattened layer, with absolute paths; it is changed.
        folder: Where it will be saved.

    Returns:
        What could not be copied.
    """
    copies = _Copies(folder)
    for spec in layers.attribute_specs(layer):
        if isinstance(spec.default, Sdf.AssetPath):
            if spec.name.startswith("inputs:"):
                spec.default = copies.relative(spec.default, str(spec.path.GetPrimPath()))
            else:
                spec.default = Sdf.AssetPath(PurePosixPath(spec.default.path).name)
    layer.Traverse(Sdf.Path.absoluteRootPath, lambda path: _forget(layer, path))
    return copies.losses


def _forget(layer: Sdf.Layer, path: Sdf.Path) -> None:
    prim = layer.GetPrimAtPath(path) if path.IsPrimPath() else None
    if prim is None or not prim.HasInfo("assetInfo"):
        return
    kept: dict[str, Any] = {
        name: value for name, value in dict(prim.assetInfo).items() if name not in _ASSET_INFO
    }
    prim.SetInfo("assetInfo", kept)


class _Copies:
    """Files that were copied, each content once."""

    def __init__(self, folder: Path) -> None:
        self.losses: list[Loss] = []
        self._folder = folder
        self._names = Names()
        self._by_source: dict[str, Sdf.AssetPath] = {}
        self._by_content: dict[tuple[str, bytes], Sdf.AssetPath] = {}

    def relative(self, asset: Sdf.AssetPath, prim: str) -> Sdf.AssetPath:
        """Where a file lies now; as it was where there is none."""
        if asset.path and asset.path not in self._by_source:
            try:
                with local_file(asset.path) as file:
                    self._by_source[asset.path] = self._copy(asset.path, file.read_bytes())
            except InputError as error:
                self.losses.append((prim, "approximated", f"{asset.path}: {error.message}"))
                self._by_source[asset.path] = Sdf.AssetPath(PurePosixPath(asset.path).name)
        return self._by_source.get(asset.path, asset)

    def _copy(self, source: str, content: bytes) -> Sdf.AssetPath:
        inner = Ar.SplitPackageRelativePathInner(source)[1] or source
        path = PurePosixPath(inner)
        key = path.suffix.lower(), hashlib.sha256(content).digest()
        if key not in self._by_content:
            name = f"{self._names.unique(path.stem)}{path.suffix.lower()}"
            atomic.write_bytes(self._folder / _TEXTURES / name, content)
            self._by_content[key] = Sdf.AssetPath(f"./{_TEXTURES}/{name}")
        return self._by_content[key]


def keep_siblings_apart(flat: Sdf.Layer, world: World) -> None:
    """Apply FilteredPairsAPI to the links of every body that has joints.

    A joint keeps what it joins apart, but not two drawers of one cabinet, and a joint to what never
    moves keeps nothing apart from the colliders there.

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


SCENE: Final = "scene.usdc"

# PhysX has hulls of at most so many points, and makes them smaller.
_MOST_POINTS: Final = 64
_PHYSX_API: Final = "PhysxMaterialAPI"
_NEWTON_API: Final = "NewtonJointAPI"
_NEWTON_FRICTION: Final = "newton:friction"
_MODES: Final = ("physxMaterial:frictionCombineMode", "physxMaterial:restitutionCombineMode")


def write_usdphysics(
    stage: Usd.Stage, world: World, folder: Path, *, roots: bool = True
) -> list[Loss]:
    """Write a stage as ``scene.usdc`` with all files that it needs, all or nothing.

    Instances in which nothing collides stay. The same stage gives the same bytes.

    Args:
        stage: The composed stage, with rigid bodies; it is not changed.
        world: What was read from it.
        folder: It receives the scene and ``textures``.
        roots: Whether coefficients become their roots, to be multiplied.

    Returns:
        What was lost, and what an engine will not do.

    Raises:
        StageError: The world is impossible.
        OutputError: A file cannot be written.
    """
    check_world(world)
    flat = flattened(stage)
    losses = [*_limits(world), *_units(stage)]
    keep_siblings_apart(flat, world)
    _say_friction_of_joints(flat)
    if roots:
        _take_roots(flat)
    with claims.refilling(folder, ".orusd.usdphysics.sha256") as refill:
        losses += gather_files(flat, refill.folder)
        layers.export(ordered(flat), refill.folder / SCENE)
    return losses


def _take_roots(flat: Sdf.Layer) -> None:
    stage = Usd.Stage.Open(flat)
    for prim in Usd.PrimRange.Stage(stage, Usd.PrimAllPrimsPredicate):
        if not prim.HasAPI(UsdPhysics.MaterialAPI):
            continue
        api = UsdPhysics.MaterialAPI(prim)
        for attribute in (
            api.GetStaticFrictionAttr(),
            api.GetDynamicFrictionAttr(),
            api.GetRestitutionAttr(),
        ):
            if attribute.HasAuthoredValue():
                attribute.Set(pair.factor(attribute.Get()))
        prim.AddAppliedSchema(_PHYSX_API)
        for name in _MODES:
            kind = Sdf.ValueTypeNames.Token
            variability = Sdf.VariabilityUniform
            prim.CreateAttribute(name, kind, False, variability).Set("multiply")


def _say_friction_of_joints(flat: Sdf.Layer) -> None:
    stage = Usd.Stage.Open(flat)
    for prim in Usd.PrimRange.Stage(stage, Usd.PrimAllPrimsPredicate):
        friction = prim.GetAttribute(names.JOINT_FRICTION)
        if friction and friction.Get() and prim.IsA(UsdPhysics.Joint):
            prim.AddAppliedSchema(_NEWTON_API)
            kind = Sdf.ValueTypeNames.Float
            prim.CreateAttribute(_NEWTON_FRICTION, kind, False).Set(friction.Get())


def _limits(world: World) -> Iterator[Loss]:
    """What PhysX does otherwise."""
    for body in world.bodies:
        for link in body.links:
            for shape in link.shapes:
                points = len(set(map(tuple, shape.mesh.points.tolist())))
                if points > _MOST_POINTS:
                    reason = f"PhysX keeps {_MOST_POINTS} of the {points} points of its hull"
                    yield f"{link.path}/{shape.name}", "approximated", reason
        for joint in body.joints:
            if joint.friction > 0.0 and body.fixed:
                reason = f"PhysX has no dry friction for {joint.name}, which holds on to the world"
                yield body.path, "approximated", reason


def _units(stage: Usd.Stage) -> Iterator[Loss]:
    found = stated_metres(stage), UsdPhysics.GetStageKilogramsPerUnit(stage)
    if found != (names.METERS_PER_UNIT, names.KILOGRAMS_PER_UNIT):
        yield "/", "approximated", f"its units stay {found[0]:g} m and {found[1]:g} kg"
