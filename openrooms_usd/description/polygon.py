"""Whether a polygon is simple: no repeated corner, no fold, no crossing, some area."""

from typing import TYPE_CHECKING, Final

from openrooms_usd.description.model import FoundMistake, refuse

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

# Points closer than this are the same point, metres.
TOLERANCE: Final = 1e-6

Corners = tuple[tuple[float, float], ...]


def simple_polygon(corners: Corners) -> Corners:
    """Accept a simple polygon.

    Args:
        corners: (N, 2) corners in order, metres.

    Returns:
        The same corners.

    Raises:
        pydantic.ValidationError: A corner is repeated, or the outline folds back, touches or
            crosses itself.
    """
    if len(corners) < 3:
        return corners  # the field's own minimum says so
    import numpy as np

    points = np.asarray(corners, dtype=np.float64)
    found = _repeated(points) or _folded(points) or _crossing(points)
    if found:
        refuse("polygon", found)
    return corners


def _repeated(points: "Array") -> list[FoundMistake]:
    """Corners that stand where the corner before them stands."""
    import numpy as np

    steps = np.linalg.norm(points - np.roll(points, 1, axis=0), axis=1)
    last = len(points) - 1
    return [
        FoundMistake((last,), "the first corner is repeated at the end; leave it out")
        if corner == 0
        else FoundMistake((int(corner),), "repeats the corner before it; leave it out")
        for corner in np.flatnonzero(steps <= TOLERANCE)
    ]


def _folded(points: "Array") -> list[FoundMistake]:
    """Corners at which the outline turns back along itself."""
    import numpy as np

    after = np.roll(points, -1, axis=0) - points
    before = np.roll(points, 1, axis=0) - points
    along = np.minimum(np.linalg.norm(after, axis=1), np.linalg.norm(before, axis=1))
    unit = after / np.linalg.norm(after, axis=1, keepdims=True)
    other = before / np.linalg.norm(before, axis=1, keepdims=True)
    aside = np.abs(unit[:, 0] * other[:, 1] - unit[:, 1] * other[:, 0]) * along
    back = (np.einsum("ij,ij->i", unit, other) > 0) & (aside <= TOLERANCE)
    return [
        FoundMistake((int(corner),), "the outline turns back along itself here")
        for corner in np.flatnonzero(back)
    ]


def _crossing(points: "Array") -> list[FoundMistake]:
    """The first wall that meets a wall which is not its neighbour.

    Walls are sorted by their smallest x, so that each is compared only with those that begin
    before it ends.
    """
    import numpy as np

    count = len(points)
    starts, ends = points, np.roll(points, -1, axis=0)
    low, high = np.minimum(starts, ends) - TOLERANCE, np.maximum(starts, ends) + TOLERANCE
    order = np.argsort(low[:, 0], kind="stable")
    until = np.searchsorted(low[order, 0], high[order, 0], side="right")
    for place, wall in enumerate(order):
        others = order[place + 1 : until[place]]
        others = others[(low[others, 1] <= high[wall, 1]) & (low[wall, 1] <= high[others, 1])]
        apart = (others - wall) % count
        others = others[(apart != 1) & (apart != count - 1)]
        meets = others[_meet(starts[wall], ends[wall], starts[others], ends[others])]
        if meets.size:
            a, b = sorted((int(wall), int(meets[0])))
            return [FoundMistake((b,), f"wall {b}, which starts at this corner, meets wall {a}")]
    return []


def _meet(a: "Array", b: "Array", c: "Array", d: "Array") -> "NDArray[np.bool_]":
    """Whether the segment a b crosses or touches each of the (M, 2) segments c d."""
    crossing = (_side(a, b, c) * _side(a, b, d) < 0) & (_side(c, d, a) * _side(c, d, b) < 0)
    touching = _near(c, a, b) | _near(d, a, b) | _near(a, c, d) | _near(b, c, d)
    return crossing | touching


def _side(a: "Array", b: "Array", p: "Array") -> "Array":
    """Twice the signed area of the triangles a b p."""
    area: Array = (b[..., 0] - a[..., 0]) * (p[..., 1] - a[..., 1]) - (b[..., 1] - a[..., 1]) * (
        p[..., 0] - a[..., 0]
    )
    return area


def _near(p: "Array", a: "Array", b: "Array") -> "NDArray[np.bool_]":
    """Whether points lie on segments, within the tolerance."""
    import numpy as np

    along = b - a
    t = ((p - a) * along).sum(axis=-1) / np.maximum((along * along).sum(axis=-1), 1e-300)
    foot = a + np.clip(t, 0.0, 1.0)[..., None] * along
    near: NDArray[np.bool_] = ((p - foot) ** 2).sum(axis=-1) <= TOLERANCE**2
    return near
