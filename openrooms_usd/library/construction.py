"""What parts weigh, what of a room can be moved, and what it takes to move a door or a drawer."""

from typing import Final, Literal

from numpy.typing import ArrayLike

from openrooms_usd.codedigest import remembered
from openrooms_usd.description.substances import Substance
from openrooms_usd.furniture.construction import ANY, BOARD, GENERAL, Construction, Row
from openrooms_usd.furniture.record import JointDamping, Support
from openrooms_usd.furniture.registry import record
from openrooms_usd.library.friction.references import density
from openrooms_usd.library.styles.assignment.kinds import kind_of, known_as
from openrooms_usd.physics.inertia import shell, solid
from openrooms_usd.physics.mass import MassProperties

# What hangs there is screwed on.
_HUNG: Final = frozenset({"ceiling", "wall"})
# Assumed, within what is known: at the handle nothing takes more than the 22 N (5 lbf) that
# accessible doors, drawers and cupboards may (ADA Standards 2010, 309.4 and 404.2.9). A drawer with
# 10 kg on rollers (rolling resistance 0.02 to 0.03) takes 2 to 3 N; lids of laptops stay where they
# are put; lids of toilets fall slowly.
_RAIL: Final = JointDamping(damping=10.0, friction=3.0)
_HINGE: Final = JointDamping(damping=0.1, friction=0.1)


def construction_of(category: str, part: str, substance: Substance | None) -> Construction:
    """How a part is made.

    Args:
        category: What it is part of; any word.
        part: Its name or kind; any word.
        substance: What it shows; None if unknown.
    """
    return _row(kind_of(category), kind_of(part), substance).construction


def density_of(substance: Substance | None) -> float:
    """kg/m3 of a part of one material; of paint, and of the unknown, that of the board under it."""
    return BOARD if substance in (None, "paint") else density(substance)


def mass_of_part(
    category: str, part: str, substance: Substance | None, points: ArrayLike, triangles: ArrayLike
) -> MassProperties:
    """Mass, centre and inertia of a part from its mesh and from what it is.

    Args:
        category: What it is part of; any word.
        part: Its name or kind, such as ``leg`` or ``Leg_2``; any word.
        substance: What it shows; None if unknown.
        points: (N, 3) metres.
        triangles: (M, 3) rows of ``points``.

    Raises:
        InputError: The mesh is broken or has no surface.
    """
    made = construction_of(category, part, substance)
    weight = density_of(substance) if made.density is None else made.density
    weigh = shell if made.kind == "shell" else solid
    return weigh(points, triangles, weight, made.wall)


def movable(category: str, mounting: Support | None = None) -> bool:
    """Whether a thing is a rigid body of its own, or fixed to the building.

    Args:
        category: What it is; any word.
        mounting: What carries it; what hangs on a wall or a ceiling is fixed.
    """
    known = record(kind_of(category))
    return not (known and known.fixed) and mounting not in _HUNG


def tolerance_of(category: str, usual: float) -> float:
    """How far the collision shapes of a category may be off, metres: leaves and drapes farther."""
    known = record(kind_of(category))
    return max(usual, known.collision_softness) if known else usual


def lies_under(category: str) -> bool:
    """Whether a category is a layer that gives way below what stands on the same support."""
    known = record(kind_of(category))
    return bool(known and known.lies_under)


def joint_damping_of(category: str, kind: Literal["hinge", "rail"]) -> JointDamping:
    """Default damping and friction of the hinges or rails of a category."""
    known = record(kind_of(category))
    return _RAIL if kind == "rail" else (known and known.joint_damping) or _HINGE


@remembered
def _row(category: str, part: str, substance: Substance | None) -> Row:
    known = record(category)
    rows = (*(known.construction if known else ()), *GENERAL)
    for name in (*known_as(part), ANY):
        for row in rows:
            if name in row.parts and (not row.substances or substance in row.substances):
                return row
    raise AssertionError("the last row fits everything")
