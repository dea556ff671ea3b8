"""The shipped table of friction over albedo and roughness, and how it is read."""

from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from openrooms_usd.arrays import Floats
from openrooms_usd.description.substances import Substance
from openrooms_usd.library.friction.mapping import Friction, Mapping
from openrooms_usd.library.friction.references import SUBSTANCES, density, references, restitution

if TYPE_CHECKING:
    from openrooms_usd.usd.shading.physics import MaterialPhysics

FILE: Final = Path(__file__).with_name("table.npy")
# Nodes of each albedo component, dense where small differences show; nodes of roughness.
ALBEDO: Final = tuple((node / 6) ** 2 for node in range(7))
ROUGHNESS: Final = (0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0)
SHAPE: Final = (len(SUBSTANCES) + 1, *[len(ALBEDO)] * 3, len(ROUGHNESS), len(Friction._fields))
_TABLE_DECIMALS: Final = 4
# Pixels that are interpolated at a time, which bounds the memory of large pictures.
_PIXELS_AT_A_TIME: Final = 2**17

Array = NDArray[np.floating[Any]]


def built() -> Floats:
    """Make the table from the references.

    Returns:
        `SHAPE` float32: substance in the order of `SUBSTANCES` and then the unknown one, albedo R,
        G and B, roughness, and static, dynamic, spread; rounded, so that machines agree.
    """
    mapping = Mapping(references())
    red, green, blue, roughness = np.meshgrid(*[ALBEDO] * 3, ROUGHNESS, indexing="ij")
    albedo = np.stack([red, green, blue], axis=-1)
    metal = mapping.codes("metal", albedo, roughness)
    other = mapping.codes("wood", albedo, roughness)  # as of all substances but metals
    known = [
        np.stack(mapping.friction_of_codes(s, metal if s == "metal" else other), axis=-1)
        for s in SUBSTANCES
    ]
    unknown = np.broadcast_to(np.stack(mapping.unknown()), known[0].shape)
    return np.stack([*known, unknown]).round(_TABLE_DECIMALS).astype(np.float32)


@cache
def _shipped() -> Floats:
    return cast("Floats", np.load(FILE, allow_pickle=False))


def friction_of(substance: Substance | None, albedo: ArrayLike, roughness: ArrayLike) -> Friction:
    """The friction of materials by what they are and how they look, from the shipped table.

    Interpolated linearly between the nodes: continuous, and never beyond its neighbours.

    Args:
        substance: What they are; None if unknown: then looks have no effect, and the spread is that
            of all substances.
        albedo: (..., 3) linear base colour, of metals too; clipped to 0..1, NaN counts as 0.
        roughness: (...,) perceptual; likewise.

    Returns:
        Static, dynamic and spread, each of the broadcast shape (...,).
    """
    A, R = np.asarray(albedo, np.float64), np.asarray(roughness, np.float64)
    shape = np.broadcast_shapes(A.shape[:-1], R.shape)
    A = np.broadcast_to(A, (*shape, 3)).reshape(-1, 3)
    R = np.broadcast_to(R, shape).reshape(-1)
    number = len(SUBSTANCES) if substance is None else SUBSTANCES.index(substance)
    table = _shipped()[number]
    found = np.empty((len(R), len(Friction._fields)))
    for start in range(0, len(R), _PIXELS_AT_A_TIME):
        part = slice(start, start + _PIXELS_AT_A_TIME)
        found[part] = _interpolated(table, A[part], R[part])
    return Friction(*(column.reshape(shape) for column in found.T))


def _interpolated(table: Array, albedo: Array, roughness: Array) -> Array:
    """(P, channels) between the nodes of a (7, 7, 7, 11, channels) table."""
    # One axis after the other: each halves the corners that are left.
    axes = [(ALBEDO, albedo[:, 0]), (ALBEDO, albedo[:, 1]), (ALBEDO, albedo[:, 2])]
    places = [_place(nodes, values) for nodes, values in [*axes, (ROUGHNESS, roughness)]]
    lows = [low for low, _ in places]
    total = np.zeros((len(roughness), table.shape[-1]))
    for corner in np.ndindex(2, 2, 2, 2):
        shares = [t if up else 1.0 - t for (_, t), up in zip(places, corner, strict=True)]
        index = tuple(low + up for low, up in zip(lows, corner, strict=True))
        total += np.prod(shares, axis=0)[:, None] * table[index]
    return total


def _place(nodes: tuple[float, ...], values: Array) -> tuple[NDArray[np.intp], Array]:
    """The node below each value, and where between it and the next it lies, 0 to 1."""
    known = np.asarray(nodes)
    inside = np.clip(np.nan_to_num(values), known[0], known[-1])
    low = np.clip(np.searchsorted(known, inside, side="right") - 1, 0, len(known) - 2)
    return low, (inside - known[low]) / (known[low + 1] - known[low])


# Coefficients are known to two digits at best.
_DECIMALS = 3


def physics_of(
    substance: Substance, albedo: tuple[float, float, float], roughness: float
) -> "MaterialPhysics":
    """What `openrooms_usd.usd.shading.physics.author` writes on a material.

    Args:
        substance: What it is.
        albedo: Its linear base colour; the mean of its map where it has one.
        roughness: Its perceptual roughness; the mean of its map where it has one.
    """
    from openrooms_usd.usd.shading.physics import MaterialPhysics

    static, dynamic, spread = (
        round(float(value), _DECIMALS) for value in friction_of(substance, albedo, roughness)
    )
    return MaterialPhysics(
        static, dynamic, restitution(substance), density(substance), friction_spread=spread
    )
