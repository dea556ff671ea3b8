"""Fuses posed depth frames into one cloud, frame by frame, in bounded memory.

Each frame is averaged over voxels first and then counts as one observation of each, because the
errors of its pixels are correlated; observations are weighted by the inverse variance of their
depth. The sums are kept in `voxels.VoxelSums`, which doubles the voxel size where memory runs out.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.arrays import Array, Bytes, Floats, Mask
from openrooms_usd.errors import InputError
from openrooms_usd.geometry.vectors import unit
from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.points.voxels import Samples, VoxelSums

# The standard error of a voxel's mean at which its confidence is one half, metres.
_HALF_CONFIDENCE_M: Final = 0.005
# At larger angles of incidence depth is not reliable: the tangent of 80 degrees.
_GRAZING_TAN: Final = 5.67
# Neighbouring depths that differ by no more than this differ by noise, in standard deviations.
_JUMP_SIGMAS: Final = 3.0
# Pixels are skipped such that at the typical depth they lie this part of a voxel apart.
_MIN_SPACING_VOXELS: Final = 0.66
_TYPICAL_DEPTH_M: Final = 3.0
_MAX_STRIDE: Final = 4
_RIGID_TOLERANCE: Final = 1e-2

# Nearest neighbours, the point included: at 2 cm between points a radius of about 4 cm.
NEIGHBOURS: Final = 16
# Points a batch: bounds the memory of their neighbourhoods.
_POINTS_AT_A_TIME: Final = 1 << 16
_MIN_NEIGHBOURS: Final = 3


@dataclass(frozen=True, eq=False)
class DepthFrame:
    """A depth picture with intrinsics and extrinsics.

    Attributes:
        depth: (H, W) metres along the optical axis; 0 or not finite where there is no return.
        K: (3, 3) intrinsics in pixels; the centre of the top-left pixel is (0.5, 0.5).
        world_from_camera: (4, 4) rigid, from the OpenCV frame (x right, y down, z forward).
        label: (H, W) NYU40 classes; 0 where there is none.
        instance: (H, W) instance numbers; 0 where there is none.
        color: (H, W, 3) uint8.
    """

    depth: NDArray[np.floating[Any]]
    K: Array
    world_from_camera: Array
    label: NDArray[np.integer[Any]] | None = None
    instance: NDArray[np.integer[Any]] | None = None
    color: Bytes | None = None


@dataclass(frozen=True)
class FusionOptions:
    """How frames are fused.

    Attributes:
        voxel: Edge length of the voxels, metres.
        near: Nearer returns are dropped, metres.
        far: Farther returns are dropped, metres.
        frames: Voxels with returns from fewer frames are dropped.
        memory: Limit of the voxels alone, bytes; frames and the final cloud come on top.
    """

    voxel: float = 0.02
    near: float = 0.15
    far: float = 8.0
    frames: int = 1
    memory: int = 1 << 30


DEFAULTS: Final = FusionOptions()


@dataclass(frozen=True, eq=False)
class Fused:
    """The fused cloud and how it was made.

    Attributes:
        cloud: One point a voxel, with normals, confidence and sensor origins.
        voxel: Final edge length of the voxels, metres.
        frames: Frames that were used.
        lost: Frames without a usable pose.
        notes: What was dropped or changed, one sentence each.
    """

    cloud: Cloud
    voxel: float
    frames: int
    lost: int
    notes: tuple[str, ...]


def depth_noise(depth: Array) -> Array:
    """Standard deviation of a structured-light depth, metres.

    0.0012 + 0.0019 (z - 0.4)^2 (Nguyen, Izadi and Lovell, "Modeling Kinect Sensor Noise for
    Improved 3D Reconstruction and Tracking", 3DIMPVT 2012).

    Args:
        depth: Metres along the optical axis.
    """
    return np.asarray(0.0012 + 0.0019 * (depth - 0.4) ** 2)


def fuse(frames: Iterable[DepthFrame], options: FusionOptions = DEFAULTS) -> Fused:
    """Fuse posed depth frames; one frame is in memory at a time.

    Args:
        frames: In the order of capture; frames whose pose is not finite are skipped.
        options: Voxel size, depth range and limits.

    Returns:
        The cloud in the frame of the poses. Its confidence is W / (W + 1 / (5 mm)^2), where 1 / W
        is the squared standard error of the voxel's mean; each frame counts once.

    Raises:
        InputError: A frame has wrong shapes, intrinsics that are not positive, or no rigid pose.
    """
    sums = VoxelSums(options.voxel, options.memory)
    sensor_origins, lost = list[Array](), 0
    for number, frame in enumerate(frames):
        if not np.isfinite(frame.world_from_camera).all():
            lost += 1
            continue
        _check(frame, number)
        sensor_origins.append(frame.world_from_camera[:3, 3])
        sums.add(_samples(frame, options))
    notes = list(_note_poseless(lost, len(sensor_origins)))
    if sums.voxel > options.voxel:
        notes.append(
            f"voxels were enlarged to {100 * sums.voxel:g} cm to stay within "
            f"{options.memory >> 20} MB"
        )
    return Fused(
        _cloud(sums, sensor_origins, options.frames),
        sums.voxel,
        len(sensor_origins),
        lost,
        tuple(notes),
    )


def _note_poseless(lost: int, used: int) -> Iterator[str]:
    if lost:
        yield f"{lost} of {lost + used} frames have no pose: they were left out"


def _check(frame: DepthFrame, number: int) -> None:
    place, shape = f"frame {number}", np.shape(frame.depth)
    if len(shape) != 2 or 0 in shape:
        raise InputError(
            f"a depth picture must have rows and columns, got the shape {shape}", place=place
        )
    for name in ("label", "instance", "color"):
        other = getattr(frame, name)
        if other is not None and other.shape[:2] != shape:
            raise InputError(
                f"its {name} picture has another size than its depth",
                place=place,
                remedy="resample it to the size of the depth picture, by the nearest pixel",
            )
    turn, K = frame.world_from_camera[:3, :3], frame.K
    if np.abs(turn.T @ turn - np.eye(3)).max() > _RIGID_TOLERANCE or np.linalg.det(turn) < 0.0:
        raise InputError("its pose is not a rotation and a translation", place=place)
    if not np.isfinite(K).all() or K[0, 0] <= 0.0 or K[1, 1] <= 0.0:
        raise InputError("its intrinsics are not valid: fx and fy must be positive", place=place)


def _samples(frame: DepthFrame, options: FusionOptions) -> Samples:
    """The reliable pixels of a frame, back-projected to weighted world points."""
    depth = np.where(np.isfinite(frame.depth), frame.depth, 0.0).astype(np.float64)
    depth[(depth < options.near) | (depth > options.far)] = 0.0
    step = _stride(options.voxel, float(frame.K[0, 0]))
    good = _without_discontinuities(depth, float(frame.K[0, 0]))[::step, ::step]
    v, u = np.nonzero(good)
    u, v = u * step, v * step
    z = depth[v, u]
    fx, fy, cx, cy = frame.K[0, 0], frame.K[1, 1], frame.K[0, 2], frame.K[1, 2]
    local = np.column_stack([(u + 0.5 - cx) * z / fx, (v + 0.5 - cy) * z / fy, z])
    turn, origin = frame.world_from_camera[:3, :3], frame.world_from_camera[:3, 3]
    rays = local @ turn.T

    def seen(picture: NDArray[Any] | None) -> NDArray[Any] | None:
        return None if picture is None else picture[v, u]

    return Samples(
        points=rays + origin,
        weights=depth_noise(z) ** -2,
        views=unit(-rays),
        label=seen(frame.label),
        instance=seen(frame.instance),
        colors=seen(frame.color),
    )


def _stride(voxel: float, focal: float) -> int:
    """The pixel stride at which samples still fill the voxels at the typical depth."""
    return int(np.clip(_MIN_SPACING_VOXELS * voxel * focal / _TYPICAL_DEPTH_M, 1, _MAX_STRIDE))


def _without_discontinuities(depth: Array, focal: float) -> Mask:
    """(H, W) pixels without a depth discontinuity to any neighbour.

    At discontinuities sensors mix both sides ("flying pixels"); angles of incidence above 80
    degrees count as discontinuities, too.
    """
    good = depth > 0.0
    allowed = _GRAZING_TAN * depth / focal + _JUMP_SIGMAS * np.sqrt(2.0) * depth_noise(depth)
    for axis in (0, 1):
        near = np.moveaxis(depth, axis, 0)
        limit = np.moveaxis(allowed, axis, 0)
        jump = np.abs(np.diff(near, axis=0)) > np.minimum(limit[1:], limit[:-1])
        jump &= (near[1:] > 0.0) & (near[:-1] > 0.0)
        kept = np.moveaxis(good, axis, 0)
        kept[1:] &= ~jump
        kept[:-1] &= ~jump
    return good


def _cloud(sums: VoxelSums, sensor_origins: list[Array], fewest: int) -> Cloud:
    table = sums.merged()
    kept = table.seen >= fewest
    points, weight = table.points()[kept], table.weight[kept]
    return Cloud(
        points=points,
        normals=towards(estimate_normals(points), table.views[kept].astype(np.float64)),
        colors=table.colors_seen()[kept] if sums.has_colors else None,
        label=table.label[kept] if sums.has_label else None,
        instance=table.instance[kept] if sums.has_instance else None,
        confidence=(weight / (weight + _HALF_CONFIDENCE_M**-2)).astype(np.float32),
        sensor_origins=np.array(sensor_origins).reshape(-1, 3),
    )


def with_normals(cloud: Cloud, neighbours: int = NEIGHBOURS) -> Cloud:
    """The cloud with normals: its own where it has them, estimated ones otherwise.

    Args:
        cloud: N points; its sensor origins give the sign of the normals.
        neighbours: Points a neighbourhood.
    """
    if cloud.normals is not None:
        return cloud
    normals = estimate_normals(cloud.points, neighbours)
    return replace(cloud, normals=towards(normals, views(cloud.points, cloud.sensor_origins)))


def estimate_normals(points: Array, neighbours: int = NEIGHBOURS) -> Floats:
    """Unit normals by principal components of each point's nearest neighbours.

    The normal is the eigenvector of the least eigenvalue of the neighbours' covariance (Hoppe et
    al., "Surface Reconstruction from Unorganized Points", SIGGRAPH 1992, section 3.2). Its sign is
    arbitrary.

    Args:
        points: (N, 3) finite, metres.
        neighbours: Their number, the point included; fewer where the cloud has fewer.

    Returns:
        (N, 3) unit vectors; +Z where the cloud has fewer than three points.
    """
    from scipy.spatial import cKDTree

    count = len(points)
    normals = np.tile(np.array([0.0, 0.0, 1.0], np.float32), (count, 1))
    if count < _MIN_NEIGHBOURS:
        return normals
    # Centred first: far from the origin, differences of coordinates would lose digits.
    local = points - points.mean(axis=0)
    tree = cKDTree(local)
    for start in range(0, count, _POINTS_AT_A_TIME):
        rows = slice(start, start + _POINTS_AT_A_TIME)
        _, near = tree.query(local[rows], min(neighbours, count))
        normals[rows] = _least_principal_axes(local[near])
    return normals


def _least_principal_axes(patches: Array) -> Floats:
    """(B, 3) the least principal axis of each patch (B, K, 3)."""
    offsets = patches - patches.mean(axis=1, keepdims=True)
    covariance = np.einsum("bki,bkj->bij", offsets, offsets)
    return np.asarray(np.linalg.eigh(covariance)[1][:, :, 0], dtype=np.float32)


def towards(normals: Floats, directions: Array) -> Floats:
    """Normals (N, 3), their signs flipped to the side of the directions (N, 3)."""
    away = np.einsum("ni,ni->n", normals, directions) < 0.0
    return np.where(away[:, None], -normals, normals).astype(np.float32)


def views(points: Array, sensor_origins: Array | None) -> Array:
    """(N, 3) the direction from each point to the sensor that probably measured it.

    That is the nearest sensor. Without any it is the median of the points, which is right for the
    walls, floor and ceiling of a convex room and for little else.

    Args:
        points: (N, 3) metres.
        sensor_origins: (V, 3) metres.
    """
    if sensor_origins is None or len(sensor_origins) == 0:
        middle = np.median(points, axis=0) if len(points) else np.zeros(3)
        return np.asarray(middle - points)
    from scipy.spatial import cKDTree

    _, nearest = cKDTree(sensor_origins).query(points)
    return np.asarray(sensor_origins[nearest] - points)
