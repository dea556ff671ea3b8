"""Seconds from the start of the process to a written 640x480 picture of one sample a pixel.

The first run has no cache of compiled kernels, the second finds that of the first.
"""

import os
import tempfile
import time
from pathlib import Path
from typing import Final

import click

from benchmarks.report import publish, table
from benchmarks.scenes import demo_stage, orusd
from openrooms_usd.description.rendering import RenderSettings
from openrooms_usd.errors import RenderError
from openrooms_usd.rendering.opening import open_for_rendering

VARIANTS: Final = ("cuda", "llvm", "scalar")


@click.command(help=__doc__)
@click.option("--stage", type=click.Path(path_type=Path), help="By default the bundled example.")
@click.option("--camera", help="By default the stage's first.")
@click.option("--variant", "variants", multiple=True, type=click.Choice(VARIANTS))
@click.option("--quick", is_flag=True, help="64x48; the scalar backend unless another is named.")
@click.option("--json", "target", type=click.Path(path_type=Path), help="Where to write numbers.")
def main(
    stage: Path | None,
    camera: str | None,
    variants: tuple[str, ...],
    quick: bool,
    target: Path | None,
) -> None:
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        scene = stage or demo_stage(place)
        shown = ("--camera", camera) if camera else first_camera(scene)
        size = "64x48" if quick else "640x480"
        rows = [
            {"backend": variant, "first_s": first, "again_s": again}
            for variant in (variants or (("scalar",) if quick else usable(scene)))
            for first, again in [measure(place / variant, scene, shown, size, variant)]
        ]
    markdown = table(("backend", "first s", "again s"), [list(row.values()) for row in rows])
    publish("first_picture", {"resolution": size, "rows": rows}, markdown, target)


def usable(stage: Path) -> tuple[str, ...]:
    """The backends that can open the stage here, the fastest first."""
    return tuple(variant for variant in VARIANTS if _opens(stage, variant))


def _opens(stage: Path, variant: str) -> bool:
    try:
        open_for_rendering(stage, RenderSettings(options={"variant": variant}))
    except RenderError:
        return False
    return True


def first_camera(stage: Path) -> tuple[str, ...]:
    """The option that chooses the stage's first camera; nothing where it has none."""
    from openrooms_usd.usd.cameras import list_cameras
    from openrooms_usd.usd.files.layers import open_stage

    paths = [str(prim.GetPath()) for prim in list_cameras(open_stage(stage))]
    return ("--camera", paths[0]) if paths else ()


def measure(
    folder: Path, stage: Path, camera: tuple[str, ...], size: str, variant: str
) -> tuple[float, float]:
    """Two runs that share a home of their own, where kernels are cached."""
    home = folder / "home"
    home.mkdir(parents=True)
    seconds = []
    for name in ("first", "again"):
        words = (*camera, "--resolution", size, "--spp", 1, "--variant", variant)
        began = time.perf_counter()
        orusd(
            *("render", stage, "-o", folder / name, "--channels", "radiance", *words),
            env={**os.environ, "HOME": str(home)},
        )
        seconds.append(time.perf_counter() - began)
    return seconds[0], seconds[1]


if __name__ == "__main__":
    main()
