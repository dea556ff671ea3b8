"""Photographs as back plates of their cameras: copies beside the layer."""

import hashlib
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Final

from pxr import Gf, Sdf, UsdGeom

from openrooms_usd import atomic, untrusted
from openrooms_usd.appearance.photographs import PosedPhotographs
from openrooms_usd.capture import CapturedFrame, read_capture
from openrooms_usd.description.scanned import CapturedSection
from openrooms_usd.portable import relative_text
from openrooms_usd.steps.base import StepContext

_PLATE: Final = "photograph"
# What viewers of USD show.
_ENDINGS: Final = (".jpg", ".jpeg", ".png")


def plate_inputs(section: CapturedSection, folder: Path) -> Iterator[str]:
    """The pictures of a capture's photographs that are here.

    Args:
        section: It names the capture.
        folder: The description's; paths are relative to it.
    """
    capture = read_capture(section.reader, folder / section.file, section.asked, folder)
    for frame in capture.frames:
        if path := _picture(frame, section, folder):
            yield relative_text(path, folder)


def show_plate(
    camera: UsdGeom.Camera,
    frame: CapturedFrame,
    section: CapturedSection,
    resolution: tuple[int, int],
    context: StepContext,
) -> bool:
    """Copy the photograph of a camera beside the layer, and show it behind everything.

    Args:
        camera: Its camera.
        frame: The photograph.
        section: It names the capture.
        resolution: Width and height of the camera's pictures.
        context: The step's.

    Returns:
        Whether the picture is here.
    """
    path = _picture(frame, section, context.source)
    if path is None:
        return False
    data = untrusted.read_bytes(path, "picture")
    stem = re.sub(r"[^A-Za-z0-9]+", "_", path.stem).strip("_")[:40] or _PLATE
    file = f"{stem}_{hashlib.sha256(data).hexdigest()[:8]}{path.suffix.lower()}"
    target = context.keep(file)
    if not target.is_file():
        target.parent.mkdir(parents=True, exist_ok=True)
        atomic.write_bytes(target, data)
    plate = UsdGeom.BackPlateAPI.Apply(camera.GetPrim(), _PLATE)
    plate.CreateImageAttr(Sdf.AssetPath(context.asset(file)))
    # The plate fills the camera's picture, whose width is that of the photograph.
    tall = frame.resolution[1] * resolution[0] / (frame.resolution[0] * resolution[1])
    if tall != 1.0:
        plate.CreateScaleTweakAttr(Gf.Vec2f(1.0, tall))
    return True


def _picture(frame: CapturedFrame, section: CapturedSection, folder: Path) -> Path | None:
    """The picture of a photograph, beside the capture or the description."""
    source = folder / section.file
    own = source if source.is_dir() else source.parent
    places = (PosedPhotographs((frame,), f, section.reader, True, True) for f in (own, folder))
    path = next((found for place in places if (found := place.file(frame))), None)
    return path if path and path.suffix.lower() in _ENDINGS else None
