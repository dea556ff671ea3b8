"""One view as arrays, with the camera and the lights that go with them.

All arrays of pixels end in (height, width, components); labels are int64, everything else float32.
What the numbers mean stands in `openrooms_usd.channels`, and holds after every transform.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.channels import Channel, definition
from openrooms_usd.geometry.pinhole import pixel_directions

Array = NDArray[Any]
Floats = NDArray[np.float64]

_NO_BOXES: Final = np.zeros((0, 4, 4))
_NO_SIZES: Final = np.zeros((0, 3))


@dataclass(frozen=True, eq=False)
class Sample:
    """A view.

    Attributes:
        name: What it is called in its source, such as ``room_0003/main/view_1``.
        size: Width and height, pixels.
        K: (3, 3) intrinsics in pixels; the centre of the top-left pixel is (0.5, 0.5).
        world_from_camera: (4, 4) from the OpenCV camera frame to the world, metres; a rotation and
            a shift.
        images: (height, width, components) by channel.
        lights: (lights, height, width, components) by channel, such as ``radiance_i``.
        grids: (rows, columns, elevations, azimuths, 3) hemispheres by channel; the grid covers the
            picture.
        light_numbers: Of the lights, in the order of their arrays.
        world_from_box: (lights, 4, 4) the frames of their boxes: three axes and a centre, metres.
        box_size: (lights, 3) metres along these axes.
        mirrored: Whether the world is mirrored: its x is the negative of what it was.
        light_scale: What nits and lux have been multiplied by.
        about: What else is known of it: ``room``, ``variant``, ``split``.
    """

    name: str
    size: tuple[int, int]
    K: Floats
    world_from_camera: Floats
    images: Mapping[str, Array] = field(default_factory=dict)
    lights: Mapping[str, Array] = field(default_factory=dict)
    grids: Mapping[str, Array] = field(default_factory=dict)
    light_numbers: tuple[int, ...] = ()
    world_from_box: Floats = field(default_factory=_NO_BOXES.copy)
    box_size: Floats = field(default_factory=_NO_SIZES.copy)
    mirrored: bool = False
    light_scale: float = 1.0
    about: Mapping[str, str] = field(default_factory=dict)

    @property
    def rays(self) -> Floats:
        """(height, width, 3) through the pixels' centres, camera frame, z = 1."""
        return pixel_directions(self.K, *self.size)

    def each(self, change: Callable[[Channel, Array], Array]) -> "Sample":
        """Change the arrays of pixels, those of lights included.

        Args:
            change: Gives new pixels for a channel's; arrays end in height, width, components.
        """

        def changed(found: Mapping[str, Array]) -> dict[str, Array]:
            return {name: change(definition(name), pixels) for name, pixels in found.items()}

        return replace(self, images=changed(self.images), lights=changed(self.lights))

    def each_grid(self, change: Callable[[Array], Array]) -> "Sample":
        """Change the grids of hemispheres."""
        return replace(self, grids={name: change(grid) for name, grid in self.grids.items()})


def is_light(channel: Channel) -> bool:
    """Whether a channel is light, or a share of it: such pixels are means over their areas."""
    return channel.kind == "light" or channel.unit in ("nit", "lux")


def is_label(channel: Channel) -> bool:
    """Whether a channel is the number of a thing."""
    return channel.kind == "label"


def is_scaled(channel: Channel) -> bool:
    """Whether a channel is proportional to all light."""
    return channel.unit in ("nit", "lux")


def has_x(channel: Channel) -> bool:
    """Whether the first component is along an x: the world's, the camera's right, the picture's."""
    return channel.components[0] == "X"


def is_in_picture(channel: Channel) -> bool:
    """Whether the components are pixels to the right and down."""
    return channel.frame == "image"


def is_camera_vector(channel: Channel) -> bool:
    """Whether the components are along the camera's right, up and backward."""
    return channel.frame == "camera, OpenGL axes"
