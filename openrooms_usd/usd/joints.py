"""Joints: how a part of an object moves against the rest."""

from typing import Literal

from pxr import Gf, Sdf, Usd

from openrooms_usd import names


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
