"""The physics of one material, as its prim shall say it."""

from typing import TYPE_CHECKING

from openrooms_usd.description.substances import Substance
from openrooms_usd.library.friction.references import density, restitution
from openrooms_usd.library.friction.table import friction_of

if TYPE_CHECKING:
    from openrooms_usd.usd.physics import MaterialPhysics

# Coefficients are known to two digits at best.
_DECIMALS = 3


def physics_of(
    substance: Substance, albedo: tuple[float, float, float], roughness: float
) -> "MaterialPhysics":
    """What `openrooms_usd.usd.physics.author` writes on a material.

    Args:
        substance: What it is.
        albedo: Its linear base colour; the mean of its map where it has one.
        roughness: Its perceptual roughness; the mean of its map where it has one.
    """
    from openrooms_usd.usd.physics import MaterialPhysics

    static, dynamic, spread = (
        round(float(value), _DECIMALS) for value in friction_of(substance, albedo, roughness)
    )
    return MaterialPhysics(
        static, dynamic, restitution(substance), density(substance), friction_spread=spread
    )
