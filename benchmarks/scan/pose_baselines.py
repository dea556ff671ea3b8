"""Poses to compare with: the paper's grid in a box, ICP, a plain fit, and features of Open3D."""

from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from benchmarks.scan.symmetry import surface_samples
from benchmarks.scan.truth import Cad, moved, pose_matrix, pose_of
from openrooms_usd.scan.registration.hypotheses import Box
from openrooms_usd.scan.results import Pose

Array = NDArray[np.float64]

SAMPLES: Final = 1000
POINTS: Final = 1000
# Points farther away than this are not of the object, metres.
OUTSIDE: Final = 0.10
# The paper's grid: headings beside those of the box, degrees, and factors on its size.
TURNS: Final = (-10.0, -5.0, 0.0, 5.0, 10.0)
SIZES: Final = (0.85, 0.925, 1.0, 1.075, 1.15)


def samples(cad: Cad, count: int = SAMPLES) -> Array:
    """(count, 3) points on a model's surface."""
    return surface_samples(cad.vertices, cad.faces, count, np.random.default_rng(0))


def thinned(points: Array) -> Array:
    """At most `POINTS` of some points, spread over their order."""
    rows = np.linspace(0, len(points) - 1, min(len(points), POINTS)).astype(int)
    return points[rows]


def grid_in_box(points: Array, cad: Cad, box: Box) -> Pose:
    """The route of OpenRooms for SUN RGB-D: the best heading and scale by the Chamfer distance.

    The CAD is put into the box, its four headings and a few beside them, its size and a few beside
    it are tried; the middle stays that of the box (Li et al., OpenRooms, CVPR 2021, appendix).

    Args:
        points: (N, 3) of the object.
        cad: Its model.
        box: Where it is.
    """
    inside = thinned(points)
    scan = cKDTree(inside)
    used = cad.vertices[np.unique(cad.faces)]
    low, high = used.min(axis=0), used.max(axis=0)
    surface = samples(cad)
    base, size, heading = box.upright()
    best: tuple[float, Pose | None] = (np.inf, None)
    for quarter in range(4):
        lengths = size if quarter % 2 == 0 else size[[1, 0, 2]]
        for turn in TURNS:
            angle = heading + np.radians(turn + 90.0 * quarter)
            for factor in SIZES:
                scale = factor * lengths / (high - low)
                R = Rotation.from_euler("z", angle)
                foot = (low + high) / 2 * (1, 1, 0) + low * (0, 0, 1)
                pose = Pose(base - R.apply(scale * foot), R.as_quat(scalar_first=True), scale)
                placed = R.apply(scale * surface) + pose.translation
                cost = _chamfer(placed, scan, inside)
                if cost < best[0]:
                    best = cost, pose
    assert best[1] is not None
    return best[1]


def _chamfer(placed: Array, scan: cKDTree, points: Array) -> float:
    there, back = scan.query(placed)[0], cKDTree(placed).query(points)[0]
    return float(np.mean(there) + np.mean(back))


def icp(points: Array, cad: Cad, start: Pose, rounds: int = 30) -> Pose:
    """Rigid point-to-plane ICP from a start pose (Chen and Medioni, 1991)."""
    surface, normals = _with_normals(cad)
    near = thinned(points)
    matrix = pose_matrix(start)
    for _ in range(rounds):
        placed = moved(matrix, surface)
        linear = np.linalg.inv(matrix[:3, :3]).T
        facing = normals @ linear.T
        facing /= np.linalg.norm(facing, axis=1, keepdims=True)
        away, rows = (np.asarray(v) for v in cKDTree(placed).query(near))
        kept = away < max(3 * np.median(away), OUTSIDE)
        p, q, n = near[kept], placed[rows[kept]], facing[rows[kept]]
        middle = q.mean(axis=0)
        A = np.hstack([np.cross(q - middle, n), n])
        x = np.linalg.lstsq(A, np.einsum("ij,ij->i", p - q, n), rcond=None)[0]
        step = np.eye(4)
        step[:3, :3] = Rotation.from_rotvec(x[:3]).as_matrix()
        step[:3, 3] = middle + x[3:] - step[:3, :3] @ middle
        matrix = step @ matrix
    return pose_of(matrix)


def _with_normals(cad: Cad) -> tuple[Array, Array]:
    a, b, c = np.moveaxis(cad.vertices[cad.faces], 1, 0)
    cross = np.cross(b - a, c - a)
    area = np.linalg.norm(cross, axis=1)
    random = np.random.default_rng(0)
    chosen = random.choice(len(area), SAMPLES, p=area / area.sum())
    u, v = random.random((2, SAMPLES, 1))
    u, v = np.where(u + v > 1, 1 - u, u), np.where(u + v > 1, 1 - v, v)
    spots = a[chosen] + u * (b - a)[chosen] + v * (c - a)[chosen]
    return spots, cross[chosen] / area[chosen, None]


def seven_degrees(points: Array, cad: Cad, start: Pose) -> Pose:
    """A plain fit of place, heading and three scales: both ways nearest points, Huber's loss."""
    surface, near = samples(cad), thinned(points)
    scan = cKDTree(near)
    tilt = Rotation.from_quat(start.rotation, scalar_first=True)

    def pose(x: Array) -> Pose:
        R = Rotation.from_euler("z", x[3]) * tilt
        scale = start.scale * np.exp(x[4:])
        return Pose(start.translation + x[:3], R.as_quat(scalar_first=True), scale)

    def errors(x: Array) -> Array:
        placed = moved(pose_matrix(pose(x)), surface)
        back = np.minimum(scan.query(placed)[0], 0.15) * 0.6
        return np.concatenate([cKDTree(placed).query(near)[0], back])

    found = least_squares(
        errors, np.zeros(7), loss="huber", f_scale=0.03, max_nfev=40, diff_step=[1e-3] * 7
    )
    return pose(found.x)


def features(points: Array, cad: Cad, voxel: float = 0.03) -> Pose | None:
    """FPFH features, RANSAC over their matches, then ICP, all of Open3D; scale stays 1.

    Raises:
        ImportError: Open3D is not installed.
    """
    import open3d  # type: ignore[import-not-found, unused-ignore]

    registration = open3d.pipelines.registration
    open3d.utility.set_verbosity_level(open3d.utility.VerbosityLevel.Error)
    open3d.utility.random.seed(0)

    def prepared(values: Array) -> tuple[object, object]:
        cloud = open3d.geometry.PointCloud(open3d.utility.Vector3dVector(values))
        cloud = cloud.voxel_down_sample(voxel)
        cloud.estimate_normals(open3d.geometry.KDTreeSearchParamHybrid(2 * voxel, 30))
        nearby = open3d.geometry.KDTreeSearchParamHybrid(5 * voxel, 100)
        return cloud, registration.compute_fpfh_feature(cloud, nearby)

    (scan, of_scan), (model, of_model) = prepared(points), prepared(samples(cad, 5000))
    rigid = registration.TransformationEstimationPointToPoint(False)
    checks = [registration.CorrespondenceCheckerBasedOnDistance(1.5 * voxel)]
    coarse = registration.registration_ransac_based_on_feature_matching(
        model, scan, of_model, of_scan, True, 1.5 * voxel, rigid, 3, checks,
        registration.RANSACConvergenceCriteria(20_000, 0.999),
    )  # fmt: skip
    plane = registration.TransformationEstimationPointToPlane()
    fine = registration.registration_icp(model, scan, voxel, coarse.transformation, plane)
    return pose_of(np.array(fine.transformation))
