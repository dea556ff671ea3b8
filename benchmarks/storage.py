"""Storage of views: bytes against the error that they bring, beside the noise of the render.

Reads finished renders in complete storage, or makes one of a generated room. For each family of
channels: its bytes in a view and its worst robust error in floats, in halves, by DWA at several
levels, and for hemispheres as spherical harmonics and Gaussians; then all of a view in both
profiles. Noise is the median over the family of the robust error that the render states.
"""

import math
import statistics
import tempfile
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any, Final

import click
import numpy as np

from benchmarks.report import publish, table
from benchmarks.scenes import orusd
from openrooms_usd.channels import definition
from openrooms_usd.geometry import spherical_harmonics
from openrooms_usd.geometry.hemisphere import HEMISPHERE, untiled
from openrooms_usd.render import exr
from openrooms_usd.render.contract import COMPACT, COMPLETE, Image, View
from openrooms_usd.render.estimates import robust_error
from openrooms_usd.render.reading import RenderedView, read_render
from openrooms_usd.render.restoring import sources_of
from openrooms_usd.render.run import write_view
from openrooms_usd.render.storage import Way, scale_of, storing

LEVELS: Final = (45, 200, 1000)
ORDERS: Final = (2, 4)
# A number of a fit as it is stored: in floats, and in halves.
_FLOAT: Final = 4
_HALF: Final = 2

Pixels = np.ndarray[Any, np.dtype[np.float32]]
Row = dict[str, Any]


@click.command(help=__doc__)
@click.argument("renders", nargs=-1, type=click.Path(path_type=Path))
@click.option("--quick", is_flag=True, help="A render of a few pixels.")
@click.option("--json", "target", type=click.Path(path_type=Path), help="Where to write numbers.")
def main(renders: tuple[Path, ...], quick: bool, target: Path | None) -> None:
    with tempfile.TemporaryDirectory() as folder:
        found = renders or (render_room(Path(folder), quick),)
        data = {f"room {n}": measure(path, Path(folder)) for n, path in enumerate(found, start=1)}
    parts = []
    for room, of in data.items():
        heads = ["family", "channels", "noise", *(k for k in of["families"][0] if "MB" in k)]
        rows = [_line(row, heads) for row in of["families"]]
        whole = table(["storage", "MB a view"], [list(row) for row in of["views"].items()])
        parts.append(
            f"{room}, {of['size']}, {of['lights']} lights\n\n{table(heads, rows)}\n\n{whole}"
        )
    publish("storage", data, "\n\n".join(parts), target)


def _line(row: Row, heads: list[str]) -> list[object]:
    """One row; bytes with the error beside them."""
    said: list[object] = [row[head] for head in heads[:3]]
    for head in heads[3:]:
        error = row.get(head.replace(" MB", ""))
        size = row.get(head)
        said.append(None if size is None else f"{size:.3g}" + (f" ({error:.1e})" if error else ""))
    return said


def render_room(folder: Path, quick: bool) -> Path:
    """A generated living room in complete storage, with all channels."""
    orusd("generate", "--type", "living_room", "--seed", 3, "-o", folder / "room")
    orusd("compose", folder / "room/room.yaml", "-o", folder / "composed")
    size = ("--resolution", "32x24", "--grid", "4x3", "--spp", 4) if quick else (
        "--resolution", "640x480", "--spp", 64)  # fmt: skip
    words = ("--camera", "view_1", "--channels", "all", *size)
    orusd("render", folder / "composed/scene.usda", "-o", folder / "render", *words)
    return folder / "render"


def measure(render: Path, folder: Path) -> Row:
    """What is measured of the first view of a render."""
    view = next(iter(read_render(render).views.values()))
    channels = dict(_channels(view))
    families = [_family(name, part, view, folder) for name, part in _families(channels).items()]
    sizes = {COMPLETE: _bytes(view.folder) / 1e6}
    images = {name: Image(pixels, 1, 0.0, 0.0) for name, pixels in channels.items()}
    seen = View(None, view.width, view.height, view.K, view.world_from_camera, 1.0, images)
    out = folder / COMPACT
    out.mkdir()
    write_view(out, seen, storing(seen, COMPACT))
    grid = view.grid("environment")
    lobes = 0 if grid is None else _HALF * 12 * 6 * grid.shape[0] * grid.shape[1]
    sizes[COMPACT] = (_bytes(out) + lobes) / 1e6
    return {
        "size": f"{view.width}x{view.height}", "lights": len(view.entry.lights),
        "families": families, "views": sizes,
    }  # fmt: skip


