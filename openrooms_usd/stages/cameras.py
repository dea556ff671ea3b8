"""The cameras stage: given views, and the best of many (`selection`); and the render settings."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from pxr import Gf, Sdf, Usd, UsdGeom, UsdRender

from openrooms_usd import names
from openrooms_usd.capture import Capture, CapturedFrame
from openrooms_usd.description.cameras import (
    FrameCameras,
    LookAtCamera,
    SelectedCameras,
    View,
    Viewed,
)
from openrooms_usd.description.room import Room
from openrooms_usd.geometry.pinhole import intrinsics, look_at
from openrooms_usd.geometry.rotations import nearest_rotation, pose
from openrooms_usd.stages.base import StageContext
from openrooms_usd.stages.captures import capture_inputs, captured_section
from openrooms_usd.stages.exposure import room_exposure
from openrooms_usd.stages.photographs import (
    frame_name,
    intrinsics_for,
    name_photograph,
    photographs,
)
from openrooms_usd.stages.selection import Selection
from openrooms_usd.usd.cameras import define_camera, exposure_of_ev100

Array = NDArray[np.float64]


class CamerasStage:
    """Writes ``/World/Cameras`` and ``/Render``."""

    name = "cameras"
    reads = ("layout", "alignment", "lights")

    def inputs(self, room: Room, source: Path) -> Iterable[str]:
        """The capture, where cameras are those of its photographs."""
        section = captured_section(room)
        framed = any(isinstance(view, FrameCameras) for view in room.cameras.views)
        return capture_inputs(section, source) if framed and section else ()

    def author(self, context: StageContext) -> None:
        """Write one Camera for each view, and the render settings.

        Raises:
            InputError: A camera looks at the very point where it stands, or the capture cannot be
                read or has no photographs.
        """
        stage, capture = context.stage, photographs(context)
        UsdGeom.Scope.Define(stage, names.CAMERAS)
        resolution = _resolution(context, capture)
        estimate = room_exposure(stage)
        paths = []
        # The room is read once, and only where somebody looks around in it.
        selection = cache(lambda: Selection.of(stage))
        for shot in _named(context, capture, selection):
            path = f"{names.CAMERAS}/{shot.name}"
            camera = define_camera(
                stage,
                path,
                world_from_camera=shot.pose,
                resolution=resolution,
                K=_intrinsics(shot, resolution),
                exposure=_exposure(shot.view),
                estimate=estimate,
                lens=_lens(shot, selection),
            )
            if shot.frame and capture:
                name_photograph(camera.GetPrim(), shot.frame, capture)
            paths.append(path)
        _define_settings(stage, resolution, paths)


@dataclass(frozen=True, eq=False)
class _Shot:
    """One camera.

    Attributes:
        view: What asks for it.
        pose: (4, 4) from the camera to the world.
        frame: The photograph that it stands for, if any.
        prefix: Of its prim name, where that is numbered.
        name: Its prim name.
    """

    view: View
    pose: Array
    frame: CapturedFrame | None = None
    prefix: str = "view"
    name: str = ""


def _resolution(context: StageContext, capture: Capture | None) -> tuple[int, int]:
    """As described, or else that of the first photograph."""
    described = context.room.cameras.resolution
    if described is None:
        assert capture is not None
        return capture.frames[0].resolution
    return described


def _intrinsics(shot: _Shot, resolution: tuple[int, int]) -> Array:
    if shot.frame is not None:
        return intrinsics_for(shot.frame, resolution)
    assert isinstance(shot.view, Viewed)
    return intrinsics(shot.view.fov, *resolution)


def _lens(shot: _Shot, selection: Callable[[], Selection]) -> tuple[float, float] | None:
    """F-number and focus, metres; None where all is sharp."""
    view = shot.view
    if not isinstance(view, Viewed) or view.f_stop is None:
        return None
    if isinstance(view.focus, float):
        return view.f_stop, view.focus
    if isinstance(view, LookAtCamera) and view.focus is None:
        return view.f_stop, float(np.linalg.norm(np.subtract(view.target, view.eye)))
    return view.f_stop, selection().focus(shot.pose, view.fov)


def _exposure(view: View) -> float | None:
    return None if view.exposure_value is None else exposure_of_ev100(view.exposure_value)


def _define_settings(stage: Usd.Stage, resolution: tuple[int, int], cameras: list[str]) -> None:
    UsdGeom.Scope.Define(stage, names.RENDER)
    settings = UsdRender.Settings.Define(stage, names.RENDER_SETTINGS)
    settings.CreateResolutionAttr(Gf.Vec2i(*resolution))
    # The horizontal field of view is the one that counts; see `usd.cameras.read_camera`.
    settings.CreateAspectRatioConformPolicyAttr(UsdRender.Tokens.adjustApertureHeight)
    settings.CreateIncludedPurposesAttr([UsdGeom.Tokens.default_, UsdGeom.Tokens.render])
    if cameras:
        settings.CreateCameraRel().SetTargets([Sdf.Path(cameras[0])])


def _shots(
    context: StageContext, capture: Capture | None, selection: Callable[[], Selection]
) -> Iterator[_Shot]:
    """Every camera with the view that asks for it; selections and captures give several."""
    for number, view in enumerate(context.room.cameras.views):
        if isinstance(view, SelectedCameras):
            chosen = enumerate(selection().choose(context, number, view))
            yield from (_Shot(view, m, prefix=_prefix(view, place)) for place, m in chosen)
        elif isinstance(view, FrameCameras):
            frames = capture.frames if capture else ()
            yield from (_Shot(view, f.world_from_camera, f) for f in frames[:: view.every])
        elif isinstance(view, LookAtCamera):
            yield _Shot(view, look_at(view.eye, view.target))
        else:
            matrix = np.array(view.world_from_camera)
            yield _Shot(view, pose(nearest_rotation(matrix[:, :3]), matrix[:, 3]))


def _prefix(view: SelectedCameras, place: int) -> str:
    """Those that are kept in case come last."""
    return view.name if place < view.count else names.SPARE_CAMERA


def _named(
    context: StageContext, capture: Capture | None, selection: Callable[[], Selection]
) -> Iterator[_Shot]:
    """The cameras with prim names: as given, by their photograph, else numbered and free."""
    several = (SelectedCameras, FrameCameras)
    given = [None if isinstance(v, several) else v.name for v in context.room.cameras.views]
    taken = {name for name in given if name is not None}
    for shot in _shots(context, capture, selection):
        view = shot.view
        if isinstance(view, FrameCameras) and shot.frame:
            name = frame_name(view.name, shot.frame, taken)
        elif isinstance(view, SelectedCameras):
            name = _free(shot.prefix, taken)
        else:
            name = view.name or _free(shot.prefix, taken)
        taken.add(name)
        yield replace(shot, name=name)


def _free(prefix: str, taken: set[str]) -> str:
    number = 0
    while f"{prefix}_{number}" in taken:
        number += 1
    return f"{prefix}_{number}"
