"""A depth camera that projects a pattern of infrared dots, such as the first Kinect.

Its noise is that which was measured: C. V. Nguyen, S. Izadi, D. Lovell, Modeling Kinect sensor
noise for improved 3D reconstruction and tracking, 3DIMPVT 2012. z is the depth in metres, and t the
angle between the surface's normal and the line of sight in radians (measured in the picture's
centre, where that is the optical axis):

    axial    s_z = 0.0012 + 0.0019 (z - 0.4)^2 + 0.0001 / sqrt(z) (t / (pi / 2 - t))^2   metres
    lateral  s_l = 0.8 + 0.035 t / (pi / 2 - t)                          pixels of 640 x 480

Disparity comes in steps: K. Khoshelham, S. Oude Elberink, Accuracy and resolution of Kinect depth
data for indoor mapping applications, Sensors 12(2), 2012, equation 8 and section 4.2: depths that
can be told apart are 2.85e-3 z^2 metres apart.

Which pixels have no depth is a rule of ours, with round numbers: what is too near or too far,
slanted, dark or a mirror to the pattern, and what the projector beside the camera does not reach.
"""

import math
from collections.abc import Mapping
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array, Floats, Ints, Mask
from openrooms_usd.description.dataset import DepthCamera
from openrooms_usd.geometry.pinhole import pixel_directions
from openrooms_usd.geometry.vectors import unit

NEEDED: Final = ("depth", "normal_geometric", "base_color", "roughness", "metallic")
"""The channels that it works with."""

_FOCAL_PX: Final = 585.0  # of the camera whose lateral noise was measured
_STEP_PER_M: Final = 2.85e-3
# The widest angle of the noise model; beyond it, returns are not distinguished.
_STEEPEST_DEG: Final = 80.0
# Of the pattern's light comes back: base colour by cosine. Infrared is not rendered: red is near.
_LEAST_RETURN: Final = 0.03
# Depths of one surface in neighbouring pixels differ by a smaller factor.
_MOST_ALONG: Final = 2.0
# In the projector's picture: a pixel's half, and a little where it sees surfaces wider than the
# camera does; and by how much more disparity a surface is before another, not slanted itself.
_BESIDE_PX: Final = 0.6
_BEFORE_PX: Final = 1.0
_MIRROR_METALLIC: Final = 0.5
_MIRROR_ROUGHNESS: Final = 0.2


def axial_sigma(depth: Array, angle: Array) -> Array:
    """Metres of standard deviation along the axis.

    Args:
        depth: Metres.
        angle: Between the normal and the line of sight, radians.
    """
    return np.asarray(
        0.0012
        + 0.0019 * (depth - 0.4) ** 2
        + 0.0001 / np.sqrt(depth) * (angle / (0.5 * np.pi - angle)) ** 2
    )


def lateral_sigma(angle: Array) -> Array:
    """Pixels of the camera of the measurement, of standard deviation across the axis."""
    return np.asarray(0.8 + 0.035 * angle / (0.5 * np.pi - angle))


def in_steps(depth: Array) -> Array:
    """Depths rounded to the nearest step of disparity; 0 stays."""
    with np.errstate(divide="ignore"):
        steps = np.rint(1.0 / (_STEP_PER_M * depth))
    return np.where((depth > 0.0) & (steps > 0), 1.0 / (_STEP_PER_M * np.maximum(steps, 1)), 0.0)


