"""A scene whose cameras are drawn by cast rays."""

import hashlib
import time
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.geometry.raycast import RayCaster
from openrooms_usd.rendering.contract import Image, RenderRequest, ViewProgress
from openrooms_usd.rendering.scene.arrays import Scene
from openrooms_usd.rendering.scene.first_hits import first_hits
from openrooms_usd.rendering.scene.ground_truth import GroundTruth
from openrooms_usd.rendering.scene.rays import CastingTracer
from openrooms_usd.usd.cameras import PinholeCamera

# What is drawn where nothing is seen: a pale sky.
BACKGROUND: Final = np.array([0.78, 0.84, 0.92])
# What the light at the camera gives of a white surface that faces it; the rest comes from around.
_HEADLIGHT_SHARE: Final = 0.35
# How much darker soft light is from below than from above.
_LOSS_FROM_BELOW: Final = 0.35

# Rays begin this far above their surface, metres: single precision puts points below it.
_LIFT_METRES: Final = 1e-3
# Steps that fill a square evenly however many they are: inverse powers of the plastic number, the
# root of x^3 = x + 1 (M. Roberts, The Unreasonable Effectiveness of Quasirandom Sequences, 2018).
_LATTICE_STEPS: Final = 1.324717957244746 ** np.array([-1.0, -2.0])
# Points that are worked on at once: some 200 bytes each.
_POINTS_A_BATCH: Final = 1 << 19
# Points along each side of a pixel, for smooth edges.
_POINTS_A_SIDE: Final = 2
# More rays per pixel than this make no visible difference.
_MOST_RAYS: Final = 32
_MEANING: Final = (
    "a preview without light transport: base colour under a light at the camera and ambient "
    "occlusion; a white surface that faces the camera has 1 / exposure, so that pictures are as "
    "bright whatever lamps and sky are"
)


