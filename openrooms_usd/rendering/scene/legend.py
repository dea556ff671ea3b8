"""What the numbers in label channels mean."""

from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True)
class Legend:
    """What the numbers in the label channels mean.

    Attributes:
        semantic: Number to OpenRooms-45 class name.
        semantic_nyu40: Number to NYU-40 class name.
        semantic_ade20k: Number to ADE20K class name.
        semantic_coco: Number to COCO class name.
        instance: Number to prim path.
        part: Number to prim path.
        material: Number to prim path.
        category: Number of an instance to our category name.
    """

    semantic: Mapping[int, str] = field(default_factory=dict)
    semantic_nyu40: Mapping[int, str] = field(default_factory=dict)
    semantic_ade20k: Mapping[int, str] = field(default_factory=dict)
    semantic_coco: Mapping[int, str] = field(default_factory=dict)
    instance: Mapping[int, str] = field(default_factory=dict)
    part: Mapping[int, str] = field(default_factory=dict)
    material: Mapping[int, str] = field(default_factory=dict)
    category: Mapping[int, str] = field(default_factory=dict)
