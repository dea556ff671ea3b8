"""Any camera, by its intrinsics and its pose."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, Self

from openrooms_usd.description.rendering import RenderSettings
from openrooms_usd.errors import InputError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike, NDArray

    from openrooms_usd.usd.cameras import PinholeCamera

# How far a rotation may be from orthonormal: rounding in text.
_ROUNDING: Final = 1e-3


@dataclass(frozen=True, eq=False)
class Camera:
    """A pinhole camera.

    Attributes:
        K: (3, 3) intrinsics in pixels, as OpenCV has them; the centre of the top-left pixel is
            (0.5, 0.5), as in the manifest of a render.
        world_from_camera: (4, 4) rigid, from the camera (x right, y down, z forward: OpenCV) to the
            world (Z up), metres.
        resolution: Width and height, pixels.
        exposure: What pictures for people multiply radiance in nits by; None fits it.
        name: Sets its random numbers apart from those of other cameras.
    """

    K: "ArrayLike"
    world_from_camera: "ArrayLike"
    resolution: tuple[int, int]
    exposure: float | None = None
    name: str = "camera"

    def __post_init__(self) -> None:
        """See that it is a camera.

        Raises:
            InputError: A matrix has another shape, or is not intrinsics or a rigid motion.
        """
        import numpy as np

        K = matrix_of(self.K, (3, 3), "K")
        pose = rigid_of(self.world_from_camera, "world_from_camera")
        rest = K - np.diag(np.diag(K))
        rest[:2, 2] = 0.0
        if not (K[0, 0] > 0.0 and K[1, 1] > 0.0 and K[2, 2] == 1.0 and not rest.any()):
            raise InputError(
                "these are not the intrinsics of a pinhole",
                place="K",
                remedy="give [[fx, 0, cx], [0, fy, cy], [0, 0, 1]] in pixels, fx and fy positive",
            )
        size = RenderSettings(resolution=self.resolution).resolution
        if size is None:
            raise InputError("a camera has a size", place="resolution", remedy="such as (640, 480)")
        if self.exposure is not None and not self.exposure > 0.0:
            raise InputError(
                f"{self.exposure} is not an exposure",
                place="exposure",
                remedy="give a positive number, or None to fit it",
            )
        object.__setattr__(self, "resolution", size)
        object.__setattr__(self, "K", K)
        object.__setattr__(self, "world_from_camera", pose)

    @classmethod
    def from_opengl(
        cls,
        K: "ArrayLike",
        world_from_camera: "ArrayLike",
        resolution: tuple[int, int],
        **more: Any,
    ) -> Self:
        """A camera whose pose is OpenGL's, as Blender and NeRF have it: x right, y up, z backward.

        Args:
            K: (3, 3) intrinsics in pixels.
            world_from_camera: (4, 4) from the OpenGL camera to the world (Z up), metres.
            resolution: Width and height, pixels.
            **more: The other attributes.
        """
        import numpy as np

        pose = matrix_of(world_from_camera, (4, 4), "world_from_camera")
        return cls(K, pose @ np.diag([1.0, -1.0, -1.0, 1.0]), resolution, **more)

    @classmethod
    def look_at(
        cls,
        eye: "ArrayLike",
        target: "ArrayLike",
        *,
        fov_degrees: float = 60.0,
        resolution: tuple[int, int] = (640, 480),
        **more: Any,
    ) -> Self:
        """An upright camera that looks at a point.

        Args:
            eye: (3,) where it is, world, metres.
            target: (3,) what it looks at.
            fov_degrees: Horizontal field of view.
            resolution: Width and height, pixels.
            **more: The other attributes.

        Raises:
            InputError: The two points coincide, or a number is outside its limits.
        """
        from openrooms_usd.geometry import pinhole

        limits = RenderSettings(field_of_view=fov_degrees, resolution=resolution)
        ends = [matrix_of(point, (3,), name) for point, name in ((eye, "eye"), (target, "target"))]
        K = pinhole.intrinsics(fov_degrees, *(limits.resolution or resolution))
        return cls(K, pinhole.look_at(*ends), resolution, **more)

    def pinhole(self) -> "PinholeCamera":
        """This camera as the core's own type."""
        import numpy as np

        from openrooms_usd.usd.cameras import PinholeCamera

        K, pose = (np.asarray(matrix) for matrix in (self.K, self.world_from_camera))
        return PinholeCamera(K, pose, self.exposure)


def rigid_of(given: "ArrayLike", what: str) -> "NDArray[np.float64]":
    """(4, 4) a rotation and a translation.

    Args:
        given: What stands for it.
        what: What it is, for the message.

    Raises:
        InputError: It is something else.
    """
    import numpy as np

    pose = matrix_of(given, (4, 4), what)
    R = pose[:3, :3]
    is_rigid = np.allclose(R.T @ R, np.eye(3), atol=_ROUNDING) and np.linalg.det(R) > 0.0
    if not (is_rigid and np.allclose(pose[3], (0.0, 0.0, 0.0, 1.0))):
        raise InputError(
            "this is not a rotation and a translation",
            place=what,
            remedy="give a 4x4 matrix with an orthonormal right-handed rotation, in metres",
        )
    return pose


def matrix_of(given: "ArrayLike", shape: tuple[int, ...], what: str) -> "NDArray[np.float64]":
    """Numbers as an array.

    Args:
        given: What stands for it.
        shape: How many there are along each axis.
        what: What it is, for the message.

    Raises:
        InputError: It has another shape, or holds what is not a finite number.
    """
    import numpy as np

    try:
        found = np.array(given, dtype=np.float64)
    except (TypeError, ValueError):
        found = np.zeros(0)
    if found.shape != shape or not np.isfinite(found).all():
        numbers = "x".join(map(str, shape))
        raise InputError(
            f"these are not {numbers} finite numbers", place=what, remedy="give an array"
        )
    return found
