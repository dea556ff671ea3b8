"""What lies on beds: mattress, pillows, a cover and the sheet turned down over it."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.joinery.assembly import Assembly
from openrooms_usd.geometry.cloth import cover, pillow
from openrooms_usd.geometry.solids import cushion

# Thickness of a cover, metres.
COVER: Final = 0.024


def bedding(
    made: Assembly,
    half: float,
    span: tuple[float, float],
    level: float,
    thick: float,
    drop: tuple[float, float],
    rng: np.random.Generator,
) -> None:
    """A mattress, pillows at its head, and a cover that is turned down before them.

    Args:
        made: Gets the parts.
        half: Half the width of the mattress, metres.
        span: Y of its foot and of its head, metres.
        level: Z of its top, metres.
        thick: Its thickness, metres.
        drop: How far the cover hangs down at the sides and at the foot, metres.
        rng: Draws creases.
    """
    foot, head = span
    pad = cushion((2.0 * half, head - foot, thick), radius=0.04, crown=(0.004, 0.004, 0.006))
    made.add("mattress", pad.moved((0.0, 0.5 * (foot + head), level - 0.5 * thick)))
    count = 1 if half < 0.6 else 2
    pitch = 2.0 * half / count
    deep = min(0.44, 0.24 * (head - foot))
    wide = min(0.72, pitch - 0.06)
    for i in range(count):
        x = -half + (i + 0.5) * pitch
        shape = pillow(wide, deep, 0.15, rng, divisions=10)
        tilt = np.eye(3)
        tilt[2, 1] = 0.12 + float(rng.uniform(-0.04, 0.04))
        y = head - 0.5 * deep - 0.02
        made.add("pillow", shape.transformed(tilt).moved((x, y, level + 0.07)))
    edge = half - 0.024 if drop[0] > 0.0 else half - 0.03
    end = head - deep - 0.06
    near = foot + (0.024 if drop[1] > 0.0 else 0.01)
    top = level + COVER + 0.012
    made.add("blanket", cover(edge, (near, end), top, drop, COVER, rng))
    fold = (end - 0.26, end + 0.02)
    hang = (max(0.0, drop[0] - 0.05), 0.0)
    made.add("sheet", cover(edge + 0.003, fold, top + 0.016, hang, 0.012, rng, puff=0.003))
