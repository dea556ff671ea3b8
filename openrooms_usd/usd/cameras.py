"""Cameras as USD prims, and as a pinhole with numbers that every tool understands.

Orthographic ones have the same numbers, with a ``K`` per metre.
"""

import math
from dataclasses import dataclass, replace
from typing import Final, Literal

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom, UsdRender

from openrooms_usd import names
from openrooms_usd.arrays import Array
from openrooms_usd.errors import InputError, StageError
from openrooms_usd.geometry.framing import FOV_DEG, framing_view
from openrooms_usd.geometry.pinhole import (
    intrinsics,
    panorama_directions,
    parallel_origins,
    pixel_directions,
)
from openrooms_usd.geometry.raycast import RayCaster
from openrooms_usd.geometry.rotations import nearest_rotation, pose
from openrooms_usd.usd.arrays import number_of, vector_of
from openrooms_usd.usd.places import frames
from openrooms_usd.usd.rendersettings import conformed_aperture, is_set, render_settings
from openrooms_usd.usd.shapes.meshes import MeshReading, read_meshes, world_triangles

Projection = Literal["pinhole", "equirectangular", "orthographic"]
"""How a camera's picture is made.

The ``K`` of an equirectangular one has pixels per radian, of an orthographic one per metre.
"""
PINHOLE: Final = "pinhole"
EQUIRECTANGULAR: Final = "equirectangular"
ORTHOGRAPHIC: Final = "orthographic"

# OpenCV axes (right, down, forward) in USD's camera axes (right, up, backward), and back.
FLIP: Final = np.diag([1.0, -1.0, -1.0, 1.0])

# Width of a full-frame film, tenths of a metre: apertures need some absolute size.
_FILM_WIDTH_TENTHS: Final = 0.36
# What cameras are written with. Planes that are nearer or farther cut nothing away: they are there
# for the depth buffers of rasterizers.
_CLIPPING_M: Final = (0.01, 1000.0)
# Nothing is cut away.
UNCLIPPED: Final = (0.0, math.inf)

# Apertures and focal lengths are in tenths of a scene unit.
_TENTH: Final = 0.1

_EXPOSURE: Final = tuple(
    f"exposure{suffix}" for suffix in ("", ":iso", ":time", ":fStop", ":responsivity")
)

# Custom data of ``exposure``: its value while no exposure was chosen.
_ESTIMATED: Final = f"{names.NAMESPACE}:estimated"


@dataclass(frozen=True, eq=False)
class PinholeCamera:
    """A camera for pictures of one size: perspective, orthographic, or a panorama.

    Attributes:
        K: (3, 3) intrinsics in pixels; the centre of the top-left pixel is (0.5, 0.5).
        world_from_camera: (4, 4) rigid, from the OpenCV frame (x right, y down, z forward) to the
            world: Z up, metres.
        exposure: What previews multiply luminance in nits by; None where none is authored.
        f_stop: Of the lens; 0 for a pinhole, everything sharp.
        focus_distance: Metres along the optical axis; 0 where none is authored.
        lens_radius: Radius of the lens's opening, metres; 0 for a pinhole.
        clipping: Nearest and farthest planar depth that is seen, metres.
        projection: How its picture is made.
    """

    K: Array
    world_from_camera: Array
    exposure: float | None = None
    f_stop: float = 0.0
    focus_distance: float = 0.0
    lens_radius: float = 0.0
    clipping: tuple[float, float] = UNCLIPPED
    projection: Projection = PINHOLE

    def directions(self, width: int, height: int) -> Array:
        """(height, width, 3) of the pixels' centres in the OpenCV frame.

        Of planar depth 1; those of a panorama of length 1, so that its depth is the distance.
        """
        if self.projection == EQUIRECTANGULAR:
            return panorama_directions(self.K, width, height)
        if self.projection == ORTHOGRAPHIC:
            return np.tile([0.0, 0.0, 1.0], (height, width, 1))
        return pixel_directions(self.K, width, height)

    def rays(self, width: int, height: int) -> tuple[Array, Array]:
        """Rays through the pixels' centres, in the world.

        Returns:
            (height x width, 3) where depth is 0, metres, and (height x width, 3) `directions`.
        """
        R, eye = self.world_from_camera[:3, :3], self.world_from_camera[:3, 3]
        directions = (self.directions(width, height) @ R.T).reshape(-1, 3)
        if self.projection != ORTHOGRAPHIC:
            return np.broadcast_to(eye, directions.shape), directions
        return (parallel_origins(self.K, width, height) @ R.T).reshape(-1, 3) + eye, directions


