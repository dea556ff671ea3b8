"""From where the views of a room are seen: cameras of its stage, or the frames of a walk.

The choice depends only on the geometry of the room and the dataset's file, never on light or on
finished views. So variants of a room share their cameras, and a resumed run makes the same choice.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Final

import numpy as np

from openrooms_usd.dataset.quality import JUDGED, camera_faults
from openrooms_usd.description.dataset import DatasetViews
from openrooms_usd.errors import RenderError
from openrooms_usd.geometry.pinhole import panorama_intrinsics, rotations
from openrooms_usd.geometry.rotations import pose
from openrooms_usd.rendering.context import RenderContext
from openrooms_usd.rendering.paths.camera_path import CameraPath, frame_times
from openrooms_usd.rendering.paths.choosing import stage_walk
from openrooms_usd.rendering.plan import is_spare
from openrooms_usd.usd.cameras import EQUIRECTANGULAR, PINHOLE, PinholeCamera

DEFAULT_RATE: Final = 4
EYES: Final = ("left", "right")

# The height of a forward direction beyond which it has no heading.
_UPRIGHT: Final = 0.999

Rejection = Mapping[str, Any]
"""A camera that was left out: its name, its pose, and what is wrong with its view."""


@dataclass(frozen=True, eq=False)
class Shot:
    """From where one view is seen.

    Attributes:
        name: The camera's prim path, or what sets its random numbers apart from those of others.
        camera: The camera.
        view: The name of the stage's own camera among those of the opened job; None where the stage
            has no camera there.
        told: What the manifest says of it besides, such as when a frame is.
        rejected: The cameras that it stands in for.
        after: The camera of the next frame of a path.
    """

    name: str | None
    camera: PinholeCamera
    view: str | None = None
    told: Mapping[str, Any] = field(default_factory=dict)
    rejected: Sequence[Rejection] = ()
    after: PinholeCamera | None = None


def shots_of(views: DatasetViews, opened: RenderContext) -> list[Shot]:
    """The shots of all views of a room, by their numbers.

    Args:
        views: What is asked for.
        opened: The room, opened; its stage has the cameras to choose among.

    Returns:
        At most as many as are asked for: a room may have fewer cameras.

    Raises:
        RenderError: There is no room for a walk.
    """
    if views.source == "path":
        found = list(_frames(views, opened))
    else:
        cameras = _listed(opened)
        if views.source == "capture":
            cameras = _spread_evenly(cameras, views.count, views.replace)
        found = list(_select_shots(views, opened, cameras))
    return found if views.stereo is None else list(_pairs(found, views.stereo))


def shot(shots: Sequence[Shot], number: int, room: str) -> Shot:
    """The shot of a view.

    Raises:
        RenderError: The room has no such view.
    """
    if number >= len(shots):
        raise RenderError(
            f"the room has {len(shots)} views, but no view {number}",
            place=room,
            remedy="request fewer views",
        )
    return shots[number]


def _select_shots(
    views: DatasetViews, opened: RenderContext, cameras: Sequence[str]
) -> Iterator[Shot]:
    """The first cameras; for those whose views are of no use, the next unused ones."""
    spare = iter(cameras[views.count : views.count + views.replace])
    for name in cameras[: views.count]:
        if views.replace == 0:
            yield _shot(views, opened, name)
            continue
        rejected: list[Rejection] = []
        tried: str | None = name
        while tried is not None:
            taken = _shot(views, opened, tried)
            faults = _faults(views, opened, taken)
            if not faults:
                yield replace(taken, rejected=tuple(rejected))
                break
            pose = taken.camera.world_from_camera.tolist()
            rejected.append({"camera": tried, "world_from_camera": pose, "faults": faults})
            tried = next(spare, None)
        else:
            # No better one is left: its faults are reported, like those of every view.
            yield replace(_shot(views, opened, name), rejected=tuple(rejected[1:]))


def _shot(views: DatasetViews, opened: RenderContext, view: str) -> Shot:
    return Shot(opened.views[view], _projected(views, opened.camera(opened.views[view])), view)


def _projected(views: DatasetViews, camera: PinholeCamera) -> PinholeCamera:
    """The camera, or a level panorama from where it is, whose middle is where it looks."""
    if views.projection == PINHOLE:
        return camera
    world = camera.world_from_camera
    # Who looks straight up or down has its forward where the picture's top is.
    ahead = world[:3, 2] if abs(world[2, 2]) < _UPRIGHT else -world[:3, 1]
    level = pose(rotations([ahead[0], ahead[1], 0.0])[0], world[:3, 3])
    return PinholeCamera(
        panorama_intrinsics(*views.resolution), level, camera.exposure, projection=EQUIRECTANGULAR
    )


def _faults(views: DatasetViews, opened: RenderContext, taken: Shot) -> list[str]:
    """What is wrong with a view, or one of a pair, by its geometry: no light is computed for it."""
    request = opened.request(taken.name, channels=JUDGED, guides=False)
    eyes = [taken.camera]
    if views.stereo is not None:
        eyes.append(_beside(taken.camera, views.stereo))
    found = (camera_faults(opened.picture(eye, request)) for eye in eyes)
    return list(dict.fromkeys(fault for faults in found for fault in faults))


def _frames(views: DatasetViews, opened: RenderContext) -> Iterator[Shot]:
    """The frames of a walk past the stage's cameras, each with the camera after it."""
    rate = views.rate or DEFAULT_RATE
    # One more than is asked for: the last frame has one after it, too.
    times = frame_times((views.count + 1) / rate, rate)
    path: CameraPath = stage_walk(opened, opened.resolution, times, rate)
    cameras = [_projected(views, camera) for camera in path.cameras]
    for number, camera in enumerate(cameras[:-1]):
        told = {"frame": {"path": path.name, "number": number, "seconds": float(times[number])}}
        yield Shot(path.frame_name(number), camera, told=told, after=cameras[number + 1])


