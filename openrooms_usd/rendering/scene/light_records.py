"""What is known of the lights of a stage."""

from collections import Counter
from collections.abc import Sequence
from typing import Final

import numpy as np
from pxr import Usd, UsdLux

from openrooms_usd.colorimetry import luminance
from openrooms_usd.geometry.rotations import nearest_rotation, pose
from openrooms_usd.rendering.scene.arrays import Patch, Scene
from openrooms_usd.rendering.scene.lights import LightRecord
from openrooms_usd.rendering.scene.pictures import Array, Picture, evaluate
from openrooms_usd.rendering.scene.sources import Source
from openrooms_usd.rendering.scene.surroundings import Surroundings, panorama, passing, surroundings
from openrooms_usd.rendering.scene.window_fit import fit
from openrooms_usd.usd.light.emitters import world_from_prim
from openrooms_usd.usd.places.frames import TIME

# Places on each triangle of a textured lamp whose mean is taken, to a side.
_PLACES_A_SIDE: Final = 8
# Rows of the picture of what an opening sees.
_PANORAMA_ROWS: Final = 128


def light_records(
    stage: Usd.Stage, scene: Scene, sources: Sequence[Source]
) -> tuple[LightRecord, ...]:
    """The records of the sources, in their order.

    A lamp that is off has one too, so that numbers stay when it is turned on.

    Args:
        stage: The composed stage.
        scene: The same as arrays.
        sources: Its lights, as `openrooms_usd.rendering.scene.sources.sources_of` gives them.
    """
    sky = surroundings(scene)
    names = _unique([source.path.rpartition("/")[2] or source.kind for source in sources])
    return tuple(
        _lamp(number, name, stage, scene, source)
        if source.kind == "lamp"
        else _outside(number, name, sky, source)
        for number, (name, source) in enumerate(zip(names, sources, strict=True))
    )


def _unique(names: Sequence[str]) -> list[str]:
    """Names of which each but the first of its kind has a number that no other has."""
    taken, counts, found = set(names), Counter[str](), []
    for name in names:
        counts[name] += 1
        chosen = name
        while counts[name] > 1 and chosen in taken:
            chosen = f"{name}_{counts[name]}"
            counts[name] += chosen in taken
        taken.add(chosen)
        found.append(chosen)
    return found


def _lamp(number: int, name: str, stage: Usd.Stage, scene: Scene, source: Source) -> LightRecord:
    patches = [scene.patches[row] for row in source.patches]
    corners = np.concatenate([patch.triangles.corners for patch in patches])
    areas, shone = _areas(corners), np.concatenate([_shone(patch) for patch in patches])
    shares = [np.full(len(patch.triangles), patch.flux_share()) for patch in patches]
    flux = np.pi * (areas * np.concatenate(shares)) @ shone
    turn = _axes(stage, source.path)
    world_from_box, size = _box(corners.reshape(-1, 3), turn)
    return LightRecord(
        number,
        name,
        source.path,
        "lamp",
        bool(flux.max() > 0.0),
        world_from_box,
        size,
        flux / (np.pi * areas.sum()) if areas.sum() > 0.0 else shone.mean(axis=0),
        float(luminance(flux)),
        _kelvin(stage, scene, patches),
        scene.pieces[int(patches[0].triangles.pieces[0])].instance,
    )


def _outside(number: int, name: str, sky: Surroundings, source: Source) -> LightRecord:
    portal = source.portal
    if portal is None:
        mean = sky.weights.ravel() @ sky.radiance.reshape(-1, 3) / (4.0 * np.pi)
        on = bool(mean.max() > 0.0) or bool(sky.suns)
        return LightRecord(number, name, "", "elsewhere", on, np.eye(4), np.zeros(3), mean, 0.0)
    lux = passing(sky, portal.world_from_portal[:3, 2])
    gaussians, error = fit(sky, portal)
    return LightRecord(
        number,
        name,
        source.path,
        "opening",
        bool(lux.max() > 0.0),
        portal.world_from_portal,
        np.array([portal.width, portal.height, 0.0]),
        lux / np.pi,
        float(luminance(lux)) * portal.width * portal.height,
        gaussians=gaussians,
        fit_error=error,
        environment=panorama(sky, portal, _PANORAMA_ROWS),
    )


def _areas(corners: Array) -> Array:
    a, b, c = np.moveaxis(corners, 1, 0)
    return np.asarray(0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1))


def _shone(patch: Patch) -> Array:
    """(M, 3) mean radiance of each triangle, nits."""
    triangles = patch.triangles
    if not isinstance(patch.radiance, Picture):
        return np.broadcast_to(np.asarray(patch.radiance, dtype=np.float64), (len(triangles), 3))
    steps = (np.arange(_PLACES_A_SIDE) + 0.5) / _PLACES_A_SIDE
    u, v = (grid.ravel() for grid in np.meshgrid(steps, steps, indexing="ij"))
    root = np.sqrt(u)
    weights = np.column_stack([1.0 - root, root * (1.0 - v), root * v])
    places = np.einsum("pi,mij->mpj", weights, triangles.st.astype(np.float64))
    return np.asarray(evaluate(patch.radiance, places, 3).mean(axis=1))


def _axes(stage: Usd.Stage, path: str) -> Array:
    """(3, 3) the axes of an object as columns; the world's for what an instancer scatters."""
    prim = stage.GetPrimAtPath(path) if "[" not in path else None
    return nearest_rotation(world_from_prim(prim)[:3, :3]) if prim else np.eye(3)


def _box(points: Array, turn: Array) -> tuple[Array, Array]:
    """The rigid motion to the middle of the points' box along some axes, and its size."""
    local = points @ turn
    low, high = local.min(axis=0), local.max(axis=0)
    return pose(turn, turn @ (0.5 * (low + high))), high - low


def _kelvin(stage: Usd.Stage, scene: Scene, patches: Sequence[Patch]) -> float | None:
    """The colour temperature of the lamp's first part that has one."""
    parts = {
        scene.pieces[row].part for patch in patches for row in np.unique(patch.triangles.pieces)
    }
    for part in sorted(parts):
        path = scene.legend.part[part]
        prim = stage.GetPrimAtPath(path) if "[" not in path else None
        light = UsdLux.LightAPI(prim) if prim and prim.HasAPI(UsdLux.LightAPI) else None
        if light and light.GetEnableColorTemperatureAttr().Get(TIME):
            return float(light.GetColorTemperatureAttr().Get(TIME))
    return None
