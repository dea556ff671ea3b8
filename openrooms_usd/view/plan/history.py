"""What was done, and what was taken back."""

from typing import Generic, TypeVar

Kept = TypeVar("Kept")


class History(Generic[Kept]):
    """States in the order in which they came about, and which of them is now.

    Args:
        first: The state at the beginning.
    """

    def __init__(self, first: Kept) -> None:
        self._states = [first]
        self._now = 0

    @property
    def now(self) -> Kept:
        """The present state."""
        return self._states[self._now]

    @property
    def done(self) -> int:
        """How many steps can be taken back."""
        return self._now

    @property
    def undone(self) -> int:
        """How many steps that were taken back can be done again."""
        return len(self._states) - 1 - self._now

    def do(self, state: Kept) -> None:
        """Go on to a state; what was taken back before is forgotten."""
        self._states = [*self._states[: self._now + 1], state]
        self._now += 1

    def undo(self) -> None:
        """Take the last step back, if there is one."""
        self._now = max(0, self._now - 1)

    def redo(self) -> None:
        """Do the step again that was taken back last, if there is one."""
        self._now = min(len(self._states) - 1, self._now + 1)
