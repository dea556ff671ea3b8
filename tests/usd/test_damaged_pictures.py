"""Pictures that claim what they do not hold, and headers that are no text, are refused by name."""

import struct
import zlib
from pathlib import Path

import numpy as np
import pytest

from openrooms_usd.errors import InputError
from openrooms_usd.usd.textures import picture_facts, read_codes, read_texture
from orusd_scans.formats.depthpicture import picture_size


def png(path: Path, width: int, height: int) -> Path:
    """A header of this size, with sums that agree, over the pixels of one row."""

    def chunk(kind: bytes, data: bytes) -> bytes:
        body = kind + data
        return struct.pack(">I", len(data)) + body + struct.pack(">I", zlib.crc32(body))

    head = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    data = zlib.compress(bytes(1 + 3 * 16))
    path.write_bytes(
        b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", data) + chunk(b"IEND", b"")
    )
    return path


@pytest.mark.parametrize("size", [(12_000, 12_000), (1 << 20, 60), (60_000, 60_000)])
def test_pixels_that_the_bytes_cannot_hold_take_no_memory(
    tmp_path: Path, size: tuple[int, int]
) -> None:
    path = png(tmp_path / "a.png", *size)
    with pytest.raises(InputError, match=r"are not read|not a readable picture"):
        read_texture(str(path))
    assert read_codes(str(path)) is None


@pytest.mark.slow
def test_a_large_picture_of_one_colour_is_read(tmp_path: Path) -> None:
    import OpenImageIO

    path = tmp_path / "a.png"
    image = OpenImageIO.ImageBuf(OpenImageIO.ImageSpec(4096, 4096, 3, "uint8"))
    image.write(str(path))
    assert path.stat().st_size * 500 < 4096 * 4096 * 3
    assert read_texture(str(path)).shape == (4096, 4096, 3)


@pytest.mark.parametrize("ending", ["exr", "hdr", "png", "tif"])
def test_no_byte_of_a_header_gives_more_than_a_refusal(tmp_path: Path, ending: str) -> None:
    import OpenImageIO

    sound = tmp_path / f"sound.{ending}"
    image = OpenImageIO.ImageBuf(OpenImageIO.ImageSpec(8, 4, 3, "float"))
    image.write(str(sound))
    data = sound.read_bytes()
    path = tmp_path / f"spoilt.{ending}"
    rng = np.random.default_rng(3)
    for _ in range(300):
        spoilt = bytearray(data)
        for at in rng.integers(0, min(len(data), 400), 3):
            spoilt[at] = rng.integers(128, 256)
        path.write_bytes(bytes(spoilt))
        for read in (picture_facts, read_texture, lambda file: picture_size(Path(file))):
            try:
                read(str(path))
            except InputError as error:
                assert str(path) in str(error)
