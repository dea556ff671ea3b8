"""Points of a cloud are cleaned, thinned and summed: identities, counts, bounded memory."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from openrooms_usd.errors import InputError
from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.points.thinning import clean, evened, thin
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


def cloud(points: np.ndarray, seed: int = 0) -> Cloud:
    rng, n = np.random.default_rng(seed), len(points)
    normals = rng.normal(size=(n, 3))
    return Cloud(
        points=points,
        normals=(normals / np.linalg.norm(normals, axis=1, keepdims=True)).astype("f4"),
        colors=rng.integers(0, 256, (n, 3)).astype("u1"),
        label=rng.integers(0, 5, n).astype("i4"),
        instance=rng.integers(0, 9, n).astype("i4"),
        confidence=rng.random(n).astype("f4"),
        sensor_origins=np.array([[1.0, 2.0, 3.0]]),
    )


def by_hand(points: np.ndarray, voxel: float) -> dict[tuple, list[int]]:
    """Rows by voxel, the slow way."""
    found: dict[tuple, list[int]] = {}
    for row, p in enumerate(points):
        found.setdefault(tuple(int(c) for c in np.floor(p / voxel)), []).append(row)
    return dict(sorted(found.items()))


@settings(max_examples=30, deadline=None)
@given(st.integers(1, 200), st.sampled_from([0.05, 0.3, 2.0]), st.sampled_from([0.0, 1e6, -37.3]))
def test_thinning_is_the_mean_of_each_voxel(count: int, voxel: float, offset: float) -> None:
    rng = np.random.default_rng(count)
    full = cloud(rng.uniform(-1, 1, (count, 3)) + offset)
    thinned, rows = thin(full, voxel), by_hand(full.points, voxel)
    assert len(thinned) == len(rows)
    for i, inside in enumerate(rows.values()):
        assert thinned.points[i] == pytest.approx(full.points[inside].mean(axis=0), abs=1e-9)
        mean = full.normals[inside].mean(axis=0)
        assert thinned.normals[i] == pytest.approx(mean / np.linalg.norm(mean), abs=1e-4)
        assert thinned.confidence[i] == pytest.approx(full.confidence[inside].mean(), abs=1e-6)
        assert np.abs(thinned.colors[i] - full.colors[inside].mean(axis=0)).max() <= 0.5
        for name in ("label", "instance"):
            values, votes = np.unique(getattr(full, name)[inside], return_counts=True)
            assert getattr(thinned, name)[i] == values[np.argmax(votes)]
    assert thinned.sensor_origins is full.sensor_origins


def test_points_alone_in_their_voxels_stay_as_they_are() -> None:
    lattice = np.stack(np.meshgrid(*[np.arange(4) * 0.1 + 0.03] * 3, indexing="ij"), -1)
    full = cloud(lattice.reshape(-1, 3) + 1e6)
    once = thin(full, 0.05)
    assert (once.points == full.points).all()
    assert (thin(once, 0.05).points == once.points).all()


def test_a_part_of_a_scan_thins_as_the_whole_does() -> None:
    full = cloud(np.random.default_rng(1).uniform(0, 2, (5000, 3)))
    left = full.take(full.points[:, 0] < 1.0)
    whole = thin(full, 0.1)
    assert thin(left, 0.1).points == pytest.approx(whole.points[whole.points[:, 0] < 1.0])


def test_a_cloud_is_evened_once() -> None:
    cloud = Cloud(np.random.default_rng(0).random((2000, 3)))
    assert evened(cloud) is evened(cloud)
    assert (evened(Cloud(cloud.points))[0] == evened(cloud)[0]).all()


def test_opposite_normals_do_not_vanish() -> None:
    normals = np.array([[0, 0, 1], [0, 0, -1]], "f4")
    thinned = thin(Cloud(np.zeros((2, 3)), normals=normals), 1.0)
    assert np.linalg.norm(thinned.normals, axis=1) == pytest.approx(1.0)


def test_far_outliers_do_not_overflow_the_voxels() -> None:
    points = np.array([[0, 0, 0], [0.001, 0, 0], [1e8, -1e8, 1e8], [9e7, 3.0, -1e8]])
    thinned = thin(Cloud(points), 0.005)
    assert len(thinned) == 3
    assert np.sort(thinned.points[:, 0]) == pytest.approx([0.0005, 9e7, 1e8])


def test_broken_points_and_repetitions_are_dropped_and_counted() -> None:
    points = np.random.default_rng(2).uniform(0, 1, (1000, 3))
    points[[3, 4, 5], [0, 1, 2]] = [np.nan, np.inf, 1e300]
    points[100:150] = points[200:250]
    points[900] = -0.0
    points[901] = 0.0
    full = cloud(points)
    kept, dropped = clean(full)
    assert (dropped.broken, dropped.duplicates) == (3, 51)
    assert len(kept) == 1000 - 54
    rows = [i for i in range(1000) if i not in (3, 4, 5, 901) and not 200 <= i < 250]
    assert (kept.points == points[rows]).all(), "the first of equal points stays, in its order"
    assert (kept.label == full.label[rows]).all()
    assert dropped.notes()[1] == "51 duplicated points were dropped"
    again, nothing = clean(kept)
    assert nothing.notes() == ()
    assert (again.points == kept.points).all()


@pytest.mark.parametrize(("broken", "dropped", "left"), [(5, False, 995), (400, True, 1000)])
def test_broken_normals(broken: int, dropped: bool, left: int) -> None:
    full = cloud(np.random.default_rng(3).uniform(0, 1, (1000, 3)))
    full.normals[:broken] = np.nan
    full.normals[0] = 0.0
    full.normals[broken:] *= 7.0
    kept, counts = clean(full)
    assert (counts.normals, counts.normals_dropped, len(kept)) == (broken, dropped, left)
    if dropped:
        assert kept.normals is None
    else:
        assert np.linalg.norm(kept.normals, axis=1) == pytest.approx(1.0, abs=1e-6)


def test_an_empty_cloud_stays_empty() -> None:
    empty = Cloud(np.empty((0, 3)))
    assert len(thin(clean(empty)[0], 0.1)) == 0
    assert len(clean(Cloud(np.full((3, 3), np.nan)))[0]) == 0
