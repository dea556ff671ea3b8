"""What is tested: a kind of input, how a sound one is planted, and the commands that read it."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

Run = str | Callable[[Path], object]
"""Words of the command line with ``{in}`` and ``{out}``, or a function of the case's folder."""
Write = Callable[[Path], object]

INPUT, OUT = "in", "out"
TINY = "materials: {resolution: 16"
AGAIN = "compose {in}/room.yaml -o {out} --only "


@dataclass(frozen=True)
class Kind:
    """One kind of input.

    Attributes:
        name: Its name in the tally.
        plant: Writes sound input into ``in`` and, where a command changes a folder that exists,
            that folder as ``out``; both lie in the folder that it is given.
        runs: What reads it, each with the share of the cases that it gets.
        victims: Patterns of the files that are spoilt, below the folder that was planted.
        needs: Packages without which it is skipped.
        share: How many cases it gets beside others.
        hostile: Whether it may be refused even as it was planted.
    """

    name: str
    plant: Write
    runs: tuple[tuple[int, Run], ...]
    victims: tuple[str, ...] = ("in/**/*",)
    needs: tuple[str, ...] = ()
    share: int = 2
    hostile: bool = False

    def files(self, planted: Path) -> list[str]:
        """The files that are spoilt, relative to the folder that was planted; sorted."""
        found = {path for pattern in self.victims for path in planted.glob(pattern)}
        return sorted(str(path.relative_to(planted)) for path in found if path.is_file())


def planting(write: Write) -> Write:
    """Have input written into ``in``."""

    def plant(folder: Path) -> None:
        (folder / INPUT).mkdir()
        write(folder / INPUT)

    return plant


def planting_out(write: Write, section: str) -> Write:
    """Input with a room that uses it, which is composed already; one stage is then run again."""

    def plant(folder: Path) -> None:
        from openrooms_usd.composing import compose_room
        from openrooms_usd.usd.files.diagnostics import quiet

        write(folder)
        room = folder / "in/room.yaml"
        room.write_text(
            "name: own\nroom: office\nlayout:\n  from: polygon\n"
            "  polygon: [[0, 0], [3, 0], [3, 3], [0, 3]]\n" + section
        )
        with quiet():
            compose_room(room, folder / "out")

    return plant
