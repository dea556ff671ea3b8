"""Pictures of radiance: noise and bias against seconds, for every method, raw and denoised."""

import json
from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict, dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any, Final

import drjit as dr
import mitsuba as mi
import numpy as np

from benchmarks.light.bias import Pair, bias_of, mse_of, robust_of
from benchmarks.light.rooms import REFERENCE_SEED, ROOMS, Room, stopwatch
from benchmarks.light.sessions import Cost, OpenedRoom, References, Shot, Target, methods_of
from benchmarks.report import table
from openrooms_usd.geometry.hemisphere import HEMISPHERE
from openrooms_usd.rendering.denoise import is_usable, load_denoiser
from openrooms_usd.rendering.estimates import robust_error
from openrooms_usd.rendering.scene.first_hits import first_hits
from orusd_mitsuba.plugins.build import load_sensor
from orusd_mitsuba.plugins.sensors import describe_sensor
from orusd_mitsuba.tracer import MitsubaTracer
from orusd_mitsuba.transport.hemispheres import coarse, surface_points

# What every section of the benchmark has: a setting to be measured in, and what comes of it.


@dataclass(frozen=True)
class Setting:
    """How a section shall measure.

    Attributes:
        quick: Small pictures, few samples, few rooms.
        folder: For what is needed meanwhile.
        references: What is true of the rooms.
        rooms: The names of those that shall be measured; all of a section's where none is named.
    """

    quick: bool
    folder: Path
    references: References
    rooms: tuple[str, ...] = ()

    def chosen(self, names: Iterable[str]) -> tuple[str, ...]:
        """Those of a section's rooms that shall be measured; the first one where it is quick."""
        found = tuple(name for name in names if name in self.rooms or not self.rooms)
        return found[:1] if self.quick else found


@dataclass(frozen=True)
class Section:
    """A part of the benchmark.

    Attributes:
        data: Numbers for programs.
        markdown: Text for people.
        targets: What shall be reached, and is or is not.
    """

    data: Any
    markdown: str
    targets: tuple[Target, ...] = ()

    def keep(self, path: Path) -> None:
        """Write it to a file."""
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(json.dumps(asdict(self), indent=1), encoding="utf-8")

    @classmethod
    def kept(cls, path: Path) -> "Section | None":
        """The one of a file; None where there is none."""
        if not path.is_file():
            return None
        found = json.loads(path.read_text(encoding="utf-8"))
        targets = tuple(Target(**target) for target in found["targets"])
        return cls(found["data"], found["markdown"], targets)


Measure = Callable[[Setting], Section]


def section(rows: list[dict[str, Any]], targets: Iterable[Target] = ()) -> Section:
    """A section that is one table; all rows have the keys of the first."""
    if not rows:
        return Section(rows, "None of the chosen rooms is measured here.")
    shown = table(tuple(rows[0]), [list(row.values()) for row in rows])
    return Section(rows, shown, tuple(targets))


_ASKED: Final = ("radiance",)
_VIEWS: Final = 20
_SAMPLES: Final = (4, 16, 64)


def pictures(setting: Setting) -> Section:
    """Every method in rooms plain, furnished and hard."""
    size, many = ((32, 24), 16) if setting.quick else ((96, 72), 1024)
    rows: list[dict[str, Any]] = []
    for name in setting.chosen(ROOMS):
        room = Room(ROOMS[name].build(setting.folder), *size)
        truth = truth_of(setting, room, _ASKED, many)["radiance"]
        named = {"room": name, "condition": ROOMS[name].condition}
        for method in methods_of(room):
            opened = OpenedRoom(room, method)
            for samples in _SAMPLES[: 1 if setting.quick else None]:
                rows += [named | row for row in _measured(room, opened, samples, truth)]
        rows.append(
            named
            | dict.fromkeys(rows[-1])
            | named
            | {
                "method": "the reference itself",
                "samples": 2 * many,
                "robust error": robust_error(*truth) / 4.0,
            }
        )
    return section(rows)


