"""Furniture in clouds without labels: pieces, names, and what is left unnamed."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from openrooms_usd.arrays import Array
from openrooms_usd.errors import InputError
from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.reconstruction import find_rooms
from openrooms_usd.scan.registration.hints import Box, Hint, corners_of
from openrooms_usd.scan.results import FoundRoom
from openrooms_usd.scan.segmentation.boxes import boxes_of
from openrooms_usd.scan.segmentation.byshape import ShapeSegmenter
from openrooms_usd.scan.segmentation.contract import Segments, checked
from openrooms_usd.scan.segmentation.naming import UNNAMED, things_of, with_labels
from orusd_scans.plainscan import ScanImporter

# x, y, z from and to, metres.
Block = tuple[float, float, float, float, float, float]

ROOM = FoundRoom(
    normal=np.array([0.0, 0.0, 1.0]),
    point=np.zeros(3),
    corners=np.array([[0, 0, 0], [5, 0, 0], [5, 4, 0], [0, 4, 0]], float),
    ceiling=2.6,
)
SPACING = 0.02


def block(box: Block) -> Array:
    """Points on all faces of a box along the axes."""
    low, high = np.array(box[:3]), np.array(box[3:])
    axes = [np.arange(a, b + 0.5 * SPACING, SPACING) for a, b in zip(low, high, strict=True)]
    faces = []
    for axis in range(3):
        others = [k for k in range(3) if k != axis]
        grid = np.stack(np.meshgrid(*(axes[k] for k in others)), -1).reshape(-1, 2)
        for end in (low[axis], high[axis]):
            face = np.full((len(grid), 3), end)
            face[:, others] = grid
            faces.append(face)
    return np.concatenate(faces)


def scanned(*blocks: Block, seed: int = 0) -> Cloud:
    """A room of 5 by 4 m with blocks in it, with the noise of a good scanner."""
    shell = (0.0, 0.0, 0.0, 5.0, 4.0, 2.6)
    points = np.concatenate([block(box) for box in (shell, *blocks)])
    noise = np.random.default_rng(seed).normal(scale=0.002, size=points.shape)
    return Cloud(points + noise)


def at(x: float, y: float, blocks: Sequence[Block]) -> list[Block]:
    """Blocks moved in the plan."""
    return [(a + x, b + y, c, d + x, e + y, f) for a, b, c, d, e, f in blocks]


def legs(width: float, depth: float, height: float) -> list[Block]:
    return [
        (x, y, 0.0, x + 0.05, y + 0.05, height)
        for x in (0.0, width - 0.05)
        for y in (0.0, depth - 0.05)
    ]


TABLE = [(0.0, 0.0, 0.70, 1.4, 0.8, 0.74), *legs(1.4, 0.8, 0.70)]
CHAIR = [
    (0.0, 0.0, 0.42, 0.45, 0.45, 0.46),
    (0.0, 0.41, 0.46, 0.45, 0.45, 0.95),
    *legs(0.45, 0.45, 0.42),
]
BED = [(0.0, 0.0, 0.05, 2.0, 1.4, 0.5)]
NIGHT_STAND = [(0.0, 0.0, 0.0, 0.45, 0.4, 0.62)]
CABINET = [(0.0, 0.0, 0.0, 1.2, 0.45, 0.9)]
SOFA = [
    (0.0, 0.0, 0.05, 1.9, 0.85, 0.42),
    (0.0, 0.65, 0.42, 1.9, 0.85, 0.85),
    (0.0, 0.0, 0.42, 0.15, 0.85, 0.6),
    (1.75, 0.0, 0.42, 1.9, 0.85, 0.6),
]
CARTON = [(0.0, 0.0, 0.0, 0.5, 0.4, 0.4)]


@pytest.mark.one_in(3)
@pytest.mark.parametrize(
    ("blocks", "word"),
    [
        (at(2.0, 1.5, TABLE), "table"),
        (at(2.0, 1.5, CHAIR), "chair"),
        (at(2.0, 1.0, BED), "bed"),
        (at(2.0, 1.5, SOFA), "sofa"),
        (at(1.5, 0.0, CABINET), "cabinet"),
        (at(2.0, 1.5, CARTON), UNNAMED),
    ],
)
def test_a_piece_is_found_whole_and_named_where_its_shape_is_telling(
    blocks: list[Block], word: str
) -> None:
    cloud = scanned(*blocks)
    found = ShapeSegmenter().segment(cloud, (ROOM,))
    assert found.words == {1: word}
    points = cloud.points[found.instance == 1]
    ends = np.array(blocks)
    low, high = np.quantile(points, (0.005, 0.995), axis=0)
    assert np.abs(low[:2] - ends[:, :2].min(axis=0)).max() < 0.12  # 10 cm are the wall's
    assert np.abs(high - ends[:, 3:].max(axis=0)).max() < 0.06
    # Nothing of the room's own shell beside it.
    inside = (points > ends[:, :3].min(axis=0) - 0.08) & (points < ends[:, 3:].max(axis=0) + 0.08)
    assert inside.all()


def test_pieces_that_touch_are_two() -> None:
    cloud = scanned(*at(1.0, 1.0, BED), *at(3.0, 1.0, NIGHT_STAND))
    found = ShapeSegmenter().segment(cloud, (ROOM,))
    assert sorted(found.words.values()) == ["bed", UNNAMED]
    stand = found.instance[np.abs(cloud.points - [3.2, 1.2, 0.62]).max(axis=1) < 0.1]
    bed = found.instance[np.abs(cloud.points - [2.0, 1.7, 0.5]).max(axis=1) < 0.3]
    assert len(set(stand.tolist())) == len(set(bed.tolist())) == 1
    assert stand[0] != bed[0]


def test_chairs_at_a_table_are_chairs() -> None:
    chairs = [*at(2.1, 2.15, CHAIR), *at(2.8, 2.15, CHAIR)]  # a part of the seat is below the top
    found = ShapeSegmenter().segment(scanned(*at(2.0, 1.5, TABLE), *chairs), (ROOM,))
    assert sorted(found.words.values()) == ["chair", "chair", "table"]


def test_an_empty_room_and_an_empty_cloud_hold_nothing() -> None:
    assert ShapeSegmenter().segment(scanned(), (ROOM,)).words == {}
    few = Cloud(scanned().points[:100])
    assert ShapeSegmenter().segment(few, (ROOM,)).words == {}


def test_what_is_flat_against_a_wall_or_outside_is_no_furniture() -> None:
    leaf = (1.0, 0.05, 0.0, 1.9, 0.09, 2.0)  # a door that stands open along the wall
    outside = (6.0, 1.0, 0.0, 7.0, 2.0, 1.0)
    assert ShapeSegmenter().segment(scanned(leaf, outside), (ROOM,)).words == {}


def test_words_become_things_and_the_room_keeps_its_classes() -> None:
    rng = np.random.default_rng(1)
    sofas = [rng.uniform(0, 0.3, (400, 3)) + np.array([x, 0, 0]) for x in (0.0, 2.0)]
    wall = rng.uniform(0, 1, (300, 3)) * [1, 0, 1]
    points = np.concatenate([*sofas, wall, rng.uniform(0, 1, (10, 3))])
    words = ["Sofa"] * 800 + ["wall"] * 300 + [""] * 10
    found = with_labels(Cloud(points), words)
    assert found.words == {1: ("sofa",), 2: ("sofa",)}
    assert found.instance is not None
    assert found.label is not None
    assert set(found.instance[:400]) == {1}
    assert set(found.instance[400:800]) == {2}
    assert not found.instance[800:].any()
    assert set(found.label[800:1100]) == {1}
    numbered = replace(Cloud(points), instance=np.repeat([7, 0], [800, 310]).astype("i4"))
    assert with_labels(numbered, words).words == {7: ("sofa",)}


def test_things_of_one_class_are_its_connected_parts() -> None:
    rng = np.random.default_rng(2)
    points = np.concatenate(
        [rng.uniform(0, 0.4, (500, 3)) + np.array([x, 0, 0]) for x in (0.0, 0.3, 1.5)]
    )
    kind = np.repeat([5, 5, 5], 500)
    kind[:3] = 0
    found = things_of(Cloud(points), kind)
    assert set(found[3:1000]) == {1}
    assert set(found[1000:]) == {2}
    assert not found[:3].any()


@pytest.mark.parametrize("bad", [np.zeros(3, "i4"), np.zeros((4, 1), "i4"), np.zeros(4)])
def test_segmenters_are_checked(bad: NDArray[np.generic]) -> None:
    with pytest.raises(InputError, match=r"'mine' gave an array of shape .* for 4 points"):
        checked(Segments(bad, {}), 4, "mine")  # type: ignore[arg-type]
    whole = checked(Segments(np.array([-1, 0, 2, 2]), {2: "sofa"}), 4, "mine")
    assert whole.instance.tolist() == [0, 0, 2, 2]
    assert whole.instance.dtype == np.int32


_LABELS = {5: "chair", 6: "sofa", 7: "table", 4: "bed", 3: "cabinet"}
_SEATS = {"chair", "armchair", "sofa"}


@pytest.mark.slow
def test_a_real_scan_without_its_labels(real: Callable[[str], Path]) -> None:
    """No name is wrong, and the chairs and the sofa that stand apart are named."""
    cloud = ScanImporter().read(real("real_dev/data/scannet_0002_00/scan.ply")).cloud
    assert cloud is not None
    assert cloud.label is not None
    layout = find_rooms(replace(cloud, label=None, instance=None))
    found = ShapeSegmenter().segment(layout.cloud, layout.rooms)
    named = {n: word for n, word in found.words.items() if word != UNNAMED}
    truth = {n: _LABELS.get(_most(cloud.label[found.instance == n])) for n in named}
    right = [n for n in named if truth[n] == named[n] or {truth[n], named[n]} <= _SEATS]
    assert len(named) >= 3
    assert len(right) == len(named), (named, truth)


def _most(values: NDArray[np.int32]) -> int:
    return int(np.bincount(values).argmax())


def test_boxes_stand_along_the_walls_and_apart() -> None:
    """Where two boxes overlap a little the smaller one is cut; one inside of another stays."""
    blocks = [
        (1.0, 1.0, 0.0, 2.0, 2.0, 0.8),
        (1.9, 1.2, 0.0, 2.4, 1.7, 0.5),
        (1.3, 1.3, 0.0, 1.5, 1.5, 0.3),
    ]
    parts = [block(box) for box in blocks]
    instance = np.repeat([1, 2, 3], [len(part) for part in parts]).astype("i4")
    found = boxes_of(Cloud(np.concatenate(parts)), instance, (1, 2, 3), (ROOM,))
    np.testing.assert_allclose(found[1].center, [1.5, 1.5, 0.4], atol=0.02)
    np.testing.assert_allclose(found[1].size, [1.0, 1.0, 0.8], atol=0.04)
    low, high = _ends(found[2])
    np.testing.assert_allclose(low[:2], [2.0, 1.2], atol=0.03)
    np.testing.assert_allclose(high, [2.4, 1.7, 0.5], atol=0.03)
    np.testing.assert_allclose(found[3].size, [0.2, 0.2, 0.3], atol=0.03)


def _ends(box: Box) -> tuple[Array, Array]:
    corners = corners_of(Hint(1, box=box), ())
    assert corners is not None
    return corners.min(axis=0), corners.max(axis=0)


def test_sparse_scans_have_whole_pieces() -> None:
    """Points a decimetre apart: the sides of a cabinet hold together."""
    dense = scanned(*at(1.5, 0.0, [(0.0, 0.0, 0.0, 2.0, 0.6, 1.0)]))
    cells = np.floor(dense.points / 0.09).astype(int)
    _, rows = np.unique(cells, axis=0, return_index=True)
    found = ShapeSegmenter().segment(dense.take(rows), (ROOM,))
    assert len(found.words) == 1
    low, high = np.quantile(dense.points[rows][found.instance == 1], (0.02, 0.98), axis=0)
    np.testing.assert_allclose(high - low, [2.0, 0.6, 1.0], atol=0.2)