def define_camera(
    stage: Usd.Stage,
    path: str | Sdf.Path,
    *,
    world_from_camera: Array,
    resolution: tuple[int, int],
    fov_degrees: float = FOV_DEG,
    K: Array | None = None,
    exposure: float | None = None,
    estimate: float | None = None,
    lens: tuple[float, float] | None = None,
) -> UsdGeom.Camera:
    """Define a camera on a Z-up stage in metres, below prims without transforms.

    Args:
        stage: Where to define it; the edit target receives everything.
        path: The prim's path.
        world_from_camera: (4, 4) from the OpenCV frame (x right, y down, z forward), metres.
        resolution: Width and height in pixels; their ratio fixes the vertical aperture.
        fov_degrees: Horizontal field of view, centred.
        K: (3, 3) intrinsics for this resolution in its place; pixels count as square.
        exposure: What previews multiply luminance in nits by.
        estimate: An estimate, if ``exposure`` is None: other programs start with it. `read_camera`
            ignores it, so previews are fitted as usual.
        lens: Its f-number, and metres to what is in focus; None: all is sharp.
    """
    width, height = resolution
    camera = UsdGeom.Camera.Define(stage, path)
    frames.author_matrix(camera.GetPrim(), world_from_camera @ FLIP)
    camera.CreateProjectionAttr(UsdGeom.Tokens.perspective)
    camera.CreateHorizontalApertureAttr(_FILM_WIDTH_TENTHS)
    camera.CreateVerticalApertureAttr(_FILM_WIDTH_TENTHS * height / width)
    K = intrinsics(fov_degrees, width, height) if K is None else K
    right, up = width / 2.0 - K[0, 2], K[1, 2] - height / 2.0
    if right or up:
        camera.CreateHorizontalApertureOffsetAttr(_FILM_WIDTH_TENTHS * right / width)
        camera.CreateVerticalApertureOffsetAttr(_FILM_WIDTH_TENTHS * up / width)
    camera.CreateFocalLengthAttr(_FILM_WIDTH_TENTHS * K[0, 0] / width)
    camera.CreateClippingRangeAttr(Gf.Vec2f(*_CLIPPING_M))
    if lens is not None:
        camera.CreateFStopAttr(lens[0])
        camera.CreateFocusDistanceAttr(lens[1])
    if exposure is not None:
        camera.CreateExposureAttr(math.log2(exposure))
    elif estimate is not None:
        guess = camera.CreateExposureAttr(round(math.log2(estimate), 1))
        guess.SetCustomDataByKey(_ESTIMATED, guess.Get())
    return camera


def exposure_of_ev100(exposure_value: float) -> float:
    """What to multiply luminance in nits by at an EV100.

    With the saturation-based speed of ISO 12232 and a lens transmittance q = 0.65, the luminance
    that saturates the sensor is 78 / (100 q) 2^EV100 = 1.2 2^EV100 cd/m2; it becomes 1.
    """
    return float(1.0 / (1.2 * 2.0**exposure_value))


def list_cameras(stage: Usd.Stage) -> list[Usd.Prim]:
    """The stage's perspective and other cameras, sorted by path."""
    prototypes = [Usd.PrimRange(prototype) for prototype in stage.GetPrototypes()]
    inside = any(prim.IsA(UsdGeom.Camera) for prims in prototypes for prim in prims)
    # Instances are entered only where it is worth it: there may be thousands of them.
    predicate = Usd.TraverseInstanceProxies() if inside else Usd.PrimDefaultPredicate
    found = [prim for prim in stage.Traverse(predicate) if prim.IsA(UsdGeom.Camera)]
    return sorted(found, key=lambda prim: str(prim.GetPath()))