class PreviewSession:
    """Draws a scene from any camera.

    Args:
        scene: The translated stage.
        reach: How far ambient occlusion looks, metres.

    Attributes:
        backend: What computes, for the record.
        advice: Empty.
        settings: The reach.
        conventions: What the radiance is here.
        tracer: The core's.
    """

    def __init__(self, scene: Scene, reach: float) -> None:
        self._scene, self._reach = scene, reach
        self.tracer = CastingTracer(scene)
        self.backend, self.advice = "preview, rays cast by the core", ""
        self.settings: Mapping[str, str] = {"reach": f"{reach:g}"}
        self.conventions: Mapping[str, str] = {"radiance": _MEANING}

    def render(
        self,
        camera: PinholeCamera,
        request: RenderRequest,
        progress: ViewProgress = lambda fraction: None,
    ) -> dict[str, Image]:
        """Draw one camera; equal seeds give equal bits.

        Args:
            camera: What sees the scene.
            request: What to draw; its samples are rays of ambient occlusion a pixel.
            progress: Called with the finished fraction, from 0 to 1.
        """
        start = time.perf_counter()
        points = _POINTS_A_SIDE**2
        rays = max(1, min(request.samples or _MOST_RAYS, _MOST_RAYS) // points)
        pixels = self._drawn(camera, request, rays, progress)
        white = 1.0 if camera.exposure is None else 1.0 / camera.exposure
        self._scene.report.add(
            request.camera or "framing camera", "approximated", "radiance: a preview, no light"
        )
        image = (white * pixels).astype(np.float32)
        return {"radiance": Image(image, rays * points, time.perf_counter() - start, None)}

    def _drawn(
        self, camera: PinholeCamera, request: RenderRequest, rays: int, progress: ViewProgress
    ) -> Array:
        """(height, width, 3) where 1 is white."""
        fine = replace(camera, K=np.diag([_POINTS_A_SIDE, _POINTS_A_SIDE, 1.0]) @ camera.K)
        width, height = _POINTS_A_SIDE * request.width, _POINTS_A_SIDE * request.height
        hits = first_hits(self._scene, self.tracer, fine, width, height)
        truth = GroundTruth(self._scene, fine, hits)
        seen = {
            name: truth.channel(name).reshape(width * height, -1)[hits.pixels].astype(np.float64)
            for name in ("base_color", "normal", "normal_geometric", "emission_mask")
        }
        rng = np.random.default_rng(_seed(request.seed, request.camera))
        free = openness(
            self.tracer.caster,
            hits.position,
            seen["normal_geometric"],
            rays,
            self._reach,
            rng,
            progress,
        )
        found = np.tile(BACKGROUND, (width * height, 1))
        found[hits.pixels] = shade(seen, hits.directions, free)
        fine_shape = request.height, _POINTS_A_SIDE, request.width, _POINTS_A_SIDE, 3
        return np.asarray(found.reshape(fine_shape).mean(axis=(1, 3)))


def _seed(seed: int, camera: str | None) -> int:
    text = f"{seed}\0{camera}".encode()
    return int.from_bytes(hashlib.blake2b(text, digest_size=8).digest(), "little")


def openness(
    caster: RayCaster,
    points: Array,
    normals: Array,
    rays: int,
    reach: float,
    rng: np.random.Generator,
    progress: Callable[[float], None] = lambda fraction: None,
) -> Array:
    """(P,) the part of the hemispheres that is free, weighted by the cosine; 1 in the open.

    What is at a distance d blocks a part 1 - d / reach of the light: each ray has a length of its
    own, even between 0 and the reach. The rays of a point are a lattice over the hemisphere, which
    every point shifts at random (Cranley and Patterson 1976).

    Args:
        caster: What may be near.
        points: (P, 3) on surfaces, metres.
        normals: (P, 3) unit, on the side that counts.
        rays: For each point.
        reach: Farther away nothing counts, metres.
        rng: Shifts the lattices.
        progress: Called with the finished fraction.
    """
    free = np.zeros(len(points))
    shifts = rng.random((len(points), 3))
    for start in range(0, len(points), _POINTS_A_BATCH):
        part = slice(start, start + _POINTS_A_BATCH)
        origins = points[part] + _LIFT_METRES * normals[part]
        across, along = _tangents(normals[part])
        for number in range(rays):
            lattice = np.array([(number + 0.5) / rays, *(number * _LATTICE_STEPS)])
            u, v, w = ((lattice + shifts[part]) % 1.0).T
            radius, phi = np.sqrt(u), 2.0 * np.pi * v
            directions = (
                (radius * np.cos(phi))[:, None] * across
                + (radius * np.sin(phi))[:, None] * along
                + np.sqrt(1.0 - u)[:, None] * normals[part]
            )
            free[part] += ~caster.occluded(origins, directions, reach * w)
            progress((start + len(origins) * (number + 1) / rays) / len(points))
    return free / rays


def _tangents(normals: Array) -> tuple[Array, Array]:
    """Two unit vectors that are normal to each unit vector and to each other.

    Without a root or a branch (T. Duff et al., Building an Orthonormal Basis, Revisited, 2017).
    """
    x, y, z = normals.T
    sign = np.copysign(1.0, z)
    a = -1.0 / (sign + z)
    b = x * y * a
    return (
        np.column_stack([1.0 + sign * x * x * a, sign * b, -sign * x]),
        np.column_stack([b, sign + y * y * a, -y]),
    )


def shade(seen: Mapping[str, Array], directions: Array, free: Array) -> Array:
    """(R, 3) colours of points, where white that faces the camera, upwards and in the open, is 1.

    Args:
        seen: (R, C) of the channels ``base_color``, ``normal`` (world) and ``emission_mask``.
        directions: (R, 3) from the camera to the points, of any length.
        free: (R,) how much of the hemisphere is free, from 0 to 1.
    """
    normals = seen["normal"]
    lengths = np.linalg.norm(directions, axis=1)
    facing = np.maximum(-np.einsum("ij,ij->i", normals, directions) / lengths, 0.0)
    above = 1.0 - _LOSS_FROM_BELOW * 0.5 * (1.0 - normals[:, 2])
    light = _HEADLIGHT_SHARE * facing + (1.0 - _HEADLIGHT_SHARE) * free * above
    # What shines is white, whatever its colour when it is off.
    return np.asarray(
        np.where(seen["emission_mask"] > 0.0, 1.0, seen["base_color"] * light[:, None])
    )
