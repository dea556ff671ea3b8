"""Commands that are killed (kill -9) at any moment, and run again: same bytes, nothing left over.

Each command is killed at random moments of its run, and right before and after operations on files
(renames and removals), where half a change would show. What lies there after the second run is
compared, byte by byte, with what a run that nobody killed leaves.
"""

import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import click

from benchmarks.report import publish, table
from benchmarks.scenes import ORUSD, SMALL_ROOM, SMALL_ROOM_CAMERAS, orusd
from openrooms_usd import unfinished

ROOM: Final = f"{SMALL_ROOM}{SMALL_ROOM_CAMERAS}"
# Every layer and every texture of it differ from those of ROOM.
OTHER: Final = ROOM.replace("4, ", "5, ").replace("seed: 3", "seed: 4")
PHYSICS: Final = f"{ROOM}physics: {{}}\n"
DATASET: Final = """\
rooms: [{files: [room.yaml, other.yaml]}]
views: {from: described, count: 2, resolution: [16, 12]}
variants: [main, mainDiffMat]
budget: {samples: 1}
rendering: {options: {variant: scalar}}
outputs: [{as: openrooms}, {as: webdataset}, {as: coco}]
"""
DESCRIPTIONS: Final = {
    "room.yaml": ROOM,
    "other.yaml": OTHER,
    "physics.yaml": PHYSICS,
    "dataset.yaml": DATASET,
}
QUICK: Final = ("--variant", "scalar", "--spp", "1", "--resolution", "16x12")
# Files and folders of one machine and one run, and so never the same.
LEFT_OUT: Final = frozenset({"timing.json", "timing"})

# Counts what is done to files, and ends the process at one of the counts.
_COUNTING: Final = """
import os, signal, sys
from openrooms_usd import removal
last, done = int(sys.argv.pop(1)), [0]
def count():
    done[0] += 1
    if done[0] == last:
        os.kill(os.getpid(), signal.SIGKILL)
def counted(function):
    def call(*given):
        count()
        found = function(*given)
        count()
        return found
    return call
for name in ("rename", "remove_file", "remove_if_empty", "remove_tree"):
    setattr(removal, name, counted(getattr(removal, name)))
from openrooms_usd.cli import main
try:
    main()
finally:
    if not last:
        print(done[0], file=sys.stderr)
"""


@dataclass(frozen=True)
class Case:
    """A command to kill.

    Attributes:
        before: Words of the commands that prepare the folder, ``{}`` standing for it.
        words: Words of the command.
        spoil: What somebody does to the folder in between.
    """

    before: tuple[tuple[str, ...], ...]
    words: tuple[str, ...]
    spoil: Callable[[Path], None] = lambda folder: None


def _save_over(folder: Path) -> None:
    """What another program does that moves the chair and saves the scene over ours."""
    scene = folder / "out" / "scene.usda"
    text = scene.read_text(encoding="utf-8")
    moved = 'over "chair" {\n double3 xformOp:translate = (1, 1, 0)\n }'
    scene.write_text(f'{text}\nover "World" {{\n over "Furniture" {{\n {moved}\n }}\n }}\n')


_COMPOSE: Final = ("compose", "{}/room.yaml", "-o", "{}/out")
_COMPOSE_PHYSICS: Final = ("compose", "{}/physics.yaml", "-o", "{}/out")
_RENDER: Final = ("render", "{}/out/scene.usda", "-o", "{}/render", *QUICK)
_DATASET: Final = ("dataset", "run", "{}/dataset.yaml", "-o", "{}/out")
CASES: Final[Mapping[str, Case]] = {
    "compose, cold": Case((), (*_COMPOSE, "--usdz")),
    "compose, warm": Case(
        (("compose", "{}/other.yaml", "-o", "{}/out", "--usdz"),), (*_COMPOSE, "--usdz")
    ),
    "compose, physics": Case((_COMPOSE,), _COMPOSE_PHYSICS),
    "render, new": Case((_COMPOSE,), _RENDER),
    "render, again": Case((_COMPOSE, (*_RENDER, "--seed", "7")), (*_RENDER, "--camera", "right")),
    "simulate": Case((_COMPOSE_PHYSICS,), ("simulate", "{}/out/scene.usda", "--duration", "0.2")),
    "dataset": Case((), (*_DATASET, "--workers", "2")),
    "adopt": Case((_COMPOSE,), ("edit", "import-changes", "{}/out/scene.usda"), _save_over),
}


@dataclass(frozen=True)
class Killed:
    """What became of one run that was killed and run again.

    Attributes:
        moment: When, for people.
        in_time: Whether the kill came before the end.
        remains: How many unfinished files and folders it left.
        differs: Files that are not as after a run that nobody killed.
        refused: What the second run said, if it failed.
    """

    moment: str
    in_time: bool
    remains: int
    differs: tuple[str, ...]
    refused: str = ""


