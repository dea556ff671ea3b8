"""The cameras stage: given views, and the best of many along the walls; and the render settings."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

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
from openrooms_usd.geometry.framing import framing_view
from openrooms_usd.geometry.pinhole import intrinsics, look_at
from openrooms_usd.geometry.raycast import RayCaster
from openrooms_usd.geometry.rotations import nearest_rotation, pose
from openrooms_usd.geometry.triangulation import TriangleMesh, bounding_box
from openrooms_usd.geometry.views import sample_views, select_views
from openrooms_usd.stages.base import StageContext
from openrooms_usd.stages.captures import capture_inputs, captured_section
from openrooms_usd.stages.exposure import room_exposure
from openrooms_usd.stages.photographs import (
    frame_name,
    intrinsics_for,
    name_photograph,
    photographs,
)
from openrooms_usd.usd.cameras import define_camera, exposure_of_ev100
from openrooms_usd.usd.frames import TIME, local_to_world
from openrooms_usd.usd.meshes import PlacedMesh, read_meshes, world_triangles

Array = NDArray[np.float64]

# Above this many triangles furniture is cast as its boxes: views need no more to be chosen.
MANY_TRIANGLES: Final = 2_000_000

# Candidates for each view that is kept, and at least this many.
_CANDIDATES_PER_VIEW: Final = 24
_MIN_CANDIDATES: Final = 192

# Where a look at an opening ends, before the inner edge of its wall, metres.
_BEFORE_OPENING_M: Final = 0.05

# Room between an eye and the ceiling, metres.
_BELOW_CEILING: Final = 0.25


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
        for shot in _named(context, capture):
            path = f"{names.CAMERAS}/{shot.name}"
            camera = define_camera(
                stage,
                path,
                world_from_camera=shot.pose,
                resolution=resolution,
                K=_intrinsics(shot, resolution),
                exposure=_exposure(shot.view),
                estimate=estimate,
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
        name: Its prim name.
    """

    view: View
    pose: Array
    frame: CapturedFrame | None = None
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


def _shots(context: StageContext, capture: Capture | None) -> Iterator[_Shot]:
    """Every camera with the view that asks for it; selections and captures give several."""
    selection: _Selection | None = None
    for number, view in enumerate(context.room.cameras.views):
        if isinstance(view, SelectedCameras):
            selection = selection or _Selection.of(context.stage)
            yield from (_Shot(view, matrix) for matrix in selection.choose(context, number, view))
        elif isinstance(view, FrameCameras):
            frames = capture.frames if capture else ()
            yield from (_Shot(view, f.world_from_camera, f) for f in frames[:: view.every])
        elif isinstance(view, LookAtCamera):
            yield _Shot(view, look_at(view.eye, view.target))
        else:
            matrix = np.array(view.world_from_camera)
            yield _Shot(view, pose(nearest_rotation(matrix[:, :3]), matrix[:, 3]))


def _named(context: StageContext, capture: Capture | None) -> Iterator[_Shot]:
    """The cameras with prim names: as given, by their photograph, else numbered and free."""
    several = (SelectedCameras, FrameCameras)
    given = [None if isinstance(v, several) else v.name for v in context.room.cameras.views]
    taken = {name for name in given if name is not None}
    for shot in _shots(context, capture):
        view = shot.view
        if isinstance(view, FrameCameras) and shot.frame:
            name = frame_name(view.name, shot.frame, taken)
        elif isinstance(view, SelectedCameras):
            name = _free(view.name, taken)
        else:
            name = view.name or _free("view", taken)
        taken.add(name)
        yield replace(shot, name=name)


def _free(prefix: str, taken: set[str]) -> str:
    number = 0
    while f"{prefix}_{number}" in taken:
        number += 1
    return f"{prefix}_{number}"


