"""The light cache of a room as a file beside it, for any number of processes at any time.

A file is named by all that determines what it holds: the scene's surfaces, textures and lights, how
it is filled, and the code that fills it (`content_key`). So an existing file is valid, whichever
process wrote it. A process that finds none computes the light and writes the same bytes. Files
appear whole, and no process waits for another.

Its bytes are a line that says what it is, the SHA-256 of all that follows, a line of JSON with the
key and the arrays' names, types and shapes, and then the arrays, one after the other.
"""

import hashlib
import json
import logging
import math
import os
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd import atomic, removal, unfinished, untrusted
from openrooms_usd.codedigest import code_digest, library_versions
from openrooms_usd.errors import InputError, OrusdError
from openrooms_usd.rendering.scene.arrays import Scene
from openrooms_usd.rendering.scene.digest import light_digest
from openrooms_usd.usercache import cache_folder

Arrays = Mapping[str, NDArray[Any]]

FOLDER: Final = ".orusd.light"
"""The folder of the files, beside the stage."""

_LOG: Final = logging.getLogger(__name__)
_IN_CACHE: Final = "light"
_SUFFIX: Final = ".light"
_MAGIC: Final = b"orusd light cache 1\n"
_SUM_BYTES: Final = hashlib.sha256().digest_size * 2 + 1
_LONGEST_HEADER_BYTES: Final = 1 << 16
_MOST_DIMENSIONS: Final = 8
_TYPES: Final = ("<f4", "<f8", "<i4", "<i8", "<u4", "<u8", "|i1", "|u1", "|b1")
# How many files stay, those that were used last: of a room whose lights are being tried out, and
# of all rooms that cannot be written to.
_MOST_BESIDE: Final = 4
_MOST_IN_CACHE: Final = 32


def content_key(scene: Scene, makers: Sequence[str], *settings: Any) -> str:
    """The name of what is computed of a scene: different where that may differ.

    Args:
        scene: The translated stage.
        makers: Modules that compute; what they import counts, too, and libraries by version.
        settings: What else determines it, as plain data: bounces, the backend, sizes.

    Returns:
        64 hexadecimal digits.
    """
    return light_digest(scene, code_digest(*makers), library_versions(*makers), settings)


def places(scene: Scene) -> tuple[Path, ...]:
    """The folders where a scene's files may lie, the best first: beside it, in the user's cache.

    None where ``$ORUSD_CACHE`` switches caches off.
    """
    kept = cache_folder(_IN_CACHE)
    if kept is None:
        return ()
    beside = (scene.folder / FOLDER,) if scene.folder else ()
    return (*beside, kept)


def load(key: str, folders: Sequence[Path]) -> dict[str, NDArray[Any]] | None:
    """The arrays that were kept under a key; None where there are none, or damaged ones.

    They are whole, of a plain type and finite; what they mean is for the caller to check.

    Args:
        key: From `content_key`.
        folders: From `places`.
    """
    for folder in folders:
        path = folder / f"{key}{_SUFFIX}"
        try:
            data = untrusted.read_bytes(path, "array")
        except InputError:
            continue
        found = _arrays(data, key)
        if found is not None:
            # What is used stays longest.
            with suppress(OSError):
                os.utime(path)
            return found
        _LOG.warning("%s is damaged: the light of the room is computed again", path)
    return None


def save(key: str, arrays: Arrays, folders: Sequence[Path]) -> Path | None:
    """Keep arrays under a key in the first folder that takes them; older files there may go.

    Args:
        key: From `content_key`.
        arrays: Finite, by name.
        folders: From `places`.

    Returns:
        Where they are; None where no folder takes them.

    Raises:
        ValueError: An array is not finite, or of a type that is not kept.
    """
    data = _bytes(key, arrays)
    if len(data) > untrusted.MOST_BYTES["array"]:
        return None
    for folder in folders:
        target = folder / f"{key}{_SUFFIX}"
        if folder.is_symlink():
            continue
        with suppress(OSError, OrusdError):
            unfinished.sweep(folder)
            atomic.write_bytes(target, data)
            _forget(folder, _MOST_BESIDE if folder.name == FOLDER else _MOST_IN_CACHE)
            return target
    return None


def _forget(folder: Path, most: int) -> None:
    """Remove all but the files that were used last, as far as they are proven to be ours."""
    used = []
    for path in folder.glob(f"*{_SUFFIX}"):
        # Others may remove it meanwhile.
        with suppress(OSError):
            used.append((path.lstat().st_mtime_ns, path))
    for _, path in sorted(used, reverse=True)[most:]:
        with suppress(OSError, InputError):
            if not path.is_symlink() and _arrays(untrusted.read_bytes(path, "array"), path.stem):
                removal.remove_file(path)


def _bytes(key: str, arrays: Arrays) -> bytes:
    rows, parts = [], []
    for name in sorted(arrays):
        array = np.ascontiguousarray(arrays[name])
        array = array.astype(array.dtype.newbyteorder("<"), copy=False)
        if array.dtype.str not in _TYPES or not np.isfinite(array).all():
            raise ValueError(f"{name} is not finite, or of a type that is not kept")
        rows.append([name, array.dtype.str, list(np.shape(arrays[name]))])
        parts.append(array.tobytes())
    header = json.dumps({"key": key, "arrays": rows}, separators=(",", ":")).encode()
    body = b"".join([header, b"\n", *parts])
    return b"".join([_MAGIC, hashlib.sha256(body).hexdigest().encode(), b"\n", body])


def _arrays(data: bytes, key: str) -> dict[str, NDArray[Any]] | None:
    """What a file holds; None where it is not what was written under the key.

    A checksum shows damage, not intent: sizes are weighed before they are believed.
    """
    start = len(_MAGIC) + _SUM_BYTES
    body = memoryview(data)[start:]
    said = data[len(_MAGIC) : start]
    if not data.startswith(_MAGIC) or said != hashlib.sha256(body).hexdigest().encode() + b"\n":
        return None
    end = data.find(b"\n", start, start + _LONGEST_HEADER_BYTES)
    try:
        header = json.loads(data[start:end]) if end >= 0 else {}
        rows = [(str(name), str(kind), _shape(shape)) for name, kind, shape in header["arrays"]]
        if header["key"] != key or any(kind not in _TYPES for _, kind, _ in rows):
            return None
        return _cut(data, end + 1, rows)
    except (ValueError, KeyError, TypeError, RecursionError):
        return None


def _shape(sizes: Any) -> tuple[int, ...]:
    if len(sizes) > _MOST_DIMENSIONS or not all(type(n) is int and 0 <= n < 2**40 for n in sizes):
        raise ValueError("no shape of an array")
    return tuple(sizes)


def _cut(
    data: bytes, at: int, rows: Sequence[tuple[str, str, tuple[int, ...]]]
) -> dict[str, NDArray[Any]] | None:
    """The arrays that lie one after the other; None where they do not fill the file exactly."""
    counts = [math.prod(shape) for _, _, shape in rows]
    sizes = [n * np.dtype(kind).itemsize for n, (_, kind, _) in zip(counts, rows, strict=True)]
    if at + sum(sizes) != len(data):
        return None
    found: dict[str, NDArray[Any]] = {}
    for (name, kind, shape), count, size in zip(rows, counts, sizes, strict=True):
        # A copy: what stands anywhere in a file is not aligned.
        array = np.frombuffer(data, kind, count, at).reshape(shape).copy()
        if not np.isfinite(array).all():
            return None
        found[name] = array
        at += size
    return found
