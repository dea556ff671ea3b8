"""Paths that a file describes: where the camera is at some times, and what it looks at."""

from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.description.reading import read_yaml
from openrooms_usd.errors import InputError
from openrooms_usd.geometry.framing import FOV_DEG
from openrooms_usd.geometry.pinhole import look_at
from openrooms_usd.rendering.paths.spline import interpolated
from openrooms_usd.untrusted import read_text

Array = NDArray[np.float64]

SUFFIXES: Final = (".yaml", ".yml", ".json")
_KEYS: Final = {"time", "position", "target"}
_TOP: Final = {"keys", "fov"}
_REMEDY: Final = "give `keys`, each with time, position [x, y, z] and target [x, y, z]"
_FOVS_DEG: Final = (1.0, 170.0)


class Keyframes:
    """Positions and targets at rising times.

    Attributes:
        times: (N,) seconds.
        positions: (N, 3) metres.
        targets: (N, 3) metres.
        fov: Horizontal field of view, degrees.

    Args:
        data: What the file says, as plain data.
        place: The file.

    Raises:
        InputError: It is no such description.
    """

    def __init__(self, data: Any, place: Path) -> None:
        keys = data.get("keys") if isinstance(data, dict) and set(data) <= _TOP else None
        if not isinstance(keys, list) or not keys:
            raise InputError("this describes no camera path", place=place, remedy=_REMEDY)
        for number, key in enumerate(keys):
            if not (isinstance(key, dict) and set(key) == _KEYS):
                where = f"{place}: keys[{number}]"
                raise InputError("this is no key of a path", place=where, remedy=_REMEDY)
        rows = [[[key["time"]], key["position"], key["target"]] for key in keys]
        self.times = _numbers([row[0] for row in rows], 1, place)[:, 0]
        self.positions = _numbers([row[1] for row in rows], 3, place)
        self.targets = _numbers([row[2] for row in rows], 3, place)
        if (np.diff(self.times) <= 0.0).any():
            raise InputError("the times of its keys do not rise", place=place, remedy=_REMEDY)
        self.fov = float(_numbers([[data.get("fov", FOV_DEG)]], 1, place)[0, 0])
        if not _FOVS_DEG[0] <= self.fov <= _FOVS_DEG[1]:
            raise InputError(f"no camera sees {self.fov:g} degrees", place=f"{place}: fov")

    @property
    def seconds(self) -> float:
        """How long the path is."""
        return float(self.times[-1] - self.times[0])

    def poses(self, times: Array) -> Array:
        """(F, 4, 4) at (F,) seconds after the first key."""
        at = self.times[0] + times
        eyes = interpolated(self.times, self.positions, at)
        aims = interpolated(self.times, self.targets, at)
        return np.array([look_at(eye, aim) for eye, aim in zip(eyes, aims, strict=True)])


def read_keyframes(path: Path) -> Keyframes:
    """Read a YAML or JSON file.

    Raises:
        InputError: It cannot be read, or describes no path.
    """
    text = read_text(path, "description", remedy=_REMEDY)
    data, mistakes = read_yaml(text, path.name)
    if mistakes:
        raise InputError(str(mistakes[0]), place=path, remedy=_REMEDY)
    return Keyframes(data, path)


def _numbers(values: list[Any], width: int, place: Path) -> Array:
    for row in values:
        good = isinstance(row, list) and len(row) == width
        if not good or not all(isinstance(x, int | float) and abs(x) < 1e6 for x in row):
            found = f"{row} are not {width} numbers" if width > 1 else f"{row[0]!r} is no number"
            raise InputError(found, place=place, remedy=_REMEDY)
    return np.array(values, dtype=np.float64)
