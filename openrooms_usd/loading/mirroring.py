"""Mirrored and turned pictures.

A mirrored picture is the picture of a mirrored room. Which mirror is a matter of choice, and here
it is the world's plane x = 0: positions, normals and boxes of lights change the sign of their x
alone, so that nothing is rounded and up stays up, and all mirrored views of a room are in the same
mirrored room. With S = diag(-1, 1, 1, 1) the pose becomes S world_from_camera S, which is a
rotation again, and the principal point goes to the other side.

Hemispheres are given in the frame (n x y, y, n), y the camera's up made orthogonal to the normal
n. Its first axis is a cross product and turns against the mirror: azimuth phi becomes pi - phi.
"""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from openrooms_usd.channels import Channel
from openrooms_usd.errors import InputError
from openrooms_usd.loading.sample import Array, Sample, has_x, is_camera_vector, is_in_picture

_MIRROR: Final = np.diag([-1.0, 1.0, 1.0, 1.0])
_X: Final = np.array([-1.0, 1.0, 1.0], np.float32)
# The camera's axes after a quarter turn of the picture to the left, in those before it: OpenCV.
_TURN: Final = np.array(
    [[0.0, -1.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]]
)


@dataclass(frozen=True)
class HorizontalFlip:
    """Left and right exchanged; twice, it gives the same bits again.

    Attributes:
        probability: How often; 1 always.
    """

    probability: float = 0.5

    def __call__(self, sample: Sample, rng: np.random.Generator, /) -> Sample:
        """The mirrored sample, or the same."""
        # Drawn in any case, so that what comes after draws the same.
        return flipped(sample) if rng.random() < self.probability else sample


def flipped(sample: Sample) -> Sample:
    """The sample with left and right exchanged."""

    def change(channel: Channel, pixels: Array) -> Array:
        mirrored = pixels[..., ::-1, :]
        return mirrored * _X[: mirrored.shape[-1]] if has_x(channel) else mirrored

    K = sample.K.copy()
    K[0, 2] = sample.size[0] - K[0, 2]
    return replace(
        sample.each(change).each_grid(_flipped_grid),
        K=K,
        world_from_camera=_MIRROR @ sample.world_from_camera @ _MIRROR,
        # With its own x mirrored too, the frame of a box stays as right-handed as it was.
        world_from_box=_MIRROR @ sample.world_from_box @ _MIRROR,
        mirrored=not sample.mirrored,
    )


def _flipped_grid(grid: Array) -> Array:
    azimuths = grid.shape[3]
    return grid[:, ::-1, :, (azimuths // 2 - 1 - np.arange(azimuths)) % azimuths]


@dataclass(frozen=True)
class QuarterTurn:
    """The picture turned to the left; the camera rolls, the world stays.

    Attributes:
        times: How many quarters.
    """

    times: int = 1

    def __call__(self, sample: Sample, rng: np.random.Generator, /) -> Sample:
        """The turned sample.

        Raises:
            InputError: It has hemispheres: their frame hangs on the camera's up.
        """
        if self.times % 4 and sample.grids:
            raise InputError(
                f"{' and '.join(sample.grids)} cannot be turned: the frame of hemispheres hangs "
                "on the camera's up",
                place=sample.name,
                remedy="leave these channels out, or the turn",
            )
        for _ in range(self.times % 4):
            sample = _turned(sample)
        return sample


def _turned(sample: Sample) -> Sample:
    def change(channel: Channel, pixels: Array) -> Array:
        turned = np.rot90(pixels, axes=(-3, -2))
        if is_camera_vector(channel):
            right, up, backward = np.moveaxis(turned, -1, 0)
            return np.stack([-up, right, backward], axis=-1)
        if is_in_picture(channel):
            across, down = np.moveaxis(turned, -1, 0)
            return np.stack([down, -across], axis=-1)
        return turned

    width, height = sample.size
    K = sample.K
    turned = [[K[1, 1], 0.0, K[1, 2]], [0.0, K[0, 0], width - K[0, 2]], [0.0, 0.0, 1.0]]
    return replace(
        sample.each(change),
        size=(height, width),
        K=np.array(turned),
        world_from_camera=sample.world_from_camera @ _TURN,
    )
