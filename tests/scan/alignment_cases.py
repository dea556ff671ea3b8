"""CADs with a shape that tells their front, and one-sided scans of them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from openrooms_usd.arrays import Array
from openrooms_usd.geometry.raycast import RayCaster
from openrooms_usd.scan.models.cad import UPRIGHT, CadModel, Symmetry, Up
from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.results import FoundRoom, Pose

Block = tuple[tuple[float, float, float], tuple[float, float, float]]

# Blocks by least and greatest corner: Z up, metres, front towards -Y, base at z = 0.
CHAIR: tuple[Block, ...] = (
    ((-0.23, -0.24, 0.42), (0.23, 0.24, 0.47)),
    ((-0.23, 0.20, 0.47), (0.23, 0.24, 0.90)),
    ((-0.23, -0.24, 0.0), (-0.19, -0.20, 0.42)),
    ((0.19, -0.24, 0.0), (0.23, -0.20, 0.42)),
    ((-0.23, 0.20, 0.0), (-0.19, 0.24, 0.42)),
    ((0.19, 0.20, 0.0), (0.23, 0.24, 0.42)),
)
TABLE: tuple[Block, ...] = (
    ((-0.70, -0.40, 0.70), (0.70, 0.40, 0.74)),
    ((-0.68, -0.38, 0.0), (-0.62, -0.32, 0.70)),
    ((0.62, -0.38, 0.0), (0.68, -0.32, 0.70)),
    ((-0.68, 0.32, 0.0), (-0.62, 0.38, 0.70)),
    ((0.62, 0.32, 0.0), (0.68, 0.38, 0.70)),
)
SOFA: tuple[Block, ...] = (
    ((-0.90, -0.40, 0.0), (0.90, 0.40, 0.42)),
    ((-0.90, 0.20, 0.42), (0.90, 0.40, 0.85)),
    ((-0.90, -0.40, 0.42), (-0.72, 0.20, 0.62)),
    ((0.72, -0.40, 0.42), (0.90, 0.20, 0.62)),
)
CABINET: tuple[Block, ...] = (((-0.40, -0.22, 0.0), (0.40, 0.22, 0.90)),)
# Of a box whose corner 4 x + 2 y + z is at the ends of its three sides.
BOX_FACES = np.array(
    [
        [0, 1, 3],
        [0, 3, 2],
        [4, 6, 7],
        [4, 7, 5],
        [0, 4, 5],
        [0, 5, 1],
        [2, 3, 7],
        [2, 7, 6],
        [0, 2, 6],
        [0, 6, 4],
        [1, 5, 7],
        [1, 7, 3],
    ],
    dtype=np.int32,
)


def mesh(blocks: tuple[Block, ...]) -> tuple[Array, NDArray[np.int32]]:
    """Vertices and triangles of blocks."""
    vertices = [
        [[box[i][0], box[j][1], box[k][2]] for i in (0, 1) for j in (0, 1) for k in (0, 1)]
        for box in blocks
    ]
    faces = [BOX_FACES + 8 * n for n in range(len(blocks))]
    return np.array(vertices, dtype=np.float64).reshape(-1, 3), np.concatenate(faces).astype("i4")


def cad(
    name: str,
    blocks: tuple[Block, ...],
    up: Up = "Z",
    scale: Array | float = 1.0,
    symmetry: Symmetry | None = None,
    stated: bool = True,
) -> CadModel:
    """A CAD whose vertices are those of the blocks over a scale (upright axes)."""
    vertices, faces = mesh(blocks)
    own = (vertices / scale) @ UPRIGHT[up]
    return CadModel(name, name.partition("_")[0], own, faces, symmetry, up if stated else None)


@dataclass(frozen=True, eq=False)
class Placed:
    """An object of a test scene: its blocks, where its base is, and its heading."""

    blocks: tuple[Block, ...]
    place: tuple[float, float, float]
    heading: float
    up: Up = "Z"
    scale: Array | float = 1.0

    def pose(self) -> Pose:
        """The true pose of its CAD."""
        turn = Rotation.from_euler("z", self.heading).as_matrix() @ UPRIGHT[self.up]
        scale = np.abs(UPRIGHT[self.up]).T @ (np.ones(3) * self.scale)
        quaternion = Rotation.from_matrix(turn).as_quat(scalar_first=True)
        return Pose(np.array(self.place), quaternion, scale)

    def vertices(self) -> tuple[Array, NDArray[np.int32]]:
        """In the scene."""
        own, faces = mesh(self.blocks)
        return Rotation.from_euler("z", self.heading).apply(own) + self.place, faces


def room(width: float = 5.0, depth: float = 4.0) -> FoundRoom:
    """A rectangular room about the origin."""
    x, y = 0.5 * width, 0.5 * depth
    corners = np.array([[-x, -y, 0.0], [x, -y, 0.0], [x, y, 0.0], [-x, y, 0.0]])
    return FoundRoom(np.array([0.0, 0.0, 1.0]), np.zeros(3), corners)


def scan(
    objects: list[Placed], sensor_origins: Array, seed: int = 0, noise: float = 0.006
) -> Cloud:
    """What scanners at some places see of objects in `room`: one-sided, instances from 1."""
    bounds: Block = ((-2.5, -2.0, 0.0), (2.5, 2.0, 2.6))
    vertices, faces = mesh((bounds,))
    parts = [(vertices, faces), *(one.vertices() for one in objects)]
    counts = np.cumsum([0, *(len(v) for v, _ in parts)])
    caster = RayCaster(
        np.concatenate([v for v, _ in parts]),
        np.concatenate([f + n for (_, f), n in zip(parts, counts, strict=False)]),
    )
    owner = np.repeat(np.arange(len(parts)), [len(f) for _, f in parts])
    rng = np.random.default_rng(seed)
    directions = rng.normal(size=(60_000, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    points, instances = [], []
    for origin in sensor_origins:
        hits = caster.first_hit(origin, directions)
        depth = hits.distance + noise * rng.normal(size=len(directions))
        points.append(origin + directions * depth[:, None])
        instances.append(owner[hits.triangle])
    return Cloud(
        np.concatenate(points),
        instance=np.concatenate(instances).astype(np.int32),
        sensor_origins=sensor_origins,
    )


SENSOR_ORIGINS = np.array([[0.0, -1.2, 1.5], [1.2, -0.8, 1.5], [-1.2, -0.6, 1.5], [0.3, 0.2, 1.6]])


def errors(pose: Pose, truth: Pose, quarter_turns: tuple[int, ...] = (0,)) -> tuple[float, ...]:
    """Metres, degrees and the greatest share of scale by which a pose is off."""
    found = Rotation.from_quat(pose.rotation, scalar_first=True)
    true = Rotation.from_quat(truth.rotation, scalar_first=True)
    angles = [
        (Rotation.from_euler("z", 0.5 * np.pi * k) * true * found.inv()).magnitude()
        for k in quarter_turns
    ]
    return (
        float(np.linalg.norm(pose.translation - truth.translation)),
        float(np.rad2deg(min(angles))),
        float(np.abs(pose.scale / truth.scale - 1.0).max()),
    )
