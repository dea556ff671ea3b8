"""Wrong labels, as segmentation networks give them: in blobs, and at the borders of things."""

from dataclasses import replace
from typing import Any, Final

import numpy as np

from openrooms_usd.arrays import Ints
from openrooms_usd.scan.points.cloud import Cloud

# Which part of the wrong labels lies at borders; there, how far a label spreads, metres.
BORDERS: Final = 0.4
SPREAD: Final = (0.02, 0.06)
# Elsewhere the radius of a blob, metres.
BLOB: Final = (0.05, 0.25)
# One blob in two takes the label of any thing of the room, the others that of the next thing.
FOREIGN: Final = 0.5
NEIGHBOURS: Final = 24
# Borders are looked for around so many points.
TRIED: Final = 50_000


def spoiled(cloud: Cloud, wrong: float, random: np.random.Generator) -> Cloud:
    """The cloud with a part of its labels wrong, and instances with them.

    Args:
        cloud: With labels and instances.
        wrong: The part of points whose label or instance is not the true one.
        random: Decides which.
    """
    from scipy.spatial import cKDTree

    if cloud.label is None or cloud.instance is None or not wrong or len(cloud) <= NEIGHBOURS:
        return cloud
    true = cloud.label.astype(np.int64) << 32 | cloud.instance.astype(np.int64)
    if (true == true[0]).all():
        return cloud
    tree, source = cKDTree(cloud.points), np.arange(len(cloud))
    _at_borders(source, true, tree, BORDERS * wrong, random)
    _in_blobs(source, true, tree, wrong, random)
    return replace(cloud, label=cloud.label[source], instance=cloud.instance[source])


def _at_borders(
    source: Ints, true: Ints, tree: Any, wrong: float, random: np.random.Generator
) -> None:
    """Let things spread over their borders; changes ``source``, whose label each point takes."""
    tried = random.permutation(len(true))[:TRIED]
    near = tree.query(tree.data[tried], k=NEIGHBOURS)[1]
    differs = true[near] != true[tried, None]
    bad = 0
    for row in np.flatnonzero(differs.any(axis=1)):
        if bad >= wrong * len(true):
            return
        other = near[row, differs[row].argmax()]
        bad += _paint(source, true, tree, other, tried[row], random.uniform(*SPREAD))


def _in_blobs(
    source: Ints, true: Ints, tree: Any, wrong: float, random: np.random.Generator
) -> None:
    bad, tries = int((true[source] != true).sum()), 0
    while bad < wrong * len(true) and tries < 10_000:
        tries += 1
        centre, other = random.integers(len(true), size=2)
        radius = random.uniform(*BLOB)
        if random.random() > FOREIGN:
            near = np.sort(tree.query_ball_point(tree.data[centre], 2 * radius))
            others = near[true[near] != true[centre]]
            if not len(others):
                continue
            other = random.choice(others)
        bad += _paint(source, true, tree, centre, other, radius)


def _paint(source: Ints, true: Ints, tree: Any, centre: int, other: int, radius: float) -> int:
    """Give all points of a ball the label of another; returns how many more are wrong now."""
    rows = np.array(tree.query_ball_point(tree.data[centre], radius))
    before = int((true[source[rows]] != true[rows]).sum())
    source[rows] = other
    return int((true[other] != true[rows]).sum()) - before
