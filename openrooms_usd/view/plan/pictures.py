"""The points of a scan as pictures to draw over: from above, and square on to a wall."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from openrooms_usd import imagefile
from openrooms_usd.arrays import Array, Bytes
from openrooms_usd.building.walls import Wall
from openrooms_usd.scratch import scratch_folder

Box = tuple[float, float, float, float]

# Between these heights walls are seen more than furniture and ceilings, metres.
_KNEE_M: Final = 0.5
_BELOW_CEILING_M: Final = 0.25
# The larger side of a picture has at most so many pixels; from above each has so many metres.
_MOST_PIXELS: Final = 1000
_LEAST_CELL_M: Final = 0.015
# What is shown around the plan, metres.
_MARGIN_M: Final = 1.0
# Points this far before and behind a wall's face are seen on its elevation, metres.
_BEFORE_M, _BEHIND_M = 0.12, 0.25
# Cells of a wall are as large as its points are apart, within these bounds.
_WALL_CELLS_M: Final = (0.02, 0.06)
# Seen on light and on dark; single points are seen, too.
_INK: Final = (74, 134, 222)
_FAINTEST: Final = 50.0
_HEIGHT_STEP_M: Final = 0.02
_HIGHEST_M: Final = 6.0


@dataclass(frozen=True)
class Picture:
    """A picture and where it lies.

    Attributes:
        png: Its bytes, with alpha; the first row is the upper edge.
        box: Left, right, bottom and top of what it shows, metres.
    """

    png: bytes
    box: Box


def view_box(corners: Array, points: Array) -> Box:
    """What a page shows from above: the plan and what is near it.

    Args:
        corners: (N, 2) of all plans, metres.
        points: (M, 3) metres.
    """
    low, high = corners.min(axis=0) - _MARGIN_M, corners.max(axis=0) + _MARGIN_M
    if len(points):
        seen_low, seen_high = np.percentile(points[:, :2], (1, 99), axis=0)
        # A scan may look far out of a window: a quarter of the plan's size around it is enough.
        reach = 0.25 * (high - low)
        low = np.minimum(low, np.maximum(seen_low, low - reach))
        high = np.maximum(high, np.minimum(seen_high, high + reach))
    return float(low[0]), float(high[0]), float(low[1]), float(high[1])


def from_above(points: Array, box: Box, height: float) -> Picture:
    """How many points there are between knee and ceiling, on a scale that shows few and many.

    Args:
        points: (N, 3) metres.
        box: What to show.
        height: Floor to ceiling, metres.
    """
    left, right, bottom, top = box
    cell = max(_LEAST_CELL_M, max(right - left, top - bottom) / _MOST_PIXELS)
    columns, rows = (max(1, round(side / cell)) for side in (right - left, top - bottom))
    z = points[:, 2]
    seen = points[(z > _KNEE_M) & (z < max(height - _BELOW_CEILING_M, _KNEE_M + 0.5))]
    counts, _, _ = np.histogram2d(
        seen[:, 1], seen[:, 0], bins=(rows, columns), range=((bottom, top), (left, right))
    )
    share = (
        np.log1p(counts) / max(float(np.log1p(np.percentile(counts[counts > 0], 99))), 1e-9)
        if counts.any()
        else counts
    )
    pixels = np.empty((rows, columns, 4), np.uint8)
    pixels[..., :3] = _INK
    alpha = _FAINTEST + (255.0 - _FAINTEST) * np.clip(share, 0.0, 1.0)
    pixels[..., 3] = np.round(np.where(counts > 0, alpha, 0.0))[::-1]
    return Picture(_png(pixels), box)


def of_wall(points: Array, colors: Bytes | None, wall: Wall, height: float) -> Picture:
    """The points near a wall, square on and seen from inside.

    Args:
        points: (N, 3) metres.
        colors: (N, 3) sRGB; None: those before the wall are dark and those behind it light.
        wall: The wall.
        height: Of what is shown, metres.
    """
    place = wall.from_plan(points[:, :2])
    z = points[:, 2]
    thick = wall.thickness if wall.partition else 0.0
    near = (place[:, 1] > -_BEFORE_M) & (place[:, 1] < max(_BEHIND_M, thick + _BEFORE_M))
    near &= (place[:, 0] > 0.0) & (place[:, 0] < wall.length) & (z > 0.0) & (z < height)
    x, depth, z = place[near, 0], place[near, 1], z[near]
    apart = np.sqrt(wall.length * height / max(int(near.sum()), 1))
    cell = max(float(np.clip(apart, *_WALL_CELLS_M)), max(wall.length, height) / _MOST_PIXELS)
    columns, rows = (max(1, round(side / cell)) for side in (wall.length, height))
    column = np.minimum((x / wall.length * columns).astype(int), columns - 1)
    row = np.minimum((z / height * rows).astype(int), rows - 1)
    cells = row * columns + column
    counts = np.bincount(cells, minlength=rows * columns).reshape(rows, columns)
    if colors is None:
        shade = 60.0 + 150.0 * np.clip((depth + _BEFORE_M) / (_BEFORE_M + _BEHIND_M), 0.0, 1.0)
        values = np.repeat(shade[:, None], 3, axis=1)
    else:
        values = colors[near].astype(np.float64)
    pixels = np.zeros((rows, columns, 4), np.uint8)
    for channel in range(3):
        sums = np.bincount(cells, values[:, channel], rows * columns).reshape(rows, columns)
        pixels[..., channel] = np.round(sums / np.maximum(counts, 1))
    pixels[..., 3] = np.where(counts > 0, 255, 0)
    return Picture(_png(_filled(pixels)[::-1]), (0.0, wall.length, 0.0, height))


def _filled(pixels: Bytes) -> Bytes:
    """The picture without single empty cells: each is as its neighbours on both sides are."""
    made = pixels.copy()
    for axis in (0, 1):
        before, after = np.roll(made, 1, axis), np.roll(made, -1, axis)
        between = (made[..., 3] == 0) & (before[..., 3] > 0) & (after[..., 3] > 0)
        mean = (before.astype(np.uint16) + after) // 2
        made[between] = mean[between].astype(np.uint8)
    return made


def heights(points: Array) -> dict[str, object]:
    """How many points there are at each height: floor and ceiling are peaks.

    Args:
        points: (N, 3) metres.
    """
    bins = round(_HIGHEST_M / _HEIGHT_STEP_M)
    counts, _ = np.histogram(points[:, 2], bins=bins, range=(0.0, _HIGHEST_M))
    last = int(np.flatnonzero(counts)[-1]) + 1 if counts.any() else 0
    return {"step": _HEIGHT_STEP_M, "counts": counts[:last].tolist()}


def _png(pixels: Bytes) -> bytes:
    with scratch_folder() as folder:
        path = folder / "picture.png"
        how = {"oiio:UnassociatedAlpha": 1, "png:compressionLevel": 4}
        imagefile.write(path, np.ascontiguousarray(pixels), "uint8", how)
        return path.read_bytes()
