"""The layers in a USDZ of unknown origin: read one by one in memory, within limits."""

import io
import tempfile
import zipfile
from collections.abc import Iterator
from pathlib import Path, PurePosixPath
from typing import Final

from pxr import Sdf, Tf

from openrooms_usd.errors import InputError
from openrooms_usd.unpickling.archives import opened_archive
from openrooms_usd.usd.crate_reader import check_crate, check_crate_reads
from openrooms_usd.usd.diagnostics import quiet, reason
from openrooms_usd.usd.preflight import check_text

_LAYERS: Final = (".usda", ".usdc", ".usd")
# Of all layers together; a capture of a large flat is below 2 MB.
_MOST_BYTES: Final = 64 << 20
_AGAIN: Final = "export the capture again"


def layers(path: Path) -> Iterator[tuple[str, Sdf.Layer]]:
    """The layers of a USDZ in its order; nothing that they refer to is opened.

    Args:
        path: The file.

    Yields:
        The layer's path in the archive and the layer.

    Raises:
        InputError: The file is missing, is damaged, encrypted or too large, or has no layers.
    """
    with opened_archive(path, "archive", remedy=_AGAIN) as archive:
        for info in _checked(path, archive):
            yield info.filename, _layer(path, info.filename, archive.read(info))


def _checked(path: Path, archive: zipfile.ZipFile) -> list[zipfile.ZipInfo]:
    """The layers in an archive that may be unpacked."""
    found = [
        info
        for info in archive.infolist()
        if PurePosixPath(info.filename).suffix.lower() in _LAYERS
    ]
    size = sum(info.file_size for info in found)
    if size > _MOST_BYTES:
        text = f"{size / 2**20:.0f} MB of layers are too much for a capture"
        raise InputError(f"{text} (at most {_MOST_BYTES >> 20} MB)", place=path, remedy=_AGAIN)
    if not found:
        raise InputError("the archive has no USD layers", place=path, remedy=_AGAIN)
    return found


def _layer(path: Path, name: str, data: bytes) -> Sdf.Layer:
    place = f"{path}[{name}]"
    try:
        with quiet():
            return _text(data, place) if data.startswith(b"#") else _binary(data, place)
    except Tf.ErrorException as error:
        text = f"not readable as USD: {reason(error)}"
        raise InputError(text, place=place, remedy=_AGAIN) from error


def _text(data: bytes, place: str) -> Sdf.Layer:
    check_text(data, place)
    layer = Sdf.Layer.CreateAnonymous(".usda")
    layer.ImportFromString(data.decode())
    return layer


def _binary(data: bytes, place: str) -> Sdf.Layer:
    """A crate, which USD reads from files only."""
    check_crate(io.BytesIO(data), len(data), place)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "layer.usdc"
        file.write_bytes(data)
        check_crate_reads(str(file), len(data), place)
        layer = Sdf.Layer.CreateAnonymous(".usdc")
        layer.Import(str(file))
        return layer
