"""Physics of materials: UsdPhysicsMaterialAPI, and how sure its friction is."""

from dataclasses import dataclass
from typing import Literal

from pxr import Gf, Sdf, Usd, UsdPhysics

from openrooms_usd import names


@dataclass(frozen=True)
class MaterialPhysics:
    """What a contact and a mass need of a material.

    Attributes:
        static_friction: Coulomb coefficient at rest, dry, against a usual counterface.
        dynamic_friction: The same while sliding; at most the static one.
        restitution: Speed after a bounce by the speed before it, 0 to 1.
        density: kg/m3; 0 where it is not known, as the standard has it.
        friction_spread: Standard deviation of the static coefficient; None if unknown.
    """

    static_friction: float
    dynamic_friction: float
    restitution: float
    density: float
    friction_spread: float | None = None


def author(prim: Usd.Prim, physics: MaterialPhysics) -> None:
    """Author the physics of a material beside its looks, for all who read UsdPhysics.

    Args:
        prim: A Material prim; the edit target receives the opinions.
        physics: What to author.

    Raises:
        ValueError: The standard does not allow a number.
    """
    _check(physics)
    api = UsdPhysics.MaterialAPI.Apply(prim)
    api.CreateStaticFrictionAttr(physics.static_friction)
    api.CreateDynamicFrictionAttr(physics.dynamic_friction)
    api.CreateRestitutionAttr(physics.restitution)
    # The standard counts masses in the stage's units; our layers are in metres and kilograms.
    api.CreateDensityAttr(physics.density)
    if physics.friction_spread is not None:
        # Without the plugin of our schemas this is what applying one writes.
        prim.AddAppliedSchema(names.MATERIAL_API)
        kind = Sdf.ValueTypeNames.Float
        spread = prim.CreateAttribute(names.MATERIAL_FRICTION_SPREAD, kind, custom=False)
        spread.Set(physics.friction_spread)


def _check(physics: MaterialPhysics) -> None:
    # A NaN is not at least anything.
    if not 0.0 <= physics.dynamic_friction <= physics.static_friction < float("inf"):
        raise ValueError(f"no friction: {physics}")
    if not (0.0 <= physics.restitution <= 1.0 and 0.0 <= physics.density < float("inf")):
        raise ValueError(f"no restitution or density: {physics}")
    spread = physics.friction_spread
    if spread is not None and not 0.0 <= spread < float("inf"):
        raise ValueError(f"no spread: {physics}")


def read(prim: Usd.Prim) -> MaterialPhysics | None:
    """The physics of a material; None where it has none.

    What a file leaves out is the standard's default, 0. Nothing that a file holds raises.

    Args:
        prim: A Material prim of any stage.
    """
    if not prim.HasAPI(UsdPhysics.MaterialAPI):
        return None
    api = UsdPhysics.MaterialAPI(prim)
    spread = prim.GetAttribute(names.MATERIAL_FRICTION_SPREAD)
    value = spread.Get() if spread else None
    return MaterialPhysics(
        static_friction=_number(api.GetStaticFrictionAttr()),
        dynamic_friction=_number(api.GetDynamicFrictionAttr()),
        restitution=_number(api.GetRestitutionAttr()),
        density=_number(api.GetDensityAttr()),
        friction_spread=float(value) if isinstance(value, float) else None,
    )


def _number(attribute: Usd.Attribute) -> float:
    """An attribute's value, 0 where it holds no finite, positive number."""
    value = attribute.Get() if attribute else None
    return value if isinstance(value, float) and 0.0 < value < float("inf") else 0.0


def read_category(prim: Usd.Prim) -> str | None:
    """What a material is made of, as `names.MATERIAL_CATEGORY` says; None where nothing does."""
    attribute = prim.GetAttribute(names.MATERIAL_CATEGORY)
    value = attribute.Get() if attribute else None
    return str(value) if value else None


def author_joint(
    prim: Usd.Prim,
    kind: Literal["hinge", "rail"],
    axis: tuple[float, float, float],
    limits: tuple[float, float],
) -> None:
    """Say on an Xform, whose origin is the pivot, how it moves.

    Args:
        prim: The Xform.
        kind: ``hinge`` turns about the axis, ``rail`` slides along it.
        axis: Unit vector in the frame of the prim; hinges turn counter-clockwise about it.
        limits: The range from how it is built, degrees or metres.
    """
    prim.AddAppliedSchema(names.JOINT_API)
    values = (
        (names.JOINT_TYPE, Sdf.ValueTypeNames.Token, kind),
        (names.JOINT_AXIS, Sdf.ValueTypeNames.Float3, Gf.Vec3f(*axis)),
        (names.JOINT_LOWER, Sdf.ValueTypeNames.Float, limits[0]),
        (names.JOINT_UPPER, Sdf.ValueTypeNames.Float, limits[1]),
    )
    for name, type_name, value in values:
        prim.CreateAttribute(name, type_name, custom=False).Set(value)
