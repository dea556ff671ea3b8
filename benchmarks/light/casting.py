"""What casting the rays alone costs: the closest hit of each, and nothing else."""

from dataclasses import replace
from typing import Any, Final

import drjit as dr
import mitsuba as mi
import numpy as np

from benchmarks.light.rooms import Room, stopwatch
from openrooms_usd.geometry.hemisphere import HEMISPHERE
from openrooms_usd.rendering.scene.first_hits import first_hits
from orusd_mitsuba.plugins.build import load_sensor
from orusd_mitsuba.plugins.sensors import describe_sensor
from orusd_mitsuba.tracer import MitsubaTracer
from orusd_mitsuba.transport.hemispheres import coarse, surface_points

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
