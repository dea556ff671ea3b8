"""What is known of the lights of a stage."""

from collections import Counter
from collections.abc import Sequence
from typing import Final

import numpy as np
from pxr import Usd, UsdLux

from openrooms_usd.arrays import Array
from openrooms_usd.colorimetry import luminance
from openrooms_usd.geometry.rotations import nearest_rotation, pose
from openrooms_usd.portable import RESERVED
from openrooms_usd.rendering.scene.arrays import Patch, Scene, Sun
from openrooms_usd.rendering.scene.lights import Gaussian, LightRecord
from openrooms_usd.rendering.scene.pictures import Picture, evaluate
from openrooms_usd.rendering.scene.sources import Source
from openrooms_usd.rendering.scene.surroundings import (
    Surroundings,
    cells_of,
    panorama,
    passing,
    sums_by,
    surroundings,
)
from openrooms_usd.rendering.scene.window_lobes import Lit, fitted
from openrooms_usd.usd.light.emitters import world_from_prim
from openrooms_usd.usd.light.inputs import light_input
from openrooms_usd.usd.light.lights import Portal
from openrooms_usd.usd.places.frames import TIME

# The fit looks at pictures with this many rows.
_FITTED_ROWS: Final = 32
# Around the brightest pixel light counts as the sun's within this angle, radians, where it is this
# much brighter than the median of what the opening sees.
_SUN_RADIANS: Final = np.radians(6.0)
_SUN_PER_MEDIAN: Final = 8.0
# A sun that brings less than this of the light that comes in has no lobe by itself.
_SUN_SHARE: Final = 0.05
# No lobe is sharper: half of it within 0.1 degrees.
_MOST_SHARPNESS: Final = 5e5
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
    """Names of which each but the first of its kind has a number; as files they differ, too."""
    taken = {name.casefold() for name in names} | RESERVED
    counts, found = Counter(RESERVED), []
    for name in names:
        key = name.casefold()
        counts[key] += 1
        chosen = name
        while counts[key] > 1 and chosen.casefold() in taken:
            chosen = f"{name}_{counts[key]}"
            counts[key] += chosen.casefold() in taken
        taken.add(chosen.casefold())
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
        is_light = prim and prim.HasAPI(UsdLux.LightAPI)
        if is_light and light_input(prim, "inputs:enableColorTemperature").Get(TIME):
            return float(light_input(prim, "inputs:colorTemperature").Get(TIME))
    return None


# A sun is taken by its moments: its direction and flux are kept, and its spread about the
# direction. Sky and ground are fitted to what is left (`window_lobes`). Where no sun shines in,
# all three lobes are fitted, and the sharper of the upper two has the sun's name.
# Errors count by how much of each direction comes in: by the cosine to the opening.
def fit(sky: Surroundings, portal: Portal) -> tuple[tuple[Gaussian, ...], float]:
    """Sun, sky and ground as an opening sees them.

    Returns:
        The Gaussians, and their relative error: the root of the mean squared error of their sum
        over incoming directions, weighted by cosine, over that of the surroundings. Both are in
        cells of 5.6 degrees, without a sun that has its own lobe: a source that small is right by
        its flux, not pixel by pixel.
    """
    outwards = portal.world_from_portal[:3, 2]
    outside = sky.directions @ outwards > 0.0
    ways = sky.directions[outside]
    weights = sky.weights[outside] * (ways @ outwards)
    light = np.maximum(sky.radiance[outside], 0.0)
    beams, rest = _sun(ways, sky.weights[outside], light, sky.suns, outwards)
    if not rest.any():
        return beams, 0.0
    found = fitted(_binned(ways, weights, rest), 2 if beams else 3)
    lobes = zip(found.colors, found.axes, np.exp(found.logs).tolist(), strict=True)
    return (*beams, *_named([*lobes])), found.error


def _named(lobes: list[tuple[Array, Array, float]]) -> tuple[Gaussian, ...]:
    """The lowest is the ground; of two others the sharper is the sun."""
    ground, *upper = sorted(lobes, key=lambda lobe: lobe[1][2])
    upper.sort(key=lambda lobe: -lobe[2])
    names = ("sun", "sky", "ground")[-len(lobes) :]
    return tuple(Gaussian(name, *lobe) for name, lobe in zip(names, [*upper, ground], strict=True))


def _binned(ways: Array, weights: Array, light: Array) -> Lit:
    """The same light in fewer pixels: means over cells of a coarse panorama."""
    cells = cells_of(ways, _FITTED_ROWS)
    solid = np.bincount(cells, weights).astype(np.float64)
    used = solid > 0.0
    middles: Array = sums_by(cells, weights, ways)[used]
    lengths = np.linalg.norm(middles, axis=1, keepdims=True)
    means = sums_by(cells, weights, light)[used] / solid[used, None]
    return Lit(middles / lengths, solid[used], means)


def _sun(
    ways: Array, weights: Array, light: Array, suns: tuple[Sun, ...], outwards: Array
) -> tuple[tuple[Gaussian, ...], Array]:
    """The brightest place as a lobe, if it stands out, and the light without it."""
    shining = [sun for sun in suns if -sun.direction @ outwards > 0.0]
    if shining:
        strongest = max(shining, key=lambda sun: float(luminance(sun.irradiance)))
        return (_lobe("sun", -strongest.direction, strongest.irradiance, _MOST_SHARPNESS),), light
    bright = luminance(light)
    if not bright.any():
        return (), light
    near = ways @ ways[int(bright.argmax())] > np.cos(_SUN_RADIANS)
    around = np.median(light[~near], axis=0) if (~near).any() else np.zeros(3)
    ring = near & (bright > _SUN_PER_MEDIAN * max(float(luminance(around)), 1e-12))
    if not ring.any():
        return (), light
    excess = np.maximum(light[ring] - around, 0.0) * weights[ring, None]
    flux, share = excess.sum(axis=0), luminance(excess)
    cosine = ways @ outwards
    if share @ cosine[ring] < _SUN_SHARE * (weights * cosine @ bright):
        return (), light
    mean = share @ ways[ring] / share.sum()
    length = float(np.linalg.norm(mean))
    # For a sharp lobe the mean of the cosine about its axis is 1 - 1 / sharpness.
    sharpness = min(_MOST_SHARPNESS, 1.0 / max(1.0 - length, 1e-12))
    rest = light.copy()
    rest[ring] = np.minimum(light[ring], around)
    return (_lobe("sun", mean / length, flux, sharpness),), rest


def _lobe(name: str, axis: Array, flux: Array, sharpness: float) -> Gaussian:
    """A lobe that brings a flux, lux on a surface that faces it if it is sharp."""
    return Gaussian(name, np.asarray(flux / _solid(sharpness)), np.asarray(axis), sharpness)


def _solid(sharpness: float) -> float:
    return float(2.0 * np.pi * -np.expm1(-2.0 * sharpness) / sharpness)
