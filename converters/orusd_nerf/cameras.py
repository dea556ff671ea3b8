"""Pinhole cameras in the words of each tool, and as plain matrices.

All count pixels as we do: the centre of the top-left pixel is (0.5, 0.5). That is so in COLMAP
(https://colmap.github.io/cameras.html), nerfstudio (image coordinates have an offset of 0.5) and
instant-ngp (principal point over resolution).
"""

import io
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np

from openrooms_usd import atomic
from openrooms_usd.arrays import Array
from openrooms_usd.errors import InputError
from openrooms_usd.geometry.quaternions import quaternion
from openrooms_usd.geometry.rotations import inverse, nearest_rotation, pose
from openrooms_usd.rendering.manifest import write_json
from openrooms_usd.rendering.reading import RenderedView

# OpenGL's camera: x right, y up, z backward.
_OPENCV_FROM_OPENGL: Final[Array] = np.diag([1.0, -1.0, -1.0, 1.0])
_CONVENTIONS: Final = {
    "K": "pixels; the centre of the top-left pixel is (0.5, 0.5); no distortion",
    "world_from_camera": "camera x right, y down, z forward (OpenCV); world metres, Z up",
    "camera_from_world": "the inverse",
}


@dataclass(frozen=True, order=True)
class Lens:
    """A pinhole camera without its place; lengths in pixels."""

    width: int
    height: int
    fl_x: float
    fl_y: float
    cx: float
    cy: float


@dataclass(frozen=True, eq=False)
class Camera:
    """A view's camera.

    Attributes:
        name: The view's name.
        lens: What it is.
        world_from_camera: (4, 4) rigid, from the OpenCV camera frame to the world, metres, Z up.
    """

    name: str
    lens: Lens
    world_from_camera: Array

    @property
    def camera_from_world(self) -> Array:
        """(4, 4) to the OpenCV camera frame, as COLMAP has it."""
        return inverse(self.world_from_camera)

    @property
    def transform_matrix(self) -> Array:
        """(4, 4) from the OpenGL camera frame to the world, as ``transforms.json`` has it."""
        return self.world_from_camera @ _OPENCV_FROM_OPENGL

    @property
    def rotation(self) -> Array:
        """(4,) the unit quaternion of `camera_from_world`: w, x, y, z."""
        return np.roll(quaternion(self.camera_from_world[:3, :3]), 1)

    @property
    def K(self) -> Array:  # noqa: N802
        """(3, 3) intrinsics."""
        lens = self.lens
        return np.array([[lens.fl_x, 0, lens.cx], [0, lens.fl_y, lens.cy], [0, 0, 1.0]])

    def project(self, points: Array) -> tuple[Array, Array]:
        """(N, 2) pixels and (N,) planar depths, metres, of (N, 3) points of the world."""
        M = self.camera_from_world
        seen = points @ M[:3, :3].T + M[:3, 3]
        with np.errstate(divide="ignore", invalid="ignore"):
            pixels = seen[:, :2] / seen[:, 2:]
        return pixels * [self.lens.fl_x, self.lens.fl_y] + [self.lens.cx, self.lens.cy], seen[:, 2]


def camera_of(view: RenderedView) -> Camera:
    """The camera of a view.

    Raises:
        InputError: Its pixels are skewed, or its name has blanks: the files have no word for that.
    """
    K, placed = view.K, view.world_from_camera
    if K[0, 1] != 0.0:
        raise InputError(
            "its camera has skewed pixels, which these files cannot express",
            place=view.folder,
            remedy="render with a camera of upright pixels",
        )
    if view.name.split() != [view.name]:
        raise InputError(
            f"the view's name {view.name!r} has spaces, which COLMAP does not support in names",
            place=view.folder,
            remedy="rename the camera, and render again",
        )
    lens = Lens(view.width, view.height, *map(float, (K[0, 0], K[1, 1], K[0, 2], K[1, 2])))
    # A manifest may be off by rounding, and a quaternion would not be.
    rigid = pose(nearest_rotation(placed[:3, :3]), placed[:3, 3])
    return Camera(view.name, lens, rigid)


def write_matrices(folder: Path, cameras: Sequence[Camera]) -> None:
    """Write ``cameras.json`` and ``cameras.npz``: K and 4x4 matrices of every view.

    Raises:
        OutputError: A file cannot be written.
    """
    rows: dict[str, Any] = {
        camera.name: {
            "width": camera.lens.width,
            "height": camera.lens.height,
            "K": camera.K.tolist(),
            "world_from_camera": camera.world_from_camera.tolist(),
            "camera_from_world": camera.camera_from_world.tolist(),
        }
        for camera in cameras
    }
    write_json(folder / "cameras.json", {"conventions": _CONVENTIONS, "cameras": rows})
    data = io.BytesIO()
    np.savez(
        data,
        name=np.array([camera.name for camera in cameras]),
        size=np.array([(camera.lens.width, camera.lens.height) for camera in cameras]),
        K=np.stack([camera.K for camera in cameras]),
        world_from_camera=np.stack([camera.world_from_camera for camera in cameras]),
        camera_from_world=np.stack([camera.camera_from_world for camera in cameras]),
    )
    atomic.write_bytes(folder / "cameras.npz", data.getvalue())