@dataclass(frozen=True, eq=False)
class _Selection:
    """The composed room, ready to be looked at.

    Attributes:
        points: (M, 3, 3) corners of everything that is drawn, metres.
        caster: The same for rays.
        polygon: (P, 2) floor.
        floor: Height of the floor.
        headroom: From the floor to a little below the ceiling, metres.
        openings: (K, 3) the middles of windows, doors and passages, on the room's side.
    """

    points: Array
    caster: RayCaster
    polygon: Array
    floor: float
    headroom: float
    openings: Array

    @classmethod
    def of(cls, stage: Usd.Stage) -> "_Selection":
        meshes = read_meshes(stage).meshes
        points, triangles, _ = world_triangles(_light(meshes))
        shell = _points(meshes, names.ROOM)
        everything = next(found for found in (shell, points, np.zeros((1, 3))) if len(found))
        low, high = everything.min(axis=0), everything.max(axis=0)
        ground = float(_points(meshes, names.FLOOR)[:, 2].max(initial=low[2]))
        top = float(_points(meshes, names.CEILING)[:, 2].min(initial=high[2]))
        polygon = _floor_polygon(stage)
        if polygon is None:
            polygon = np.array([low[:2], [high[0], low[1]], high[:2], [low[0], high[1]]])
        caster = RayCaster(points, triangles)
        headroom = top - ground - _BELOW_CEILING
        return cls(points[triangles], caster, polygon, ground, headroom, _openings(stage))

    def choose(self, context: StageContext, number: int, view: SelectedCameras) -> Array:
        """(C, 4, 4) poses of the best views."""
        width, height = context.room.cameras.resolution or (1, 1)
        highest = min(view.height[1], max(self.headroom, 0.1))
        candidates = sample_views(
            self.polygon,
            self.floor,
            max(_MIN_CANDIDATES, _CANDIDATES_PER_VIEW * view.count),
            context.rng("cameras", "select", str(number)),
            height=(min(view.height[0], highest), highest),
            distance=(min(view.distance), max(view.distance)),
        )
        chosen = select_views(
            self.caster,
            candidates,
            view.count,
            fov_degrees=view.fov,
            aspect=width / height,
            places=self.openings,
        )
        if not len(chosen):
            context.notes.append("no free view along the walls: the room is framed as a whole")
            return framing_view(self.points, self.caster, width / height).poses()
        if len(chosen) < view.count:
            context.notes.append(
                f"only {len(chosen)} of {view.count} views found room along the walls"
            )
        return chosen.poses()


def _points(meshes: list[PlacedMesh], root: str) -> Array:
    """(N, 3) points in the world of all meshes at or below a path."""
    below = [m.world_points() for m in meshes if m.path == root or m.path.startswith(f"{root}/")]
    return np.concatenate([np.zeros((0, 3)), *below])


def _openings(stage: Usd.Stage) -> Array:
    """(K, 3) a little before the middle of every opening, in the world."""
    openings, cache = stage.GetPrimAtPath(names.OPENINGS), UsdGeom.XformCache(TIME)
    rows = [
        prim for prim in (openings.GetChildren() if openings else ()) if UsdGeom.Xformable(prim)
    ]
    before = np.array([0.0, -_BEFORE_OPENING_M, 0.0, 1.0])
    return np.array([(local_to_world(prim, cache) @ before)[:3] for prim in rows]).reshape(-1, 3)


def _floor_polygon(stage: Usd.Stage) -> Array | None:
    """(P, 2) as the layout stage left it; None where there is no usable one."""
    room = stage.GetPrimAtPath(names.ROOM)
    attribute = room.GetAttribute(names.ROOM_FLOOR) if room else None
    corners = np.array(attribute.Get() if attribute and attribute.HasValue() else [])
    usable = corners.ndim == 2 and len(corners) >= 3 and np.isfinite(corners).all()
    return corners.astype(np.float64) if usable else None


def _light(meshes: list[PlacedMesh]) -> list[PlacedMesh]:
    """The meshes, or boxes for those of the furniture when there are too many triangles."""
    if sum(len(mesh.mesh.triangles) for mesh in meshes) <= MANY_TRIANGLES:
        return meshes
    boxes: dict[int, TriangleMesh] = {}
    for mesh in meshes:
        boxes.setdefault(id(mesh.mesh), bounding_box(mesh.mesh))
    return [
        PlacedMesh(mesh.path, mesh.prim, boxes[id(mesh.mesh)], mesh.world_from_local)
        if mesh.path.startswith(f"{names.FURNITURE}/")
        else mesh
        for mesh in meshes
    ]