def _channels(view: RenderedView) -> Iterator[tuple[str, Pixels]]:
    yield from view.pixels.items()
    for name, lights in view.lights.items():
        yield from ((f"{name}_{number}", pixels) for number, pixels in lights.items())
    for name in view.entry.channels:
        if definition(name).scope == "grid":
            yield name, exr.read_picture(view.folder / f"{name}.exr")


def _families(channels: Mapping[str, Pixels]) -> dict[str, dict[str, Pixels]]:
    families: dict[str, dict[str, Pixels]] = {}
    for name, pixels in channels.items():
        row = definition(name)
        family = "left out" if sources_of(name) else name if row.scope == "grid" else row.kind
        each = ", each light" if row.scope == "light" and family == "light" else ""
        families.setdefault(f"{family}{each}", {})[name] = pixels
    return families


def _family(family: str, channels: dict[str, Pixels], view: RenderedView, folder: Path) -> Row:
    lossy = all(definition(name).kind in ("light", "derived") for name in channels)
    stated = (view.entry.channels[name].estimated_robust_error for name in channels)
    known = [error for error in stated if error]
    row: Row = {"family": family, "channels": len(channels)}
    row["noise"] = statistics.median(known) if known else None
    ways: dict[str, Callable[[str, Pixels], Way]] = {
        "float": lambda name, pixels: Way("", "zip", "float"),
        "half": lambda name, pixels: Way("", "zip", "half", scale_of(pixels)),
    }
    for level in LEVELS:
        ways[f"dwa {level}"] = lambda name, pixels, level=level: Way(  # type: ignore[misc]
            "", f"dwaa:{level}", "half", scale_of(pixels)
        )
    for head, way in ways.items():
        allowed = head == "float" or (lossy and "left" not in family)
        found = _written(channels, way, folder) if allowed else (None, None)
        row[f"{head} MB"], row[head] = found
    for head, found in _fits(family, channels, view).items():
        row[f"{head} MB"], row[head] = found
    return row


def _written(
    channels: dict[str, Pixels], way: Callable[[str, Pixels], Way], folder: Path
) -> tuple[float, float]:
    """Megabytes, and the worst error of a channel."""
    total, worst = 0, 0.0
    path = folder / "channel.exr"
    for name, pixels in channels.items():
        one = way(name, pixels)
        exr.write_channels(path, {name: one.rows(pixels)}, {name: one.sample}, one.compression)
        total += path.stat().st_size
        found = exr.read_channels(path)[name] / np.float32(one.scale)
        worst = max(worst, robust_error(found, pixels))
    return total / 1e6, worst


def _fits(
    family: str, channels: dict[str, Pixels], view: RenderedView
) -> dict[str, tuple[float | None, float | None]]:
    """Hemispheres as harmonics, in floats; and as the Gaussians that the render has."""
    found: dict[str, tuple[float | None, float | None]] = {}
    grid = untiled(channels[family]) if family in channels else None
    for order in ORDERS:
        found[f"SH {order}"] = (None, None)
        if grid is not None:
            numbers = spherical_harmonics.project(grid, HEMISPHERE, order)
            basis = spherical_harmonics.basis(HEMISPHERE.directions, order)
            back = np.einsum("...kc,ijk->...ijc", numbers, basis)
            found[f"SH {order}"] = _FLOAT * numbers.size / 1e6, robust_error(back, grid)
    lobes = view.fit("environment_sg") if family == "environment" else None
    found["12 SG"] = (None, None)
    if lobes is not None and grid is not None:
        from openrooms_usd.geometry import spherical_gaussians

        # Some points tell the error; of all, the pictures take gigabytes.
        step = max(1, math.isqrt(grid.shape[0] * grid.shape[1] // 400))
        some, true = lobes[::step, ::step], grid[::step, ::step]
        found["12 SG"] = (
            _FLOAT * lobes.size / 1e6, robust_error(spherical_gaussians.evaluate(some), true)
        )  # fmt: skip
    return found


def _bytes(folder: Path) -> int:
    return sum(path.stat().st_size for path in folder.rglob("*") if path.is_file())


if __name__ == "__main__":
    main()
