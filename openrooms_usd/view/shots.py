"""What there is of a stage's cameras besides the page: finished renders and photographs."""

import base64
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Annotated, Any, Final

import numpy as np
from pydantic import Field

from openrooms_usd import untrusted
from openrooms_usd.colorimetry import srgb_from_linear
from openrooms_usd.comparison.photographs import Photographs
from openrooms_usd.description.model import Model, Number
from openrooms_usd.errors import InputError
from openrooms_usd.geometry.hemisphere import irradiance
from openrooms_usd.imagefile import write_png
from openrooms_usd.rendering.color import quantize
from openrooms_usd.rendering.reading import RenderedScene, RenderedView
from openrooms_usd.rendering.tone import fitted_tone
from openrooms_usd.scratch import scratch_folder

Resources = dict[str, Callable[[], bytes]]

PHOTOGRAPH: Final = "photograph"
_HEMISPHERES: Final = "environment"
# Pixels to a side of one of a hemisphere's.
_ENLARGED: Final = 8


class ViewPoint(Model):
    """A place in a view of a render."""

    camera: str
    """The camera's prim."""
    x: Annotated[Number, Field(ge=0.0, le=1.0)]
    """From the left, in parts of the width."""
    y: Annotated[Number, Field(ge=0.0, le=1.0)]
    """From the top, in parts of the height."""


def rendered_shots(
    render: RenderedScene, cameras: list[dict[str, Any]]
) -> tuple[dict[str, dict[str, str]], Resources]:
    """The pictures of a render: by the prim of the camera and the channel, names of resources.

    Args:
        render: A finished render of the stage.
        cameras: The stage's, as `openrooms_usd.view.prims.cameras_of` tells them.
    """
    told: dict[str, dict[str, str]] = {}
    resources: Resources = {}
    known = {camera["path"] for camera in cameras}
    for number, view in enumerate(render.each()):
        if view.entry.camera not in known:
            continue
        for channel, path in _previews(render, view).items():
            name = f"shot_{number}_{channel}{path.suffix}"
            told.setdefault(str(view.entry.camera), {})[channel] = name
            resources[name] = partial(untrusted.read_bytes, path, "picture")
    return told, resources


def _previews(render: RenderedScene, view: RenderedView) -> dict[str, Path]:
    found = {}
    for channel, said in view.entry.channels.items():
        if said.preview is not None:
            # A name from a file may not lead out of the folder.
            path = untrusted.inside(render.folder, said.preview)
            if untrusted.kind_of(path) == "a file":
                found[channel] = path
    return found


def photographs_of(
    taken: Photographs, cameras: list[dict[str, Any]]
) -> tuple[dict[str, dict[str, str]], Resources]:
    """The photographs that cameras stand for, likewise.

    Args:
        taken: What the capture knows.
        cameras: The stage's.
    """
    told: dict[str, dict[str, str]] = {}
    resources: Resources = {}
    frames = {frame.id: frame for frame in taken.frames}
    for number, camera in enumerate(cameras):
        frame = frames.get(camera["photograph"] or "")
        path = taken.file(frame) if frame else None
        if path is not None:
            name = f"photograph_{number}{path.suffix}"
            told[camera["path"]] = {PHOTOGRAPH: name}
            resources[name] = partial(untrusted.read_bytes, path, "picture")
    return told, resources


def has_hemispheres(render: RenderedScene) -> list[str]:
    """The prims of the cameras whose views have hemispheres of light."""
    found = (view for view in render.each() if (view.folder / f"{_HEMISPHERES}.exr").is_file())
    return [str(view.entry.camera) for view in found]


def hemisphere(render: RenderedScene, spot: ViewPoint) -> dict[str, Any]:
    """The light that arrives at a place, as a picture of the hemisphere above it.

    Raises:
        InputError: The view has none.
    """
    view = next((one for one in render.each() if one.entry.camera == spot.camera), None)
    grid = view.grid(_HEMISPHERES) if view is not None else None
    if grid is None:
        raise InputError(
            "this camera has no hemispheres of light",
            place=spot.camera,
            remedy=f"render it with --channels {_HEMISPHERES} among others",
        )
    rows, columns = grid.shape[:2]
    place = min(int(spot.y * rows), rows - 1), min(int(spot.x * columns), columns - 1)
    light = np.nan_to_num(grid[place].astype(np.float32))
    enlarged = np.repeat(np.repeat(light, _ENLARGED, axis=0), _ENLARGED, axis=1)
    tone = fitted_tone("film", enlarged)
    with scratch_folder() as folder:
        file = folder / "hemisphere.png"
        write_png(file, quantize(srgb_from_linear(tone.shown(enlarged))))
        text = base64.b64encode(file.read_bytes()).decode("ascii")
    return {
        "picture": f"data:image/png;base64,{text}",
        "irradiance": irradiance(light).tolist(),
        "row": place[0],
        "column": place[1],
    }
