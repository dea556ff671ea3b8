"""The photographs of a capture as cameras, so that each view stands for one of them."""

import re
from dataclasses import replace

import numpy as np
from pxr import Sdf, Usd

from openrooms_usd import names
from openrooms_usd.arrays import Array
from openrooms_usd.capture import Capture, CapturedFrame
from openrooms_usd.description.cameras import FrameCameras
from openrooms_usd.description.layout import ScanLayout
from openrooms_usd.errors import InputError
from openrooms_usd.stages.base import StageContext
from openrooms_usd.stages.captures import capture_of, captured_section


def photographs(context: StageContext) -> Capture | None:
    """The room's capture where the description asks for its cameras; None where it does not.

    Raises:
        InputError: The capture cannot be read, or knows no cameras.
    """
    if not any(isinstance(view, FrameCameras) for view in context.room.cameras.views):
        return None
    section = captured_section(context.room)
    if section is None:
        raise InputError(
            "the room comes from no capture, whose cameras could be taken",
            place="cameras",
            remedy="describe the cameras, or let them be selected: `from: select`",
        )
    capture = capture_of(context, section)
    if not capture.frames:
        raise InputError(
            "this capture knows no cameras of photographs",
            place=context.source / section.file,
            remedy="import it with --frames where its importer has that, or describe the cameras",
        )
    if isinstance(section, ScanLayout):
        capture = replace(capture, frames=_standing(context, capture))
    return capture


def _standing(context: StageContext, capture: Capture) -> tuple[CapturedFrame, ...]:
    """The photographs of a scan, as the room stands that was found in it."""
    room = context.stage.GetPrimAtPath(names.ROOM)
    source_from_room = np.array(room.GetAttribute(names.SOURCE_FROM_WORLD).Get()).T
    room_from_scan = np.linalg.inv(source_from_room) @ capture.source_from_world
    return tuple(
        replace(frame, world_from_camera=room_from_scan @ frame.world_from_camera)
        for frame in capture.frames
    )


def frame_name(prefix: str, frame: CapturedFrame, taken: set[str]) -> str:
    """A free prim name that tells the frame's identifier: ``frame_33``."""
    name = f"{prefix}_" + re.sub(r"\W", "_", frame.id, flags=re.ASCII)
    while name in taken:
        name += "_"
    return name


def intrinsics_for(frame: CapturedFrame, resolution: tuple[int, int]) -> Array:
    """(3, 3) intrinsics of a frame for pictures of another size.

    The picture's width stays what it sees; where the shape is another, rows are added or left out
    above and below alike. Pixels are square: the horizontal focal length counts.
    """
    (width, height), (own_width, own_height) = resolution, frame.resolution
    scale = width / own_width
    K = frame.K
    cy = 0.5 * height + scale * (K[1, 2] - 0.5 * own_height)
    focal = scale * K[0, 0]
    return np.array([[focal, 0.0, scale * K[0, 2]], [0.0, focal, cy], [0.0, 0.0, 1.0]])


def name_photograph(prim: Usd.Prim, frame: CapturedFrame, capture: Capture) -> None:
    """Write on a camera which photograph it stands for."""
    prim.AddAppliedSchema(names.SOURCE_API)
    source = {names.SOURCE_FILE: frame.picture or capture.source, names.SOURCE_ID: frame.id}
    for name, value in source.items():
        prim.CreateAttribute(name, Sdf.ValueTypeNames.String, custom=False).Set(value)
