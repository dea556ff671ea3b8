"""Renders a room from the cameras of its photographs, and says how near it is to them."""

import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd import atomic, claims
from openrooms_usd.appearance.edges import (
    EdgeMap,
    EdgeMatch,
    geometry_edges,
    match_edges,
    photograph_edges,
)
from openrooms_usd.capture import CapturedFrame
from openrooms_usd.comparison.likeness import Likeness, likeness
from openrooms_usd.comparison.photographs import Photographs, chosen_frames, read_photographs
from openrooms_usd.comparison.scandepth import DepthError, depth_error, scan_depth, spacing
from openrooms_usd.description.rendering import REFERENCE, RenderSettings
from openrooms_usd.errors import InputError
from openrooms_usd.progress import Progress, part, silent
from openrooms_usd.rendering.color import quantize
from openrooms_usd.rendering.context import RenderContext
from openrooms_usd.rendering.denoise import DENOISED, is_usable
from openrooms_usd.rendering.opening import check_settings, open_for_rendering
from openrooms_usd.rendering.previews import preview
from openrooms_usd.rendering.sheet import MOST_VIEWS, Tile, reduced, write_sheet
from openrooms_usd.steps.cameras.selection import intrinsics_for
from openrooms_usd.usd.cameras import PinholeCamera
from openrooms_usd.usd.files.layers import open_stage
from openrooms_usd.usd.shading.textures import read_texture

# Full colour of the difference of depth, metres.
_FULL_M: Final = 0.3
_MET: Final = (90, 230, 90)
_MISSED: Final = (255, 70, 200)
_UNKNOWN: Final = 40
# How much of the photograph stays below the edges.
_DIMMED: Final = 0.55
Array = NDArray[np.float64]
Bytes = NDArray[np.uint8]

DEFAULT_COUNT: Final = 8
DEFAULT_SAMPLES: Final = 32
DEFAULT_WIDTH: Final = 480

_LEDGER: Final = ".orusd.compare.sha256"
_FRAMES: Final = "frames"
_SHEET: Final = "contact_sheet.png"
_RESULT: Final = "comparison.json"
_EXACT: Final = ("depth", "normal_geometric", "instance")
_COLOR: Final = "radiance"


@dataclass(frozen=True, eq=False)
class ComparedFrame:
    """A photograph and a render from its camera.

    Attributes:
        id: The frame's identifier in the capture.
        picture: The picture's name in the capture; None where it has none, or it was not found.
        edges: How many of the render's edges the photograph has; None without a photograph.
        depth: How the render's depth differs from the scan's; None where nothing was scanned.
        likeness: How alike both pictures are; None without a photograph.
    """

    id: str
    picture: str | None
    edges: EdgeMatch | None
    depth: DepthError | None
    likeness: Likeness | None = None

    def as_dict(self) -> dict[str, Any]:
        """As plain data."""
        return {
            "id": self.id,
            "picture": self.picture,
            "edges": self.edges and self.edges.as_dict(),
            "depth": self.depth and self.depth.as_dict(),
            "likeness": self.likeness and self.likeness.as_dict(),
        }


@dataclass(frozen=True, eq=False)
class Comparison:
    """How near a room is to its photographs.

    Attributes:
        out: The folder that was written.
        frames: One by one.
        missing: Pictures that were not found.
    """

    out: Path
    frames: tuple[ComparedFrame, ...]
    missing: tuple[str, ...]

    def as_dict(self) -> dict[str, Any]:
        """As plain data: means over all frames, and each frame."""
        edges = [frame.edges for frame in self.frames if frame.edges]
        depths = [frame.depth for frame in self.frames if frame.depth]
        alike = [frame.likeness for frame in self.frames if frame.likeness]
        return {
            "frames": [frame.as_dict() for frame in self.frames],
            "mean": {
                "edges": _mean([edge.as_dict() for edge in edges]),
                "depth": _mean([depth.as_dict() for depth in depths]),
                "likeness": _mean([one.as_dict() for one in alike]),
            },
            "missing_pictures": list(self.missing),
        }


