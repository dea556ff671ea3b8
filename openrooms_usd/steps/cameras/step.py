"""The cameras step: given views, and the best of many (`selection`); and the render settings.

The room is taken for an integrating sphere: what lamps give and what comes in through openings,
the flux F in lumen, spreads evenly over all that bounds it, the area A. At a reflectance r what
leaves a surface is F r / (A (1 - r)) lumen a square metre, and its luminance a pi-th of that
(W. E. Sumpner, The Direct Measurement of the Total Light Emitted from a Lamp, 1892).
"""

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cache, reduce
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray
from pxr import Gf, Sdf, Usd, UsdGeom, UsdRender

from openrooms_usd import names
from openrooms_usd.arrays import Array
from openrooms_usd.capture import Capture, CapturedFrame
from openrooms_usd.colorimetry import luminance
from openrooms_usd.description.cameras import (
    FrameCameras,
    LookAtCamera,
    SelectedCameras,
    View,
    Viewed,
)
from openrooms_usd.description.room import Room
from openrooms_usd.errors import InputError
from openrooms_usd.geometry.pinhole import intrinsics, look_at
from openrooms_usd.geometry.rotations import nearest_rotation, pose
from openrooms_usd.steps.alignment.surroundings import RoomGeometry, surroundings
from openrooms_usd.steps.base import StepContext
from openrooms_usd.steps.cameras.plates import plate_inputs, show_plate
from openrooms_usd.steps.cameras.selection import (
    ViewCandidates,
    frame_name,
    intrinsics_for,
    name_photograph,
    photographs,
)
from openrooms_usd.steps.captures import capture_inputs, captured_section
from openrooms_usd.usd.cameras import define_camera, exposure_of_ev100
from openrooms_usd.usd.light.emitters import flux_share, world_area
from openrooms_usd.usd.light.lights import DomeLight, MeshLight, read_lights, read_portals
from openrooms_usd.usd.places.frames import Z_UP_FROM_Y_UP
from openrooms_usd.usd.shading.textures import read_texture

# Mean reflectance of walls, floor, ceiling and furniture.
_REFLECTANCE: Final = 0.5
# Share of daylight that passes frames, curtains and the depth of the wall.
_LET_IN: Final = 0.5
# Target of the mean luminance after exposure, as in previews.
_KEY: Final = 0.27
# So many pixels of a panorama along each side are taken together.
_BLOCK_PIXELS: Final = 4


class CamerasStep:
    """Writes ``/World/Cameras`` and ``/Render``."""

    name = "cameras"
    reads = ("layout", "alignment", "lights")

    def inputs(self, room: Room, source: Path) -> Iterable[str]:
        """The capture, where cameras are those of its photographs."""
        section = captured_section(room)
        framed = [view for view in room.cameras.views if isinstance(view, FrameCameras)]
        if not framed or section is None:
            return ()
        plates = plate_inputs(section, source) if any(view.plates for view in framed) else ()
        return dict.fromkeys([*capture_inputs(section, source), *plates])

    def author(self, context: StepContext) -> None:
        """Write one Camera for each view, and the render settings.

        Raises:
            InputError: A camera looks at the very point where it stands, or the capture cannot be
                read or has no photographs.
        """
        stage, capture = context.stage, photographs(context)
        UsdGeom.Scope.Define(stage, names.CAMERAS)
        resolution = _resolution(context, capture)
        estimate = room_exposure(stage)
        paths, lost = [], 0
        # The room is read once, and only if a view is selected in it.
        selection = cache(lambda: ViewCandidates.of(stage))
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
                lost += not _has_plate(camera, shot, resolution, context)
            paths.append(path)
        if lost:
            context.notes.append(f"the photographs of {lost} cameras are not here: no back plates")
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


def _has_plate(
    camera: UsdGeom.Camera, shot: _Shot, resolution: tuple[int, int], context: StepContext
) -> bool:
    """Whether a camera has the back plate that is asked for."""
    section = captured_section(context.room)
    if section is None or shot.frame is None or not isinstance(shot.view, FrameCameras):
        return True
    return not shot.view.plates or show_plate(camera, shot.frame, section, resolution, context)


