"""The contract of segmenters: which points of a scan belong to which thing, and what it is."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.errors import InputError
from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.results import FoundRoom


@dataclass(frozen=True, eq=False)
class Segments:
    """The things of a scan.

    Attributes:
        instance: (N,) for each point the number of its thing, from 1; 0 where there is none.
        words: What each thing is, by its number: any word, such as ``sofa``. An object with an
            unknown word, or without one, becomes a box of its size.
    """

    instance: NDArray[np.int32]
    words: Mapping[int, str]


class Segmenter(Protocol):
    """Finds the things in a scan; registered as an entry point ``openrooms_usd.segmenters``."""

    def segment(self, cloud: Cloud, rooms: Sequence[FoundRoom]) -> Segments:
        """Find the things.

        Args:
            cloud: N points in metres, floor at z = 0, Z up, with colours, normals and positions of
                the sensor where the scan has them.
            rooms: What was found of the rooms, in the same frame.

        Raises:
            InputError: It cannot, and why.
        """
        ...


def checked(segments: Segments, count: int, name: str) -> Segments:
    """Segments that fit their scan.

    Args:
        segments: As a segmenter gave them.
        count: How many points the scan has.
        name: The segmenter's name, for messages.

    Raises:
        InputError: They are not one whole number for each point.
    """
    instance = np.asarray(segments.instance)
    if instance.shape != (count,) or instance.dtype.kind not in "iu":
        raise InputError(
            f"the segmenter {name!r} gave an array of shape {instance.shape} and type "
            f"{instance.dtype} for {count} points",
            place="furniture.segmenter",
            remedy="it must give one whole number for each point",
        )
    whole = np.where(instance > 0, instance, 0).astype(np.int32)
    return Segments(whole, {int(number): str(word) for number, word in segments.words.items()})
