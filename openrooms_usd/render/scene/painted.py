"""Colours that meshes carry themselves: one for all of it, or one at each corner as a picture."""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from pxr import UsdGeom

from openrooms_usd.render.scene.pictures import Picture
from openrooms_usd.usd.arrays import array_of
from openrooms_usd.usd.frames import TIME
from openrooms_usd.usd.meshes import PlacedMesh
from openrooms_usd.usd.surfaces import Color

# So many blocks of two texels by two are as many as fit into a picture of 4096 by 4096.
_MOST_TRIANGLES: Final = 2048**2


@dataclass(frozen=True, eq=False)
class Paint:
    """A colour, or a picture and where its triangles lie in it.

    Attributes:
        color: Of all of it, or the mean.
        picture: What there is at each corner; None where it is one colour.
        st: (M, 3, 2) where the corners lie in the picture.
        losses: What was approximated.
    """

    color: Color
    picture: Picture | None = None
    st: NDArray[np.float32] | None = None
    losses: tuple[str, ...] = ()


def paint(mesh: PlacedMesh, name: str) -> Paint | None:
    """What a mesh says in a primvar of colours, scene-linear, cut to 0..1; None if nothing.

    Args:
        mesh: The mesh; of one colour it may be inherited.
        name: Of the primvar, such as ``displayColor``.
    """
    primvar = UsdGeom.PrimvarsAPI(mesh.prim).FindPrimvarWithInheritance(name)
    values = array_of(primvar.ComputeFlattened(TIME) if primvar else None, np.float64, 3)
    if not len(values) or not np.isfinite(values).all():
        return None
    values = np.clip(values, 0.0, 1.0)
    red, green, blue = values.mean(axis=0).tolist()
    mean = red, green, blue
    if (values == values[0]).all():
        return Paint(mean)
    corners = mesh.mesh.colors.get(name)
    if corners is None or len(corners) > _MOST_TRIANGLES:
        return Paint(mean, losses=(f"its primvars:{name} are taken as their mean",))
    return Paint(mean, *_blocks(np.clip(corners.astype(np.float64), 0.0, 1.0)))


def _blocks(colors: NDArray[np.float64]) -> tuple[Picture, NDArray[np.float32]]:
    """A block of two by two texels for each triangle, and where its corners are in the picture.

    Three texels are the corners' colours. With the fourth on their plane, what is bilinear between
    the centres of texels is linear, as it is in the triangle; nothing of other blocks comes in.
    """
    across = math.ceil(math.sqrt(len(colors)))
    down = -(-len(colors) // across)
    first, second, third = np.moveaxis(colors, 1, 0)
    blocks = np.zeros((down * across, 2, 2, 3))
    blocks[: len(colors)] = np.stack(
        [np.stack([first, second], 1), np.stack([third, second + third - first], 1)], 1
    )
    grid = blocks.reshape(down, across, 2, 2, 3).swapaxes(1, 2)
    texels = grid.reshape(2 * down, 2 * across, 3).astype(np.float32)
    row, column = np.divmod(np.arange(len(colors)), across)
    corner = np.array([[0.5, 0.5], [1.5, 0.5], [0.5, 1.5]])
    at = 2.0 * np.stack([column, row], axis=1)[:, None] + corner
    st = (at / [2.0 * across, 2.0 * down]).astype(np.float32)
    return Picture(texels, wrap="clamp"), st
