"""How texture coordinates lie on a surface: how dense they are, and how they stretch pictures.

A triangle's map from the surface to the texture is linear. Its two singular values say how long a
metre is in the texture along the most and the least dense direction. See Sander, Snyder, Gortler
and Hoppe, "Texture Mapping Progressive Meshes", SIGGRAPH 2001, section 3: their greatest stretch is
one over our least density.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.geometry.mesh import Mesh

# A triangle so much thinner in the texture than the mean, in some direction, has no area there.
_NO_AREA_RATIO: Final = 1e-3
# The part of the surface whose densities do not represent the rest: slivers.
_OUTLIER_SHARE: Final = 1e-3
# What coordinates may have to be of use: the part of the area without a place in the texture, ...
MOST_FOLDED: Final = 0.01
# ... the stretch, which an even one of 1 : 2.8 reaches, ...
MOST_STRETCH: Final = 1.25
# ... and the texture's length for a metre, beyond which rounding or a wrong unit is at work.
DENSITIES: Final = (1e-4, 1e4)


@dataclass(frozen=True)
class UvQuality:
    """What texture coordinates do to a picture; surfaces count by their area.

    Attributes:
        finite: Whether all of them are numbers; if not, nothing below means anything.
        density: Length in the texture for a metre: the root of the ratio of the areas.
        least: The density along the least dense direction, of all but the least 0.1 % of the
            surface.
        greatest: The density along the densest direction, of all but the greatest 0.1 %.
        stretch: Sander's L2 norm, 1 for a map that only scales, else more; folded triangles left
            out.
        folded: The part of the surface that has no area in the texture.
    """

    finite: bool
    density: float
    least: float
    greatest: float
    stretch: float
    folded: float

    @property
    def fault(self) -> str:
        """Why they are of no use; empty where they are."""
        if not self.finite:
            return "they are not finite"
        if self.folded > MOST_FOLDED:
            return f"{100 * self.folded:.3g} % of the surface has no place in the texture"
        if not DENSITIES[0] <= self.density <= DENSITIES[1]:
            return f"a metre is {self.density:.3g} long in the texture"
        if self.stretch > MOST_STRETCH:
            return f"they stretch pictures (L2 {self.stretch:.3g}, at most {MOST_STRETCH:g})"
        return ""


def densities(mesh: Mesh) -> tuple[Array, Array]:
    """Length in the texture for a metre on the surface, in the two extreme directions.

    Args:
        mesh: A mesh with texture coordinates.

    Returns:
        (M, 2) the singular values of each triangle's map, the greater first, 0 on triangles
        without an area; and (M,) the triangles' areas, square metres.
    """
    assert mesh.st is not None
    corners, _ = mesh.triangles()
    a, b, c = np.moveaxis(mesh.points[mesh.indices[corners]], 1, 0)
    at, bt, ct = np.moveaxis(mesh.st[corners].astype(np.float64), 1, 0)
    along, other = b - a, c - a
    length = np.linalg.norm(along, axis=1)
    areas = 0.5 * np.linalg.norm(np.cross(along, other), axis=1)
    flat = (areas == 0.0) | (length == 0.0)
    length, height = np.where(flat, 1.0, length), np.where(flat, 1.0, 2.0 * areas)
    across = height / length
    shear = np.einsum("ij,ij->i", along, other) / length
    # The columns of the Jacobian in the frame (along, across) of the triangle's plane.
    first = (bt - at) / length[:, None]
    second = ((ct - at) - first * shear[:, None]) / across[:, None]
    values = _singular_values(first, second)
    values[flat] = 0.0
    return values, np.where(flat, 0.0, areas)


def _singular_values(first: Array, second: Array) -> Array:
    """(M, 2) of the matrices with these columns; the lesser by the determinant, which is exact."""
    squares = (first**2).sum(axis=1) + (second**2).sum(axis=1)
    determinant = np.abs(first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0])
    # (s1 + s2)^2 and (s1 - s2)^2.
    total = np.sqrt(squares + 2.0 * determinant)
    apart = np.sqrt(np.maximum(squares - 2.0 * determinant, 0.0))
    greatest = 0.5 * (total + apart)
    least = determinant / np.where(greatest > 0.0, greatest, 1.0)
    return np.stack([greatest, least], axis=1)


def uv_quality(mesh: Mesh) -> UvQuality:
    """Measure the texture coordinates of a mesh.

    Args:
        mesh: A mesh with texture coordinates and an area, metres.
    """
    assert mesh.st is not None
    if not np.isfinite(mesh.st).all():
        return UvQuality(False, 0.0, 0.0, 0.0, np.inf, 1.0)
    values, areas = densities(mesh)
    surface = float(areas.sum())
    texture = float((areas * values[:, 0] * values[:, 1]).sum())
    if not surface or not texture:
        return UvQuality(True, 0.0, 0.0, 0.0, np.inf, 1.0)
    density = float(np.sqrt(texture / surface))
    laid = (areas > 0.0) & (values[:, 1] > _NO_AREA_RATIO * density)
    return UvQuality(
        finite=True,
        density=density,
        least=_quantile(values[:, 1], areas, _OUTLIER_SHARE),
        greatest=_quantile(values[:, 0], areas, 1.0 - _OUTLIER_SHARE),
        stretch=_stretch(values[laid], areas[laid]),
        folded=1.0 - float(areas[laid].sum()) / surface,
    )


def _quantile(values: Array, areas: Array, part: float) -> float:
    """The value that a part of the area does not exceed."""
    order = np.argsort(values, kind="stable")
    covered = np.cumsum(areas[order])
    return float(values[order[np.searchsorted(covered, part * covered[-1])]])


def _stretch(values: Array, areas: Array) -> float:
    """Sander's L2 of a mesh, equations 2 and 4, at equal areas of surface and texture."""
    surface = float(areas.sum())
    if not surface:
        return np.inf
    texture = float((areas * values[:, 0] * values[:, 1]).sum())
    squares = 0.5 * (values**-2.0).sum(axis=1)
    return float(np.sqrt((squares * areas).sum() / surface * texture / surface))
