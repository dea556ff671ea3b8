"""Every way out of a generated room that can be looked through leads somewhere."""

import json
from pathlib import Path

import pytest
import shapely

from openrooms_usd.composing import compose_room
from openrooms_usd.generation.programs import PROGRAMS
from openrooms_usd.generation.rooms import draw_shell

# The least hallway: beside its opening, how deep, and how far from a window's view; metres.
BESIDE, DEEP, VIEW = 0.12, 0.8, 3.0


@pytest.mark.parametrize("seed", range(4))
def test_a_hallway_has_space_wherever_one_is_seen(seed: int) -> None:
    assert [row for kind in PROGRAMS for row in nowhere(kind, seed)] == []


@pytest.mark.parametrize("thickness", [0.2, 0.5])
def test_the_layout_builds_all_hallways_that_are_seen(tmp_path: Path, thickness: float) -> None:
    """Of the two doors of this room that were seen through, one stood open on a lawn."""
    shell, rows = draw_shell("living_room", 101, thickness=thickness)
    room = {"polygon": shell.corners.tolist(), "height": shell.height, "openings": rows,
            "wall_thickness": thickness}  # fmt: skip
    (tmp_path / "room.yaml").write_text(json.dumps({"layout": room}))
    composed = compose_room(tmp_path / "room.yaml", tmp_path / "out", only="layout")
    assert [note for stage in composed.stages for note in stage.notes] == []


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(4, 40))
def test_a_hallway_has_space_in_a_thousand_rooms(seed: int) -> None:
    assert [row for kind in PROGRAMS for row in nowhere(kind, seed)] == []


def nowhere(room_type: str, seed: int, thickness: float = 0.2) -> list[str]:
    """Ways out that show a hallway for which there is no space, by the plan alone."""
    shell, rows = draw_shell(room_type, seed, thickness=thickness)
    house = shapely.Polygon(shell.corners).buffer(thickness - 0.02, join_style="mitre")
    found = []

    def behind(row: dict, beside: float, deep: float) -> shapely.Polygon:
        side = shell.sides[row["wall"]]
        half = 0.5 * row["width"] + beside
        ends = [(-half, thickness), (half, thickness), (half, thickness + deep),
                (-half, thickness + deep)]  # fmt: skip
        return shapely.Polygon([side.point(row["at"] + a, -away) for a, away in ends])

    views = [behind(row, 0.0, VIEW) for row in rows if row["kind"] == "window"]
    for row in rows:
        if row.get("beyond") == "hallway" and (row["kind"] == "opening" or row["open"] > 0.0):
            out = row["kind"] == "door" and row["swing"] == "out"
            hall = behind(row, BESIDE, max(DEEP, row["width"] if out else 0.0))
            if any(hall.intersection(other).area > 1e-3 for other in (house, *views)):
                found.append(f"{room_type} {seed}: {row}")
            views.append(hall)
    return found
