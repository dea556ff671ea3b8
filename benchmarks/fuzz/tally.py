"""The result of a campaign: a row for each kind, and defects that are alike as one."""

from collections import Counter, defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Final, get_args

from benchmarks.fuzz.case import BAD, Outcome, Verdict

VERDICTS: Final[tuple[Verdict, ...]] = get_args(Verdict)
_EXAMPLES: Final = 3


@dataclass
class Row:
    """What became of one kind's cases."""

    cases: int = 0
    counts: Counter[str] = field(default_factory=Counter)
    seconds: float = 0.0
    worst_seconds: float = 0.0
    worst_mebibytes: float = 0.0

    def add(self, outcome: Outcome) -> None:
        """Count a case."""
        self.cases += 1
        self.counts[outcome.verdict] += 1
        self.seconds += outcome.seconds
        self.worst_seconds = max(self.worst_seconds, outcome.seconds)
        self.worst_mebibytes = max(self.worst_mebibytes, outcome.mebibytes)

    def cells(self) -> list[Any]:
        """A row of the table, without its name."""
        counts = [self.counts[verdict] for verdict in VERDICTS]
        return [self.cases, *counts, round(self.worst_seconds, 2), round(self.worst_mebibytes)]


class Tally:
    """Counts outcomes as they come."""

    def __init__(self) -> None:
        self.rows: defaultdict[str, Row] = defaultdict(Row)
        self.defects: defaultdict[tuple[str, str, str], list[Outcome]] = defaultdict(list)
        self.unsound: list[Outcome] = []

    def add(self, outcome: Outcome) -> None:
        """Count a case."""
        self.rows[outcome.kind].add(outcome)
        if outcome.verdict in BAD:
            self.defects[outcome.verdict, outcome.what, outcome.where].append(outcome)
        elif outcome.sound and outcome.verdict != "accepted":
            self.unsound.append(outcome)

    @property
    def bad(self) -> int:
        """How many cases ended as none may."""
        return sum(map(len, self.defects.values()))

    def table(self) -> tuple[tuple[str, ...], list[list[Any]]]:
        """Titles and rows, the last one the sum."""
        total = Row()
        for row in self.rows.values():
            total.cases += row.cases
            total.counts += row.counts
            total.seconds += row.seconds
            total.worst_seconds = max(total.worst_seconds, row.worst_seconds)
            total.worst_mebibytes = max(total.worst_mebibytes, row.worst_mebibytes)
        named = [*sorted(self.rows.items()), ("all", total)]
        titles = ("kind", "cases", *VERDICTS, "worst s", "worst MiB")
        return titles, [[name, *row.cells()] for name, row in named]

    def grouped(self) -> list[dict[str, Any]]:
        """Defects that are alike, the most frequent first."""
        found = sorted(self.defects.items(), key=lambda item: (-len(item[1]), item[0]))
        return [
            {
                "verdict": verdict,
                "what": what,
                "where": where,
                "cases": len(outcomes),
                "kinds": sorted({outcome.kind for outcome in outcomes}),
                "examples": examples(outcomes),
                "said": outcomes[0].said,
            }
            for (verdict, what, where), outcomes in found
        ]


def examples(outcomes: Sequence[Outcome]) -> list[str]:
    """Some cases, as the command line takes them."""
    first = {outcome.kind: outcome for outcome in reversed(outcomes)}.values()
    return [f"--only {o.kind} --case {o.number}" for o in list(first)[:_EXAMPLES]]
