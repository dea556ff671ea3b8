"""Loading for training: views a second by form, channels and workers, beside size and what is lost.

One small dataset is rendered and written in every form. A row reads the same views in the same
order, as batches of PyTorch, after one round that lets workers start and the system cache files.
Errors are those of the stored channels against the complete EXR files: the root of the squared
difference over that of the channel.
"""

import json
import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any, Final, NamedTuple

import click
import numpy as np

from benchmarks.report import publish, table
from benchmarks.scenes import SMALL_ROOM, orusd
from openrooms_usd import loading
from openrooms_usd.errors import OrusdError
from openrooms_usd.loading.source import Shards

FEW: Final = ("radiance", "depth")
MANY: Final = (*FEW, "normal_camera", "base_color", "roughness", "semantic", "valid", "position")


# What Hypersim's files do not tell is left out there.
OF_HYPERSIM: Final = (*FEW, "normal_camera", "semantic_nyu40", "instance", "valid", "position")


class Form(NamedTuple):
    """A form of the dataset.

    Attributes:
        name: For people.
        folder: Where it lies.
        form: As sources call it; None: they find it.
        many: The channels of its second row.
    """

    name: str
    folder: str
    form: str | None = None
    many: tuple[str, ...] = MANY


FORMS: Final = (
    Form("dataset, complete", "complete"),
    Form("dataset, compact", "compact"),
    Form("WebDataset shards, compact", "compact/outputs/webdataset"),
    Form("OpenRooms, merged", "complete/outputs/openrooms", "openrooms"),
    Form("Hypersim, HDF5", "complete/outputs/hypersim", "hypersim", OF_HYPERSIM),
)
OUTPUTS: Final[dict[str, list[dict[str, Any]]]] = {
    "complete": [{"as": "openrooms", "layout": "merged", "crowded": "keep"}, {"as": "hypersim"}],
    "compact": [{"as": "webdataset", "shard_mb": 12}],
}
"""By storage, what else is written."""


@click.command(help=__doc__)
@click.option("--rooms", type=int, default=1, show_default=True)
@click.option("--views", type=int, default=6, show_default=True, help="Of each room.")
@click.option("--size", type=(int, int), default=(640, 480), show_default=True)
@click.option("--samples", type=int, default=4, show_default=True)
@click.option("--rounds", type=int, default=2, show_default=True, help="That are timed.")
@click.option("--workers", type=int, multiple=True, default=(0, 1, 2), show_default=True)
@click.option("--folder", type=click.Path(path_type=Path), help="Where the forms are, and stay.")
@click.option("--quick", is_flag=True, help="A small room.")
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
    made: dict[str, Any] = {"types": ["bathroom"], "count": rooms}
    if quick:
        made, views, size, rounds, workers = {"files": ["room.yaml"]}, 11, (32, 24), 1, (0,)
    wanted: dict[str, Any] = {
        "rooms": [made],
        "views": {"count": views, "resolution": list(size), "fov": 57.95},
        "budget": {"samples": samples},
    }
    with ExitStack() as stack:
        kept = folder or Path(stack.enter_context(tempfile.TemporaryDirectory()))
        kept.mkdir(parents=True, exist_ok=True)
        (kept / "room.yaml").write_text(SMALL_ROOM)
        rows = list(measure(kept, wanted, rounds, workers))
    heads = (
        "form",
        "MB a view",
        "channels",
        *(f"views/s, {n} workers" for n in workers),
        "processor ms a view",
        "error of radiance",
        "of depth",
    )
    cells = [
        (
            r["form"],
            r["MB_a_view"],
            r["channels"],
            *r["views_a_second"],
            r["processor_ms"],
            *r["errors"].values(),
        )
        for r in rows
    ]
    publish("loading", {"rows": rows}, table(heads, cells), target)


def measure(
    folder: Path, wanted: dict[str, Any], rounds: int, workers: Sequence[int]
) -> Iterator[dict[str, Any]]:
    """A row for every form and choice of channels."""
    for storage, outputs in OUTPUTS.items():
        if not (folder / storage).exists():
            _run(folder / storage, {**wanted, "storage": storage, "outputs": outputs})
    truth = loading.open_source(folder / FORMS[0].folder)
    for form in FORMS:
        source = loading.open_source(folder / form.folder, form=form.form)
        for channels in (FEW, form.many):
            yield {
                "form": form.name,
                "MB_a_view": _bytes(folder / form.folder) / len(source) / 1e6,
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
    began = time.process_time()
    for view in views_of(source, channels):
        loading.tensors_of(view)
    return 1000.0 * (time.process_time() - began) / len(source)


def error(source: Any, truth: Any, channel: str) -> float:
    """The root of the squared difference over that of the channel, over all views."""
    off = whole = 0.0
    pairs = zip(views_of(source, [channel]), views_of(truth, [channel]), strict=True)
    for here, there in pairs:
        exact = there.images[channel].astype(float)
        off += float(np.square(here.images[channel] - exact).sum())
        whole += float(np.square(exact).sum())
    return (off / whole) ** 0.5


def views_of(source: Any, channels: Sequence[str]) -> Iterator[loading.Sample]:
    """All views, in their order."""
    if isinstance(source, Shards):
        for name in source.names:
            yield from source.stream(name, channels)
    else:
        yield from (source.read(index, channels) for index in range(len(source)))


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
