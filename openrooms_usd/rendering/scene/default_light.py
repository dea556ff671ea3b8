"""Light for a stage that has none: most files that people pass on are lit by who shows them."""

from typing import Final

import numpy as np
from pxr import Usd

from openrooms_usd import names
from openrooms_usd.geometry.vectors import unit
from openrooms_usd.rendering.scene.arrays import Environment
from openrooms_usd.rendering.scene.pictures import Array, Picture, Value
from openrooms_usd.usd.light.lightsearch import is_light

BRIGHTEST_FROM: Final[Array] = unit(np.array([-0.35, -0.5, 0.8]))
"""(3,) where the default light comes from, in the world: above, from the front left."""
EXPOSURE: Final = 0.5
"""What pictures in the default light are multiplied by: white that faces it is nearly white."""
TOLD: Final = (
    "the stage has no light: it stands in a default one of 1 nit in the mean, brighter from above "
    "(--no-default-light leaves it dark)"
)

_ROWS: Final = 65
_MOST_OF_A_GLOW_NITS: Final = 1.0


def is_unlit(stage: Usd.Stage) -> bool:
    """Whether nobody says how a stage is lit.

    A light that is off or invisible says it, and so does our own step that writes lights, which may
    write none. What is bright by its material does, too (`merely_glows`).
    """
    if stage.GetPrimAtPath(names.LIGHTS):
        return False
    return not any(
        is_light(prim)
        for root in (stage.GetPseudoRoot(), *stage.GetPrototypes())
        for prim in Usd.PrimRange(root)
    )


def merely_glows(radiance: Value) -> bool:
    """Whether an emission is none that is meant to light the rest.

    Screens and signs of models that are shown in any light have colours up to 1; what shall light a
    scene is brighter.
    """
    most = radiance.pixels.max() if isinstance(radiance, Picture) else np.max(radiance)
    return bool(most <= _MOST_OF_A_GLOW_NITS)


def default_light() -> Environment:
    """The surroundings of a stage that has none: 1 nit in the mean, dark where one looks.

    The radiance in the direction d is 1/4 + 9/16 (1 + c)^2 nits with c = d . BRIGHTEST_FROM. A
    surface with the normal n and nothing around it receives pi (1 + 3/4 c + 3/64 (3 c^2 - 1)) lux
    with c = n . BRIGHTEST_FROM, so that the three sides of a box that one sees at once differ.
    """
    theta = np.linspace(0.0, np.pi, _ROWS)[:, None]
    phi = 2.0 * np.pi * (np.arange(2 * (_ROWS - 1)) + 0.5) / (2 * (_ROWS - 1))
    ways = np.stack(
        [np.sin(theta) * np.sin(phi), np.cos(theta) + 0.0 * phi, -np.sin(theta) * np.cos(phi)], -1
    )
    # The picture's upper edge is the world's +Z.
    upright = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
    nits = 0.25 + 0.5625 * (1.0 + ways @ upright.T @ BRIGHTEST_FROM) ** 2
    pixels = np.repeat(nits[..., None], 3, axis=2).astype(np.float32)
    return Environment(pixels, upright)
