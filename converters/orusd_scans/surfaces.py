"""A mesh as a cloud: its vertices, and samples of large triangles; polygons as triangles."""

from dataclasses import replace
from typing import Any, Final

import numpy as np

from openrooms_usd.arrays import Array, Floats, Ints
from openrooms_usd.geometry.vectors import UP, unit
from openrooms_usd.scan.points.cloud import Cloud

Faces = Ints

# Spacing of samples, metres; larger where there would be too many.
SPACING_M: Final = 0.02
_MOST_SAMPLES: Final = 2_000_000
_MAX_COORDINATE_M: Final = 1e8


def as_cloud(
    cloud: Cloud, faces: Faces, spacing: float = SPACING_M
) -> tuple[Cloud, tuple[str, ...]]:
    """Vertices and surface samples of a mesh as one cloud; normals follow the triangles' winding.

    Each triangle gets area / spacing^2 uniform samples, stochastically rounded; a dense mesh gets
    few. They have the colour, label and instance of the nearest corner.

    Args:
        cloud: The mesh's points, metres.
        faces: (F, 3) rows of points.
        spacing: Metres.

    Returns:
        The cloud, and a note where points had to be farther apart.
    """
    corners = cloud.points[faces]
    usable = np.isfinite(corners).all(axis=(1, 2)) & (np.abs(corners) < _MAX_COORDINATE_M).all(
        axis=(1, 2)
    )
    faces, corners = faces[usable], corners[usable]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    twice = np.linalg.norm(cross, axis=1)
    notes: tuple[str, ...] = ()
    if (wanted := 0.5 * twice.sum() / spacing**2) > _MOST_SAMPLES:
        spacing *= float(np.sqrt(wanted / _MOST_SAMPLES))
        notes = (f"points on large triangles are {100 * spacing:.1f} cm apart, to keep them few",)
    rng = np.random.default_rng(0)
    count = np.floor(0.5 * twice / spacing**2 + rng.random(len(faces))).astype(np.int64)
    owner = np.repeat(np.arange(len(faces)), count)
    weights = _barycentric(rng.random((len(owner), 2)))
    nearest = faces[owner, np.argmax(weights, axis=1)]
    normals = cross / np.where(twice > 0.0, twice, 1.0)[:, None]
    samples = replace(
        cloud.take(nearest),
        points=np.einsum("nc,nci->ni", weights, corners[owner]),
        normals=normals[owner].astype(np.float32),
    )
    if cloud.normals is None:
        cloud = replace(cloud, normals=_smooth(len(cloud), faces, cross))
    return _joined(cloud, samples), notes


def _barycentric(random: Array) -> Array:
    """(N, 3) uniform on a triangle (Osada et al., "Shape Distributions", 2002, equation 1)."""
    root = np.sqrt(random[:, 0])
    return np.column_stack([1.0 - root, root * (1.0 - random[:, 1]), root * random[:, 1]])


def _smooth(count: int, faces: Faces, cross: Array) -> Floats:
    """(N, 3) normals of points: the mean of their triangles', by area; +Z without any."""
    sums = np.column_stack(
        [np.bincount(faces.reshape(-1), np.repeat(cross[:, axis], 3), count) for axis in range(3)]
    )
    return unit(sums.astype(np.float64), UP).astype(np.float32)


def _joined(first: Cloud, second: Cloud) -> Cloud:
    def both(name: str) -> Any:
        values = getattr(first, name)
        return None if values is None else np.concatenate([values, getattr(second, name)])

    names = ("points", "normals", "colors", "label", "instance", "confidence")
    return replace(first, **{name: both(name) for name in names})


def fans(corners: Ints) -> Ints:
    """Polygons as fans of triangles.

    Args:
        corners: (P, C) of polygons that have as many each.

    Returns:
        (F, 3) triangles; none for two corners or fewer.
    """
    found = [corners[:, [0, i, i + 1]] for i in range(1, corners.shape[1] - 1)]
    return np.concatenate(found) if found else np.empty((0, 3), np.int64)
