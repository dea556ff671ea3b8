"""An upright CAD as points with seven pose parameters: translation, yaw and three log scales."""

from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np
from scipy.spatial import KDTree
from scipy.spatial.transform import Rotation

from openrooms_usd.arrays import Array, Mask
from openrooms_usd.geometry.rotations import in_plan
from openrooms_usd.geometry.vectors import unit
from openrooms_usd.scan.models.cad import CadModel
from openrooms_usd.scan.results import Pose

# Outward directions of the sides of a template's box.
SIDES: Final = np.array([[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, -1.0, 0.0]])
# Points on a side of the box: within this share of the extent, with an outward normal.
_SIDE_SHARE: Final = 0.02
_OUTWARD_COS: Final = 0.9
# Of the k-d tree: with fewer, queries of points beside a surface take longer.
_LEAF_POINTS: Final = 24


@dataclass(frozen=True, eq=False)
class Template:
    """Points of an upright CAD at a reference scale, metres, origin in the middle of its base.

    Its pose has seven parameters: the base's middle in the scan (3), the yaw (radians), and the
    log scales along its upright axes relative to the reference (3).

    Attributes:
        model: The CAD.
        upright: (3, 3) signed permutation from the CAD's axes to Z up.
        reference: (3,) scale along the CAD's own axes at which it is sampled.
        points: (N, 3).
        normals: (N, 3) unit, outward.
        two_sided: (N,) whether both sides can be seen.
        spacing: Between points, metres.
        base: (3,) the origin, in the CAD's scaled and turned frame.
        size: (3,) of its box.
    """

    model: CadModel
    upright: Array
    reference: Array
    points: Array
    normals: Array
    two_sided: Mask
    spacing: float
    base: Array
    size: Array

    @cached_property
    def tree(self) -> "KDTree[None]":
        """k-d tree of its points."""
        return KDTree(self.points, leafsize=_LEAF_POINTS)

    @cached_property
    def flat(self) -> Array:
        """(4,) share of the sides +x, -x, +y and -y of its box that is surface, from 0 to 1."""
        reach = self.points @ SIDES.T / np.maximum(0.5 * np.abs(SIDES) @ self.size, 1e-9)
        on = (reach > 1.0 - 2.0 * _SIDE_SHARE) & (self.normals @ SIDES.T > _OUTWARD_COS)
        areas = self.size[2] * self.size[[1, 1, 0, 0]]
        filled = on.sum(axis=0) * self.spacing**2 / np.maximum(areas, 1e-9)
        return np.asarray(np.minimum(filled, 1.0))

    def part(self, count: int) -> "Template":
        """The template with a uniform sample of about so many points."""
        step = max(len(self.points) // count, 1)
        return Template(
            self.model,
            self.upright,
            self.reference,
            self.points[::step],
            self.normals[::step],
            self.two_sided[::step],
            self.spacing * float(np.sqrt(step)),
            self.base,
            self.size,
        )

    def pose(self, parameters: Array) -> Pose:
        """The CAD's pose of seven parameters."""
        turn, stretch = turn_of(parameters), np.exp(parameters[4:])
        quaternion = Rotation.from_matrix(turn @ self.upright).as_quat(scalar_first=True)
        return Pose(
            parameters[:3] - turn @ (stretch * self.base),
            quaternion * (1.0 if quaternion[0] >= 0.0 else -1.0),
            self.reference * (np.abs(self.upright).T @ stretch),
        )

    def parameters(self, pose: Pose) -> Array:
        """(7,) parameters of a pose, tilt removed about the middle of its box."""
        rotation = Rotation.from_quat(pose.rotation, scalar_first=True).as_matrix()
        turn = rotation @ self.upright.T
        stretch = np.abs(self.upright) @ (pose.scale / self.reference)
        rise = np.array([0.0, 0.0, 0.5 * self.size[2]])
        base = turn @ (stretch * (self.base + rise)) + pose.translation - stretch * rise
        yaw = np.arctan2(turn[1, 0] - turn[0, 1], turn[0, 0] + turn[1, 1])
        return np.array([*base, yaw, *np.log(stretch)])


def template_of(model: CadModel, upright: Array, reference: Array) -> Template:
    """A CAD turned upright at a scale.

    Args:
        model: The CAD.
        upright: (3, 3) signed permutation to Z up.
        reference: (3,) scale along the CAD's own axes.
    """
    surface = model.surface
    low, high = np.sort((model.extent * reference) @ upright.T, axis=0)
    base = np.array([0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1]), low[2]])
    normals = (surface.normals / reference) @ upright.T
    return Template(
        model=model,
        upright=upright,
        reference=reference,
        points=(surface.points * reference) @ upright.T - base,
        normals=unit(normals),
        two_sided=surface.two_sided,
        spacing=surface.spacing * float(np.prod(reference) ** (1.0 / 3.0)),
        base=base,
        size=high - low,
    )


def upright_of(rotation: Array) -> Array:
    """(3, 3) the signed permutation that differs from a rotation by little but a turn about Z."""
    k = int(np.abs(rotation[2]).argmax())
    up = np.eye(3)[k] * np.sign(rotation[2, k])
    right = np.eye(3)[(k + 1) % 3]
    return np.stack([right, np.cross(up, right), up])


def turn_of(parameters: Array) -> Array:
    """(..., 3, 3) the rotation about the vertical."""
    turn = np.zeros((*parameters.shape[:-1], 3, 3))
    turn[..., :2, :2] = in_plan(parameters[..., 3])
    turn[..., 2, 2] = 1.0
    return turn


def posed(points: Array, parameters: Array) -> Array:
    """(..., N, 3) points from the template's frame to the scan's."""
    scaled = points * np.exp(parameters[..., None, 4:])
    return np.asarray(scaled @ turn_of(parameters).swapaxes(-1, -2) + parameters[..., None, :3])


def unposed(points: Array, parameters: Array) -> Array:
    """(..., N, 3) points from the scan's frame to the template's."""
    turned = (points - parameters[..., None, :3]) @ turn_of(parameters)
    return np.asarray(turned / np.exp(parameters[..., None, 4:]))


def directions(normals: Array, parameters: Array) -> Array:
    """(..., N, 3) unit normals from the template's frame to the scan's."""
    scaled = normals / np.exp(parameters[..., None, 4:])
    turned = scaled @ turn_of(parameters).swapaxes(-1, -2)
    return np.asarray(turned / np.sqrt(np.einsum("...i,...i->...", turned, turned))[..., None])
