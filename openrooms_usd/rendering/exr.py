"""OpenEXR files: one part, channels by name, the same bytes for the same pixels."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, Protocol

import numpy as np

from openrooms_usd import imagefile
from openrooms_usd.arrays import Floats
from openrooms_usd.channels import definition
from openrooms_usd.errors import InputError
from openrooms_usd.untrusted import checked

Pixels = Floats

# Written at once: a multiple of the 16 rows that zip compression packs together, and few where
# there are many channels.
_ROWS_PACKED: Final = 16
_MOST_BYTES_PER_WRITE: Final = 1 << 26

# What is read at most, and how many numbers a byte can hold: of halves, deflated as far as it goes.
_MOST_NUMBERS: Final = 2**31
_MOST_RATIO: Final = 520
# Of DWA, which keeps two halves of 64 numbers where all are alike.
_MOST_DWA_RATIO: Final = 32 * _MOST_RATIO
_AGAIN: Final = "render again"

# The largest power of two in halves: what is rounded never becomes infinite.
_MOST_ROUNDED: Final = np.float32(32768.0)
_DIGITS_OF_FLOATS: Final = 23

# Rec.709 primaries and D65, x and y of red, green, blue and white.
_CHROMATICITIES: Final = (0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290)


class Rows(Protocol):
    """A picture whose rows are asked for as they are written: (height, width, components)."""

    @property
    def shape(self) -> tuple[int, ...]:
        """Of all of it."""
        ...

    def __getitem__(self, which: slice, /) -> Pixels:
        """Some rows."""
        ...


def exr_channels(name: str) -> list[str]:
    """The names in the EXR file of one of our channels: ``depth`` gives ``["depth.Y"]``."""
    return [f"{name}.{component}" for component in definition(name).components]


def write_channels(
    path: Path, images: Mapping[str, Rows], samples: Mapping[str, str] | None = None
) -> None:
    """Write channels of the table into one part.

    Args:
        path: The file.
        images: (height, width, components) by channel name.
        samples: ``half`` or ``float`` by channel name; by default what the table says.

    Raises:
        OutputError: The file cannot be written.
    """
    names = [part for channel in images for part in exr_channels(channel)]
    kinds = samples or {name: definition(name).storage for name in images}
    storage = [kinds[name] for name in images for _ in definition(name).components]
    _write(path, names, storage, list(images.values()))


def write_rgb(path: Path, pixels: Rows, sample: str = "float") -> None:
    """Write plain R, G, B, for any viewer.

    Args:
        path: The file.
        pixels: (height, width, 3) scene-linear.
        sample: ``half`` or ``float``.

    Raises:
        OutputError: The file cannot be written.
    """
    _write(path, ["R", "G", "B"], [sample] * 3, [pixels])


@dataclass(frozen=True, eq=False)
class Rounded:
    """A picture in few binary digits, rounded row by row as it is written.

    Attributes:
        pixels: (height, width, components).
        scale: A power of two that numbers are multiplied by; 32,768 is the most that they become.
        digits: Binary digits behind the first one, at most 10.
    """

    pixels: Pixels
    scale: float
    digits: int

    @property
    def shape(self) -> tuple[int, ...]:
        """Height, width, components."""
        return self.pixels.shape

    def __getitem__(self, which: slice) -> Pixels:
        # Numbers that are infinite, or none, have no place in a lossy file.
        rows = np.nan_to_num(self.pixels[which] * np.float32(self.scale))
        rows = np.clip(rows, -_MOST_ROUNDED, _MOST_ROUNDED)
        # Half of the last digit that is kept is added, and what lies below it cut off: this is
        # rounding, of either sign, and what is carried over makes the exponent one larger.
        dropped = np.uint32(_DIGITS_OF_FLOATS - self.digits)
        numbers = (rows.view(np.uint32) + (np.uint32(1) << (dropped - 1))) >> dropped << dropped
        return np.asarray(numbers.view(np.float32))


def _write(path: Path, names: list[str], storage: Sequence[str], planes: list[Rows]) -> None:
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
    packs = _MOST_BYTES_PER_WRITE // (4 * len(names) * width * _ROWS_PACKED)
    step = _ROWS_PACKED * max(1, packs)
    for top in range(0, height, step):
        rows = np.concatenate([plane[top : top + step] for plane in planes], axis=2)
        rows = np.ascontiguousarray(rows)  # numpy keeps the memory order of what it joins
        done = done and output.write_scanlines(top, top + len(rows), 0, rows)
    imagefile.finish(output, done, path)


def read_channels(path: Path, size: tuple[int, int] | None = None) -> dict[str, Pixels]:
    """The layers of a picture, whatever their names.

    Args:
        path: An EXR file with channels ``<layer>.<part>``.
        size: Width and height that it must have, if they are known.

    Returns:
        (height, width, parts) by layer, in the file's order; parts as X Y Z, as R G B, or alone.

    Raises:
        InputError: It is missing, no such picture, damaged, of another size, or a layer that is
            one of our channels lacks a part.
    """
    names, picture = _read(path, size)
    layers: dict[str, dict[str, int]] = {}
    for place, name in enumerate(names):
        layer, _, part = name.rpartition(".")
        layers.setdefault(layer, {})[part] = place
    for layer, places in layers.items():
        _check_parts(path, layer, places)
    return {
        layer: picture[..., [places[part] for part in sorted(places, key=_rank)]]
        for layer, places in layers.items()
    }


def read_picture(path: Path) -> Pixels:
    """A picture without layers: (height, width, 3), red first.

    Raises:
        InputError: It is missing, no such picture, or damaged.
    """
    found = read_channels(path).get("")
    if found is None or found.shape[-1] != 3:
        raise InputError("it has not just the channels R, G, B", place=path, remedy=_AGAIN)
    return found


def _rank(part: str) -> int:
    return "RGBXYZ".find(part)


def _check_parts(path: Path, layer: str, parts: Iterable[str]) -> None:
    try:
        wanted = definition(layer).components
    except KeyError:  # another tool's
        return
    if {*parts} != {*wanted}:
        raise InputError(
            f"the channel {layer!r} has the parts {', '.join(sorted(parts))}, not "
            f"{', '.join(wanted)}",
            place=path,
            remedy=_AGAIN,
        )


def _read(path: Path, size: tuple[int, int] | None) -> tuple[list[str], Pixels]:
    import OpenImageIO

    bytes_there = checked(path, "picture", remedy=_AGAIN)
    try:
        source: Any = OpenImageIO.ImageInput.open(str(path))
        if source is None:
            raise InputError(_reason(OpenImageIO.geterror()), place=path, remedy=_AGAIN)
        try:
            _check_header(path, source, size, bytes_there)
            names = list(source.spec().channelnames)
            pixels = source.read_image(OpenImageIO.FLOAT)
            if pixels is None:
                raise InputError(_reason(source.geterror()), place=path, remedy=_AGAIN)
        finally:
            source.close()
    # Its names and its own messages quote the file, in whatever bytes.
    except UnicodeDecodeError as error:
        raise InputError(_reason("its header is not text"), place=path, remedy=_AGAIN) from error
    return names, np.asarray(pixels, np.float32)


def _check_header(path: Path, source: Any, size: tuple[int, int] | None, bytes_there: int) -> None:
    spec = source.spec()
    if source.format_name() != "openexr" or spec.deep or spec.depth != 1:
        raise InputError("this is not a flat OpenEXR picture", place=path, remedy=_AGAIN)
    if size and (spec.width, spec.height) != size:
        raise InputError(
            f"the picture has {spec.width}x{spec.height} pixels, the manifest says "
            f"{size[0]}x{size[1]}",
            place=path,
            remedy=_AGAIN,
        )
    numbers = spec.width * spec.height * spec.nchannels
    lossy = str(spec.getattribute("compression")).startswith("dwa")
    ratio = _MOST_DWA_RATIO if lossy else _MOST_RATIO
    if not 0 < numbers <= min(_MOST_NUMBERS, ratio * bytes_there):
        raise InputError(
            f"it claims {spec.width}x{spec.height} pixels of {spec.nchannels} numbers in "
            f"{bytes_there:,} bytes",
            place=path,
            remedy=_AGAIN,
        )


def _reason(text: str) -> str:
    first = next(iter(text.strip().splitlines()), "unknown reason")
    return f"not a readable image: {first}"
