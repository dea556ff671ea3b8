"""Does anything hang where nobody would hang it? By the meshes of a room alone."""

from collections.abc import Iterator

import numpy as np

from tests.generation.scenes import Body, Scene

# What people hang on walls, and what electricians screw to them.
HUNG = set("picture clock mirror whiteboard wall_shelf wall_lamp towel_rail coat_rack".split())
ELECTRIC = set("wall_lamp socket data_outlet light_switch thermostat".split())
WET = {"bathtub", "shower"}
HOT = {"hob", "radiator", "stove"}
# Electric things keep from baths and showers (IEC 60364-7-701, zone 2), and so high; metres.
DRY, ZONE = 0.595, 2.25
# How far from a wall furniture hides what hangs on it, metres, and which part of its face may be.
NEAR, HIDDEN = 0.5, 0.5
# Between a hob and the wall behind it, metres.
BEHIND = 0.15
GRID = np.linspace(0.1, 0.9, 7)


def misplaced(scene: Scene, supports: dict[str, str]) -> Iterator[str]:
    """What hangs over a bath, a hob or a radiator, or behind furniture, one sentence each."""
    for body in scene.objects:
        if supports[body.name] != "wall" or body.category not in HUNG | ELECTRIC:
            continue
        wet, hot = _away(body, scene, WET), _away(body, scene, HOT)
        if body.category in ELECTRIC and body.low[2] < ZONE:
            yield from (f"{body.name} is in the spray of {n}" for n, away in wet if away < DRY)
        if body.category in HUNG - {"coat_rack"}:
            rail = body.category == "towel_rail"
            over = hot if rail else [*wet, *hot]
            yield from (f"{body.name} hangs above {n}" for n, away in over if away <= 0.0)
            if rail:
                yield from (
                    f"{body.name} hangs in {n}" for n, away in wet if away <= 0.0 and "shower" in n
                )
            if (share := _hidden(body, scene, supports)) > HIDDEN:
                yield f"{share:.0%} of {body.name} is hidden by what stands before it"


def _away(body: Body, scene: Scene, categories: set[str]) -> list[tuple[str, float]]:
    """How far a body is in the plan from the upright box around each of some others, metres."""
    found = []
    for other in scene.objects:
        if other.category in categories and other.low[2] < body.high[2]:
            own = (other.points - other.frame[:3, 3]) @ other.frame[:3, :3]
            low, high = own[:, :2].min(axis=0), own[:, :2].max(axis=0)
            high[1] += BEHIND if other.category in HOT else 0.0
            plan = ((body.points - other.frame[:3, 3]) @ other.frame[:3, :3])[:, :2]
            beside = np.maximum(low - plan.max(axis=0), plan.min(axis=0) - high)
            reach = np.linalg.norm(np.maximum(beside, 0.0))
            found.append((other.name, float(reach or beside.max())))
    return found


def _hidden(body: Body, scene: Scene, supports: dict[str, str]) -> float:
    """The share of a thing's face from which no straight look into the room comes far."""
    into = body.frame[:3, :3]
    own = (body.points - body.frame[:3, 3]) @ into
    low, high = own.min(axis=0), own.max(axis=0)
    x, z = np.meshgrid(low[0] + GRID * (high - low)[0], low[2] + GRID * (high - low)[2])
    met = np.zeros(x.shape, dtype=bool)
    for other in scene.objects:
        if other is body or supports[other.name] == body.name:
            continue
        points = (other.points - body.frame[:3, 3]) @ into
        near = (points.min(axis=0) < [high[0], low[1], high[2]]).all()
        near &= (points.max(axis=0) > [low[0], low[1] - NEAR, low[2]]).all()
        if near:
            met |= _looks_meet(points[other.triangles], x, z, low[1])
    return float(met.mean())


def _looks_meet(corners: np.ndarray, x: np.ndarray, z: np.ndarray, face: float) -> np.ndarray:
    """Which looks along -y, from a face on, meet triangles near."""
    a, b, c = np.moveaxis(corners, 1, 0)
    e, f = b - a, c - a
    px, pz = x[..., None] - a[:, 0], z[..., None] - a[:, 2]
    area = e[:, 0] * f[:, 2] - e[:, 2] * f[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        v = (px * f[:, 2] - pz * f[:, 0]) / area
        w = (e[:, 0] * pz - e[:, 2] * px) / area
        y = a[:, 1] + v * e[:, 1] + w * f[:, 1]
        hit = (area != 0.0) & (v >= 0.0) & (w >= 0.0) & (v + w <= 1.0)
        hit &= (y < face - 1e-4) & (y > face - NEAR)
    return np.asarray(hit.any(axis=-1))
