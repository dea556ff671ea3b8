"""Reads crates that nobody vouches for, in a process that may crash: started by `isolation`.

Each line of standard input names a crate; each line of standard output answers one of them. USD
alone is imported, so that the process is there in a moment.
"""

import json
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, TextIO

if TYPE_CHECKING:
    from pxr import Sdf

# Values of more specs than this are not all looked at: a scene that large is no small accident.
_MOST_SPECS = 200_000
_DEEPEST = 1_000


def main(most_bytes: int) -> None:
    """Answer until nobody asks.

    Args:
        most_bytes: The memory that reading may take.
    """
    with suppress(ImportError):  # not everywhere
        import resource

        resource.setrlimit(resource.RLIMIT_DATA, (most_bytes, most_bytes))
    # What libraries print is not an answer.
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)
    _answer(answers, "ready")
    for line in sys.stdin:
        _answer(answers, _read(json.loads(line)))


@contextmanager
def _going_on() -> Iterator[None]:
    """Whatever is wrong here is for the one who asks; only memory is not."""
    try:
        yield
    except MemoryError:
        raise
    except Exception:
        return


def _answer(answers: TextIO, word: str) -> None:
    answers.write(f"{word}\n")
    answers.flush()


def _read(name: str) -> str:
    """Read all of a crate as whoever asks will; what is only wrong there is said there."""
    from pxr import Sdf

    layer = None
    for read in (_read_specs, _read_prims, _compose):
        # Each by itself: where one of them stops at an error, another may not.
        try:
            layer = layer or Sdf.Layer.FindOrOpen(name)
            read(layer)
        except MemoryError:
            return "memory"
        except Exception:
            continue
    return "read"


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
    for _ in range(_DEEPEST):
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
        if not level or seen > _MOST_SPECS:
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
    main(int(sys.argv[1]))