def _pairs(shots: Sequence[Shot], baseline: float) -> Iterator[Shot]:
    """Each shot as the left eye, and the right eye beside it."""
    for number, left in enumerate(shots):
        for eye, side in enumerate(EYES):
            moved = _beside(left.camera, eye * baseline)
            told = {**left.told, "stereo": {"eye": side, "baseline": baseline, "pair": number}}
            name = f"{left.name}/{side}" if left.name else side
            after = None if left.after is None else _beside(left.after, eye * baseline)
            changed = replace(left, name=name, camera=moved, told=told, after=after)
            yield replace(changed, view=None, rejected=()) if eye else changed


def _beside(camera: PinholeCamera, metres: float) -> PinholeCamera:
    """The same camera, so much to its right."""
    pose = camera.world_from_camera.copy()
    pose[:3, 3] += metres * pose[:3, 0]
    return replace(camera, world_from_camera=pose)


def _listed(opened: RenderContext) -> list[str]:
    """The stage's cameras in its own order: that of the room.yaml, or of the capture.

    Those of selected views that are kept in case come after the others.
    """
    places = {str(prim.GetPath()): place for place, prim in enumerate(opened.stage.Traverse())}

    def rank(name: str) -> tuple[bool, int]:
        place = places.get(opened.views[name] or "", len(places))
        return is_spare(opened.views[name] or ""), place

    return sorted(opened.views, key=rank)


def _spread_evenly(cameras: Sequence[str], count: int, spare: int) -> list[str]:
    """So many of a sequence, evenly spread, and then as many as are spare of those between."""
    taken = _evenly(cameras, count)
    return [*taken, *_evenly([name for name in cameras if name not in taken], spare)]


def _evenly(cameras: Sequence[str], count: int) -> list[str]:
    rows = np.linspace(0, len(cameras) - 1, min(count, len(cameras))).round().astype(int)
    return [cameras[row] for row in rows]
