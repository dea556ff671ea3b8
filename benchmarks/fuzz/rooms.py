"""A room that uses what was planted and is composed already, so that one stage can run again."""

from collections.abc import Callable
from pathlib import Path

TINY = "materials: {resolution: 16"
AGAIN = "compose {in}/room.yaml -o {out} --only "


def planting_out(
    write: Callable[[Path], None], section: str
) -> Callable[[Path], None]:  # fmt: skip
    """Input with a room that uses it, which is composed already; one stage is then run again."""

    def plant(folder: Path) -> None:
        from openrooms_usd.compose import compose_room
        from openrooms_usd.usd.diagnostics import quiet

        write(folder)
        room = folder / "in/room.yaml"
        room.write_text(
            "name: own\nroom: office\nlayout:\n  from: polygon\n"
            "  polygon: [[0, 0], [3, 0], [3, 3], [0, 3]]\n" + section
        )
        with quiet():
            compose_room(room, folder / "out")

    return plant
