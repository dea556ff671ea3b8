"""What light shall reach, beside what it has reached."""

from collections.abc import Sequence
from dataclasses import dataclass

from benchmarks.report import table


@dataclass(frozen=True)
class Target:
    """A number that shall be reached.

    Attributes:
        what: It is, with its unit.
        limit: The number.
        found: What it is; None where nothing that was measured reaches what it is asked of.
        at_least: Whether it shall be at least the limit; else at most, whatever its sign.
    """

    what: str
    limit: float
    found: float | None
    at_least: bool = False

    @property
    def met(self) -> bool:
        """Whether it is reached."""
        if self.found is None:
            return False
        return self.found >= self.limit if self.at_least else abs(self.found) <= self.limit


def listed(targets: Sequence[Target]) -> str:
    """Targets as a table."""
    return table(
        ("target", "limit", "found", "met"),
        [
            (
                target.what,
                f"{'>=' if target.at_least else '<='} {target.limit:g}",
                target.found,
                "yes" if target.met else "no",
            )
            for target in targets
        ],
    )
