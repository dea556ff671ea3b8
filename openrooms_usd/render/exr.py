"""OpenEXR files: one part, channels by name, the same bytes for the same pixels."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.channels import CHANNELS, definition
from openrooms_usd.errors import InputError
from openrooms_usd.usd import imagefile

_ROWS: Final = 256  # written at once: a multiple of the 16 rows that zip compression packs together

# Rec.709 primaries and D65, x and y of red, green, blue and white.
_CHROMATICITIES: Final = (0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290)


def exr_channels(name: str) -> list[str]:
    """The names in the EXR file of one of our channels: ``depth`` gives ``["depth.Y"]``."""
    return [f"{name}.{component}" for component in definition(name).components]


def write_channels(path: Path, images: Mapping[str, NDArray[np.float32]]) -> None:
    """Write channels of the table into one part, each in the sample type that the table says.

    Args:
        path: The file.
        images: (height, width, components) by channel name.

    Raises:
        OutputError: The file cannot be written.
    """
    names = [part for channel in images for part in exr_channels(channel)]
    storage = [definition(c).storage for c in images for _ in definition(c).components]
    _write(path, names, storage, list(images.values()))


def write_rgb(path: Path, pixels: NDArray[np.float32]) -> None:
    """Write plain R, G, B in float, for any viewer.

    Args:
        path: The file.
        pixels: (height, width, 3) scene-linear.

    Raises:
        OutputError: The file cannot be written.
    """
    _write(path, ["R", "G", "B"], ["float"] * 3, [pixels])


def _write(
    path: Path, names: list[str], storage: Sequence[str], planes: list[NDArray[np.float32]]
) -> None:
    import OpenImageIO

    height, width = planes[0].shape[:2]
    # Types by constant: given as words, unsigned integers silently become half. And the spec's own
    # type counts where all channels agree: their formats are then ignored.
    kinds = [OpenImageIO.HALF if word == "half" else OpenImageIO.FLOAT for word in storage]
    spec = OpenImageIO.ImageSpec(width, height, len(names), kinds[0])
    spec.channelnames = tuple(names)
    spec.channelformats = tuple(kinds)
    spec.attribute("compression", "zip")
    spec.attribute("DateTime", "")  # otherwise the writer adds the time of day
    spec.attribute("whiteLuminance", 1.0)  # cd/m2 of (1, 1, 1): radiance is in nits
    spec.attribute("chromaticities", OpenImageIO.TypeDesc("float[8]"), _CHROMATICITIES)
    output: Any = OpenImageIO.ImageOutput.create(str(path))
    done = output.open(str(path), spec)
    for top in range(0, height, _ROWS):
        rows = np.concatenate([plane[top : top + _ROWS] for plane in planes], axis=2)
        rows = np.ascontiguousarray(rows)  # numpy keeps the memory order of what it joins
        done = done and output.write_scanlines(top, top + len(rows), 0, rows)
    imagefile.finish(output, done, path)


def read_channels(path: Path) -> dict[str, NDArray[np.float32]]:
    """Read a file of `write_channels` back.

    Args:
        path: The file.

    Returns:
        (height, width, components) by channel name, in the order of the table.

    Raises:
        InputError: The file is missing or is no image.
    """
    import OpenImageIO

    source: Any = OpenImageIO.ImageInput.open(str(path))
    if source is None:
        raise InputError(f"not a readable image: {OpenImageIO.geterror()}", place=path)
    try:
        place = {name: index for index, name in enumerate(source.spec().channelnames)}
        pixels = source.read_image(OpenImageIO.FLOAT)
    finally:
        source.close()
    return {
        name: np.stack([pixels[..., place[part]] for part in exr_channels(name)], axis=-1)
        for name in CHANNELS
        if exr_channels(name)[0] in place
    }
