"""What a user knows of objects before alignment: models of another size, and rough poses."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final, Literal

import numpy as np
from scipy.spatial.transform import Rotation

from benchmarks.scan.truth import Cad, Truth
from openrooms_usd.arrays import Array
from openrooms_usd.draws import generator
from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.registration.hypotheses import Box
from openrooms_usd.scan.results import FoundObject, Pose

# Standard deviations of a rough pose: metres, degrees of its heading, and a part of each axis.
PLACE, TURN, SCALE = 0.10, 10.0, 0.10
# Models come this much smaller or larger than in the room, along each axis.
SIZES: Final = (0.8, 1.25)
# Objects count that are furniture, show so many points, and are as large as this, metres.
LEAST_POINTS: Final = 300
LEAST_SIZE: Final = 0.3
HANGING: Final = frozenset(
    {"ceiling_lamp", "clock", "curtain", "picture", "pillow", "rug", "wall_lamp", "whiteboard"}
)


@dataclass(frozen=True, eq=False)
class RoughHint:
    """One object's start: a pose that is off, or a box whose heading may be off by quarters."""

    instance: int
    cad: str
    category: str
    pose: Pose | None = None
    box: Box | None = None


def stretched(truth: Truth, seed: int) -> Truth:
    """The same room, but its models have other sizes, so that true scales are not 1."""
    cads, factors = {}, {}
    for name, cad in truth.cads.items():
        factor = np.exp(generator(seed, "size", name).uniform(*np.log(SIZES), size=3))
        if cad.symmetry in ("4", "inf"):
            factor[1] = factor[0]
        factors[name] = factor
        cads[name] = replace(cad, vertices=cad.vertices / factor)
    objects = tuple(_scaled(item, factors[item.cad]) for item in truth.objects)
    return replace(truth, cads=cads, objects=objects)


def _scaled(item: FoundObject, factor: Array) -> FoundObject:
    pose = replace(item.pose, scale=item.pose.scale * factor)
    return replace(item, pose=pose, placed=pose)


def countable(truth: Truth, cloud: Cloud) -> list[FoundObject]:
    """The furniture that the scan shows enough of to be aligned."""
    assert cloud.instance is not None
    numbers, counts = np.unique(cloud.instance, return_counts=True)
    shown = dict(zip(numbers.tolist(), counts.tolist(), strict=True))
    return [
        item
        for item in truth.objects
        if item.category not in HANGING
        and shown.get(item.instance, 0) >= LEAST_POINTS
        and extent(truth.cads[item.cad], item.pose).max() >= LEAST_SIZE
    ]


def extent(cad: Cad, pose: Pose) -> Array:
    """(3,) size along the CAD's own axes, metres."""
    used = cad.vertices[np.unique(cad.faces)]
    return np.asarray(np.ptp(used, axis=0) * pose.scale)


def rough(
    items: Sequence[FoundObject], cads: dict[str, Cad], seed: int, kind: Literal["pose", "box"]
) -> list[RoughHint]:
    """Hints with the noise of `PLACE`, `TURN` and `SCALE` (normal), boxes also turned by quarters.

    Args:
        items: The true objects, in a frame with Z up.
        cads: Their models.
        seed: Decides the noise.
        kind: Which hints.
    """
    hints = []
    for item in items:
        random = generator(seed, kind, item.instance)
        shift = random.normal(0.0, PLACE, 3)
        turn = Rotation.from_euler("z", random.normal(0.0, TURN), degrees=True)
        scale = np.exp(random.normal(0.0, SCALE, 3))
        true = Rotation.from_quat(item.pose.rotation, scalar_first=True)
        R = turn * true
        if kind == "pose":
            off = Pose(
                item.pose.translation + shift, R.as_quat(scalar_first=True), item.pose.scale * scale
            )
            hints.append(RoughHint(item.instance, item.cad, item.category, pose=off))
            continue
        used = cads[item.cad].vertices[np.unique(cads[item.cad].faces)]
        middle = true.apply((used.min(axis=0) + used.max(axis=0)) / 2 * item.pose.scale)
        size = extent(cads[item.cad], item.pose) * scale
        quarter = int(random.integers(4))
        R = R * Rotation.from_euler("z", 90 * quarter, degrees=True)
        box = Box(
            item.pose.translation + middle + shift,
            size if quarter % 2 == 0 else size[[1, 0, 2]],
            R.as_quat(scalar_first=True),
        )
        hints.append(RoughHint(item.instance, item.cad, item.category, box=box))
    return hints
