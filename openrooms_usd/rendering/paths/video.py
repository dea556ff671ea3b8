"""Videos: VP9 in WebM, by FFmpeg as the package PyAV brings it.

VP9 is free to use, and read by every browser. PyAV is under the BSD licence; its wheels carry
FFmpeg (LGPL 3) beside encoders under the GPL, of which none is used and nothing is shipped here.
One thread encodes, and nothing of time or version is written: equal frames give equal bytes.
"""

import importlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType
from typing import Any, Final

import numpy as np

from openrooms_usd.arrays import Bytes
from openrooms_usd.errors import InputError, MissingPackageError, OutputError

SUFFIX: Final = ".webm"
CODEC: Final = "libvpx-vp9"
# Constant quality, 0 to 63, good and not too slow.
_OPTIONS: Final = {
    "crf": "24",
    "b": "0",
    "deadline": "good",
    "cpu-used": "3",
    "row-mt": "0",
    "threads": "1",
    "flags": "+bitexact",
}
_BITEXACT: Final = {"fflags": "+bitexact"}

# BT.709, 8 bits of video range: luma 16 to 235, chroma 16 to 240.
_LUMA: Final = np.array([0.2126, 0.7152, 0.0722])
_BLUE_RANGE, _RED_RANGE = 1.8556, 1.5748


def check(size: tuple[int, int]) -> None:
    """See whether videos of a size can be written, before anything slow begins.

    Args:
        size: Width and height.

    Raises:
        InputError: Colour is stored for 2x2 pixels, and a side is odd.
        MissingPackageError: PyAV is not installed.
    """
    if size[0] % 2 or size[1] % 2:
        raise InputError(
            f"a video of {size[0]}x{size[1]} pixels cannot be encoded",
            place="resolution",
            remedy="give an even width and height",
        )
    _package()


@contextmanager
def writing(
    path: Path, size: tuple[int, int], rate: int, *, whole: int | None = None
) -> Iterator["Encoder"]:
    """Encode frames into a file, which is complete when the block ends.

    Args:
        path: The file.
        size: Width and height.
        rate: Frames a second.
        whole: Every so manieth frame stands for itself; by default one a second, to which players
            can jump.

    Raises:
        OutputError: It cannot be written.
    """
    package = _package()
    try:
        with package.open(
            str(path), "w", format=SUFFIX[1:], container_options=_BITEXACT
        ) as container:
            stream = container.add_stream(CODEC, rate=rate, options=dict(_OPTIONS))
            stream.width, stream.height, stream.pix_fmt = *size, "yuv420p"
            stream.codec_context.gop_size = whole or rate
            # What the numbers mean: BT.709 throughout, video range.
            context = stream.codec_context
            context.colorspace = context.color_primaries = context.color_trc = 1
            context.color_range = 1
            yield Encoder(package, container, stream)
            for packet in stream.encode():
                container.mux(packet)
    except package.FFmpegError as error:
        raise OutputError(f"the video cannot be written: {error}", place=path) from error


class Encoder:
    """Takes the frames of a video one by one."""

    def __init__(self, package: ModuleType, container: Any, stream: Any) -> None:
        self._package, self._container, self._stream = package, container, stream

    def add(self, pixels: Bytes) -> None:
        """Encode a frame.

        Args:
            pixels: (height, width, 3) sRGB.
        """
        frame = self._package.VideoFrame.from_ndarray(yuv420(pixels), format="yuv420p")
        for packet in self._stream.encode(frame):
            self._container.mux(packet)


def yuv420(pixels: Bytes) -> Bytes:
    """(3 height / 2, width) planes of luma, then blue and red differences of 2x2 pixels each.

    Args:
        pixels: (height, width, 3) non-linear RGB, even sides.
    """
    height, width = pixels.shape[:2]
    rgb = pixels.astype(np.float64) / 255.0
    luma = rgb @ _LUMA
    blue, red = (rgb[..., 2] - luma) / _BLUE_RANGE, (rgb[..., 0] - luma) / _RED_RANGE
    planes = [16.0 + 219.0 * luma]
    for plane in (blue, red):
        coarse = plane.reshape(height // 2, 2, width // 2, 2).mean(axis=(1, 3))
        planes.append((128.0 + 224.0 * coarse).reshape(-1, width))
    return np.asarray(np.rint(np.concatenate(planes)), dtype=np.uint8)


def _package() -> ModuleType:
    try:
        return importlib.import_module("av")
    except (ImportError, OSError) as error:
        raise MissingPackageError(
            f"videos need the package 'av', which cannot be imported ({error})",
            remedy="pip install openrooms-usd[video]",
        ) from error
