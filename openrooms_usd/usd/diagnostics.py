"""What USD says is wrong: in words for people, and not on standard error."""

import os
import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Final

from pxr import Tf, Usd, UsdUtils

# Where in memory something lies, and names of rules in USD's own grammar.
_NOISE: Final = re.compile(
    r"\s*\([^()]*\b0x[^()]*\)"
    r"|(?: (?:of|in|from|on) layer )?@anon:[^@]*@"
    r"| matching pxrInternal\S+"
)


def reason(error: Tf.ErrorException) -> str:
    """What USD says is wrong, without where in USD it was said."""
    # The first of its errors is the cause, the others what followed from it.
    return _plain(error.args[0].commentary)


def composition_errors(stage: Usd.Stage) -> list[tuple[str, str]]:
    """What a stage refers to and USD cannot find or read.

    Returns:
        Prim path and sentence, in the order in which USD met them; files are named from the
        stage's folder.
    """
    home = f"{Path(stage.GetRootLayer().realPath).absolute().parent}{os.sep}"
    return [
        (str(error.rootSite.path), _plain(error).replace(home, "./"))
        for error in stage.GetCompositionErrors()
    ]


def _plain(said: object) -> str:
    """One line, without addresses in memory and names of rules in USD's own grammar."""
    return _NOISE.sub("", " ".join(str(said).split()))


@contextmanager
def quiet() -> Iterator[None]:
    """Keep USD from printing what is said better elsewhere."""
    delegate = UsdUtils.CoalescingDiagnosticDelegate()
    try:
        yield
    finally:
        delegate.TakeUncoalescedDiagnostics()
        del delegate
