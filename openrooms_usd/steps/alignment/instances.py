"""The instances of a scan: by what word each goes, and what may stand for it."""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.furniture.words import Meaning, meaning, plain
from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.registration.alignment import Rejected
from openrooms_usd.scan.registration.hints import Box, Hint
from openrooms_usd.usd.semantics import NYU40

# Where an instance begins: at this quantile of its heights, below which wrong labels may lie.
_BOTTOM_QUANTILE: Final = 0.02
# How class lists spell words otherwise than everybody.
_SPELT: Final = {"refridgerator": "refrigerator", "unlabeled": "object"}
_LEFT: Final = {
    "building": "it is part of the building, which the layout reconstructs",
    "nothing": "it is not part of a room",
}


@dataclass(frozen=True)
class Instance:
    """An instance of a scan.

    Attributes:
        number: In the scan.
        words: For it, the source's own first.
        bottom: Where it begins above the floor, metres.
    """

    number: int
    words: tuple[str, ...]
    bottom: float

    @property
    def meaning(self) -> Meaning:
        """What it is."""
        return meaning(self.words, self.bottom)

    @property
    def hint(self) -> Hint:
        """What alignment needs to know of it."""
        return hint_of(self.number, self.words, self.bottom)

    @property
    def left_out(self) -> Rejected:
        """Why it gets no CAD if it is not an object."""
        return Rejected(self.number, self.words[0], _LEFT[self.meaning.kind])


def hint_of(number: int, words: Sequence[str], bottom: float, box: Box | None = None) -> Hint:
    """What alignment needs to know of a thing.

    Args:
        number: Of its instance.
        words: For it, the source's own first; CADs of people's own folder may go by that.
        bottom: Where it begins above the floor, metres.
        box: Around it, where one is known.
    """
    choices = meaning(words, bottom).choices or ((plain(words[0]),),)
    return Hint(number, box=box, word=words[0], choices=choices)


def instances_of(cloud: Cloud) -> list[Instance] | None:
    """All instances by their words, or else by their points' classes.

    Args:
        cloud: Level: floor at z = 0, Z up, metres.

    Returns:
        None where nothing says what an instance is, or the cloud has none.
    """
    if cloud.instance is None or (cloud.label is None and not cloud.words):
        return None
    order = np.argsort(cloud.instance, kind="stable")
    numbers, starts = np.unique(cloud.instance[order], return_index=True)
    found = []
    for number, rows in zip(numbers.tolist(), np.split(order, starts[1:]), strict=True):
        if number > 0:
            words = (*(cloud.words or {}).get(number, ()), *_class(cloud.label, rows))
            bottom = float(np.quantile(cloud.points[rows, 2], _BOTTOM_QUANTILE))
            found.append(Instance(number, words, bottom))
    return found


def told_left_out(left: Sequence[Instance]) -> Iterator[str]:
    """One sentence about all instances that are not furniture."""
    if left:
        counts = Counter(instance.words[0] for instance in left)
        listed = ", ".join(f"{count} {word}" for word, count in sorted(counts.items()))
        yield f"not furniture, but parts of the building or outside the room: {listed}"


def _class(label: NDArray[np.int32] | None, rows: NDArray[np.intp]) -> tuple[str, ...]:
    """The class of most points, in words."""
    if label is None:
        return ("object",)
    number = int(np.bincount(np.maximum(label[rows], 0)).argmax())
    name = NYU40[number] if number < len(NYU40) else "object"
    return (_SPELT.get(name, name.replace("_", " ")),)
