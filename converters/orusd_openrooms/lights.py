"""What the files of a light hold: its box, its parameters and whether it is seen."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np

from openrooms_usd.arrays import Array, Mask
from openrooms_usd.rendering.reading import RenderedScene
from openrooms_usd.rendering.scene.lights import Gaussian, LightKind, LightRecord, LobeName

# The lights of a render, as the files of the dataset need them.

LAMP: Final[LightKind] = "lamp"
ELSEWHERE: Final[LightKind] = "elsewhere"  # what no lamp and no opening brings: it has no place
# Of an opening's fit, with the endings of their names in the loaders' files.
LOBES: Final[dict[LobeName, str]] = {"sun": "", "sky": "Sky", "ground": "Grd"}


@dataclass(frozen=True, eq=False)
class Lobe:
    """Light that arrives from about a direction: intensity exp(sharpness (axis . d - 1)).

    Attributes:
        axis: (3,) unit, towards where the light comes from; world.
        sharpness: At least 0; 0 is the same in every direction.
        intensity: (3,) nits.
    """

    axis: Array
    sharpness: float
    intensity: Array


@dataclass(frozen=True, eq=False)
class Light:
    """A light with a place.

    Attributes:
        number: Its number among the light channels.
        is_window: Whether it is an opening, not a lamp.
        on: Whether it shines.
        center: (3,) of its box; world, metres.
        axes: (3, 3) the box's unit vectors as columns; world.
        size: (3,) the box's lengths along them, metres; an opening's third is 0.
        radiance: (3,) nits that a lamp emits, or the mean of what an opening lets in.
        lobes: By name, the fit of what an opening lets in; empty for a lamp.
    """

    number: int
    is_window: bool
    on: bool
    center: Array
    axes: Array
    size: Array
    radiance: Array
    lobes: Mapping[str, Lobe]


def lights_of(scene: RenderedScene) -> list[Light]:
    """The lights of a render that have a place, in the order of their numbers."""
    return [light_of(record) for record in scene.lights if record.kind != ELSEWHERE]


def light_of(record: LightRecord) -> Light:
    """A light with a place."""
    axes = record.world_from_box[:3, :3]
    lobes = {gaussian.name: _lobe(gaussian) for gaussian in record.gaussians}
    # An opening without a fit lets its mean radiance in, alike from everywhere.
    lobes = lobes or {"sky": Lobe(np.array([0.0, 0.0, 1.0]), 0.0, record.radiance)}
    return Light(
        number=record.number,
        is_window=record.kind != LAMP,
        on=record.on,
        center=record.world_from_box[:3, 3],
        axes=axes / np.linalg.norm(axes, axis=0),
        size=record.size,
        radiance=record.radiance,
        lobes=lobes if record.kind != LAMP else {},
    )


def _lobe(fit: Gaussian) -> Lobe:
    return Lobe(fit.axis / np.linalg.norm(fit.axis), fit.sharpness, fit.amplitude)


# Right, up and backward from the right, down and forward of OpenCV.
_OPENGL: Final = np.diag([1.0, -1.0, -1.0])


def camera_from_world(world_from_camera: Array) -> Array:
    """(4, 4) from our world to right, up and backward of a camera given in OpenCV's axes."""
    turned = np.eye(4)
    turned[:3, :3] = _OPENGL
    result: Array = turned @ np.linalg.inv(world_from_camera)
    return result


def box(light: Light, camera: Array, mask: Mask) -> dict[str, Any]:
    """The box of a light, as the loaders want it.

    The y axis is the most upright of the box's own and points up; x is the longer of the others; z
    points towards the camera.

    Args:
        light: The light.
        camera: (4, 4) from `camera_from_world`.
        mask: (height, width) the pixels whose centres see it.
    """
    upright = int(np.argmax(np.abs(light.axes[2])))
    rest = sorted({0, 1, 2} - {upright}, key=lambda axis: -light.size[axis])
    x, y = light.axes[:, rest[0]], light.axes[:, upright]
    y = y if y[2] >= 0 else -y
    turn = camera[:3, :3]
    center = turn @ light.center + camera[:3, 3]
    axes = [turn @ axis for axis in (x, y, np.cross(x, y))]
    if axes[2] @ center > 0:
        axes = [-axes[0], axes[1], -axes[2]]
    named: dict[str, Any] = {f"{name}Axis": axis for name, axis in zip("xyz", axes, strict=True)}
    sizes = (light.size[rest[0]], light.size[upright], light.size[rest[1]])
    named |= {f"{name}Len": float(size) for name, size in zip("xyz", sizes, strict=True)}
    return {
        "isWindow": light.is_window,
        "box3D": {"center": center, **named},
        "box2D": _box_2d(mask),
    }


def _box_2d(mask: Mask) -> dict[str, int | None]:
    """The first and last column and row that show it; None where it is not seen."""
    columns, rows = np.flatnonzero(mask.any(axis=0)), np.flatnonzero(mask.any(axis=1))
    if not len(columns):
        return dict.fromkeys(("x1", "x2", "y1", "y2"))
    edges = (columns[0], columns[-1], rows[0], rows[-1])
    return {name: int(edge) for name, edge in zip(("x1", "x2", "y1", "y2"), edges, strict=True)}


