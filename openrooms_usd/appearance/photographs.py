"""Photographs whose cameras are known: read from many forms, made straight, in metres with Z up."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final, Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from openrooms_usd import adapters, untrusted
from openrooms_usd.arrays import Array, Mask
from openrooms_usd.capture import CapturedFrame
from openrooms_usd.errors import InputError
from openrooms_usd.spelling import did_you_mean

# Numbers of coefficients that OpenCV's models have.
_LENSES: Final = {False: (0, 4, 5, 8), True: (0, 4)}
# Radii at which it is looked for where a lens folds the picture.
_RADII: Final = 1024
_AXES: Final = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
_BY_CAMERAS: Final = "cameras"
_SCALES: Final = (1e-6, 1e6)
# How much the tops of pictures count beside their level rows: where all look the same way.
_UPRIGHT_WEIGHT: Final = 1e-3


@dataclass(frozen=True, eq=False)
class PosedPhotographs:
    """Photographs with their cameras, in one world.

    Attributes:
        frames: In the order they were taken, where that is known.
        folder: Names of pictures and depth maps are relative to it.
        form: The reader that read them.
        scale_known: Whether the world is in metres.
        up_known: Whether its Z axis is up.
        notes: What was left out or guessed, one sentence each.
    """

    frames: tuple[CapturedFrame, ...]
    folder: Path
    form: str
    scale_known: bool
    up_known: bool
    notes: tuple[str, ...] = ()

    def file(self, frame: CapturedFrame) -> Path | None:
        """The picture of a frame; None where it is not in the folder."""
        return self._inside(frame.picture)

    def depth_file(self, frame: CapturedFrame) -> Path | None:
        """The depth map of a frame; None where it is not in the folder."""
        return self._inside(frame.depth)

    def _inside(self, name: str | None) -> Path | None:
        """A file of the folder; whatever its name says, never one outside."""
        if name is None:
            return None
        try:
            path = untrusted.inside(self.folder, name)
            return path if untrusted.kind_of(path) == "a file" else None
        except (InputError, OSError):
            return None


class PhotographReader(Protocol):
    """Reads one form of posed photographs; an entry point ``openrooms_usd.photographs``."""

    reads: str
    """What it reads, such as ``a COLMAP model``, for messages."""

    def recognises(self, path: Path) -> bool:
        """Whether a file or folder looks like this form, by the names of its files."""
        ...

    def read(self, path: Path) -> PosedPhotographs:
        """Read a file or folder of this form.

        Raises:
            InputError: It is damaged or lacks something; names the place.
        """
        ...


def read_posed(path: Path, form: str | None = None) -> PosedPhotographs:
    """Read posed photographs of any form that is known.

    Args:
        path: A file or folder.
        form: The name of its reader; by default its contents decide.

    Raises:
        InputError: Nothing is there, no reader knows it, it is damaged, or it has no frames.
    """
    untrusted.check_path(path)
    if not path.exists():
        raise InputError("no such file or folder", place=path, remedy="check the path")
    known = adapters.available(adapters.PHOTOGRAPHS)
    if form is not None and form not in known:
        raise InputError(
            f"no form of posed photographs is named {form!r}{did_you_mean(form, known)}",
            remedy=f"known: {', '.join(known)}",
        )
    readers = {
        name: adapters.load(adapters.PHOTOGRAPHS, name) for name in ([form] if form else known)
    }
    chosen, *others = [form] if form else _recognised(path, readers)
    found: PosedPhotographs = readers[chosen].read(path)
    if not found.frames:
        raise InputError(f"no photograph with a pose is here ({chosen})", place=path)
    notes = list(found.notes)
    named = [frame for frame in found.frames if frame.picture is not None]
    if missing := sum(found.file(frame) is None for frame in named):
        notes.append(f"{missing} of {len(named)} pictures are not in {found.folder.name!r}")
    if others:
        notes.append(f"read as {chosen}: give --form for {' or '.join(others)}, which is here too")
    return replace(found, notes=tuple(notes))


def _recognised(path: Path, readers: Mapping[str, PhotographReader]) -> list[str]:
    """The forms that a path may have, the preferred one first."""
    try:
        fitting = [name for name, reader in readers.items() if reader.recognises(path)]
    except OSError as error:
        raise InputError(f"cannot read it: {error.strerror or error}", place=path) from error
    if not fitting:
        raise InputError(
            "this holds no posed photographs in a form that is known",
            place=path,
            remedy=f"give {'; '.join(reader.reads for reader in readers.values())}",
        )
    return fitting


# Pictures of a lens as a pinhole would take them (OpenCV, "Camera Calibration and 3D
# Reconstruction").


def distorted(points: Array, frame: CapturedFrame) -> Array:
    """(..., 2) where a frame's lens shows points on the plane z = 1 of its camera, (..., 2).

    Raises:
        InputError: The lens has a number of coefficients that OpenCV's model does not have.
    """
    count = len(frame.distortion)
    if count not in _LENSES[frame.fisheye]:
        raise InputError(
            f"a lens has {' or '.join(map(str, _LENSES[frame.fisheye]))} coefficients, not {count}",
            place=f"frame {frame.id}",
        )
    x, y = points[..., 0], points[..., 1]
    r2 = x * x + y * y
    given = np.zeros(8)
    given[:count] = frame.distortion
    if frame.fisheye:
        return points * _fisheye(np.sqrt(r2), given[:4])[..., None]
    k1, k2, p1, p2, k3, k4, k5, k6 = given
    over = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))
    radial = over / (1.0 + r2 * (k4 + r2 * (k5 + r2 * k6)))
    across = x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x)
    down = y * radial + 2.0 * p2 * x * y + p1 * (r2 + 2.0 * y * y)
    return np.stack([across, down], axis=-1)


def _fisheye(r: Array, k: Array) -> Array:
    """By how much a fisheye moves points at radii towards the middle."""
    angle = np.arctan(r)
    square = angle * angle
    bent = angle * (1.0 + square * (k[0] + square * (k[1] + square * (k[2] + square * k[3]))))
    return np.where(r > 1e-9, bent / np.maximum(r, 1e-9), 1.0)


def undistorted(
    pixels: NDArray[Any], frame: CapturedFrame, *, blend: bool = True
) -> tuple[NDArray[Any], CapturedFrame]:
    """A photograph as a pinhole with the same K would have taken it.

    What the photograph does not show (`seen`) is 0. The frame's depth map stays: where it shows the
    bent picture, resample it in the same way.

    Args:
        pixels: (H, W) or (H, W, C) of the frame's resolution.
        frame: Its camera.
        blend: Interpolate between pixels; without, as for depth, the nearest one counts.

    Returns:
        Pixels of the same shape and type, and the frame without distortion.

    Raises:
        InputError: The picture has another size than the frame says.
    """
    if pixels.shape[1::-1] != tuple(frame.resolution):
        raise InputError(
            f"the picture has {pixels.shape[1]} x {pixels.shape[0]} pixels, its camera "
            f"{frame.resolution[0]} x {frame.resolution[1]}",
            place=frame.picture or frame.id,
            remedy="use the pictures that the cameras were found for",
        )
    straight = replace(frame, distortion=(), fisheye=False)
    if not _bends(frame):
        return pixels, straight
    from scipy.ndimage import map_coordinates

    at, valid = _origins(frame)
    # Beyond the middles of the outermost pixels their own values count.
    rows, columns = at[..., 1] - 0.5, at[..., 0] - 0.5
    planes = pixels.reshape(*pixels.shape[:2], -1)
    moved = np.empty(planes.shape)
    for channel in range(planes.shape[2]):
        plane = np.asarray(planes[:, :, channel], dtype=np.float64)
        order: Literal[0, 1] = 1 if blend else 0
        moved[:, :, channel] = map_coordinates(plane, [rows, columns], order=order, mode="nearest")
    if np.issubdtype(pixels.dtype, np.integer):
        moved = np.rint(moved)
    return np.where(valid[..., None], moved, 0).astype(pixels.dtype).reshape(pixels.shape), straight


def seen(frame: CapturedFrame) -> Mask:
    """(H, W) which pixels of the undistorted picture the photograph of a frame shows."""
    width, height = frame.resolution
    return _origins(frame)[1] if _bends(frame) else np.ones((height, width), dtype=np.bool_)


def _bends(frame: CapturedFrame) -> bool:
    return frame.fisheye or any(frame.distortion)


def _origins(frame: CapturedFrame) -> tuple[Array, Mask]:
    """(H, W, 2) where pixels of the undistorted picture are in the photograph; which are there."""
    width, height = frame.resolution
    u, v = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
    pixels = np.stack([u, v, np.ones_like(u)], axis=-1)
    plane = (pixels @ np.linalg.inv(frame.K).T)[..., :2]
    radius = np.linalg.norm(plane, axis=-1)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        bent = distorted(plane, frame)
        at = bent @ frame.K[:2, :2].T + frame.K[:2, 2]
        within = (at >= 0.0).all(axis=-1) & (at[..., 0] <= width) & (at[..., 1] <= height)
    at = np.nan_to_num(at, nan=0.0, posinf=0.0, neginf=0.0)
    return at, within & (radius <= _fold(frame, float(radius.max())))


def _fold(frame: CapturedFrame, largest: float) -> float:
    """The radius up to which what is farther out stays farther out in the photograph."""
    radii = np.linspace(0.0, largest, _RADII)
    # Alone the radial part: the others move both sides of the picture by little.
    lens = frame.distortion
    radial = lens if frame.fisheye or not lens else (*lens[:2], 0.0, 0.0, *lens[4:])
    line = np.stack([radii, np.zeros_like(radii)], axis=-1)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        moved = distorted(line, replace(frame, distortion=radial))[:, 0]
        back = np.flatnonzero(~(np.diff(moved) > 0.0))
    return float(radii[back[0]]) if len(back) else np.inf


# Models without a scale or a vertical, which the user has to give.


def metric(
    photographs: PosedPhotographs, *, scale: float | None = None, up: str | None = None
) -> PosedPhotographs:
    """Photographs in metres with Z up, about the same origin.

    Args:
        photographs: As they were read.
        scale: Metres for one unit of their world; needed where that is not known.
        up: Its vertical: ``x``, ``-y``, ``0,1,0.2``, or ``cameras`` for the direction in which the
            pictures are upright and level; needed where Z is not known to be up.

    Raises:
        InputError: One is needed and missing, or makes no sense.
    """
    if scale is None and not photographs.scale_known:
        raise InputError(
            "these cameras have no scale: their world is not in metres",
            place=photographs.folder,
            remedy="give the metres for one of its units by --scale, or --scale 1 if it is metric",
        )
    if up is None and not photographs.up_known:
        raise InputError(
            "these cameras do not say which way is up",
            place=photographs.folder,
            remedy="give it by --up: z, -y, a direction such as 0,1,0.2, or `cameras` where most "
            "photographs are upright and level",
        )
    notes = list(photographs.notes)
    frames = photographs.frames
    if scale is not None:
        if not _SCALES[0] <= scale <= _SCALES[1]:
            raise InputError(f"{scale:g} metres for one unit make no sense", place="--scale")
        frames = tuple(_scaled(frame, scale) for frame in frames)
        notes.append(f"one unit of the cameras' world is taken for {scale:g} m (--scale)")
    if up is not None:
        direction = _level(frames) if up == _BY_CAMERAS else _direction(up)
        frames = tuple(_turned(frame, _upright(direction)) for frame in frames)
        shown = ",".join(f"{value:.3g}" for value in direction)
        notes.append(f"up in the cameras' world is taken for {shown} (--up)")
    return replace(photographs, frames=frames, scale_known=True, up_known=True, notes=tuple(notes))


def _scaled(frame: CapturedFrame, scale: float) -> CapturedFrame:
    pose = frame.world_from_camera.copy()
    pose[:3, 3] *= scale
    return replace(frame, world_from_camera=pose, depth_unit=frame.depth_unit * scale)


def _turned(frame: CapturedFrame, rotation: Array) -> CapturedFrame:
    return replace(frame, world_from_camera=rotation @ frame.world_from_camera)


def _direction(text: str) -> Array:
    """(3,) unit, of an axis or three numbers."""
    sign, axis = (-1.0, text[1:]) if text[:1] == "-" else (1.0, text.removeprefix("+"))
    if axis.lower() in _AXES:
        return sign * np.array(_AXES[axis.lower()])
    try:
        found = np.array([float(word) for word in text.split(",")])
    except ValueError:
        found = np.zeros(0)
    length = float(np.linalg.norm(found))
    if found.shape != (3,) or not 1e-9 < length < 1e9:
        raise InputError(
            f"{text[:40]!r} is not a direction",
            place="--up",
            remedy=f"give x, y, z, -x, -y, -z, three numbers such as 0,1,0.2, or {_BY_CAMERAS}",
        )
    return np.asarray(found / length)


def _level(frames: Iterable[CapturedFrame]) -> Array:
    """(3,) unit: at right angles to the rows of most pictures, and against their columns."""
    turns = np.stack([frame.world_from_camera[:3, :3] for frame in frames])
    rows, tops = turns[:, :, 0], -turns[:, :, 1]
    mean = tops.mean(axis=0)
    spread = rows.T @ rows / len(turns) - _UPRIGHT_WEIGHT * np.outer(mean, mean)
    direction = np.linalg.eigh(spread)[1][:, 0]
    return np.asarray(direction if direction @ mean >= 0.0 else -direction)


def _upright(direction: Array) -> Array:
    """(4, 4) the smallest turn that takes a direction to Z."""
    from scipy.spatial.transform import Rotation

    axis = np.cross(direction, (0.0, 0.0, 1.0))
    length = float(np.linalg.norm(axis))
    axis = axis / length if length > 1e-12 else np.array([1.0, 0.0, 0.0])
    turn = np.eye(4)
    angle = float(np.arctan2(length, direction[2]))
    turn[:3, :3] = Rotation.from_rotvec(axis * angle).as_matrix()
    return turn