def compare_stage(
    path: Path,
    out: Path,
    settings: RenderSettings | None = None,
    *,
    description: Path | None = None,
    pictures: Path | None = None,
    frames: Sequence[str] = (),
    count: int = DEFAULT_COUNT,
    width: int = DEFAULT_WIDTH,
    progress: Progress = silent,
) -> Comparison:
    """Render a room from the cameras of its photographs, and put all side by side.

    ``out`` then holds ``comparison.json``, ``contact_sheet.png`` and a picture for each frame in
    ``frames/``: the photograph, the render, the render's edges over the photograph, and the
    difference of depth from the scan.

    Args:
        path: The composed stage.
        out: The folder to write.
        settings: What is asked for; its samples are `DEFAULT_SAMPLES` by default, its method is
            ``reference``, and it is denoised where the denoiser is installed.
        description: The room.yaml it was composed from; by default beside the stage's folder.
        pictures: Where the photographs lie; by default where the capture does.
        frames: Identifiers of the frames; by default ``count`` of all, evenly spread.
        count: How many frames at most.
        width: Of the pictures, pixels; at most the photograph's.
        progress: Called with the frame's name and the finished fraction.

    Raises:
        InputError: A file is missing or damaged, the room comes from no capture with cameras, or
            there is no such frame.
        OutputError: The folder cannot be written.
        RenderError: The renderer cannot do it.
    """
    if count < 1 or width < 16:
        raise InputError("give at least one frame, and pictures at least 16 pixels wide")
    settings = settings or RenderSettings()
    settings = settings.replace(
        channels=(_COLOR, *_EXACT),
        samples=settings.samples or DEFAULT_SAMPLES,
        method=settings.method or REFERENCE,
        # These pictures are for people.
        denoise=is_usable(),
    )
    check_settings(settings)
    taken = read_photographs(open_stage(path), path, description, pictures)
    chosen = chosen_frames(taken.frames, frames, count)
    names = (*(f"{_FRAMES}/{_plain(frame.id)}.png" for frame in chosen), _SHEET, _RESULT)
    claims.check_refill(out, _LEDGER, names)
    with claims.refilling(out, _LEDGER) as refill:
        context = open_for_rendering(path, settings)
        scan = spacing(taken.points) if taken.points is not None and len(taken.points) else None
        done: list[ComparedFrame] = []
        rows: list[list[Tile]] = []
        missing: list[str] = []
        beside = refill.folder
        (beside / _FRAMES).mkdir()
        for index, frame in enumerate(chosen):
            share = part(progress, frame.id, index, len(chosen))
            found, tiles = _compared(frame, taken, scan, context, width)
            if frame.picture and found.picture is None:
                missing.append(frame.picture)
            write_sheet(beside / _FRAMES / f"{_plain(frame.id)}.png", [tiles[:2], tiles[2:]])
            done.append(found)
            rows.append(reduced(tiles))
            share(1.0)
        result = Comparison(out, tuple(done), tuple(missing))
        write_sheet(beside / _SHEET, rows[:MOST_VIEWS])
        text = json.dumps(result.as_dict(), indent=2, ensure_ascii=False, allow_nan=False)
        atomic.write_text(beside / _RESULT, text + "\n")
    return result


def _compared(
    frame: CapturedFrame,
    taken: Photographs,
    scan: tuple[Array, float] | None,
    context: RenderContext,
    width: int,
) -> tuple[ComparedFrame, list[Tile]]:
    size = _size(frame, width)
    K = intrinsics_for(frame, size)
    camera = PinholeCamera(K, frame.world_from_camera)
    view = context.shoot(camera, f"/photographs/{frame.id}", size=size)
    depth, normal, instance = (
        np.asarray(view.images[name].pixels, dtype=np.float64) for name in _EXACT
    )
    edges = geometry_edges(depth[..., 0], normal, instance[..., 0])
    color = view.images.get(DENOISED, view.images[_COLOR])
    file = taken.file(frame)
    photograph = None if file is None else _photograph(file, size)
    match = None if photograph is None else match_edges(edges, photograph_edges(photograph))
    error, difference = None, blank(size)
    if scan is not None:
        scanned = scan_depth(*scan, K, frame.world_from_camera, size)
        error = depth_error(depth[..., 0], scanned)
        difference = depth_picture(depth[..., 0], scanned)
    shown = blank(size) if photograph is None else photograph
    tiles = [
        (f"{frame.id}  photograph" + ("" if file else ": not found"), shown),
        (f"{frame.id}  render", preview(_COLOR, color.pixels).pixels),
        (edge_words(match), edge_picture(shown, edges, match)),
        (depth_words(error), difference),
    ]
    picture = frame.picture if file else None
    alike = None if photograph is None else likeness(color.pixels.astype(np.float64), photograph)
    return ComparedFrame(frame.id, picture, match, error, alike), tiles