def source(light: Light, camera: Array, loss: float = 0.0) -> dict[str, Any]:
    """The parameters of a light: a lamp's radiance, an opening's three lobes.

    Axes are in the camera's frame (right, up, backward) and point to where the light comes from.
    What is off has no intensity. Loaders tell so by the first lobe alone: without a sun the lobe of
    the greatest flux takes its place.

    Args:
        light: The light.
        camera: (4, 4) from `camera_from_world`.
        loss: How far off the light of an opening's lobes is in the picture, lux; loaders bring it
            to the scale of their shadings, and add it up beside their own mean absolute errors.
    """
    if not light.is_window:
        return {"intensity": light.radiance * light.on}
    lobes = {name: light.lobes.get(name, _DARK) for name in LOBES}
    first, *_ = lobes
    if not lobes[first].intensity.any():
        brightest = max(lobes, key=lambda name: _arriving(lobes[name], light)[0].sum())
        lobes[first], lobes[brightest] = lobes[brightest], lobes[first]
    found: dict[str, Any] = {"loss": loss, "scale": 1.0}
    for name, ending in LOBES.items():
        found |= _parameters(lobes[name], light.on, camera, ending)
    return found


def single_source(light: Light, camera: Array) -> dict[str, Any]:
    """The parameters of a light as one lobe.

    A lamp shines alike in every direction. For an opening: the lobe with the same flux and the same
    mean direction as its three together, as far as they come from outside (Banerjee et al.,
    "Clustering on the Unit Hypersphere using von Mises-Fisher Distributions", JMLR 2005, eq. 4.4).
    """
    lobe = _joined(light) if light.is_window else Lobe(_DARK.axis, 0.0, light.radiance)
    return _parameters(lobe, light.on, camera, "")


def _parameters(lobe: Lobe, on: bool, camera: Array, ending: str) -> dict[str, Any]:
    return {
        f"intensity{ending}": lobe.intensity * on,
        f"axis{ending}": camera[:3, :3] @ lobe.axis,
        f"lamb{ending}": np.array([lobe.sharpness]),
    }


def spread(sharpness: float) -> float:
    """The integral of exp(sharpness (cos - 1)) over the sphere, steradian."""
    if sharpness < 1e-6:
        return 4.0 * np.pi
    return float(-np.expm1(-2.0 * sharpness) * 2.0 * np.pi / sharpness)


def _arriving(lobe: Lobe, light: Light) -> tuple[Array, Array]:
    """(3,) flux of a lobe from outside of an opening, and (3,) its directions' sum, by their flux.

    A lobe may point into the room: the fit is never evaluated there, and may have any value.
    """
    outwards = light.axes[:, 2]
    if lobe.sharpness > _SHARP_LOBE:
        flux: Array = lobe.intensity * spread(lobe.sharpness) * (lobe.axis @ outwards > 0.0)
        return flux, flux.sum() * _length(lobe.sharpness) * lobe.axis
    ways = _HALF_SPHERE @ light.axes.T
    shape = np.exp(lobe.sharpness * (ways @ lobe.axis - 1.0)) * (2.0 * np.pi / len(ways))
    return lobe.intensity * shape.sum(), lobe.intensity.sum() * (shape @ ways)


def _half_sphere(count: int) -> Array:
    """(count, 3) unit vectors about +Z, each of the same solid angle: a spiral by the golden angle.

    A sum over them is that over the half sphere to 1e-3.
    """
    heights = (np.arange(count) + 0.5) / count
    turns = np.arange(count) * np.pi * (3.0 - np.sqrt(5.0))
    flat = np.sqrt(1.0 - heights**2)
    return np.stack([flat * np.cos(turns), flat * np.sin(turns), heights], axis=1)


# Sharper lobes lie on one side of the opening.
_SHARP_LOBE: Final = 50.0
_HALF_SPHERE: Final = _half_sphere(4096)


def _joined(light: Light) -> Lobe:
    lobes = list(light.lobes.values())
    if len(lobes) == 1:
        return lobes[0]
    arriving = [_arriving(lobe, light) for lobe in lobes]
    flux: Array = sum((flux for flux, _ in arriving), np.zeros(3))
    moment: Array = sum((moment for _, moment in arriving), np.zeros(3))
    length = float(np.linalg.norm(moment))
    if not length:
        return Lobe(_DARK.axis, 0.0, flux / spread(0.0))
    mean = min(length / float(flux.sum()), 1.0 - 1e-9)
    sharpness = mean * (3.0 - mean**2) / (1.0 - mean**2)
    lobe = Lobe(moment / length, sharpness, np.ones(3))
    return replace(lobe, intensity=flux / _arriving(lobe, light)[0])


def _length(sharpness: float) -> float:
    """How long the mean of a lobe's directions is: coth k - 1 / k."""
    if sharpness < 1e-4:
        return sharpness / 3.0
    return float(1.0 / np.tanh(sharpness) - 1.0 / sharpness)


_DARK: Final = Lobe(np.array([0.0, 0.0, 1.0]), 0.0, np.zeros(3))