def read_camera(prim: Usd.Prim, width: int, height: int) -> PinholeCamera:
    """A camera prim as a pinhole, or with parallel rays, for pictures of one size.

    The horizontal aperture gives the horizontal field of view and pixels are square: where the
    picture has another shape than the apertures, the vertical field of view follows the picture,
    unless the stage's render settings say otherwise.
    An orthographic camera sees a window as wide as its aperture, in tenths of a scene unit; it has
    no lens.

    Args:
        prim: A ``UsdGeom.Camera`` of any stage.
        width: Pixels.
        height: Pixels.

    Raises:
        StageError: It is not a camera, or its values cannot form a picture.
    """
    camera = UsdGeom.Camera(prim)
    if not camera:
        raise _unusable(prim, "this prim is not a camera", "name a Camera prim")
    stage = prim.GetStage()
    metres = frames.meters_per_unit(stage)
    parallel = camera.GetProjectionAttr().Get(frames.TIME) == UsdGeom.Tokens.orthographic
    focal = _number(camera.GetFocalLengthAttr())
    seen = PinholeCamera(
        # The window is seen from 1 m, or from the focal length.
        K=_intrinsics(camera, 1.0 / (_TENTH * metres) if parallel else focal, width, height),
        world_from_camera=_pose(prim, frames.world_from_stage(stage)),
        exposure=_exposure(camera),
        clipping=_clipping(camera, metres, parallel=parallel),
    )
    if parallel:
        return replace(seen, projection=ORTHOGRAPHIC)
    sharp = is_set(stage, str(prim.GetPath()), "disableDepthOfField")
    f_stop = 0.0 if sharp else _number(camera.GetFStopAttr())
    return replace(
        seen,
        f_stop=f_stop,
        focus_distance=_number(camera.GetFocusDistanceAttr()) * metres,
        lens_radius=focal * _TENTH * metres / (2.0 * f_stop) if f_stop > 0 else 0.0,
    )


def with_lens(camera: PinholeCamera, f_stop: float, focus: float, width: int) -> PinholeCamera:
    """The camera with a lens before film 36 mm wide.

    Args:
        camera: For pictures so many pixels wide.
        f_stop: F-number.
        focus: Metres along the optical axis to what is sharp.
        width: Pixels.
    """
    focal = _FILM_WIDTH_TENTHS * _TENTH * float(camera.K[0, 0]) / width
    return replace(camera, f_stop=f_stop, focus_distance=focus, lens_radius=focal / (2.0 * f_stop))


def photograph(prim: Usd.Prim) -> dict[str, str] | None:
    """The photograph that a camera stands for: its ``file`` and its ``id`` in the capture.

    Args:
        prim: Any camera; None comes back for one that stands for none.
    """
    if not prim or not prim.GetAttribute(names.SOURCE_ID).HasAuthoredValue():
        return None
    found = {"file": names.SOURCE_FILE, "id": names.SOURCE_ID}
    return {key: str(prim.GetAttribute(name).Get() or "") for key, name in found.items()}


def framing_camera(
    stage: Usd.Stage, width: int, height: int, *, reading: MeshReading | None = None
) -> PinholeCamera:
    """A camera for a stage that has none: it sees everything, or a closed room from inside.

    Args:
        stage: Any stage.
        width: Pixels.
        height: Pixels.
        reading: The stage's meshes, where they have been read already.
    """
    found = read_meshes(stage, outside=False) if reading is None else reading
    points, triangles, _ = world_triangles(found)
    view = framing_view(points[triangles], RayCaster(points, triangles), width / height)
    return PinholeCamera(intrinsics(FOV_DEG, width, height), view.poses()[0])


def _unusable(prim: Usd.Prim, message: str, remedy: str) -> StageError:
    return StageError(message, place=prim.GetPath(), remedy=remedy)


def _number(attribute: Usd.Attribute) -> float:
    value = number_of(attribute.Get(frames.TIME))
    return value if value is not None and math.isfinite(value) else 0.0


