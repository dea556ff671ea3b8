"""The layers in a USDZ of unknown origin: read one by one in memory, within limits."""

import lzma
import tempfile
import zipfile
import zlib
from collections.abc import Iterator
from pathlib import Path, PurePosixPath
from typing import Final

from pxr import Sdf, Tf

from openrooms_usd.errors import InputError
from openrooms_usd.usd.diagnostics import quiet, reason
from orusd_scans.jsonfile import LARGEST

# What zipfile raises for archives that are cut off or changed.
_DAMAGE: Final = (
    zipfile.BadZipFile, zlib.error, lzma.LZMAError, EOFError, NotImplementedError, ValueError
)  # fmt: skip
_ENCRYPTED: Final = 0x1
_LAYERS: Final = (".usda", ".usdc", ".usd")
_MOST: Final = 100_000
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
    try:
        with zipfile.ZipFile(path) as archive:
            for info in _checked(path, archive):
                yield info.filename, _layer(path, info.filename, archive.read(info))
    except OSError as error:
        text = f"cannot read it: {error.strerror or error}"
        raise InputError(text, place=path, remedy="check the path") from error
    except _DAMAGE as error:
        text = f"this is no whole USDZ: {error}"
        raise InputError(text, place=path, remedy=_AGAIN) from error


def _checked(path: Path, archive: zipfile.ZipFile) -> list[zipfile.ZipInfo]:
    """The layers in an archive that may be unpacked."""
    entries = archive.infolist()
    found = [info for info in entries if PurePosixPath(info.filename).suffix.lower() in _LAYERS]
    size = sum(info.file_size for info in found)
    if len(entries) > _MOST or size > LARGEST:
        text = f"{len(entries)} files of {size / 2**20:.0f} MB are too much for a capture"
        most = f"at most {_MOST} files and {LARGEST >> 20} MB of layers"
        raise InputError(f"{text} ({most})", place=path, remedy=_AGAIN)
    for info in entries:
        name = info.filename.replace("\\", "/")
        if name.startswith("/") or ".." in name.split("/") or ":" in name.split("/")[0]:
            text = f"the archive's file {info.filename!r} would leave its folder"
            raise InputError(text, place=path, remedy=_AGAIN)
        if info.flag_bits & _ENCRYPTED:
            text = f"the archive's file {info.filename!r} is encrypted"
            raise InputError(text, place=path, remedy="give the file as RoomPlan exported it")
    if not found:
        raise InputError("the archive has no USD layers", place=path, remedy=_AGAIN)
    return found


def _layer(path: Path, name: str, data: bytes) -> Sdf.Layer:
    try:
        with quiet():
            return _text(data) if data.startswith(b"#usda") else _binary(data)
    except Tf.ErrorException as error:
        text = f"not readable as USD: {reason(error)}"
        raise InputError(text, place=f"{path}[{name}]", remedy=_AGAIN) from error
    except UnicodeDecodeError as error:
        text = f"not readable as USD: byte {error.start} is not UTF-8 text"
        raise InputError(text, place=f"{path}[{name}]", remedy=_AGAIN) from error


def _text(data: bytes) -> Sdf.Layer:
    layer = Sdf.Layer.CreateAnonymous(".usda")
    layer.ImportFromString(data.decode("utf-8"))
    return layer


def _binary(data: bytes) -> Sdf.Layer:
    """A crate, which USD reads from files only."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "layer.usdc"
        file.write_bytes(data)
        layer = Sdf.Layer.CreateAnonymous(".usdc")
        layer.Import(str(file))
        return layer
