"""Other people's stages: whether each gives a picture or one sentence, how soon, and how they look.

Folders of USD files are walked, such as checkouts of the asset working group's samples or of
OpenUSD's own tests. Every file with something to draw is rendered by the command in a process of
its own, which is ended after a while. Two tables and contact sheets come out; the error beside the
seconds is for people to see: pictures are looked at.
"""

import multiprocessing
import os
import sys
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from multiprocessing.connection import wait
from pathlib import Path
from typing import Any, Final

import click
import numpy as np
from numpy.typing import NDArray

from benchmarks.report import publish, table
from openrooms_usd import imagefile
from openrooms_usd.lettering import lettered, stamp
from openrooms_usd.usd.textures import read_texture

_SUFFIXES: Final = (".usd", ".usda", ".usdc", ".usdz")
# What a picture, one sentence and a failure of ours end with.
_OUTCOMES: Final = {0: "picture", 2: "one sentence", None: "out of time"}
_CELL: Final = (160, 120)
_ACROSS, _DOWN, _WORDS = 8, 8, 16
_PRELOADED: Final = ["openrooms_usd.render.run", "orusd_mitsuba"]


@dataclass(frozen=True)
class Ended:
    """What became of one file.

    Attributes:
        file: Its path, from its folder.
        outcome: ``picture``, ``one sentence``, ``out of time`` or ``failure``.
        seconds: From the start of the process.
        said: The last that the command said.
    """

    file: str
    outcome: str
    seconds: float
    said: str


def has_something_to_draw(file: str) -> bool:
    """Whether a stage has any shape or light; also where it cannot be opened."""
    from pxr import Tf, Usd, UsdGeom, UsdLux

    try:
        stage = Usd.Stage.Open(file)
    except Tf.ErrorException:
        return True
    return any(
        prim.IsA(UsdGeom.Gprim) or prim.HasAPI(UsdLux.LightAPI)
        for prim in stage.Traverse(Usd.TraverseInstanceProxies())
    )


def render(file: str, out: str, words: tuple[str, ...]) -> None:
    """Run the command on one file, quietly; a process of its own calls this."""
    from openrooms_usd.cli import main

    Path(out).mkdir(parents=True, exist_ok=True)
    said = os.open(f"{out}.txt", os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
    os.dup2(said, 1)
    os.dup2(said, 2)
    if not has_something_to_draw(file):
        os._exit(100)
    sys.argv = ["orusd", "render", file, "-o", f"{out}/render", *words]
    main()


def run(
    files: list[tuple[Path, str]], out: Path, words: tuple[str, ...], limit: float, workers: int
) -> Iterator[Ended]:
    """Render files, some at once.

    Args:
        files: Each with its name.
        out: A folder for each of them comes here.
        words: Further words of the command.
        limit: Seconds for each.
        workers: How many at once.
    """
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(_PRELOADED)
    waiting, running = list(reversed(files)), dict[Any, tuple[Any, str, float]]()
    while waiting or running:
        while waiting and len(running) < workers:
            file, name = waiting.pop()
            process = context.Process(
                target=render, args=(str(file), str(out / name.replace("/", "__")), words)
            )
            process.start()
            running[process.sentinel] = process, name, time.perf_counter()
        for ended in wait(list(running), timeout=0.2):
            process, name, began = running.pop(ended)
            process.join()
            if process.exitcode != 100:
                yield _ended(out, name, process.exitcode, time.perf_counter() - began)
        for sentinel, (process, name, began) in list(running.items()):
            if time.perf_counter() - began > limit:
                process.kill()
                process.join()
                del running[sentinel]
                yield _ended(out, name, None, limit)


def _ended(out: Path, name: str, code: int | None, seconds: float) -> Ended:
    said = (out / f"{name.replace('/', '__')}.txt").read_text(errors="replace").strip()
    outcome = _OUTCOMES.get(code, "failure")
    if outcome == "one sentence" and not said.startswith(("error:", "warning:", "note:")):
        outcome = "failure"
    return Ended(name, outcome, seconds, said[-300:])


def sheets(out: Path, names: list[str]) -> Iterator[Path]:
    """Contact sheets of the first view of each render."""
    wide, high = _CELL
    for start in range(0, len(names), _ACROSS * _DOWN):
        shown_here = names[start : start + _ACROSS * _DOWN]
        rows = -(-len(shown_here) // _ACROSS)
        page = np.full((rows * (high + _WORDS), _ACROSS * wide, 3), 32, np.uint8)
        for number, name in enumerate(shown_here):
            row, column = divmod(number, _ACROSS)
            top, left = row * (high + _WORDS), column * wide
            picture = _first_view(out / name.replace("/", "__") / "render")
            if picture is not None:
                shown = picture[:high, :wide]
                page[top : top + shown.shape[0], left : left + shown.shape[1]] = shown
            stamp(page, lettered(name[-26:], 10), left + 2, top + high + 1, (255.0, 255.0, 0.0))
        target = out / f"sheet_{start // (_ACROSS * _DOWN) + 1:02d}.png"
        imagefile.write_png(target, page)
        yield target


def _first_view(render: Path) -> NDArray[np.uint8] | None:
    for file in sorted(render.glob("*/radiance.png")):
        return np.round(255.0 * read_texture(str(file))[..., :3]).astype(np.uint8)
    return None


@click.command()
@click.argument("folders", nargs=-1, required=True, type=click.Path(exists=True, path_type=Path))
@click.option("-o", "--out", type=click.Path(path_type=Path), default=Path("out/public_stages"))
@click.option("--limit", type=float, default=90.0, show_default=True, help="Seconds a file.")
@click.option("--workers", type=int, default=2, show_default=True)
@click.option("--spp", type=int, default=16, show_default=True)
@click.option("--json", "target", type=click.Path(path_type=Path), default=None)
def main(
    folders: tuple[Path, ...], out: Path, limit: float, workers: int, spp: int, target: Path | None
) -> None:
    """Render every stage below FOLDERS that has something to draw."""
    out.mkdir(parents=True, exist_ok=True)
    files = [
        (file, f"{folder.name}/{file.relative_to(folder).as_posix()}")
        for folder in folders
        for file in sorted(folder.rglob("*"))
        if file.suffix.lower() in _SUFFIXES and file.is_file()
    ]
    words = "--resolution", f"{_CELL[0]}x{_CELL[1]}", "--spp", str(spp)
    found = []
    for one in run(files, out.absolute(), words, limit, workers):
        found.append(one)
        if one.outcome in ("failure", "out of time"):
            click.echo(f"{one.outcome}: {one.file}: {one.said}", err=True)
    found.sort(key=lambda one: one.file)
    pages = list(sheets(out, [one.file for one in found if one.outcome == "picture"]))
    click.echo(f"{len(pages)} contact sheets in {out}", err=True)
    publish("public_stages", {"files": [asdict(one) for one in found]}, _table(found), target)


def _table(found: list[Ended]) -> str:
    kinds = ("picture", "one sentence", "out of time", "failure")
    rows = []
    for folder in dict.fromkeys(one.file.split("/")[0] for one in found):
        own = [one for one in found if one.file.startswith(f"{folder}/")]
        counts = Counter(one.outcome for one in own)
        slowest = max(one.seconds for one in own)
        rows.append([folder, len(own), *(counts[kind] for kind in kinds), slowest])
    return table(("of", "files", *kinds, "longest, s"), rows)


if __name__ == "__main__":
    main()
