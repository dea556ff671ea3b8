"""How far a CAD may be scaled and still be the thing that it is.

A CAD of known size may be 0.6 to 1.6 times as long along each axis, one of unknown unit as much off
the proportions that it has. What the library builds anew has sizes of its own: a table of 0.4 to
8 m is one, a table of 5 cm is none.
"""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.scan.models.cad import CadModel

Array = NDArray[np.float64]

SCALES: Final = (0.6, 1.6)
"""The least and the greatest scale along an axis."""
CAD_UNITS_M: Final = (1.0, 0.001, 0.01, 0.0254)
"""The units that CADs are in."""


def sizes_of(model: CadModel, upright: Array, size: Array) -> Array:
    """(2, 3) the least and the greatest size of a CAD, upright, metres.

    Args:
        model: The CAD.
        upright: (3, 3) signed permutation from its axes to Z up.
        size: (3,) along its upright axes as it was measured, by which a unit is guessed, metres.
    """
    if model.sizes is not None:
        return model.sizes
    own = np.maximum(np.abs(upright) @ np.ptp(model.extent, axis=0), 1e-9)
    unit = model.unit or float(np.exp(np.median(np.log(np.maximum(size, 1e-9) / own))))
    return np.asarray(np.outer(SCALES, own * unit))


def may_have(model: CadModel, upright: Array, size: Array) -> bool:
    """Whether a CAD, turned by quarters, may have a size (3,), metres.

    The points of an object bound its size from below: of what was seen from one side, the lesser
    of the level sides is not known.
    """
    for turned in (size, size[[1, 0, 2]]):
        least, most = sizes_of(model, upright, turned)
        known = np.array([turned[0] >= turned[1], turned[1] > turned[0], True])
        if (turned <= most).all() and (turned >= least)[known].all():
            return True
    return False
