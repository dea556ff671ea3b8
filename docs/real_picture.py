"""Draws ``docs/real.png``: plans that were found in real captures, over what is true of them.

The captures and their photographs are not ours to show: the picture has lines that were found and
traced, and renders of the rooms that were made. ``python -m docs.real_picture --data DIR`` runs
what ``benchmarks.real`` runs; ``--work`` takes what that left.
"""

import json
import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

import click
import numpy as np
from numpy.typing import NDArray

import openrooms_usd as ou
from benchmarks.real.captures import Capture, captures_of
from benchmarks.real.plans import PlanScore, hole_of, plan_score
from benchmarks.real.running import outcome_of
from benchmarks.real.truth import Hole
from benchmarks.scenes import ORUSD
from openrooms_usd.rendering.sheet import Tile, write_sheet
from openrooms_usd.scan.report.canvas import Canvas
from openrooms_usd.usd.shading.textures import read_codes

Bytes = NDArray[np.uint8]

SIZE: Final = (320, 240)
COLUMNS: Final = 3
TRUE, FOUND, GUESSED = (70, 170, 90), (20, 20, 20), (170, 170, 170)
SELECTED: Final = "\ncameras: {resolution: [640, 480], views: [{from: select, count: 1}]}\n"
HOLES: Final = {"door": (200, 90, 20), "window": (40, 110, 220), "opening": (150, 60, 170)}


def tile(capture: Capture, folder: Path) -> Tile:
    """The plan of a capture with its scores.

    Args:
        capture: Its truth.
        folder: The composed room.
    """
    rooms = json.loads((folder / "report.json").read_text(encoding="utf-8"))["layout"]["rooms"]
    found = plan_score(rooms, capture.truth)
    return f"{capture.name}\n{_words(found)}", plan(capture, rooms)


def _words(found: PlanScore) -> str:
    holes = found.openings.typed if found.openings else None
    said = f"IoU {found.iou:.2f}, {found.corners.hits} of {found.corners.true} corners"
    return said + (f", {holes.hits} of {holes.true} openings" if holes else "")


def plan(capture: Capture, rooms: Sequence[dict[str, Any]]) -> Bytes:
    """(H, W, 3) true outlines in green, found walls in black, guessed ones in grey, openings."""
    frame = capture.truth.frame
    assert frame is not None
    plans = [frame.plan(room["corners"])[:, :2] for room in rooms]
    outlines = [room.outlines[0] for room in capture.truth.rooms]
    every = np.concatenate([plans[0], *outlines])
    middle, half = 0.5 * (every.min(axis=0) + every.max(axis=0)), 0.5 * np.ptp(every, axis=0) + 0.4
    half = np.maximum(half, half[::-1] * np.array([SIZE[0] / SIZE[1], SIZE[1] / SIZE[0]]))
    canvas = Canvas.over(middle - half, middle + half, max(SIZE), 1e3)
    for outline in outlines:
        canvas.ring(outline, TRUE, 7)
    for corners, room in zip(plans, rooms, strict=True):
        guessed = set(room.get("guessed_walls", ()))
        for wall, (start, end) in enumerate(zip(corners, np.roll(corners, -1, 0), strict=True)):
            canvas.line(start, end, GUESSED if wall in guessed else FOUND, 2)
        for hole in room["openings"]:
            _draw(canvas, hole_of(hole, frame), 6)
    for true in capture.truth.rooms:
        for opening in true.openings or ():
            _draw(canvas, opening, 2, inner=True)
    return _cut(canvas.pixels)


def _draw(canvas: Canvas, hole: Hole, width: float, *, inner: bool = False) -> None:
    """A found opening as a bar, a true one as a thin line of light in it."""
    color = (255, 255, 255) if inner else HOLES[hole.type]
    canvas.line(np.array(hole.ends[0]), np.array(hole.ends[1]), color, width)


def _cut(pixels: Bytes) -> Bytes:
    """Exactly as large as a tile."""
    sheet = np.full((SIZE[1], SIZE[0], 3), 255, np.uint8)
    part = pixels[: SIZE[1], : SIZE[0]]
    sheet[: part.shape[0], : part.shape[1]] = part
    return sheet


def picture(folder: Path, samples: int) -> Bytes:
    """(H, W, 3) the best view of a composed room: photographs lean, and stand too near."""
    home, target = folder.parent / "room", folder.parent / "picture"
    described = (home / "room.yaml").read_text(encoding="utf-8").partition("\ncameras:")[0]
    (home / "pictured.yaml").write_text(described + SELECTED, encoding="utf-8")
    scene = ou.compose(home / "pictured.yaml", folder)
    view = next(iter(ou.render(scene, target, resolution=SIZE, samples=samples, denoise=True)))
    pixels = read_codes(str(target / view / "denoised.png"))
    assert pixels is not None
    return pixels


@click.command()
@click.option("--data", "folders", multiple=True, required=True, type=click.Path(path_type=Path))
@click.option("--only", multiple=True, metavar="CAPTURE", help="This capture alone; repeated.")
@click.option("--work", required=True, type=click.Path(path_type=Path))
@click.option("--tool", help="Another version of the orusd command.")
@click.option("--reuse", is_flag=True, help="Take what is in --work.")
@click.option("-o", "--out", type=click.Path(path_type=Path), default=Path("docs/real.png"))
@click.option("--spp", type=int, default=64, show_default=True)
def main(
    folders: tuple[Path, ...],
    only: tuple[str, ...],
    work: Path,
    tool: str | None,
    reuse: bool,
    out: Path,
    spp: int,
) -> None:
    """Draw the picture."""
    plans: list[Tile] = []
    renders: list[Tile] = []
    command = shlex.split(tool) if tool else list(ORUSD)
    for capture in (one for folder in folders for one in captures_of(folder, only, False)):
        # What was told of its axis and photographs is the last run.
        run = next((one for one in capture.runs if one.name == "told"), capture.runs[0])
        place = work.resolve() / capture.name / run.name.replace(" ", "_")
        outcome = outcome_of(run, place, command, 900.0, reuse)
        if capture.truth.frame is None or outcome.refusal is not None:
            continue
        plans.append(tile(capture, outcome.folder))
        renders.append(("", picture(outcome.folder, spp)))
    rows = []
    for first in range(0, len(plans), COLUMNS):
        rows += [plans[first : first + COLUMNS], renders[first : first + COLUMNS]]
    write_sheet(out, rows)


if __name__ == "__main__":
    main()