def truth_of(
    setting: Setting, room: Room, channels: tuple[str, ...], samples: int, **how: Any
) -> Mapping[str, Pair]:
    """Both halves of the reference of channels, by image."""

    @cache
    def opened() -> OpenedRoom:
        return OpenedRoom(room)

    halves = setting.references.pair(
        room.scene,
        {"seen": room.seen, "channels": channels, "samples": samples, **how},
        lambda half: opened().shot(channels, samples, seed=REFERENCE_SEED + half, **how).pixels,
    )
    return {name: (halves[0][name], halves[1][name]) for name in halves[0]}


def _measured(room: Room, opened: OpenedRoom, samples: int, truth: Pair) -> list[dict[str, Any]]:
    """A row for the raw pictures, and one for them denoised."""
    method = opened.method
    shots = [opened.shot(_ASKED, samples, seed=seed, guides=True) for seed in (11, 12)]
    cost, rays = opened.cost(_ASKED, samples), pixels(room, samples)
    raw = [shot.pixels["radiance"] for shot in shots]
    rows = [_row(method, samples, cost, rays, (raw[0], raw[1]), truth)]
    if is_usable():
        taken: list[float] = []
        clean = [denoised(shot, taken) for shot in shots]
        guided = Cost(cost.room, cost.view + taken[-1])
        rows.append(_row(f"{method}, denoised", samples, guided, rays, (clean[0], clean[1]), truth))
    return rows


def denoised(shot: Shot, seconds: list[float]) -> Any:
    """The radiance of a view, denoised; its seconds are added to a list."""
    with stopwatch(seconds):
        return load_denoiser().denoise(shot.pixels["radiance"], shot.guides)


def _row(
    method: str, samples: int, cost: Cost, rays: float, found: Pair, truth: Pair
) -> dict[str, Any]:
    apart = bias_of(found, truth)
    return {
        "method": method,
        "samples": samples,
        "s, one view": cost.views(1),
        f"s, of {_VIEWS} views": cost.views(_VIEWS),
        "s, rays alone": rays,
        "relative MSE": float(np.mean([mse_of(x, truth) for x in found])),
        "robust error": float(np.mean([robust_of(x, truth) for x in found])),
        **apart.columns,
    }


# What casting the rays alone costs: the closest hit of each, and nothing else.

_RAYS_IN_FLIGHT: Final = 1 << 21


def pixels(room: Room, samples: int) -> float:
    """Seconds for the rays of a picture: so many through every pixel."""
    width, height = room.size
    described = describe_sensor(room.camera, width, height, room.scene.origin)
    sensor = load_sensor(described, {"type": "independent"})
    count = width * height * samples
    sampler = mi.load_dict({"type": "independent"})
    sampler.seed(0, count)
    path = dr.arange(mi.UInt32, count) // samples
    corner = mi.Point2f(mi.Float(path % width), mi.Float(path // width))
    at = (corner + sampler.next_2d()) / mi.Point2f(width, height)
    return _seconds(room.built, sensor.sample_ray(0.0, 0.5, at, sampler.next_2d())[0])


def hemispheres(room: Room, grid: tuple[int, int]) -> tuple[int, float]:
    """How many rays a grid's hemispheres have, one a cell, and their seconds."""
    camera = replace(room.camera, K=coarse(room.camera, room.size, grid))
    hits = first_hits(room.scene, MitsubaTracer(room.scene, room.built), camera, *grid)
    points = surface_points(room.scene, camera, hits)
    inner = HEMISPHERE.directions.reshape(-1, 3)
    batch = _RAYS_IN_FLIGHT // len(inner)
    total = 0.0
    for start in range(0, len(points), batch):
        part = points.rows(slice(start, start + batch))
        d = np.einsum("cr,prk->pck", inner, part.frames)
        origin = np.broadcast_to(part.position[:, None] + 1e-4 * part.geometric[:, None], d.shape)
        ray = mi.Ray3f(
            *(
                make(np.float32(x.reshape(-1, 3).T))
                for make, x in ((mi.Point3f, origin), (mi.Vector3f, d))
            )
        )
        total += _seconds(room.built, ray)
    return len(points) * len(inner), total


def _seconds(built: Any, ray: Any) -> float:
    """The second time, when all is compiled."""
    dr.eval(ray)
    dr.sync_thread()
    taken: list[float] = []
    for _ in range(2):
        with stopwatch(taken):
            dr.eval(built.ray_intersect_preliminary(ray, coherent=False).t)
            dr.sync_thread()
    return taken[-1]
