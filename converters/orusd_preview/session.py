"""A scene whose cameras are drawn by cast rays."""

import hashlib
import time
from collections.abc import Mapping
from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.rendering.contract import Image, RenderRequest, ViewProgress
from openrooms_usd.rendering.scene.arrays import Scene
from openrooms_usd.rendering.scene.first_hits import first_hits
from openrooms_usd.rendering.scene.ground_truth import GroundTruth
from openrooms_usd.rendering.scene.rays import CastingTracer
from openrooms_usd.usd.cameras import PinholeCamera
from orusd_preview.occlusion import openness
from orusd_preview.shading import BACKGROUND, shade

# Points along each side of a pixel, for smooth edges.
_POINTS_A_SIDE: Final = 2
# More rays a pixel than this nobody sees.
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
    ) -> NDArray[np.float64]:
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
