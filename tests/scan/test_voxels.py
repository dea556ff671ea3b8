"""Sums over voxels: the order does not matter, memory is bounded, majorities win."""

import numpy as np
import pytest

from openrooms_usd.errors import InputError
from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.points.thinning import thin
from openrooms_usd.scan.points.voxels import Samples, Table, VoxelSums

ROOMY = 1 << 28


def samples(points: np.ndarray, **more: np.ndarray) -> Samples:
    up = np.tile([0.0, 0.0, 1.0], (len(points), 1))
    return Samples(points, more.pop("weights", np.ones(len(points))), up, **more)


def scattered(count: int, seed: int, size: float = 1.0) -> np.ndarray:
    return np.random.default_rng(seed).uniform(-size, size, (count, 3))


def all_of(points: list[np.ndarray], voxel: float, memory: int) -> tuple[VoxelSums, Table]:
    sums = VoxelSums(voxel, memory)
    for one in points:
        sums.add(samples(one))
    return sums, sums.merged()


def test_single_points_a_time_are_a_plain_mean() -> None:
    points = scattered(400, 0)
    _, table = all_of([p[None] for p in points], 0.25, ROOMY)
    assert np.sort(table.points(), axis=0) == pytest.approx(
        np.sort(thin(Cloud(points), 0.25).points, axis=0), abs=1e-9
    )
    assert table.seen.sum() == 400


def test_an_observation_counts_once_for_a_voxel() -> None:
    sums = VoxelSums(1.0, ROOMY)
    sums.add(samples(np.full((100, 3), 0.2)))
    sums.add(samples(np.full((1, 3), 0.6)))
    table = sums.merged()
    assert table.seen.tolist() == [2]
    assert table.points()[0] == pytest.approx([0.4] * 3)


def test_weights_are_inverse_variances() -> None:
    sums = VoxelSums(1.0, ROOMY)
    for x, weight in ((0.1, 3.0), (0.5, 1.0)):
        sums.add(samples(np.full((1, 3), x), weights=np.array([weight])))
    assert sums.merged().points()[0] == pytest.approx([0.2] * 3)
    assert sums.merged().weight.tolist() == [4.0]


def test_merging_on_the_way_changes_nothing() -> None:
    points = [scattered(500, seed) for seed in range(20)]
    _, once = all_of(points, 0.2, ROOMY)
    # So little memory that rows are merged after almost every observation, but voxels stay.
    sums, often = all_of(points, 0.2, 88 * 4 * len(once.key))
    assert sums.voxel == 0.2
    assert (once.key == often.key).all()
    assert once.points() == pytest.approx(often.points(), abs=1e-12)
    assert (once.seen == often.seen).all()


@pytest.mark.parametrize("most", [8, 20, 300])
def test_voxels_grow_rather_than_memory(most: int) -> None:
    points = [scattered(300, seed, 3.0) + 1e6 for seed in range(10)]
    sums, table = all_of(points, 0.05, 88 * 4 * most)
    assert 0 < len(table.key) <= most
    ratio = np.log2(sums.voxel / 0.05)
    assert ratio == pytest.approx(round(ratio))
    assert ratio >= 1
    everything = np.concatenate(points)
    total = (table.place.sum(axis=0)) / table.weight.sum() + table.origin
    assert total == pytest.approx(everything.mean(axis=0), abs=0.2)
    # Doubled voxels hold what voxels of that size would have held from the start.
    origin = np.rint(points[0].mean(axis=0))
    cells = np.unique(np.floor((everything - origin) / sums.voxel), axis=0)
    assert len(table.key) == len(cells)


def test_memory_that_is_never_enough_ends_at_the_octants() -> None:
    sums, table = all_of([scattered(300, 0), scattered(300, 1)], 0.1, 0)
    assert len(table.key) == 8
    assert table.seen.sum() > 8
    assert np.isfinite(sums.voxel)


def test_a_majority_of_labels_wins_in_any_order() -> None:
    rng = np.random.default_rng(5)
    votes = np.array([7] * 26 + [3] * 15 + [9] * 10)
    for _ in range(5):
        sums = VoxelSums(1.0, 88 * 4)
        for label in rng.permutation(votes):
            sums.add(samples(np.full((1, 3), 0.5), label=np.array([label])))
        assert sums.merged().label.tolist() == [7]


def test_no_label_is_no_vote() -> None:
    sums = VoxelSums(1.0, ROOMY)
    for label in (0, 0, 0, 4):
        sums.add(samples(np.full((1, 3), 0.5), label=np.array([label])))
    assert sums.merged().label.tolist() == [4]
    assert sums.has_label
    assert not sums.has_instance


def test_colours_are_means_of_those_that_have_them() -> None:
    sums = VoxelSums(1.0, ROOMY)
    sums.add(samples(np.full((1, 3), 0.5)))
    for value in (100, 200):
        colors = np.full((1, 3), value, np.uint8)
        sums.add(samples(np.full((1, 3), 0.5), colors=colors))
    assert sums.merged().colors_seen().tolist() == [[150, 150, 150]]


def test_a_path_into_the_distance_is_refused() -> None:
    sums = VoxelSums(0.01, ROOMY)
    sums.add(samples(np.zeros((1, 3))))
    with pytest.raises(InputError, match="reaches more than 10 km"):
        sums.add(samples(np.full((1, 3), 2e4)))
