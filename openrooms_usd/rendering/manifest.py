"""The manifest: everything that a reader of the files must know, the same for the same render.

It holds no time, no machine and no absolute path; those are in ``timing.json``.
"""

import json
import math
import os
import platform
from collections.abc import Mapping, Sequence
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd import atomic, names
from openrooms_usd.arrays import Array
from openrooms_usd.channels import CHANNELS, definition, numbered
from openrooms_usd.description.rendering import RenderSettings
from openrooms_usd.rendering.contract import Image, RenderRequest, RenderSession, View
from openrooms_usd.rendering.exr import exr_channels
from openrooms_usd.rendering.folder import ERRORS_FILE, grid_file, opening_file, preview_file
from openrooms_usd.rendering.previews import Preview
from openrooms_usd.rendering.rle import tight_box
from openrooms_usd.rendering.scene.legend import Legend
from openrooms_usd.rendering.scene.lights import LightRecord, plain
from openrooms_usd.rendering.storage import Storing
from openrooms_usd.version import __version__

# Nearer to the camera's plane nothing is projected, metres.
_NEAR_PLANE_M: Final = 1e-3
# OpenCV axes (right, down, forward) in OpenGL's (right, up, backward).
_OPENGL: Final = np.diag([1.0, -1.0, -1.0, 1.0])
# The corners of a box about 0, and the pairs of them that are edges.
_CORNERS: Final = np.array(
    [[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)]
)
_EDGES: Final = np.array([[i, i | bit] for i in range(8) for bit in (1, 2, 4) if not i & bit])
FORMAT: Final = 1
CONVENTIONS: Final = {
    "world": "right-handed, Z up, metres",
    "world_from_camera": "4x4, row-major, multiplies column vectors; camera frame of OpenCV: "
    "x right, y down, z forward; metres",
    "K": "3x3 intrinsics in pixels; the centre of the top-left pixel is at (0.5, 0.5)",
    "projection": "of a view: pinhole by default. Equirectangular: columns are angles to the "
    "right of the forward direction, rows angles below the horizon, K has pixels "
    "per radian, depth is the distance. Orthographic: all rays look forward, and K "
    "has pixels per metre and says where each has depth 0. Depth is the distance "
    "there too, and is negative behind",
    "lens": "light is seen through the camera's lens where it has one (fStop "
    "and focusDistance); geometry, materials, labels and grids of hemispheres by a pinhole",
    "color": "scene-linear, Rec.709 primaries, D65; radiance in nits",
    "estimated_error": "what the mean over pixels and components of (x - t)^2 / (t^2 + 0.01 T^2) "
    "is likely to be. x is the picture, t what it would be with endless samples, T the mean of t "
    "in a component. It is estimated from two independent halves of the samples, allowing for "
    "rare bright "
    "paths, so rather too large than too small. 0 where one ray is exact, null where there is no "
    "estimate, such as where no sample has met any light",
    "estimated_robust_error": "the same with the part of every pixel and component capped at 1: no "
    "single pixel dominates it; a render that stops at an error stops by this one",
    "bias": "of a method that is not the reference. total is the excess of the picture over the "
    "reference, relative to the sum of the reference, by paths that are independent of "
    "the picture in so many pixels. worst_tenth is the mean size of the bias in the "
    "worst tenth of the pixels, in groups of neighbours, relative to the reference "
    "there: about 0 without bias. Each has its standard error (_error); null where it "
    "was not measured",
    "nonfinite_pixels": "pixels that hold a NaN or an infinity, and those where the renderer put 0 "
    "in its place",
    "bounces": "at most this many scatterings on the way from a light to the camera",
    "denoised": "of denoised versions of channels. bias is the mean of the denoised picture over "
    "that of the raw one, less 1. standard_error is that of the raw mean, relative. "
    "blocks_beyond is the part of blocks of 16x16 pixels whose mean lies more than "
    "two standard errors from the raw one",
    "time_code": "of a stage that moves: when it is seen; where nothing is said, everything is at "
    "the first of its time samples",
    "traced": "of a view: the mean over its pixels of the channel of that name",
    "method": "how light was computed: reference, every path is followed to its end, without bias; "
    "cache, what is smooth was computed once for the room and looked up",
}

Plain = dict[str, Any]