class Lab:
    """A case, its folder before the command, and what the command leaves.

    Args:
        case: The case.
        scratch: An empty folder.
    """

    def __init__(self, case: Case, scratch: Path) -> None:
        self._case = case
        self._scratch = scratch
        base = scratch / "base"
        base.mkdir()
        for name, text in DESCRIPTIONS.items():
            (base / name).write_text(text)
        for words in case.before:
            orusd(*_at(words, base))
        case.spoil(base)
        whole = self._fresh("whole")
        began = time.perf_counter()
        done = self._start(whole, counting=0)
        said = done.communicate()[1]
        self.seconds = time.perf_counter() - began
        if done.returncode:
            raise SystemExit(f"{' '.join(case.words)} failed:\n{said}")
        self.operations = int(said.split()[-1])
        self.expected = tree(whole)

    def at_moment(self, seconds: float) -> Killed:
        """Kill the command some time after its start, and run it again."""
        folder = self._fresh("killed")
        process = self._start(folder)
        try:
            process.communicate(timeout=seconds)
        except subprocess.TimeoutExpired:
            process.send_signal(signal.SIGKILL)
            process.communicate()
        return self._again(folder, f"{seconds:.2f} s", process.returncode)

    def at_operation(self, number: int) -> Killed:
        """Kill the command at an operation on files, and run it again."""
        folder = self._fresh("killed")
        process = self._start(folder, counting=number)
        process.communicate()
        return self._again(folder, f"operation {number}", process.returncode)

    def _again(self, folder: Path, moment: str, code: int) -> Killed:
        remains = sum(unfinished.is_unfinished(path) for path in folder.rglob("*"))
        process = self._start(folder)
        said = process.communicate()[1]
        found = tree(folder)
        names = sorted(found.keys() | self.expected.keys())
        differs = tuple(name for name in names if found.get(name) != self.expected.get(name))
        return Killed(
            moment, code == -signal.SIGKILL, remains, differs, said if process.returncode else ""
        )

    def _fresh(self, name: str) -> Path:
        target = self._scratch / name
        shutil.rmtree(target, ignore_errors=True)
        shutil.copytree(self._scratch / "base", target, symlinks=True)
        return target

    def _start(self, folder: Path, counting: int | None = None) -> "subprocess.Popen[str]":
        words = _at(self._case.words, folder)
        begin = ORUSD if counting is None else (sys.executable, "-c", _COUNTING, str(counting))
        pipe = subprocess.PIPE
        return subprocess.Popen([*begin, *words], stdout=pipe, stderr=pipe, text=True)


def _at(words: tuple[str, ...], folder: Path) -> list[str]:
    return [word.replace("{}", str(folder)) for word in words]


def tree(folder: Path) -> dict[str, bytes | None]:
    """Every file and folder with its bytes, apart from what no two runs have alike."""
    return {
        path.relative_to(folder).as_posix(): path.read_bytes() if path.is_file() else None
        for path in folder.rglob("*")
        if LEFT_OUT.isdisjoint(path.relative_to(folder).parts)
    }


def kills(case: Case, moments: int, operations: int, seed: int) -> Iterator[Killed]:
    """Kill a command again and again.

    Args:
        case: The command.
        moments: How many kills at random moments.
        operations: How many at operations on files, evenly over all of them.
        seed: Of the moments.
    """
    with tempfile.TemporaryDirectory() as scratch:
        lab = Lab(case, Path(scratch))
        draw = random.Random(seed)
        for _ in range(moments):
            # The first fifth of the time is the start of the interpreter.
            yield lab.at_moment(lab.seconds * draw.uniform(0.2, 1.0))
        chosen = min(operations, lab.operations)
        for index in range(chosen):
            yield lab.at_operation(1 + index * lab.operations // chosen)


@click.command(help=__doc__)
@click.option("--moments", type=int, default=30, show_default=True, help="Of each command.")
@click.option("--operations", type=int, default=30, show_default=True, help="Of each command.")
@click.option("--seed", type=int, default=0, show_default=True)
@click.option("--only", type=click.Choice(list(CASES)), multiple=True)
@click.option("--json", "target", type=click.Path(path_type=Path), help="Where to write numbers.")
def main(
    moments: int, operations: int, seed: int, only: tuple[str, ...], target: Path | None
) -> None:
    rows = []
    bad = 0
    for name in only or CASES:
        done = list(kills(CASES[name], moments, operations, seed))
        wrong = [row for row in done if row.differs or row.refused]
        for row in wrong:
            click.echo(f"{name} at {row.moment}: {row.refused or row.differs[:5]}", err=True)
        bad += len(wrong)
        rows.append(
            {
                "command": name,
                "kills": len(done),
                "before its end": sum(row.in_time for row in done),
                "with remains": sum(row.remains > 0 for row in done),
                "other bytes": sum(bool(row.differs) for row in done),
                "refused": sum(bool(row.refused) for row in done),
            }
        )
    publish("kills", {"rows": rows}, table(list(rows[0]), [list(r.values()) for r in rows]), target)
    if bad:
        raise SystemExit(1)


if __name__ == "__main__":
    main()
