"""A stage as one flat USD file with its pictures, for engines that read UsdPhysics.

Isaac Sim (PhysX) and Newton find everything with ``UsdPhysics.LoadUsdPhysicsFromRange``. PhysX
averages coefficients unless told otherwise; here both surfaces ask to be multiplied, and have the
root of what they are, so that a pair has the geometric mean. Links of one body are told not to
collide. Dry friction of joints is said in Newton's word, which PhysX reads too, in articulations.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import Final

from pxr import Sdf, Usd, UsdPhysics

from openrooms_usd import atomic, names
from openrooms_usd.physics import pair
from openrooms_usd.physics.world import World
from openrooms_usd.usd.files import layers
from openrooms_usd.usd.places.frames import stated_metres
from orusd_urdf.checking import check_world
from orusd_urdf.flattening import flattened, ordered
from orusd_urdf.looks import Loss
from orusd_urdf.siblings import keep_siblings_apart
from orusd_urdf.usdfiles import gather_files

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
    with atomic.filling(folder) as beside:
        losses += gather_files(flat, beside)
        layers.export(ordered(flat), beside / SCENE)
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
