"""Is a composed room sound? An independent check on the meshes of its USD stage.

Nothing here knows how rooms are generated. Triangle meshes are read back from the composed stage
and compared by the collision library FCL (python-fcl): two objects penetrate each other by no more
than a depth if moving one of them by that much, in one of some directions, sets it free. That is
the definition of penetration depth, and exact for triangle soups; boxes are only used to leave out
pairs that are far apart.
"""

import itertools
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np

from tests.generation.building import misbuilt
from tests.generation.hanging import misplaced
from tests.generation.plans import inside
from tests.generation.resting import floating
from tests.generation.scenes import Body, Scene
from tests.generation.walking import blocked, swings

DEEPEST = 0.005  # metres
# How deep things may stand in the hole of a window, metres.
REVEAL = 0.1
# How things lie that hang, by the records.
HUNG = {"draped", "hung"}
AROUND = np.array([way for way in itertools.product((0.0, 1.0, -1.0), repeat=3) if any(way)])
# One axis first: that is what frees most.
DIRECTIONS = sorted(AROUND / np.linalg.norm(AROUND, axis=1)[:, None], key=np.count_nonzero)


def violations(
    scene: Scene, supports: dict[str, str], hanging: frozenset[str] = frozenset()
) -> list[str]:
    """Everything that is wrong with a room, one sentence each.

    Args:
        scene: The room.
        supports: What carries each object: ``floor``, ``ceiling``, ``wall`` or another's name.
        hanging: The objects that hang over an edge or from a hook, by their description.
    """
    return [
        *_penetrations(scene),
        *_outside(scene),
        *floating(scene, supports, hanging),
        *swings(scene),
        *blocked(scene),
        *misbuilt(scene, supports),
        *misplaced(scene, supports),
    ]


def _pairs(scene: Scene) -> Iterator[tuple[Body, Body]]:
    bodies = [*scene.objects, *scene.room]
    low, high = np.array([b.low for b in bodies]), np.array([b.high for b in bodies])
    for i, body in enumerate(scene.objects):
        near = (low[i + 1 :] < high[i]).all(axis=1) & (high[i + 1 :] > low[i]).all(axis=1)
        for j in np.flatnonzero(near).tolist():
            yield body, bodies[i + 1 + j]


def _penetrations(scene: Scene) -> Iterator[str]:
    for a, b in _pairs(scene):
        if a.hits(b) and not _freed(a, b):
            yield f"{a.name} penetrates {b.name} by more than {1000 * DEEPEST:g} mm"


def _freed(a: Body, b: Body) -> bool:
    """Whether a move of one by the depth sets both free, along, across or between their axes."""
    ways = (frame[:3, :3] @ way for way in DIRECTIONS for frame in (a.frame, b.frame))
    return any(not a.hits(b, DEEPEST * way) for way in ways)


def _outside(scene: Scene) -> Iterator[str]:
    """Corners beyond a wall's inner face, below the floor or above the ceiling."""
    corners = scene.polygon
    ahead = np.roll(corners, -1, axis=0) - corners
    for body in scene.objects:
        points = body.points
        for window in (opening for opening in scene.openings if opening.kind == "window"):
            x, y, z = ((points - window.frame[:3, 3]) @ window.frame[:3, :3]).T
            beside = (np.abs(x) > 0.5 * window.width) | (np.abs(z) > 0.5 * window.height)
            points = points[beside | (y < 0.0) | (y > REVEAL)]  # else on its sill, in the wall
        plan = points[:, :2]
        within = inside(corners, plan)
        if not within.all():
            out = plan[~within]
            away = out[:, None] - corners
            t = np.clip((away * ahead).sum(2) / (ahead**2).sum(1), 0.0, 1.0)
            far = np.linalg.norm(away - t[..., None] * ahead, axis=2).min(axis=1).max()
            if far > DEEPEST:
                yield f"{body.name} is {1000 * far:.0f} mm outside of the room"
        if body.low[2] < -DEEPEST or body.high[2] > scene.height + DEEPEST:
            yield f"{body.name} is below the floor or above the ceiling"


def described_supports(rows: Sequence[Any], usual: Callable[[str], str]) -> dict[str, str]:
    """What carries each object of a description; ``usual`` says it for a category."""
    return {row.name: row.on or usual(row.category) for row in rows}


def described_hanging(rows: Sequence[Any], lies: Callable[[str], Sequence[Any]]) -> frozenset[str]:
    """What hangs, of a description: ``lies`` says how a category lies.

    A thing of a style that hangs and never stands hangs wherever it is.
    """
    return frozenset(
        row.name
        for row in rows
        if _poses(row.style, lies(row.category)) and _poses(row.style, lies(row.category)) <= HUNG
    )


def _poses(style: str | None, lies: Sequence[Any]) -> set[str]:
    return {row.pose for row in lies if style in (row.styles or (style,))}
