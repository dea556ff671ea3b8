"""Generated rooms: are they sound, what are they like, and how many are made in a minute.

Every room is generated, its layout and its furniture are composed, and the meshes of the composed
stage are checked by independent code (`tests.generation.checks`): nothing penetrates by more than
5 mm, floats, stands outside or blocks a door. Some rooms are composed to the end and timed.
"""

import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import chain
from pathlib import Path
from typing import Any

import click

from benchmarks.report import publish, table
from openrooms_usd.composing import compose_room
from openrooms_usd.description import parse_room
from openrooms_usd.furniture import category
from openrooms_usd.generation import generate, write
from openrooms_usd.generation.programs import PROGRAMS
from openrooms_usd.generation.rooms import USUAL_CLUTTER
from openrooms_usd.generation.shapes import Shapes
from openrooms_usd.generation.statistics import RoomNumbers, numbers, summary


@dataclass
class Tally:
    """What was found so far."""

    rooms: list[RoomNumbers] = field(default_factory=list)
    violations: list[str] = field(default_factory=list)
    missing: int = 0
    seconds: list[float] = field(default_factory=list)


@click.command(help=__doc__)
@click.option("--rooms", type=int, default=1000, show_default=True, help="How many are checked.")
@click.option("--timed", type=int, default=27, show_default=True, help="How many are timed.")
@click.option("--seed", type=int, default=0, show_default=True, help="Of the first rooms.")
@click.option(
    "--clutter",
    type=click.IntRange(0, 3),
    default=USUAL_CLUTTER,
    show_default=True,
    help="How much lies about.",
)
@click.option("--quick", is_flag=True, help="Two rooms only.")
@click.option("--json", "target", type=click.Path(path_type=Path), help="Where to write numbers.")
def main(rooms: int, timed: int, seed: int, clutter: int, quick: bool, target: Path | None) -> None:
    tally, began = Tally(), time.perf_counter()
    with click.progressbar(_rooms(2 if quick else rooms, seed), file=sys.stderr) as todo:
        for room_type, number in todo:
            with tempfile.TemporaryDirectory() as folder:
                check(tally, room_type, number, clutter, Path(folder))
    minutes = (time.perf_counter() - began) / 60.0
    speeds = [_timed(*room, clutter) for room in _rooms(1 if quick else timed, seed)]
    data = {"minutes": minutes, **_results(tally, speeds)}
    publish("generate", data, _markdown(data), target)


def _rooms(count: int, seed: int) -> list[tuple[str, int]]:
    """Room types in turn, then the next seed."""
    kinds = list(PROGRAMS)
    return [(kinds[i % len(kinds)], seed + i // len(kinds)) for i in range(count)]


def check(tally: Tally, room_type: str, seed: int, clutter: int, folder: Path) -> None:
    """Generate, compose and check one room."""
    from tests.generation import checks
    from tests.generation.assembled import assembled

    began = time.perf_counter()
    shapes = Shapes(seed)
    room = generate(room_type, seed, clutter=clutter, shapes=shapes)
    text = write(room)
    tally.seconds.append(time.perf_counter() - began)
    rows = parse_room(text).furniture.objects
    supports = checks.described_supports(rows, lambda name: category(name).support)
    hanging = checks.described_hanging(rows, lambda name: category(name).placements)
    wrong = checks.violations(assembled(text, shapes, folder), supports, hanging)
    for sentence in wrong:
        tally.violations.append(f"{room_type} {seed}: {sentence}")
        click.echo(f"\n{tally.violations[-1]}", err=True)
    tally.missing += room.furnishing.missing
    tally.rooms.append(numbers(room))


def _timed(room_type: str, seed: int, clutter: int) -> dict[str, Any]:
    """Seconds to generate and to compose a whole room, in this process."""
    with tempfile.TemporaryDirectory() as name:
        path = Path(name) / "room.yaml"
        began = time.perf_counter()
        path.write_text(write(generate(room_type, seed, clutter=clutter)), encoding="utf-8")
        generated = time.perf_counter()
        compose_room(path, Path(name) / "out")
        composed = time.perf_counter()
        return {
            "room": f"{room_type} {seed}",
            "generate_s": generated - began,
            "compose_s": composed - generated,
        }


def _results(tally: Tally, speeds: Sequence[dict[str, Any]]) -> dict[str, Any]:
    by_type = {
        kind: summary(rows)
        for kind in PROGRAMS
        if (rows := [room for room in tally.rooms if room.room_type == kind])
    }
    seconds = sorted(tally.seconds)
    whole = sum(row["generate_s"] + row["compose_s"] for row in speeds)
    return {
        "rooms": len(tally.rooms),
        "violations": tally.violations,
        "missing_groups": tally.missing,
        "generate_median_s": seconds[len(seconds) // 2],
        "generate_p95_s": seconds[int(0.95 * (len(seconds) - 1))],
        "generate_worst_s": seconds[-1],
        "rooms_per_minute": 60.0 * len(speeds) / whole,
        "timed": list(speeds),
        "types": by_type,
    }


def _markdown(data: dict[str, Any]) -> str:
    titles = (
        "room type",
        "rooms",
        "area m2",
        "least",
        "most",
        "objects",
        "classes",
        "free floor",
        "most common, objects a room",
    )
    rows = [[kind, *row.values()] for kind, row in data["types"].items()]
    found = list(chain(data["violations"][:20], ["..."] * (len(data["violations"]) > 20)))
    facts = [
        f"{data['rooms']} rooms in {data['minutes']:.0f} minutes, "
        f"{len(data['violations'])} violations, "
        f"{data['missing_groups']} groups that found no place",
        f"generate: median {data['generate_median_s']:.3f} s, 95 % below "
        f"{data['generate_p95_s']:.3f} s, worst {data['generate_worst_s']:.3f} s",
        f"generate + compose: {data['rooms_per_minute']:.1f} rooms a minute",
    ]
    return "\n".join([table(titles, rows), "", *facts, *found])


if __name__ == "__main__":
    main()
