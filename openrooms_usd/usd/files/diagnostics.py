"""USD's own error messages, rewritten for people, and kept off standard error."""

import re
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Final

from pxr import Tf, Usd, UsdUtils

from openrooms_usd.errors import InputError, printable

# What Python gets where USD cannot read something: the second for names that are not text.
UNREADABLE: Final = (Tf.ErrorException, UnicodeDecodeError)
# Python type of values whose type USD does not know: code that uses them as numbers fails.
NO_TYPE: Final = "UnregisteredValue"
# How the exception of a prim that USD does not have begins.
_NO_PRIM: Final = "Accessed "

# Where in memory something lies, names of rules in USD's own grammar, and of its source files.
_NOISE: Final = re.compile(
    r" pxrInternal\w*pegtl::.*?(?= at '|\Z)"
    r"|\s*\([^()]*\b0x[^()]*\)"
    r"|(?: (?:of|in|from|on) layer )?@anon:[^@]*@"
    r"| matching pxrInternal\S+"
    r"|\s*\bpxrInternal_\w+?__pxrReserved__::"
    r"|(?: at line \d+)? (?:in|of) (?:file )?\S+\.(?:cpp|h)\b(?: line \d+)?"
)
# A line and a column of a text.
_PLACED: Final = re.compile(r":\d+:\d+: ")
# Longer sentences quote the file itself.
_MAX_REASON_CHARACTERS: Final = 300


def reason(error: BaseException) -> str:
    """What USD says is wrong, in one sentence, without where in USD it was said."""
    if isinstance(error, UnicodeDecodeError):
        return "it holds names that are not UTF-8 text"
    if isinstance(error, TypeError):
        return "it holds a value of a type that USD does not know"
    if isinstance(error, RecursionError):
        return "it nests too deeply"
    if not isinstance(error, Tf.ErrorException) or not error.args:
        return plain(error) or "it is damaged"
    try:
        # The first of its errors is the cause, the others what followed from it; of a value that
        # is wrong only one of those says in which line.
        said = [one.commentary for one in error.args]
        placed = [text for text in said if _PLACED.search(text)]
        return plain((placed or said)[0]) or "it is damaged"
    except UnicodeDecodeError as other:
        return reason(other)


@contextmanager
def reading(path: object) -> Iterator[None]:
    """Say of a file what USD cannot read of it, also where values are read late.

    Args:
        path: The file, for the message.

    Raises:
        InputError: USD, or what Python makes of its values, fails inside the block.
    """
    try:
        yield
    except (*UNREADABLE, RuntimeError, TypeError) as error:
        is_usd = isinstance(error, (*UNREADABLE, RecursionError))
        if not is_usd and not str(error).startswith(_NO_PRIM) and NO_TYPE not in str(error):
            raise
        raise InputError(
            f"not a readable USD file: {reason(error)}",
            place=path,
            remedy="open it with a USD tool to see the mistake, or export it again",
        ) from error


def composition_errors(stage: Usd.Stage) -> list[tuple[str, str]]:
    """What a stage refers to and USD cannot find or read.

    Returns:
        Prim path and sentence, in the order in which USD met them; files are named from the
        stage's folder.
    """
    home = f"{Path(stage.GetRootLayer().realPath).absolute().parent.as_posix()}/"
    return [
        (str(error.rootSite.path), _message_of(error).replace(home, "./"))
        for error in stage.GetCompositionErrors()
    ]


def _message_of(error: object) -> str:
    try:
        return plain(error)
    except UnicodeDecodeError as other:
        return reason(other)


def plain(said: object) -> str:
    """One line of bounded length, without what is of USD's own program."""
    text = printable(_NOISE.sub("", " ".join(str(said).split())), lines=False).strip()
    if len(text) <= _MAX_REASON_CHARACTERS:
        return text
    # What USD quotes is long; what it says of it stands at either end.
    return f"{text[: _MAX_REASON_CHARACTERS - 104]} ... {text[-99:]}"


@contextmanager
def quiet() -> Iterator[None]:
    """Keep USD from printing what is said better elsewhere."""
    delegate = UsdUtils.CoalescingDiagnosticDelegate()
    try:
        yield
    finally:
        with suppress(UnicodeDecodeError):
            delegate.TakeUncoalescedDiagnostics()
        del delegate
