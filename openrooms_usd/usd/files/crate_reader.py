"""Reads untrusted crates, in a process that may crash (see `isolation`).

Crates are maps of memory: a few wrong bytes end USD's reader. What this very process has written
needs no second reader.
"""

import struct
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, BinaryIO, Final

from openrooms_usd.errors import InputError
from openrooms_usd.isolation import check_reads, serve

if TYPE_CHECKING:
    from pxr import Sdf

# Of more specs than this, not all values are checked: the file then is a large scene, not a damaged
# small one.
_MOST_SPECS: Final = 50_000
_MAX_DEPTH: Final = 1_000


def check_crate_reads(name: str, size: int, place: str = "") -> None:
    """See that another process can read a crate, and lives.

    Args:
        name: The crate's path, or its place in a package (``/x/y.usdz[z.usdc]``).
        size: How many bytes it has.
        place: What messages call it; ``name`` by default.

    Raises:
        InputError: The process crashed, hung, or took too much memory.
    """
    # Not this module's own name, which is another one where it is run.
    check_reads("openrooms_usd.usd.files.crate_reader", name, size, what="USD", place=place)


@contextmanager
def _going_on() -> Iterator[None]:
    """Whatever is wrong here is for the one who asks; only memory is not."""
    try:
        yield
    except MemoryError:
        raise
    except Exception:
        return


def _read(name: str) -> None:
    """Read all of a crate as the caller will; the caller reports errors that only appear there."""
    from pxr import Sdf

    layer = None
    for read in (_read_specs, _read_prims, _compose):
        # Each by itself: where one of them stops at an error, another may not.
        with _going_on():
            layer = layer or Sdf.Layer.FindOrOpen(name)
            read(layer)


def _read_specs(layer: "Sdf.Layer") -> None:
    """What the layer says, spec by spec."""
    from pxr import Sdf

    paths: list[Sdf.Path] = []
    layer.Traverse(Sdf.Path.absoluteRootPath, paths.append)
    for path in paths[:_MOST_SPECS]:
        with _going_on():
            spec = layer.GetObjectAtPath(path)
            for key in spec.ListInfoKeys():
                with _going_on():
                    spec.GetInfo(key)
        with _going_on():
            for time in layer.ListTimeSamplesForPath(path):
                layer.QueryTimeSample(path, time)


def _read_prims(layer: "Sdf.Layer") -> None:
    """The layer's prims from the top down, with their properties and variants."""
    level = list(layer.rootPrims)
    seen = 0
    for _ in range(_MAX_DEPTH):
        level = level[: _MOST_SPECS - seen]
        seen += len(level)
        below = []
        for spec in level:
            with _going_on():
                list(spec.properties)
            with _going_on():
                below += spec.nameChildren
            with _going_on():
                for variants in spec.variantSets.values():
                    below += [variant.primSpec for variant in variants.variants.values()]
        level = below
        if not level:
            return


def _compose(layer: "Sdf.Layer") -> None:
    """The layer as a stage, its values included; not where it would bring others along."""
    from pxr import Usd

    if list(layer.GetCompositionAssetDependencies()):
        return
    stage = Usd.Stage.Open(layer, Usd.Stage.LoadAll)
    for seen, prim in enumerate(stage.TraverseAll()):
        if seen > _MOST_SPECS:
            return
        for attribute in prim.GetAttributes():
            with _going_on():
                attribute.Get()


if __name__ == "__main__":
    serve(_read)


MAGIC: Final = b"PXR-USDC"
_HEAD: Final = struct.Struct("<8s8sq")
_COUNT: Final = struct.Struct("<Q")
_SECTION: Final = struct.Struct("<16sqq")
_MOST_SECTIONS: Final = 64
# LZ4 packs 255 bytes into one at most, and USD's coding of whole numbers 16 into one before.
_MOST_GAIN: Final = 255 * 16
_MOST_TEXT_GAIN: Final = 256
_STRING_BYTES: Final = 4  # bytes; the only ones that are never packed


def check_crate(stream: BinaryIO, size: int, place: object) -> None:
    """See that a crate's sections lie in it and announce no more than they can hold.

    Args:
        stream: The file, or its bytes; files that are not crates are skipped.
        size: How many bytes there are.
        place: Where they are from, for messages.

    Raises:
        InputError: They do not, or it is cut off.
    """
    stream.seek(0)
    head = stream.read(_HEAD.size)
    if not head.startswith(MAGIC):
        return
    try:
        _, _, table = _HEAD.unpack(head)
        for name, start, length in _sections(stream, table, size):
            if min(start, length) < 0 or start + length > size:
                raise ValueError("a section lies outside the file")
            _check_section(stream, name, start, length)
    except (struct.error, ValueError) as error:
        raise InputError(
            f"not a readable USD file: {error}",
            place=place,
            remedy="copy it again, or export it again",
        ) from error


def _sections(stream: BinaryIO, table: int, size: int) -> list[tuple[bytes, int, int]]:
    if not 0 < table <= size - _COUNT.size:
        raise ValueError("its table of contents lies outside the file")
    stream.seek(table)
    (count,) = _COUNT.unpack(stream.read(_COUNT.size))
    if count > _MOST_SECTIONS:
        raise ValueError(f"it announces {count:,} sections")
    return [_SECTION.unpack(stream.read(_SECTION.size)) for _ in range(count)]


def _check_section(stream: BinaryIO, name: bytes, start: int, length: int) -> None:
    name = name.rstrip(b"\0")
    stream.seek(start)
    (count,) = _COUNT.unpack(stream.read(_COUNT.size))
    most = length // _STRING_BYTES if name == b"STRINGS" else _MOST_GAIN * length
    if name == b"TOKENS":
        (text,) = _COUNT.unpack(stream.read(_COUNT.size))
        count = max(count, text)
        most = _MOST_TEXT_GAIN * length
    if count > most:
        said = name.decode("ascii", "replace")
        raise ValueError(f"its section {said} announces {count:,} entries in {length:,} bytes")
