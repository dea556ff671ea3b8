"""Loading for training: views a second by form, channels and workers, beside size and what is lost.

One small dataset is rendered and written in every form. A row reads the same views in the same
order, as batches of PyTorch, after one round that lets workers start and the system cache files.
Errors are those of the stored channels against the complete EXR files: the root of the squared
difference over that of the channel.
"""

import json
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any, Final, NamedTuple

import click
import numpy as np

from benchmarks.report import publish, table
from benchmarks.scenes import orusd
from openrooms_usd import loading
from openrooms_usd.errors import OrusdError

FEW: Final = ("radiance", "depth")
MANY: Final = (*FEW, "normal_camera", "base_color", "roughness", "semantic", "valid", "position")


class Form(NamedTuple):
    """A form of the dataset, and how it is made of the complete one."""

    name: str
    form: str | None
    make: Callable[[Path, Path, dict[str, Any]], Path]


def complete(out: Path, renders: Path, wanted: dict[str, Any]) -> Path:
    return _run(out, {**wanted, "storage": "complete"})


def compact(out: Path, renders: Path, wanted: dict[str, Any]) -> Path:
    return _run(out, {**wanted, "storage": "compact"})


def openrooms(out: Path, renders: Path, wanted: dict[str, Any]) -> Path:
    for number, render in enumerate(sorted((renders / "renders").glob("*/*"))):
        words = ("--scene", f"scene{number:04d}_00", "--layout", "merged", "--crowded", "keep")
        orusd("dataset", "write", render, "-o", out, "--as", "openrooms", *words)
    return out


FORMS: Final = (
    Form("dataset, complete", None, complete),
    Form("dataset, compact", None, compact),
    Form("OpenRooms, merged", "openrooms", openrooms),
)


@click.command(help=__doc__)
@click.option("--rooms", type=int, default=1, show_default=True)
@click.option("--views", type=int, default=6, show_default=True, help="Of each room.")
@click.option("--size", type=(int, int), default=(640, 480), show_default=True)
@click.option("--samples", type=int, default=4, show_default=True)
@click.option("--rounds", type=int, default=2, show_default=True, help="That are timed.")
@click.option("--workers", type=int, multiple=True, default=(0, 1, 2), show_default=True)
@click.option("--folder", type=click.Path(path_type=Path), help="Where the forms are, and stay.")
@click.option("--quick", is_flag=True, help="One small room.")
@click.option("--json", "target", type=click.Path(path_type=Path), help="Where to write numbers.")
def main(
    rooms: int,
    views: int,
    size: tuple[int, int],
    samples: int,
    rounds: int,
    workers: tuple[int, ...],
    folder: Path | None,
    quick: bool,
    target: Path | None,
) -> None:
    if quick:
        rooms, views, size, rounds, workers = 1, 2, (64, 48), 1, (0,)
    wanted: dict[str, Any] = {
        "rooms": [{"types": ["bathroom"], "count": rooms}],
        "views": {"count": views, "resolution": list(size), "fov": 57.95},
        "budget": {"samples": samples},
    }
    with ExitStack() as stack:
        kept = folder or Path(stack.enter_context(tempfile.TemporaryDirectory()))
        rows = list(measure(kept, wanted, rounds, workers))
    heads = ("form", "MB a view", "channels", *(f"views/s, {n} workers" for n in workers),
             "processor ms a view", "error of radiance", "of depth")  # fmt: skip
    cells = [
        (r["form"], r["MB_a_view"], r["channels"], *r["views_a_second"], r["processor_ms"],
         *r["errors"].values())
        for r in rows
    ]  # fmt: skip
    publish("loading", {"rows": rows}, table(heads, cells), target)


def measure(
    folder: Path, wanted: dict[str, Any], rounds: int, workers: Sequence[int]
) -> Iterator[dict[str, Any]]:
    """A row for every form and choice of channels."""
    first: Path | None = None
    for name, form, make in FORMS:
        there = folder / name.replace(", ", "_").replace(" ", "_")
        root = there if there.exists() else make(there, first or there, wanted)
        source = loading.open_source(root, form=form)
        first = first or root
        truth = loading.open_source(first)
        for channels in (FEW, MANY):
            yield {
                "form": name,
                "MB_a_view": _bytes(root) / len(source) / 1e6,
                "channels": len(channels),
                "views_a_second": [speed(source, channels, rounds, n) for n in workers],
                "processor_ms": processor_ms(source, channels),
                "errors": {one: error(source, truth, one) for one in FEW},
            }


def speed(source: Any, channels: Sequence[str], rounds: int, workers: int) -> float:
    """Views a second, by the clock."""
    views = loading.loader(source, channels, batch=2, workers=workers, shuffle=False, start="fork")
    for _ in views:
        pass
    began = time.perf_counter()
    for _ in range(rounds):
        for _ in views:
            pass
    return rounds * len(source) / (time.perf_counter() - began)


def processor_ms(source: Any, channels: Sequence[str]) -> float:
    """Milliseconds of processor for a view as tensors."""
    views = loading.ViewDataset(source, channels)
    began = time.process_time()
    for index in range(len(views)):
        views[index]
    return 1000.0 * (time.process_time() - began) / len(views)


def error(source: Any, truth: Any, channel: str) -> float:
    """The root of the squared difference over that of the channel, over all views."""
    off = whole = 0.0
    for index in range(len(truth)):
        here, there = (s.read(index, [channel]).images[channel] for s in (source, truth))
        off += float(np.square(here.astype(float) - there).sum())
        whole += float(np.square(there.astype(float)).sum())
    return (off / whole) ** 0.5


def _run(out: Path, wanted: dict[str, Any]) -> Path:
    file = out.with_suffix(".yaml")
    file.write_text(json.dumps(wanted))  # JSON is YAML
    orusd("dataset", "run", file, "-o", out)
    return out


def _bytes(root: Path) -> int:
    """Of what is read: not of pictures for people, scenes and records."""
    below = root / "renders" if (root / "renders").is_dir() else root
    return sum(p.stat().st_size for p in below.rglob("*") if p.is_file())


if __name__ == "__main__":
    try:
        main()
    except OrusdError as told:
        raise SystemExit(str(told)) from told
