"""Clouds whose points are labelled, in words or by class, but not told apart into things."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.points.thinning import groups, majority

# Parts of one label that are farther apart than this are different things, metres; smaller parts
# than so many places of the thinned cloud are none.
_APART_M: Final = 0.1
_THINNING_M: Final = 0.03
_MIN_PLACES: Final = 30
# Classes of NYU40 that are the room's, and the class of what has none.
SHELL_CLASSES: Final = {"wall": 1, "floor": 2, "door": 8, "window": 9, "ceiling": 22}
_OTHER_PROP: Final = 40


def with_labels(cloud: Cloud, labels: Sequence[str]) -> Cloud:
    """A cloud whose points have a word each.

    Points of the room itself (wall, floor, ceiling, door, window) get that class. What else has a
    word belongs to a thing: to that of its number where the cloud has numbers, else to a connected
    part of its word. A thing has the word that most of its points have.
    """
    plain = [label.strip().lower().replace("_", " ") for label in labels]
    names, of_point = np.unique(np.array(plain), return_inverse=True)
    room = np.array([SHELL_CLASSES.get(str(name), 0) for name in names], dtype=np.int32)
    thing = np.array([bool(name) and str(name) not in SHELL_CLASSES for name in names])
    label = np.where(thing, _OTHER_PROP, room).astype(np.int32)[of_point]
    instance = cloud.instance
    if instance is None or not instance.any():
        instance = things_of(cloud, np.where(thing[of_point], of_point + 1, 0))
    rows = np.flatnonzero(instance > 0)
    group, first = groups(instance[rows].astype(np.int64))
    best = majority(group, of_point[rows].astype(np.int32))
    numbers = instance[rows][first].tolist()
    words = {
        number: (str(names[row]),)
        for number, row in zip(numbers, best.tolist(), strict=True)
        if names[row]
    }
    return replace(cloud, label=label, instance=instance, words=words)


def things_of(cloud: Cloud, kind: NDArray[np.int64]) -> NDArray[np.int32]:
    """(N,) numbers of things, from 1: connected parts of points of one kind; 0 where there is none.

    Args:
        cloud: N points, metres.
        kind: (N,) of each point; 0 where it belongs to no thing.
    """
    found, count = np.zeros(len(cloud), dtype=np.int32), 0
    for number in np.unique(kind[kind > 0]):
        rows = np.flatnonzero(kind == number)
        cells = np.floor(cloud.points[rows] / _THINNING_M).astype(np.int64)
        places, place = np.unique(cells, axis=0, return_inverse=True)
        pairs = KDTree(places * _THINNING_M).query_pairs(_APART_M, output_type="ndarray")
        graph = coo_array((np.ones(len(pairs)), pairs.T), shape=(len(places),) * 2)
        _, part = connected_components(graph, directed=False)
        large = np.flatnonzero(np.bincount(part) >= _MIN_PLACES)
        order = np.zeros(int(part.max()) + 1, dtype=np.int32)
        order[large] = np.arange(len(large)) + count + 1
        found[rows] = order[part][place.reshape(-1)]
        count += len(large)
    return found
