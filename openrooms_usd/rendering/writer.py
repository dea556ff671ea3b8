"""Files of a view are written while the next is rendered.

One view is written at a time, by a thread beside that which renders; who has the next one waits for
it. So views appear in their order, and at most two are in memory. One that is large is waited for
at once. When the run is interrupted, what is all but written has a moment to be finished.
"""

import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor, wait
from contextlib import contextmanager
from typing import Final

from openrooms_usd.rendering.contract import View

# A view that takes more than this is written before the next is rendered.
_MOST_BESIDE_BYTES: Final = 1 << 29
# What writing has left when the run is interrupted.
_GRACE_SECONDS: Final = 1.0


class InterruptedWritingError(Exception):
    """Writing has stopped because the run has; it is never shown."""


class ViewWriter:
    """Writes views one after the other, beside what goes on."""

    def __init__(self, pool: ThreadPoolExecutor) -> None:
        self._pool = pool
        self._now: Future[None] | None = None
        self._stopped = threading.Event()

    def put(self, view: View, write: Callable[[Callable[[], None]], None]) -> None:
        """Have a view written, once the one before is.

        Args:
            view: What is written.
            write: Writes it; calls what it is given from time to time, which raises when it shall
                stop.

        Raises:
            OrusdError: The view before could not be written.
        """
        self.wait()
        self._now = self._pool.submit(write, self._check_going)
        if _bytes(view) > _MOST_BESIDE_BYTES:
            self.wait()

    def check(self) -> None:
        """Raise what has kept a view from being written, if anything has."""
        if self._now is not None and self._now.done():
            self.wait()

    def wait(self) -> None:
        """Wait until everything is written.

        Raises:
            OrusdError: It could not be.
        """
        if self._now is not None:
            now, self._now = self._now, None
            now.result()

    def stop(self) -> None:
        """Stop writing, and forget what has not been written in a moment."""
        if self._now is not None:
            wait([self._now], _GRACE_SECONDS)
        self._stopped.set()

    def _check_going(self) -> None:
        if self._stopped.is_set():
            raise InterruptedWritingError


@contextmanager
def view_writer() -> Iterator[ViewWriter]:
    """What writes views beside the block; at its end everything is written.

    When the block raises, what is then being written is finished in a moment, or leaves nothing.
    """
    with ThreadPoolExecutor(max_workers=1) as pool:
        writer = ViewWriter(pool)
        try:
            yield writer
            writer.wait()
        except BaseException:
            writer.stop()
            raise


def _bytes(view: View) -> int:
    images = view.images.values()
    halves = (image.halves for image in images if image.halves)
    kept = sum(half.a.nbytes + half.b.nbytes for half in halves)
    clean = sum(image.pixels.nbytes for image in view.denoised.values())
    return kept + clean + sum(image.pixels.nbytes for image in images)
