"""A scanner: depth frames of a room along a hand-held path, fused to a cloud of labelled points.

The errors are those of consumer depth cameras, the poses drift, and labels are wrong in blobs and
at borders, as those of segmentation networks.
"""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import numpy as np

from benchmarks.scan.depth import Scanner, returns, spoiled, take
from benchmarks.scan.fusion import Fused, fuse
from benchmarks.scan.path import walk, with_corridors
from benchmarks.scan.rooms import SimulatedRoom, read_room
from benchmarks.scan.truth import Truth
from openrooms_usd.arrays import Array
from openrooms_usd.draws import generator
from openrooms_usd.geometry.raycast import RayCaster
from openrooms_usd.geometry.rotations import pose
from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.points.fusion import DepthFrame

__all__ = ["Scan", "Scanner", "simulate", "typical"]


# Drift is as large as declared after so many metres.
WAY: Final = 8.0


@dataclass(frozen=True, eq=False)
class Scan:
    """What a scanner gives, and what is true of it in the same frame.

    Attributes:
        cloud: The fused points.
        truth: In the cloud's frame; ``guessed`` are the walls that no frame shows.
        frames: The posed depth frames that were fused, where they were kept.
    """

    cloud: Cloud
    truth: Truth
    frames: tuple[DepthFrame, ...] = ()

    def moved(self, matrix: Array) -> "Scan":
        """The scan and its truth after a rigid motion (4, 4)."""
        frames = tuple(
            replace(frame, world_from_camera=matrix @ frame.world_from_camera)
            for frame in self.frames
        )
        return Scan(self.cloud.moved(matrix), self.truth.moved(matrix), frames)


def simulate(
    room: SimulatedRoom | Path | str,
    seed: int,
    scanner: Scanner | None = None,
    *,
    keep_frames: bool = False,
) -> Scan:
    """Scan a room.

    Args:
        room: The room, or its composed stage: then with corridors behind its doors.
        seed: Decides the path and every error.
        scanner: How; without it `typical` of the seed.
        keep_frames: Whether the depth frames are given too.
    """
    seen = room if isinstance(room, SimulatedRoom) else with_corridors(read_room(Path(room)))
    how = scanner or typical(seed)
    caster = RayCaster(seen.points, seen.triangles)
    true_poses = walk(seen, caster, how.frames, generator(seed, "path"), lowered=not how.ceiling)
    if how.single:
        true_poses = true_poses[how.frames // 2 : how.frames // 2 + 1]
    poses = drifted(true_poses, how, generator(seed, "drift"))
    missed = missed_walls(seen, how, generator(seed, "walls"))
    random = generator(seed, "depth")
    fused, frames = Fused(how.voxel, len(seen.parts)), []
    for true_pose, believed in zip(true_poses, poses, strict=True):
        view = take(seen, caster, true_pose, how, random, missed)
        fused.add(*returns(view, believed))
        if keep_frames:
            frames.append(view.frame(seen.parts, believed))
    cloud = fuse(fused, seen.parts, poses[:, :3, 3], how.fewest)
    labelled = spoiled(cloud, how.wrong_labels, generator(seed, "labels"))
    return Scan(labelled, _seen_truth(seen.truth, missed, how), tuple(frames))


def typical(seed: int) -> Scanner:
    """The scanner of a seed: some rooms with drift, missing walls or no ceiling."""
    random = generator(seed, "scanner")
    share = random.uniform(0.2, 1.0) if random.random() < 0.4 else 0.0
    return Scanner(
        drift=0.08 * share,
        drift_degrees=0.8 * share,
        voxel=random.uniform(0.014, 0.020),
        wrong_labels=random.uniform(0.05, 0.10),
        ceiling=bool(random.random() < 0.7),
        missing_walls=int(random.random() < 0.25),
    )


def drifted(poses: Array, how: Scanner, random: np.random.Generator) -> Array:
    """(F, 4, 4) what the scanner takes its poses for: errors are slow waves of zero mean."""
    from scipy.spatial.transform import Rotation

    if len(poses) < 2 or not (how.drift or how.drift_degrees):
        return poses
    places, turns = (_waves(len(poses), random) for _ in range(2))
    # Drift grows on the way: a walk through a small room is over before it is large.
    way = np.linalg.norm(np.diff(poses[:, :3, 3], axis=0), axis=1).sum()
    share = min(1.0, way / WAY)
    errors = Rotation.from_rotvec(np.radians(share * how.drift_degrees) * turns).as_matrix()
    moved = [
        pose(error @ P[:3, :3], P[:3, 3] + share * how.drift * place)
        for P, error, place in zip(poses, errors, places, strict=True)
    ]
    return np.stack(moved)


def _waves(count: int, random: np.random.Generator) -> Array:
    """(count, 3) smooth vectors of zero mean, the longest of length 1."""
    t = np.linspace(0.0, 1.0, count)[:, None, None]
    rate, phase = random.uniform(0.4, 2.5, (1, 3, 3)), random.uniform(0, 2 * np.pi, (1, 3, 3))
    waves = np.sin(2 * np.pi * rate * t + phase).sum(axis=2)
    waves -= waves.mean(axis=0)
    return np.asarray(waves / np.linalg.norm(waves, axis=1).max())


def missed_walls(room: SimulatedRoom, how: Scanner, random: np.random.Generator) -> frozenset[int]:
    """Numbers of the walls that the scan does not show: never two neighbours."""
    count = len(room.floor)
    chosen: set[int] = set()
    for wall in random.permutation(count):
        beside = {(wall + 1) % count, (wall - 1) % count}
        if len(chosen) < how.missing_walls and not beside & chosen:
            chosen.add(int(wall))
    return frozenset(chosen)


def _seen_truth(truth: Truth, missed: frozenset[int], how: Scanner) -> Truth:
    rooms = tuple(
        replace(room, guessed=tuple(sorted(missed)), ceiling=room.ceiling if how.ceiling else None)
        for room in truth.rooms
    )
    return replace(truth, rooms=rooms)
