"""How much a scan shows of a room whose points are given: shares that can be counted by hand."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from openrooms_usd.description.layout import ScanLayout
from openrooms_usd.scan.results import FoundOpening, FoundRoom
from openrooms_usd.scan.shown import shown
from openrooms_usd.steps.layout.scanned import scanned

CORNERS = np.array([[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [4.0, 3.0, 0.0], [0.0, 3.0, 0.0]])
DOOR = FoundOpening(
    "door", np.array([[1.0, 0, 0], [2.0, 0, 0], [2.0, 0, 2.0], [1.0, 0, 2.0]]), 1, 0
)
ROOM = FoundRoom(np.array([0.0, 0.0, 1.0]), CORNERS[0], CORNERS, ceiling=2.5)
DOCS = Path(__file__).parents[2] / "docs/results/datasets.md"
DEV = "real_dev/data"
SCANNET = "scan2cad_scene0470_00/Assets/scannet-sample/scene0470_00"


def sheet(a: tuple[float, float], b: tuple[float, float], fixed: int, at: float) -> np.ndarray:
    """Points every 4 cm of a rectangle across an axis."""
    u, v = np.meshgrid(np.arange(a[0] + 0.02, a[1], 0.04), np.arange(b[0] + 0.02, b[1], 0.04))
    return np.insert(np.column_stack([u.ravel(), v.ravel()]), fixed, at, axis=1)


FLOOR = sheet((0, 4), (0, 3), 2, 0.0)
WALLS = [
    sheet((0, 4), (0, 2.5), 1, 0.0),
    sheet((0, 3), (0, 2.5), 0, 4.0),
    sheet((0, 4), (0, 2.5), 1, 3.0),
    sheet((0, 3), (0, 2.5), 0, 0.0),
]


def test_a_whole_scan_shows_all() -> None:
    found = shown(np.concatenate([FLOOR, *WALLS]), [ROOM])
    assert found.as_dict() == {"floor": 1.0, "walls": 1.0, "whole": 1.0}


@pytest.mark.parametrize("side", [1, 2])
def test_what_is_not_scanned_is_missed(side: int) -> None:
    half = FLOOR[FLOOR[:, 0] < 2.0]
    rest = [wall for number, wall in enumerate(WALLS) if number != side]
    found = shown(np.concatenate([half, *rest]), [ROOM])
    # Cells beside what was scanned count as far as 10 cm, and before walls a metre of floor does.
    floor, missing = 0.5, [0, 3.0, 4.0][side] / 14.0
    assert found.floor == pytest.approx(floor, abs=0.16)
    assert found.walls == pytest.approx(1.0 - missing, abs=0.05)
    area = 12.0 + 14.0 * 2.5
    together = (found.floor * 12.0 + found.walls * 14.0 * 2.5) / area
    assert found.whole == pytest.approx(together, abs=1e-3)


def test_openings_are_no_wall_and_furniture_hides_what_is_behind() -> None:
    wall = WALLS[0]
    hole = (wall[:, 0] > 1.0) & (wall[:, 0] < 2.0) & (wall[:, 2] < 2.0)
    points = np.concatenate([FLOOR, wall[~hole], *WALLS[1:]])
    with_door = FoundRoom(ROOM.normal, ROOM.point, CORNERS, ceiling=2.5, openings=(DOOR,))
    assert shown(points, [ROOM]).walls < 0.97
    assert shown(points, [with_door]).walls == 1.0
    under = (FLOOR[:, 0] > 1.0) & (FLOOR[:, 0] < 2.5) & (FLOOR[:, 1] > 1.0) & (FLOOR[:, 1] < 2.0)
    assert shown(np.concatenate([FLOOR[~under], *WALLS]), [ROOM]).floor < 0.95
    # The top of a table hides the floor, however high it is.
    for height in (0.3, 0.42, 0.7, 0.75):
        table = sheet((1.0, 2.5), (1.0, 2.0), 2, height)
        assert shown(np.concatenate([FLOOR[~under], table, *WALLS]), [ROOM]).floor > 0.97
    # A lamp at the ceiling does not.
    lamp = sheet((1.0, 2.5), (1.0, 2.0), 2, 1.6)
    assert shown(np.concatenate([FLOOR[~under], lamp, *WALLS]), [ROOM]).floor < 0.95


def test_of_several_rooms_all_cells_count_alike() -> None:
    far = np.array([10.0, 0.0, 0.0])
    other = FoundRoom(ROOM.normal, CORNERS[0] + far, CORNERS + far, ceiling=2.5)
    found = shown(np.concatenate([FLOOR, *WALLS, FLOOR + far]), [ROOM, other])
    alone = shown(FLOOR, [ROOM])
    assert found.floor == 1.0
    assert found.walls == pytest.approx(0.5 * (1.0 + alone.walls), abs=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("row", "file", "more"),
    [
        ("ScanNet 0002_00", f"{DEV}/scannet_0002_00/scan.ply", {}),
        ("ScanNet 0470_00, low walls", f"{SCANNET}/scene0470_00_vh_clean_2.ply", {}),
        ("ARKit mesh of a lounge", f"{DEV}/arkit_lounge/textured.obj", {}),
        (
            "one RGB-D view, taken with `partial`",
            "sunrgbd_sample/sunrgbd_000017_infos.pkl",
            {"importer": "sunrgbd", "partial": True},
        ),
    ],
)
def test_what_is_said_of_captures_holds(
    real: Callable[[str], Path], row: str, file: str, more: dict[str, object]
) -> None:
    text = DOCS.read_text(encoding="utf-8")
    (said,) = (line for line in text.splitlines() if line.startswith(f"| {row} |"))
    wanted = [float(cell) for cell in said.split("|")[2:6]]
    layout = ScanLayout.model_validate({"from": "scan", "scan": str(real(file)), **more})
    scan = scanned(layout, Path(layout.file), Path("/")).found()
    points, rooms = scan.cloud.points, scan.composed
    found = shown(points, rooms)
    measured = [found.floor, found.walls, found.whole, rooms[0].measures["coverage"]]
    assert measured == pytest.approx(wanted, abs=0.011)
