"""Numbers that meshes carry: one for all of it, or one at each corner as a picture."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np
from pxr import Usd, UsdGeom

from openrooms_usd.arrays import Array, Floats
from openrooms_usd.rendering.scene.pictures import Picture, Value
from openrooms_usd.rendering.scene.surfaces import CLEAR, Surface
from openrooms_usd.usd.arrays import array_of, flattened
from openrooms_usd.usd.shading.surfaces import PreviewSurface
from openrooms_usd.usd.shapes.meshes import PlacedMesh

# So many blocks of two texels by two are as many as fit into a picture of 4096 by 4096.
_MOST_TRIANGLES: Final = 2048**2


@dataclass(frozen=True, eq=False)
class Paint:
    """Values of a mesh, or a picture of them with the texture coordinates of its triangles.

    Attributes:
        mean: (C,) of all of it: three of a colour, one of an opacity.
        picture: What there is at each corner; None where it is one colour.
        st: (M, 3, 2) where the corners lie in the picture.
        losses: What was approximated.
    """

    mean: tuple[float, ...]
    picture: Picture | None = None
    st: Floats | None = None
    losses: tuple[str, ...] = ()


def paint(mesh: PlacedMesh, name: str) -> Paint | None:
    """What a mesh says in a primvar of colours or of one number, cut to 0..1; None if nothing.

    Colours are scene-linear.

    Args:
        mesh: The mesh; what is the same for all of it may be inherited.
        name: Of the primvar, such as ``displayColor``.
    """
    values = _values(mesh, name)
    if not len(values) or not np.isfinite(values).all():
        return None
    values = np.clip(values, 0.0, 1.0)
    mean = tuple(values.mean(axis=0).tolist())
    if (values == values[0]).all():
        return Paint(mean)
    corners = mesh.mesh.colors.get(name)
    if corners is None or len(corners) > _MOST_TRIANGLES:
        return Paint(mean, losses=(f"its primvars:{name} are taken as their mean",))
    return Paint(mean, *_blocks(np.clip(corners.astype(np.float64), 0.0, 1.0)))


def passed_on(stage: Usd.Stage) -> frozenset[str]:
    """The primvars that prims of a stage may inherit: those that are said elsewhere than of shapes.

    Instances of one prototype differ by these alone.
    """
    begin = "primvars:"
    return frozenset(
        attribute.GetName().removeprefix(begin)
        for root in (stage.GetPseudoRoot(), *stage.GetPrototypes())
        for prim in Usd.PrimRange(root)
        if not prim.IsA(UsdGeom.Gprim)
        for attribute in prim.GetAuthoredPropertiesInNamespace(begin)
    )


def _values(mesh: PlacedMesh, name: str) -> Array:
    """(N, 1 or 3) its own values, those of its instance, or what it inherits; none without any."""
    api = UsdGeom.PrimvarsAPI(mesh.prim)
    tint = dict(mesh.tints).get(name)
    if tint is not None and not api.GetPrimvar(name).HasAuthoredValue():
        return np.array([tint])
    primvar = api.FindPrimvarWithInheritance(name)
    said = flattened(primvar) if primvar else None
    for width in (3, None):
        # One value is not always written as an array of one.
        for whole in (said, [said]):
            values = array_of(whole, np.float64, width)
            if len(values):
                return np.asarray(values.reshape(len(values), -1))
    return np.zeros((0, 3))


def _blocks(colors: Array) -> tuple[Picture, Floats]:
    """A block of two by two texels for each triangle, and where its corners are in the picture.

    Three texels are the corners' numbers. With the fourth on their plane, what is bilinear between
    the centres of texels is linear, as it is in the triangle; nothing of other blocks comes in.
    """
    across = math.ceil(math.sqrt(len(colors)))
    down = -(-len(colors) // across)
    first, second, third = np.moveaxis(colors, 1, 0)
    many = colors.shape[2]
    blocks = np.zeros((down * across, 2, 2, many))
    blocks[: len(colors)] = np.stack(
        [np.stack([first, second], 1), np.stack([third, second + third - first], 1)], 1
    )
    grid = blocks.reshape(down, across, 2, 2, many).swapaxes(1, 2)
    texels = grid.reshape(2 * down, 2 * across, many).astype(np.float32)
    row, column = np.divmod(np.arange(len(colors)), across)
    corner = np.array([[0.5, 0.5], [1.5, 0.5], [0.5, 1.5]])
    at = 2.0 * np.stack([column, row], axis=1)[:, None] + corner
    st = (at / [2.0 * across, 2.0 * down]).astype(np.float32)
    return Picture(texels, wrap="clamp"), st


def paint_over(
    surface: Surface, preview: PreviewSurface, found: Mapping[str, Paint], losses: list[str]
) -> tuple[dict[str, Value], Floats | None]:
    """The fields of a surface with the paint of a mesh applied.

    Args:
        surface: The surface.
        preview: What it was read of.
        found: What is painted, by field.
        losses: Receives what was approximated.

    Returns:
        The fields, and (M, 3, 2) where the mesh lies in pictures among them, if there are any.
    """
    primvars, st = dict(preview.painted), None
    values: dict[str, Value] = {}
    for field, one in found.items():
        picture = one.picture
        # Pictures of the material want other texture coordinates than what is painted.
        if picture is not None and surface.is_textured:
            losses.append(f"its primvars:{primvars[field]} are taken as their mean beside textures")
            picture = None
        else:
            losses += one.losses
        values[field] = _value(field, one.mean, picture, preview.opacity_threshold)
        st = st if picture is None else one.st
        if field == "opacity" and preview.opacity_threshold <= 0.0 and _is_clear(values[field]):
            losses.append(CLEAR)
    return values, st


def _value(
    field: str, mean: tuple[float, ...], picture: Picture | None, threshold: float = 0.0
) -> Value:
    """What a field of a `Surface` becomes by what is painted.

    Args:
        field: Its name; ``base_color`` has three channels, others have one.
        mean: The value where there is no picture.
        picture: The values.
        threshold: Of an opacity that is a mask; 0 if it is not a mask.
    """
    many = 3 if field == "base_color" else 1
    numbers = np.array([mean]) if picture is None else picture.pixels
    if numbers.shape[-1] != many:
        numbers = np.repeat(numbers.mean(axis=-1, keepdims=True), many, axis=-1)
    if field == "opacity" and threshold > 0.0:
        numbers = (numbers >= threshold).astype(np.float32)
    if picture is not None:
        return picture if numbers is picture.pixels else Picture(numbers, wrap=picture.wrap)
    if many == 1:
        return float(numbers[0, 0])
    red, green, blue = numbers[0].tolist()
    return red, green, blue


def _is_clear(opacity: Value) -> bool:
    """Whether an opacity lets anything through."""
    return bool(np.min(opacity.pixels if isinstance(opacity, Picture) else opacity) < 1.0)
