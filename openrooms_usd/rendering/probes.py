"""Light probes: all light that arrives at a point, as a panorama and as spherical harmonics."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, Final, Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike

from openrooms_usd import claims, names
from openrooms_usd.arrays import Array, Floats
from openrooms_usd.description.rendering import DEFAULT_BOUNCES, DEFAULT_SAMPLES, RenderSettings
from openrooms_usd.errors import InputError, RenderError
from openrooms_usd.geometry import spherical_harmonics
from openrooms_usd.geometry.hemisphere import PANORAMA, cosine_weights, panorama_cells
from openrooms_usd.imagefile import write_png
from openrooms_usd.portable import RESERVED
from openrooms_usd.progress import Progress, silent
from openrooms_usd.rendering import exr
from openrooms_usd.rendering.contract import Image
from openrooms_usd.rendering.manifest import write_json
from openrooms_usd.rendering.previews import preview
from openrooms_usd.version import __version__

RESOLUTION: Final = (256, 128)
FILE: Final = "probes.json"
_LEDGER: Final = ".orusd.probes.sha256"
ORDER: Final = 2
_MAX_CELLS: Final = 1 << 26
_AXES: Final = {
    f"{sign}{axis}": tuple(value if axis == name else 0.0 for name in "XYZ")
    for axis in "XYZ"
    for sign, value in (("+", 1.0), ("-", -1.0))
}
_CONVENTIONS: Final = {
    "position": "world, right-handed, Z up, metres",
    "panorama": "latitude-longitude, scene-linear Rec.709 radiance in nits, each pixel the mean "
    "over its solid angle; first row around +Z, middle column along -Y, a quarter from the left "
    "along +X: the texture of a UsdLux DomeLight_1 whose pole axis is Z",
    "harmonics": "real, orthonormal, no Condon-Shortley phase, in world axes. Rows l = 0, then m "
    "= -l to l: 0.282095, 0.488603 y, 0.488603 z, 0.488603 x, 1.092548 x y, "
    "1.092548 y z, "
    "0.315392 (3 z^2 - 1), 1.092548 x z, 0.546274 (x^2 - y^2); columns red, green, blue",
    "radiance": "sum of coefficients times functions in direction d: nits that come from d",
    "irradiance": "the same for a surface with normal n: lux; radiance convolved with the clamped "
    "cosine, factors pi, 2 pi / 3, pi / 4; over pi it is what a white Lambertian surface sends out",
    "axes": "lux on a surface that faces along an axis of the world, from the panorama itself",
}


@dataclass(frozen=True)
class Place:
    """Where a probe is.

    Attributes:
        name: Of its files.
        position: World, metres.
        opening: The prim of the portal whose centre it is; None where a person chose it.
        outwards: The opening's normal, out of the room.
    """

    name: str
    position: tuple[float, float, float]
    opening: str | None = None
    outwards: tuple[float, float, float] | None = None


@dataclass(frozen=True)
class ProbeRequest:
    """What to find out.

    Attributes:
        positions: World, metres.
        width: Pixels around.
        height: Pixels from the zenith down.
        samples: Paths for each pixel.
        seed: Of random numbers.
        bounces: At most this many scatterings between a light and the probe.
    """

    positions: tuple[tuple[float, float, float], ...]
    width: int
    height: int
    samples: int
    seed: int = 0
    bounces: int = DEFAULT_BOUNCES


@runtime_checkable
class Prober(Protocol):
    """A session of a renderer that can make probes."""

    def probe(self, request: ProbeRequest, progress: Callable[[float], None]) -> Sequence[Image]:
        """The panoramas of a request, in its order.

        Raises:
            RenderError: The backend cannot.
        """
        ...


def openings(stage: Any) -> list[Place]:
    """The centres of the openings of a stage, by the names of their portals."""
    from openrooms_usd.usd.light.lights import read_portals

    found = []
    for portal in read_portals(stage):
        center, outwards = portal.world_from_portal[:3, 3], portal.world_from_portal[:3, 2]
        name = portal.path.strip("/").replace("/", ".")
        found.append(Place(name, _three(center), portal.path, _three(outwards)))
    short = [place.name.rpartition(".")[2] for place in found]
    if len({name.casefold() for name in short} - RESERVED) < len(short):
        return found
    return [
        Place(name, p.position, p.opening, p.outwards) for name, p in zip(short, found, strict=True)
    ]


def probe_stage(
    path: Path,
    out: Path,
    settings: RenderSettings | None = None,
    *,
    at: Sequence[tuple[float, float, float]] = (),
    at_openings: bool = False,
    progress: Progress = silent,
) -> dict[str, Any]:
    """Make light probes in a USD stage.

    ``out`` receives ``probes.json`` with the spherical harmonics, and for every probe its panorama
    as EXR and a PNG to look at.

    Args:
        path: The USD file.
        out: The folder to write.
        settings: What is asked for; its resolution is that of the panoramas, `RESOLUTION` by
            default, and its samples are paths for each pixel.
        at: Positions, world, metres.
        at_openings: Whether there is a probe in the centre of every opening too.
        progress: Called with what is done and the finished fraction.

    Returns:
        What stands in ``probes.json``.

    Raises:
        InputError: There is nothing to do, or a number is absurd.
        OutputError: The folder cannot be written.
        RenderError: The renderer makes no probes.
    """
    from openrooms_usd.rendering.opening import open_for_rendering

    settings = settings or RenderSettings()
    width, height = settings.resolution or RESOLUTION
    _check(at, (width, height))
    context = open_for_rendering(path, settings)
    places = [Place(f"probe_{number}", point) for number, point in enumerate(at)]
    places += openings(context.stage) if at_openings else []
    if not places:
        raise InputError(
            "there is no opening" if at_openings else "there is no place to probe",
            place=path,
            remedy="give --at x,y,z" if at_openings else "give --at x,y,z or --openings",
        )
    files = [f"{place.name}{suffix}" for place in places for suffix in (".exr", ".png")]
    claims.check_refill(out, _LEDGER, (FILE, *files))
    session = context.session
    if not isinstance(session, Prober):
        raise RenderError(
            f"the renderer {settings.renderer} does not support probes", remedy="--renderer mitsuba"
        )
    request = ProbeRequest(
        positions=tuple(place.position for place in places),
        width=width,
        height=height,
        samples=settings.samples or DEFAULT_SAMPLES,
        seed=settings.seed,
        bounces=settings.bounces,
    )
    images = session.probe(request, partial(progress, f"{len(places)} probes"))
    return _write(out, path, request, places, images)


def _write(
    out: Path, stage: Path, request: ProbeRequest, places: Sequence[Place], images: Sequence[Image]
) -> dict[str, Any]:
    with claims.refilling(out, _LEDGER) as refill:
        beside, probes = refill.folder, []
        for place, image in zip(places, images, strict=True):
            exr.write_rgb(beside / f"{place.name}.exr", image.pixels)
            write_png(
                beside / f"{place.name}.png", preview("radiance", image.pixels, tone="film").pixels
            )
            probes.append(_entry(place, image))
        entry = {
            "format": 1,
            "generator": f"{names.CREATOR} {__version__}",
            "stage": stage.name,
            "resolution": [request.width, request.height],
            "samples": request.samples,
            "seed": request.seed,
            "bounces": request.bounces,
            "order": ORDER,
            "conventions": _CONVENTIONS,
            "probes": probes,
        }
        write_json(beside / FILE, entry)
    return entry


def _entry(place: Place, image: Image) -> dict[str, Any]:
    radiance = harmonics(image.pixels)
    entry = {
        "name": place.name,
        "position": list(place.position),
        "panorama": f"{place.name}.exr",
        "radiance": radiance.tolist(),
        "irradiance": spherical_harmonics.irradiance(radiance).tolist(),
        "axes": {name: irradiance(image.pixels, way).tolist() for name, way in _AXES.items()},
        "estimated_error": image.error,
        "estimated_robust_error": image.robust_error,
        "nonfinite_pixels": image.replaced,
    }
    if place.opening and place.outwards:
        ways = {"from_outside": np.array(place.outwards), "from_inside": -np.array(place.outwards)}
        entry["opening"] = {
            "path": place.opening,
            "outwards": list(place.outwards),
            **{name: irradiance(image.pixels, way).tolist() for name, way in ways.items()},
        }
    return entry


def harmonics(panorama: Floats, order: int = ORDER) -> Array:
    """((order + 1)^2, 3) of a panorama's radiance, in world axes.

    Args:
        panorama: (height, width, 3).
        order: The highest degree.
    """
    local = spherical_harmonics.project(panorama, panorama_cells(panorama), order)
    return spherical_harmonics.turned(local, PANORAMA)


def irradiance(panorama: Floats, normal: ArrayLike) -> Array:
    """(3,) lux on a surface with a normal, from a panorama.

    Args:
        panorama: (height, width, 3).
        normal: (3,) unit, world.
    """
    weights = cosine_weights(panorama_cells(panorama), PANORAMA @ np.asarray(normal))
    return np.asarray(np.einsum("rc,rcx->x", weights, panorama.astype(np.float64)))


def _check(at: Sequence[tuple[float, float, float]], resolution: tuple[int, int]) -> None:
    for point in at:
        if not np.isfinite(point).all():
            raise InputError(f"{point} is not a position", place="at", remedy="x,y,z in metres")
    width, height = resolution
    if min(width, height) < 4 or width * height > _MAX_CELLS:
        raise InputError(
            f"{width}x{height} is not the size of a panorama", place="resolution", remedy="256x128"
        )


def _three(vector: Array) -> tuple[float, float, float]:
    x, y, z = (float(value) for value in vector)
    return x, y, z
