"""Free-standing walls of the layout stage: as they are described or captured, and as prims."""

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray
from pxr import Sdf, Usd, Vt

from openrooms_usd import names
from openrooms_usd.capture import CapturedPartition
from openrooms_usd.description import layout
from openrooms_usd.description.naming import captured_names
from openrooms_usd.errors import DescriptionError
from openrooms_usd.geometry.partitions import Partition, misplaced, partition_walls
from openrooms_usd.geometry.walls import Wall

Array = NDArray[np.float64]

# Captured partitions whose top is nearer to the ceiling than this reach it, metres.
_TO_THE_CEILING_M: Final = 0.15


def described_partitions(
    described: Sequence[layout.Partition], corners: Array, height: float
) -> list[Partition]:
    """The partitions of a description.

    Args:
        described: As they are described.
        corners: (N, 2) the room's polygon, metres.
        height: Floor to ceiling, metres.

    Raises:
        DescriptionError: Some do not stand in the room.
    """
    made = [
        Partition(name, np.array(row.line), row.thickness, _below(row.height, height))
        for name, row in layout.named_partitions(described)
    ]
    mistakes = [
        f"{one.name} {reason}" for one in made if (reason := misplaced(one, corners)) is not None
    ]
    if mistakes:
        raise DescriptionError(
            "; ".join(mistakes), place="layout.partitions", remedy="change the ends of their lines"
        )
    return made


def captured_partitions(
    captured: Sequence[CapturedPartition],
    corners: Array,
    height: float,
    *,
    described: Sequence[layout.Partition],
    notes: list[str],
) -> list[tuple[CapturedPartition, Partition]]:
    """The partitions of a capture that stand in the room, each with its source.

    Args:
        captured: As they were captured.
        corners: (N, 2) the room's polygon, metres.
        height: Floor to ceiling, metres.
        described: The partitions of the description, whose names stay theirs.
        notes: Receives a sentence for each that is left out.
    """
    taken = {name for name, _ in layout.named_partitions(described)}
    made = []
    for name, source in zip(
        captured_names([("partition", row.id) for row in captured], taken), captured, strict=True
    ):
        thickness = source.thickness or names.PARTITION_THICKNESS
        one = Partition(name, source.ends, thickness, _below(source.height, height))
        if reason := misplaced(one, corners):
            notes.append(f"dropped the inner wall {source.id}: it {reason}")
        else:
            made.append((source, one))
    return made


def _below(height: float | None, ceiling: float) -> float | None:
    """A height that ends below the ceiling, or None."""
    return None if height is None or height > ceiling - _TO_THE_CEILING_M else height


def walls_within(
    partitions: Sequence[Partition], corners: Array, notes: list[str]
) -> tuple[Wall, ...]:
    """The partitions as walls, with a note for what is too short to be built."""
    walls = partition_walls(partitions, corners)
    built = {wall.partition for wall in walls}
    notes += [
        f"left out {one.name}: nothing of it is left between the walls it ends at"
        for one in partitions
        if one.name not in built
    ]
    return walls


def author_partition(
    prim: Usd.Prim, wall: Wall, height: float, source: CapturedPartition | None
) -> None:
    """Say of a wall's prim that it stands free, and where it was captured.

    Args:
        prim: The wall's mesh.
        wall: The wall.
        height: What it reaches up to, metres.
        source: What it is made from, if anything.
    """
    kinds = Sdf.ValueTypeNames
    outline = np.ascontiguousarray(wall.to_plan(wall.outline))
    prim.AddAppliedSchema(names.PARTITION_API)
    _set(prim, names.PARTITION_OUTLINE, kinds.Double2Array, Vt.Vec2dArray.FromNumpy(outline))
    _set(prim, names.PARTITION_HEIGHT, kinds.Double, height)
    if source:
        prim.AddAppliedSchema(names.SOURCE_API)
        _set(prim, names.SOURCE_ID, kinds.String, source.id)
        if source.confidence:
            _set(prim, names.SOURCE_CONFIDENCE, kinds.Token, source.confidence)


def _set(prim: Usd.Prim, name: str, kind: Sdf.ValueTypeName, value: object) -> None:
    prim.CreateAttribute(name, kind, custom=False).Set(value)
