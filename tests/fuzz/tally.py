"""The result of a campaign: a row for each kind, and defects that are alike as one."""

from collections import Counter, defaultdict
from collections.abc import Sequence
from dataclasses import asdict
from typing import Any, Final

from tests.fuzz.case import BAD, VERDICTS, Outcome

TITLES: Final = ("kind", "cases", *VERDICTS, "mean ms", "worst s", "worst MiB")
_EXAMPLES: Final = 3


def row(name: str, found: Sequence[Outcome]) -> list[Any]:
    """What became of a kind's cases, as `TITLES` says."""
    counts = Counter(outcome.verdict for outcome in found)
    seconds = [outcome.seconds for outcome in found] or [0.0]
    return [
        name,
        len(found),
        *(counts[verdict] for verdict in VERDICTS),
        round(1000 * sum(seconds) / len(seconds), 1),
        round(max(seconds), 2),
        round(max((outcome.mebibytes for outcome in found), default=0.0)),
    ]


def rows(found: Sequence[Outcome]) -> list[list[Any]]:
    """One for each kind, the last one for all of them."""
    kinds: defaultdict[str, list[Outcome]] = defaultdict(list)
    for outcome in found:
        kinds[outcome.kind].append(outcome)
    return [*(row(name, kinds[name]) for name in sorted(kinds)), row("all", found)]


def unsound(found: Sequence[Outcome]) -> list[Outcome]:
    """Those that were refused although nothing was spoilt."""
    return [o for o in found if o.sound and o.verdict != "accepted" and o.verdict not in BAD]


def defects(found: Sequence[Outcome]) -> list[dict[str, Any]]:
    """Those that are alike once, the most frequent first."""
    alike: defaultdict[tuple[str, str, str], list[Outcome]] = defaultdict(list)
    for outcome in found:
        if outcome.verdict in BAD:
            alike[outcome.verdict, outcome.what, outcome.where].append(outcome)
    return [
        {
            "verdict": verdict,
            "what": what,
            "where": where,
            "cases": len(outcomes),
            "kinds": sorted({outcome.kind for outcome in outcomes}),
            "examples": [again(o) for o in _one_of_each_kind(outcomes)[:_EXAMPLES]],
            "said": outcomes[0].said,
        }
        for (verdict, what, where), outcomes in sorted(
            alike.items(), key=lambda item: (-len(item[1]), item[0])
        )
    ]


def _one_of_each_kind(outcomes: Sequence[Outcome]) -> list[Outcome]:
    return list({outcome.kind: outcome for outcome in reversed(outcomes)}.values())


def again(outcome: Outcome) -> str:
    """A case, as the command line takes it."""
    return f"--only {outcome.kind} --case {outcome.number}"


def as_dict(found: Sequence[Outcome]) -> dict[str, Any]:
    """All of it as plain data."""
    return {
        "rows": [dict(zip(TITLES, cells, strict=True)) for cells in rows(found)],
        "unsound": [asdict(outcome) for outcome in unsound(found)],
        "defects": defects(found),
    }


def text(found: Sequence[Outcome]) -> str:
    """All of it for people."""
    cells = [[str(cell) for cell in line] for line in (TITLES, *rows(found))]
    widths = [max(len(line[i]) for line in cells) for i in range(len(TITLES))]
    lines = [
        "  ".join([line[0].ljust(widths[0]), *map(str.rjust, line[1:], widths[1:])])
        for line in cells
    ]
    if refused := unsound(found):
        lines.append(f"refused although nothing was spoilt: {', '.join(map(again, refused))}")
    for defect in defects(found):
        what = "{cases} x {verdict}: {what} at {where}".format(**defect)
        lines.append(f"\n{what} ({', '.join(defect['kinds'][:4])})")
        lines.append(f"  {defect['examples'][0]}\n  {defect['said'][:200]!r}")
    return "\n".join(lines)