def run_entry(
    stage: Path,
    settings: RenderSettings,
    session: RenderSession,
    request: RenderRequest,
    lights: Sequence[LightRecord],
    legend: Legend,
) -> Plain:
    """What all views of a run share.

    Args:
        stage: The rendered file; only its name is kept.
        settings: What is asked for.
        session: What renders.
        request: What every view was asked for, and which channels are listed.
        lights: Those of the scene, by their numbers.
        legend: What the label numbers mean.
    """
    asked = {"samples": request.samples, "error": request.error, "seconds": request.seconds}
    given = {name: getattr(settings, name) for name in ("time_code", "f_stop")}
    return {
        "format": FORMAT,
        "generator": f"{names.CREATOR} {__version__}",
        "stage": stage.name,
        **{name: value for name, value in given.items() if value is not None},
        "renderer": {"name": settings.renderer, "backend": session.backend, **session.settings},
        "seed": request.seed,
        "bounces": request.bounces,
        "method": request.method,
        "storage": settings.storage,
        "stop": {name: value for name, value in asked.items() if value is not None},
        "conventions": {**CONVENTIONS, **session.conventions},
        "channels": {name: _definition(name) for name in request.channels},
        "lights": [_light(light, request) for light in lights],
        "legend": {part.name: dict(getattr(legend, part.name)) for part in fields(Legend)},
    }


def by_light(request: RenderRequest) -> bool:
    """Whether anything is asked for of every light."""
    return any(CHANNELS[name].scope == "light" for name in request.channels)


def _light(light: LightRecord, request: RenderRequest) -> Plain:
    shown = light.environment is not None and by_light(request)
    return {**light.as_dict(), **({"environment": opening_file(light.name)} if shown else {})}


def _definition(name: str) -> Plain:
    row = {**CHANNELS[name].as_dict(), "exr_channels": exr_channels(name)}
    del row["name"]
    return row


def view_entry(
    name: str,
    view: View,
    stored: Storing,
    previews: Mapping[str, Preview],
    lights: Sequence[LightRecord] = (),
    photograph: Mapping[str, str] | None = None,
) -> Plain:
    """A finished view: its camera, its files and how good each channel is.

    Args:
        name: The view's name, which is its folder.
        view: What was rendered.
        stored: How its channels lie on disk.
        previews: By channel name.
        lights: Those of the scene.
        photograph: What the view stands for in a capture: its ``file`` and ``id``.
    """
    files = {channel: f"{name}/{file}" for channel, file in stored.plain.items()}
    files |= {Path(file).stem: f"{name}/{file}" for file in stored.files}
    grids = [channel for channel in view.images if definition(channel).scope == "grid"]
    known = [c for c, image in view.images.items() if image.halves]
    files |= {"errors": f"{name}/{ERRORS_FILE}"} if {*known} - {*grids} else {}
    files |= {f"{c}_errors": f"{name}/{grid_file(c, errors=True)}" for c in grids if c in known}
    masks = {
        light.number: view.images[mask].pixels
        for light in lights
        if (mask := numbered("mask_i", light.number)) in view.images
    }
    seen = view_lights(lights, view.K, view.world_from_camera, (view.width, view.height), masks)
    is_pinhole = view.projection == "pinhole"
    if not is_pinhole:
        # No box is projected into a panorama, or by parallel rays.
        seen = [{k: v for k, v in row.items() if k != "box2d_projected"} for row in seen]
    denoised = {
        channel: {**image.change, **stored.entry(stored.denoised[channel], name)}
        for channel, image in view.denoised.items()
    }
    return {
        **({"projection": view.projection} if not is_pinhole else {}),
        **({"photograph": dict(photograph)} if photograph else {}),
        "camera": view.camera,
        "resolution": [view.width, view.height],
        "K": view.K.tolist(),
        "world_from_camera": view.world_from_camera.tolist(),
        "exposure": view.exposure,
        "lights": seen,
        "files": files,
        **({"denoised": denoised} if denoised else {}),
        **({"traced": _mean(view.images["traced"])} if "traced" in view.images else {}),
        "channels": {
            channel: _channel_entry(name, channel, image, stored, previews)
            for channel, image in view.images.items()
        },
    }


def _channel_entry(
    name: str, channel: str, image: Image, stored: Storing, previews: Mapping[str, Preview]
) -> Plain:
    """How good a channel of a view is, and how it lies on disk."""
    shown = {
        "preview": f"{name}/{preview_file(channel)}",
        "preview_shows": previews[channel].shows if channel in previews else None,
    }
    return {
        "samples": image.samples,
        "estimated_error": _number(image.error),
        "estimated_robust_error": _number(image.robust_error),
        "bias": asdict(image.bias) if image.bias else None,
        "nonfinite_pixels": nonfinite_pixels(channel, image),
        **(shown if stored.is_previewed(channel) else {}),
        **stored.entry(stored.channels[channel], name),
    }