def measured(
    channels: Mapping[str, Floats],
    K: Array,
    world_from_camera: Array,
    camera: DepthCamera,
    rng: np.random.Generator,
) -> Floats:
    """The depth that such a camera measures.

    Args:
        channels: Those of `NEEDED`, (height, width, components).
        K: (3, 3) intrinsics, pixels.
        world_from_camera: (4, 4) of the OpenCV frame.
        camera: The camera.
        rng: Draws the noise.

    Returns:
        (height, width, 1) metres along the optical axis; 0 where there is none.
    """
    truth = channels["depth"][..., 0].astype(np.float64)
    normals = channels["normal_geometric"].astype(np.float64)
    height, width = truth.shape
    rays = pixel_directions(K, width, height) @ world_from_camera[:3, :3].T
    cosine = np.abs(np.einsum("ijk,ijk->ij", normals, unit(rays)))
    angle = np.arccos(np.clip(cosine, 0.0, 1.0))
    held = np.minimum(angle, np.radians(_STEEPEST_DEG))
    # The same draws with and without noise: parts can be switched off one by one.
    draws = rng.standard_normal((3, height, width))
    blur = camera.noise * lateral_sigma(held) * K[0, 0] / _FOCAL_PX
    row, column = np.indices((height, width))
    column = np.clip(np.rint(column + blur * draws[0]), 0, width - 1).astype(np.int64)
    row = np.clip(np.rint(row + blur * draws[1]), 0, height - 1).astype(np.int64)
    depth = truth[row, column] * _along(normals, rays, row, column)
    slant, there = held[row, column], depth > 0.0
    sigma = axial_sigma(np.where(there, depth, 1.0), slant)
    noisy = np.where(there, depth + camera.noise * sigma * draws[2], 0.0)
    found = in_steps(noisy) if camera.steps else noisy
    if camera.missing:
        lost = _lacks_pattern(channels, truth, angle, camera) | _in_shadow(
            truth, K, camera.baseline
        )
        found = np.where(lost[row, column], 0.0, found)
    inside = (found >= camera.range[0]) & (found <= camera.range[1])
    return np.where(inside, found, 0.0)[..., None].astype(np.float32)


def _lacks_pattern(
    channels: Mapping[str, Floats], depth: Array, angle: Array, camera: DepthCamera
) -> Mask:
    """Where nothing of the pattern comes back."""
    returned = channels["base_color"][..., 0] * np.cos(angle)
    mirror = (channels["metallic"][..., 0] > _MIRROR_METALLIC) & (
        channels["roughness"][..., 0] < _MIRROR_ROUGHNESS
    )
    steep = angle > np.radians(_STEEPEST_DEG)
    return np.asarray((depth <= 0.0) | steep | mirror | (returned < _LEAST_RETURN))


def _along(normals: Array, rays: Array, row: Ints, column: Ints) -> Array:
    """(height, width) factors of other pixels' depths: their surfaces, met by the pixels' own rays.

    Which surface is seen wanders; on one that is slanted, its slope is in the axial noise already.
    """
    own = np.einsum("ijk,ijk->ij", normals, rays)[row, column]
    met = np.einsum("ijk,ijk->ij", normals[row, column], rays)
    factors = np.divide(own, met, out=np.ones_like(own), where=met != 0.0)
    return np.where((factors > 1.0 / _MOST_ALONG) & (factors < _MOST_ALONG), factors, 1.0)


def _in_shadow(depth: Array, K: Array, baseline: float) -> Mask:
    """Where the projector, so far right of the camera, has something nearer before it.

    What lies in a column of the camera lies as many columns further left in the projector's picture
    as its disparity. So a pixel hides those that lie where it does and are farther away: to its
    left, by as many columns as their disparities differ. Of things only what the camera sees of
    them casts a shadow.
    """
    with np.errstate(divide="ignore"):
        disparity = np.where(depth > 0.0, K[0, 0] * baseline / depth, 0.0)
    hidden = np.zeros(depth.shape, dtype=bool)
    most = min(depth.shape[1] - 1, math.ceil(np.ptp(disparity) + _BESIDE_PX))
    for columns in range(1, most + 1):
        nearer = disparity[:, columns:] - disparity[:, :-columns]
        meets = np.abs(nearer - columns) <= _BESIDE_PX
        hidden[:, :-columns] |= meets & (nearer > _BEFORE_PX)
    return hidden
