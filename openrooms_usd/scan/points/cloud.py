"""A point cloud with its optional attributes."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields, replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.arrays import Array, Bytes, Floats

# Attributes that have no value for each point.
_OF_ALL: Final = ("sensor_origins", "words")


@dataclass(frozen=True, eq=False)
class Cloud:
    """Points of a scan, metres; None: the scan has no such attribute.

    Attributes:
        points: (N, 3) double precision, because scans may lie a million metres from the origin.
        normals: (N, 3) unit vectors, towards the sensor where that is known.
        colors: (N, 3) uint8, sRGB.
        label: (N,) NYU40 classes; 0 where there is none.
        instance: (N,) instance numbers; 0 where there is none.
        confidence: (N,) from 0 to 1.
        sensor_origins: (V, 3) positions of the sensor, V being unrelated to N.
        words: The source's words for instances by their numbers: its name, then what is said of it
            besides, such as a synset or a class.
    """

    points: Array
    normals: Floats | None = None
    colors: Bytes | None = None
    label: NDArray[np.int32] | None = None
    instance: NDArray[np.int32] | None = None
    confidence: Floats | None = None
    sensor_origins: Array | None = None
    words: Mapping[int, tuple[str, ...]] | None = None

    def __len__(self) -> int:
        return len(self.points)

    def take(self, rows: NDArray[Any]) -> "Cloud":
        """Some of the points, by row numbers or a mask."""
        return self._each(lambda values: values[rows])

    def moved(self, matrix: Array) -> "Cloud":
        """The cloud after a similarity or rigid motion (4, 4)."""
        linear = matrix[:3, :3]
        turn = linear / np.cbrt(np.linalg.det(linear))
        normals, sensor_origins = self.normals, self.sensor_origins
        return replace(
            self,
            points=self.points @ linear.T + matrix[:3, 3],
            normals=None if normals is None else (normals @ turn.T).astype(np.float32),
            sensor_origins=None
            if sensor_origins is None
            else sensor_origins @ linear.T + matrix[:3, 3],
        )

    def _each(self, change: Callable[[NDArray[Any]], NDArray[Any]]) -> "Cloud":
        kept: dict[str, Any] = {
            field.name: change(values)
            for field in fields(self)
            if field.name not in _OF_ALL and (values := getattr(self, field.name)) is not None
        }
        return replace(self, **kept)