def nonfinite_pixels(channel: str, image: Image) -> int:
    """How many pixels hold a NaN or an infinity as they are stored, or 0 in its place."""
    stored: NDArray[Any] = image.pixels
    if definition(channel).storage == "half":
        with np.errstate(over="ignore", invalid="ignore"):
            stored = stored.astype(np.float16)
    return int((~np.isfinite(stored)).any(axis=-1).sum()) + image.replaced


def _mean(image: Image) -> float | None:
    return _number(float(image.pixels.mean(dtype=np.float64)))


def _number(value: float | None) -> float | None:
    return value if value is not None and math.isfinite(value) else None


def machine_entry(backend: str) -> Plain:
    """Where a run took its time: the processor, the cores that it may use, and the backend."""
    return {"cpu": _processor(), "cores": _cores(), "backend": backend}


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text("utf-8").splitlines()
    except OSError:
        lines = []
    models = (line.partition(":")[2].strip() for line in lines if line.startswith("model name"))
    return next(models, "") or platform.processor() or platform.machine()


def _cores() -> int:
    # Not everywhere can a process ask which cores it is allowed to use.
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def write_json(path: Path, data: Plain) -> None:
    """Write data with sorted keys; the file appears whole or not at all."""
    text = json.dumps(data, indent=2, sort_keys=True, ensure_ascii=False, allow_nan=False)
    atomic.write_text(path, text + "\n")


def view_lights(
    records: Sequence[LightRecord],
    K: Array,
    world_from_camera: Array,
    size: tuple[int, int],
    masks: Mapping[int, NDArray[Any]],
) -> list[dict[str, Any]]:
    """The lights as one camera has them, for its entry of the manifest.

    Args:
        records: All lights.
        K: (3, 3) intrinsics, pixels.
        world_from_camera: (4, 4) from the OpenCV camera frame.
        size: Width and height of the picture.
        masks: By number, (height, width, 1) images of ``mask_i``, where they were asked for.

    Returns:
        For each light its ``number``, and its box as ``camera_from_box`` in the OpenCV frame and
        ``opengl_from_box`` in OpenGL's. ``box2d_projected`` is left, top, right, bottom of the box
        as if nothing hid it, cut off at the edges of the picture and empty outside. With a mask
        also ``box2d`` of its pixels, right and bottom exclusive, empty where there are none.
        ``elsewhere`` has no boxes.
    """
    camera_from_world: Array = np.linalg.inv(world_from_camera).astype(np.float64)
    return [_in_view(record, K, camera_from_world, size, masks) for record in records]


def _in_view(
    record: LightRecord,
    K: Array,
    camera_from_world: Array,
    size: tuple[int, int],
    masks: Mapping[int, NDArray[Any]],
) -> dict[str, Any]:
    entry: dict[str, Any] = {"number": record.number}
    if record.kind != "elsewhere":
        pose = camera_from_world @ record.world_from_box
        entry["camera_from_box"] = plain(pose)
        entry["opengl_from_box"] = plain(_OPENGL @ pose)
        corners = (_CORNERS * record.size) @ pose[:3, :3].T + pose[:3, 3]
        entry["box2d_projected"] = _projected(corners[_EDGES], K, size)
    if record.number in masks:
        mask = masks[record.number][..., 0] > 0.5
        entry["box2d"] = list(tight_box(mask)) if mask.any() else []
    return entry


def _projected(edges: Array, K: Array, size: tuple[int, int]) -> list[float]:
    """Left, top, right, bottom of edges (E, 2, 3) in the picture; empty where none are."""
    deep = edges[..., 2] >= _NEAR_PLANE_M
    crossing = edges[deep[:, 0] != deep[:, 1]]
    share = (_NEAR_PLANE_M - crossing[:, 0, 2]) / (crossing[:, 1, 2] - crossing[:, 0, 2])
    cut = crossing[:, 0] + share[:, None] * (crossing[:, 1] - crossing[:, 0])
    points = np.concatenate([edges[deep], cut]) @ K.T
    if not len(points):
        return []
    places = points[:, :2] / points[:, 2:]
    low, high = (np.clip(edge, 0.0, size) for edge in (places.min(axis=0), places.max(axis=0)))
    inside = bool((places.max(axis=0) > 0.0).all() and (places.min(axis=0) < size).all())
    box: list[float] = np.round([*low, *high], 3).tolist()
    return box if inside else []