def _clipping(camera: UsdGeom.Camera, metres: float, *, parallel: bool) -> tuple[float, float]:
    """Nearest and farthest depth that is seen, metres; unlimited if not authored or not valid."""
    attribute = camera.GetClippingRangeAttr()
    if not attribute.HasAuthoredValue():
        return UNCLIPPED
    depths = vector_of(attribute.Get(frames.TIME), 2)
    if depths is None or not depths[0] < depths[1]:
        return UNCLIPPED
    near, far = (depths * metres).tolist()
    least, most = _CLIPPING_M
    # What is behind an orthographic camera may be seen: it stands where rays do not meet.
    nearest = near if parallel or np.float32(near) > np.float32(least) else 0.0
    return nearest, far if np.float32(far) < np.float32(most) else math.inf


def _intrinsics(camera: UsdGeom.Camera, focal: float, width: int, height: int) -> Array:
    """Of a window at a distance, both in the camera's own units."""
    aperture = conformed_aperture(camera, width, height)
    if not (0 < focal < math.inf and 0 < aperture < math.inf):
        raise _unusable(
            camera.GetPrim(),
            f"focalLength {focal:g} and horizontalAperture {aperture:g} cannot form a picture",
            "both must be positive, in tenths of a scene unit",
        )
    per_length = width / aperture
    right = _number(camera.GetHorizontalApertureOffsetAttr()) * per_length
    up = _number(camera.GetVerticalApertureOffsetAttr()) * per_length
    # The window moves right and up, so the optical axis moves left and down in the picture.
    return np.array(
        [
            [focal * per_length, 0.0, width / 2.0 - right],
            [0.0, focal * per_length, height / 2.0 + up],
            [0.0, 0.0, 1.0],
        ]
    )


def _pose(prim: Usd.Prim, world: Array) -> Array:
    with np.errstate(all="ignore"):
        placed = world @ frames.local_to_world(prim, UsdGeom.XformCache(frames.TIME)) @ FLIP
        determinant = np.linalg.det(placed[:3, :3])
    if not (np.isfinite(placed).all() and math.isfinite(determinant) and determinant > 0):
        raise _unusable(
            prim, "its transform is mirrored or singular", "use rotations and positive scales"
        )
    return pose(nearest_rotation(placed[:3, :3]), placed[:3, 3])


def _exposure(camera: UsdGeom.Camera) -> float | None:
    """What previews multiply nits by; None if not authored."""
    prim = camera.GetPrim()
    said = [x for x in map(prim.GetAttribute, _EXPOSURE) if x and x.HasAuthoredValue()]
    if not said:
        return None
    # A changed estimate counts as chosen.
    guess = camera.GetExposureAttr()
    if said == [guess] and guess.GetCustomDataByKey(_ESTIMATED) == guess.Get(frames.TIME):
        return None
    return float(camera.ComputeLinearExposureScale(frames.TIME))


_LEAST_FIELD_DEG: Final = 1.0
_MOST_FIELD_DEG: Final = 170.0


def set_field_of_view(stage: Usd.Stage, degrees: float) -> None:
    """Give all cameras of an opened stage a horizontal field of view; its files stay as they are.

    Args:
        stage: An opened stage.
        degrees: The angle between the picture's left and right edge.

    Raises:
        InputError: No picture has such an angle.
    """
    if not _LEAST_FIELD_DEG <= degrees <= _MOST_FIELD_DEG:
        raise InputError(
            f"a field of view of {degrees:g} degrees cannot form a picture",
            remedy=f"give {_LEAST_FIELD_DEG:g} to {_MOST_FIELD_DEG:g}",
        )
    with Usd.EditContext(stage, stage.GetSessionLayer()):
        if (settings := render_settings(stage)) is not None:
            # Else the horizontal field of view may follow from the vertical one.
            policy = settings.GetAspectRatioConformPolicyAttr()
            policy.Set(UsdRender.Tokens.adjustApertureHeight)
        for prim in list_cameras(stage):
            camera = UsdGeom.Camera(prim)
            aperture = number_of(camera.GetHorizontalApertureAttr().Get(frames.TIME)) or 0.0
            camera.GetFocalLengthAttr().Set(0.5 * aperture / math.tan(math.radians(degrees) / 2.0))
