"""Reads crates that nobody vouches for, in a process that may crash (see `isolation`).

Crates are maps of memory: a few wrong bytes end USD's reader. What this very process has written
needs no second reader.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Final

from openrooms_usd.isolation import check_reads, serve

if TYPE_CHECKING:
    from pxr import Sdf

# Values of more specs than this are not all looked at: a scene that large is no small accident.
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
    check_reads("openrooms_usd.usd.crate_reader", name, size, what="USD", place=place)


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
    """Read all of a crate as whoever asks will; what is only wrong there is said there."""
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