def _size(frame: CapturedFrame, width: int) -> tuple[int, int]:
    own_width, own_height = frame.resolution
    wide = min(width, own_width)
    return wide, max(1, round(own_height * wide / own_width))


def _photograph(path: Path, size: tuple[int, int]) -> Bytes:
    """(H, W, 3) a picture at another size, sRGB.

    Raises:
        InputError: It cannot be read.
    """
    import OpenImageIO

    pixels = read_texture(str(path))[..., :3]
    if pixels.shape[2] < 3:
        pixels = np.repeat(pixels[..., :1], 3, axis=2)
    roi = OpenImageIO.ROI(0, size[0], 0, size[1], 0, 1, 0, 3)
    small = OpenImageIO.ImageBufAlgo.resize(
        OpenImageIO.ImageBuf(np.ascontiguousarray(pixels)), "box", roi=roi
    )
    values = np.asarray(small.get_pixels(OpenImageIO.FLOAT))
    return np.asarray(np.clip(np.round(255.0 * values), 0, 255), dtype=np.uint8)


def _plain(name: str) -> str:
    return re.sub(r"[^\w.-]", "_", name, flags=re.ASCII).lstrip(".") or "frame"


def _mean(rows: Sequence[Mapping[str, float]]) -> dict[str, float] | None:
    if not rows:
        return None
    return {key: round(float(np.mean([row[key] for row in rows])), 4) for key in rows[0]}


def edge_picture(photograph: Bytes, edges: EdgeMap, match: EdgeMatch | None) -> Bytes:
    """The render's edges over the photograph: green where the photograph has them, too."""
    from scipy.ndimage import binary_dilation

    picture = (_DIMMED * photograph.astype(np.float64)).astype(np.uint8)
    picture[binary_dilation(edges.mask)] = _MISSED
    if match is not None:
        picture[binary_dilation(match.met)] = _MET
    return picture


def depth_picture(rendered: Array, scanned: Array) -> Bytes:
    """Blue where the render is nearer than the scan, red where it is farther, white where alike."""
    both = (rendered > 0.0) & (scanned > 0.0)
    off = np.where(both, np.clip((rendered - scanned) / _FULL_M, -1.0, 1.0), 0.0)[..., None]
    farther = np.array([1.0, 0.25, 0.2])
    nearer = np.array([0.2, 0.4, 1.0])
    mixed = 1.0 + np.maximum(off, 0.0) * (farther - 1.0) + np.maximum(-off, 0.0) * (nearer - 1.0)
    picture = quantize(mixed)
    picture[~both] = _UNKNOWN
    return picture


def blank(size: tuple[int, int]) -> Bytes:
    """(H, W, 3) in place of a picture that is not there."""
    return np.full((size[1], size[0], 3), _UNKNOWN, np.uint8)


def edge_words(match: EdgeMatch | None) -> str:
    """The caption of the edges."""
    if match is None:
        return "edges of the render over the photograph"
    return f"edges: {match.share:.0%} meet (by chance {match.chance:.0%}), in green"


def depth_words(error: DepthError | None) -> str:
    """The caption of the difference of depth, in two lines."""
    if error is None:
        return "depth: nothing scanned here"
    return (
        f"depth off by {100 * error.median:.0f} cm (median)\n"
        f"{error.right:.0%} within 10 cm; blue nearer, red farther than the scan"
    )
