"""Doors, drawers, lids and taps move through their whole range without running into the rest."""

from collections.abc import Iterator
from functools import cached_property

import numpy as np
import pytest

from openrooms_usd.furniture import Furniture, Joint, Size, make, part_of
from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.geometry.raycast import RayCaster
from openrooms_usd.geometry.solids import box
from tests.furniture.pieces import STYLES, piece, usual

# What may overlap, metres: seals, and handles let into their doors.
ALLOWED = 0.002
STEPS = (0.0, 0.2, 0.45, 0.7, 1.0)
# Who can only move once another one has: a seat lies under its lid.
AFTER = {"seat": "lid", "rack": "door", "tray": "door"}

Array = np.ndarray


class Solid:
    """A closed mesh that tells how deep points are inside it."""

    def __init__(self, mesh: Mesh) -> None:
        self.mesh = mesh
        self.extent = mesh.extent
        corners, _ = mesh.triangles()
        self._triangles = mesh.indices[corners]

    @cached_property
    def caster(self) -> RayCaster:
        return RayCaster(self.mesh.points, self._triangles)

    @cached_property
    def samples(self) -> Array:
        """(N, 3) its corners, and points spread evenly over its surface."""
        a, b, c = np.moveaxis(self.mesh.points[self._triangles], 1, 0)
        area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
        rng = np.random.default_rng(0)
        face = rng.choice(len(area), size=500, p=area / area.sum())
        u = rng.dirichlet((1, 1, 1), size=len(face))
        spread = u[:, :1] * a[face] + u[:, 1:2] * b[face] + u[:, 2:] * c[face]
        step = max(1, len(self.mesh.points) // 500)
        return np.concatenate([self.mesh.points[::step], spread])

    def depth(self, points: Array) -> float:
        """How deep the deepest of some points lies, metres; 0 when all are outside.

        A point is inside when five of six rays along the axes leave through the back of a face;
        the shortest of them bounds its depth from above.
        """
        low, high = self.extent[0] + ALLOWED, self.extent[1] - ALLOWED
        near = points[((points > low) & (points < high)).all(axis=1)]
        if not len(near):
            return 0.0
        axes = np.concatenate([np.eye(3), -np.eye(3)])
        origins = np.repeat(near, 6, axis=0)
        directions = np.tile(axes, (len(near), 1))
        hits = self.caster.first_hit(origins, directions)
        facing = np.einsum("ij,ij->i", self.caster.normals[hits.triangle], directions) > 0
        leaves = (hits.hit & facing).reshape(-1, 6)
        reach = np.where(leaves, hits.distance.reshape(-1, 6), np.inf).min(axis=1)
        return float(np.where(leaves.sum(axis=1) >= 5, reach, 0.0).max())


def pose(joint: Joint, share: float) -> Array:
    """(4, 4) where the parts of a joint come to at a share of its range."""
    value = joint.limits[0] + share * (joint.limits[1] - joint.limits[0])
    axis, moved = np.array(joint.axis), np.eye(4)
    if joint.kind == "rail":
        moved[:3, 3] = value * axis
        return moved
    # Rodrigues' formula.
    cross = np.cross(axis, np.eye(3)).T
    angle = np.radians(value)
    moved[:3, :3] += np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
    moved[:3, 3] = np.array(joint.origin) - moved[:3, :3] @ joint.origin
    return moved


def _over(points: Array, matrix: Array) -> Array:
    return points @ matrix[:3, :3].T + matrix[:3, 3]


def _apart(first: Array, second: Array) -> bool:
    return bool((first[0] > second[1] - ALLOWED).any() or (second[0] > first[1] - ALLOWED).any())


def collisions(furniture: Furniture) -> Iterator[tuple[str, str, str, float, float]]:
    """Joint, moving part, part it runs into, share of the range, and depth in metres."""
    poses = {name: np.eye(4) for name in furniture.parts}
    solids = {name: Solid(mesh) for name, mesh in furniture.parts.items()}
    for joint in furniture.joints:
        others = {name: matrix for name, matrix in poses.items() if name not in joint.meshes}
        for first in furniture.joints:
            if part_of(first.name) == AFTER.get(part_of(joint.name)):
                others |= dict.fromkeys(first.meshes, pose(first, 1.0))
        for share in STEPS:
            moved = pose(joint, share)
            for name in joint.meshes:
                points = _over(solids[name].samples, moved)
                extent = np.stack([points.min(axis=0), points.max(axis=0)])
                for other, matrix in others.items():
                    back = np.linalg.inv(matrix)
                    seen = solids[other]
                    if np.array_equal(matrix, np.eye(4)) and _apart(extent, seen.extent):
                        continue
                    there = np.linalg.inv(moved) @ matrix
                    depth = max(
                        seen.depth(_over(points, back)),
                        solids[name].depth(_over(seen.samples, there)),
                    )
                    if depth > ALLOWED:
                        yield joint.name, name, other, share, depth


def _made(name: str, style: str, seed: int, factor: Size = (1.0, 1.0, 1.0)) -> Furniture:
    if seed == 0 and factor == (1.0, 1.0, 1.0):
        return piece(name, style)
    width, depth, height = (np.array(usual(name, style)) * factor).tolist()
    return make(name, (width, depth, height), style, np.random.default_rng(seed))


@pytest.mark.parametrize(("name", "style"), STYLES)
@pytest.mark.parametrize("seed", [0, pytest.param(5, marks=pytest.mark.long)])
def test_what_moves_stays_clear_of_the_rest(name: str, style: str, seed: int) -> None:
    factor = (1.0, 1.0, 1.0) if seed == 0 else (1.15, 0.95, 1.06)
    assert list(collisions(_made(name, style, seed, factor))) == []


@pytest.mark.parametrize(("name", "style"), STYLES)
@pytest.mark.parametrize("seed", [0, pytest.param(1, marks=pytest.mark.long)])
def test_joints_are_sound_and_open_to_the_front(name: str, style: str, seed: int) -> None:
    furniture = _made(name, style, seed)
    moving = [mesh for joint in furniture.joints for mesh in joint.meshes]
    assert len(moving) == len(set(moving))
    assert set(moving) <= set(furniture.parts)
    names = [joint.name for joint in furniture.joints]
    assert len(names) == len(set(names))
    for joint in furniture.joints:
        assert np.linalg.norm(joint.axis) == pytest.approx(1)
        assert joint.limits[0] <= 0 <= joint.limits[1]
        assert joint.limits[0] < joint.limits[1]
        if part_of(joint.name) in ("door", "drawer"):
            mesh = furniture.parts[joint.meshes[0]]
            opened = _over(mesh.points, pose(joint, 1.0))
            assert opened[:, 1].min() < mesh.extent[0, 1] - 0.05


def test_depth_in_a_box() -> None:
    solid = Solid(box((2, 2, 2)))
    assert solid.depth(np.array([[0.0, 0.1, 0.7]])) == pytest.approx(0.3)
    assert solid.depth(np.array([[0.0, 0.0, 1.2], [3.0, 0.0, 0.0]])) == 0


def test_a_drawer_that_is_too_wide_is_found() -> None:
    block, front = box((1, 1, 1)), box((0.5, 1, 0.5), (0.6, -0.3, 0))
    rail = Joint("drawer_0", "rail", ("front",), (0, 0, 0), (0, -1, 0), (0.0, 0.2))
    found = list(collisions(Furniture({"frame": block, "front": front}, (rail,))))
    assert {(joint, part, other) for joint, part, other, *_ in found} == {
        ("drawer_0", "front", "frame")
    }


def test_hinges_turn_counter_clockwise_about_their_axis() -> None:
    joint = Joint("door_0", "hinge", ("door",), (1, 0, 0), (0, 0, 1), (0.0, 90.0))
    np.testing.assert_allclose(_over(np.array([[2.0, 0, 5]]), pose(joint, 1)), [[1, 1, 5]])