def _resolution(context: StepContext, capture: Capture | None) -> tuple[int, int]:
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


def _lens(shot: _Shot, selection: Callable[[], ViewCandidates]) -> tuple[float, float] | None:
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
    context: StepContext, capture: Capture | None, selection: Callable[[], ViewCandidates]
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
    context: StepContext, capture: Capture | None, selection: Callable[[], ViewCandidates]
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


# The height of a room where it is unknown, metres.


def room_exposure(stage: Usd.Stage) -> float | None:
    """What to multiply luminance in nits by, so that the room is neither black nor white.

    Args:
        stage: A composed room, in metres with Z up.

    Returns:
        The factor; None for a room without a floor plan, or without light.
    """
    room = surroundings(stage)
    if not len(room.walls):
        return None
    floor, bounds = _areas(room)
    ways = [(p.world_from_portal[:3, 2], p.width * p.height) for p in read_portals(stage)]
    if room.ceiling is None:
        ways.append((np.array([0.0, 0.0, 1.0]), floor))
    flux = 0.0
    for light in read_lights(stage):
        if isinstance(light, MeshLight):
            area = world_area(stage.GetPrimAtPath(light.path))
            share = flux_share(stage.GetPrimAtPath(light.path), light.shaping)
            flux += math.pi * area * share * float(luminance(light.radiance))
        elif isinstance(light, DomeLight):
            lux = _illuminances(light, [outwards for outwards, _ in ways])
            flux += _LET_IN * sum(size * found for found, (_, size) in zip(lux, ways, strict=True))
    nits = flux * _REFLECTANCE / (bounds * (1.0 - _REFLECTANCE)) / math.pi
    return _KEY / nits if nits > 0.0 and math.isfinite(nits) else None


def _coarse(pixels: NDArray[np.float32]) -> NDArray[np.float32]:
    """The means of square blocks of pixels, about half a degree wide, as far as they fit."""
    count = math.gcd(*pixels.shape[:2], _BLOCK_PIXELS)
    # Sums of whole planes, which take a third of the time of a mean over two short axes.
    rows = reduce(np.add, [pixels[k::count] for k in range(count)])
    blocks = reduce(np.add, [rows[:, k::count] for k in range(count)])
    return np.asarray(blocks / np.float32(count**2))


def _areas(room: RoomGeometry) -> tuple[float, float]:
    """Of the floor, and of all that bounds the room; square metres."""
    (x0, y0), (x1, y1) = room.walls[:, 0].T, room.walls[:, 1].T
    floor = abs(float((x0 * y1 - x1 * y0).sum())) / 2.0
    height = names.ROOM_HEIGHT if room.ceiling is None else max(room.ceiling - room.floor, 0.0)
    return floor, 2.0 * floor + height * float(np.hypot(x1 - x0, y1 - y0).sum())


def _illuminances(dome: DomeLight, outwards: list[Array]) -> Iterator[float]:
    """Lux of planes that face outwards, by the half of the surroundings before each."""
    if dome.texture is None:
        yield from [math.pi * float(luminance(dome.radiance))] * len(outwards)
        return
    try:
        pixels = read_texture(dome.texture)[..., :3]
    except InputError:
        # The caller that draws it says it.
        yield from [0.0] * len(outwards)
        return
    nits = luminance(_coarse(pixels) * dome.radiance)
    height, width = nits.shape
    # The frame of the picture: its middle looks along -Y, a quarter from the left along +X.
    turn = Z_UP_FROM_Y_UP[:3, :3] @ dome.world_from_light[:3, :3].T
    edges = np.pi * (0.5 - np.arange(height + 1) / height)
    up, along = (
        0.5 * (edges[1:] + edges[:-1]),
        np.pi * (1.0 - 2.0 * (np.arange(width) + 0.5) / width),
    )
    weights = nits * -np.diff(np.sin(edges))[:, None] * (2.0 * np.pi / width)
    for way in outwards:
        x, y, z = turn @ way
        flat = x * np.sin(along) - y * np.cos(along)
        cosines = np.cos(up)[:, None] * flat + z * np.sin(up)[:, None]
        yield float((weights * np.clip(cosines, 0.0, None)).sum())
