"""How much real captures show of their rooms is what the documentation says."""

from collections.abc import Callable
from pathlib import Path

import pytest

from openrooms_usd.description.layout import ScanLayout
from openrooms_usd.scan.shown import shown
from openrooms_usd.stages.layout.scanned import scanned

DOCS = Path(__file__).parents[2] / "docs/datasets.md"
DEV = "real_dev/data"
SCANNET = "scan2cad_scene0470_00/Assets/scannet-sample/scene0470_00"


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
