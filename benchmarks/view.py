"""A room in the browser: seconds to its first picture, what is sent, memory, and what is drawn.

Chromium draws in software here, so that times say what the way to the picture costs, and frames a
second nothing of any graphics unit.
"""

import json
import tempfile
import time
from pathlib import Path
from typing import Any

import click

from benchmarks.report import publish, table
from benchmarks.scenes import demo_stage, orusd
from openrooms_usd.view.room import room_app
from openrooms_usd.view.server import serving
from tests.chromium import opened

SIZE = (1180, 760)
_DRAWN = "new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))"
_SAID = """(() => {
  const room = document.getElementById('view').room;
  return {...room.surfaces.sizes,
    sent: performance.getEntriesByType('resource').reduce((sum, one) => sum + one.transferSize, 0),
    heap: performance.memory.usedJSHeapSize};
})()"""


@click.command(help=__doc__)
@click.option("--stage", "stages", type=click.Path(path_type=Path), multiple=True,
              help="By default the bundled example and a generated kitchen.")  # fmt: skip
@click.option("--quick", is_flag=True, help="The example only.")
@click.option("--json", "target", type=click.Path(path_type=Path), help="Where to write numbers.")
def main(stages: tuple[Path, ...], quick: bool, target: Path | None) -> None:
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        if not stages:
            stages = (demo_stage(place),) if quick else (demo_stage(place), kitchen(place))
        rows = [{"room": called(stage), **measure(stage)} for stage in stages]
    titles = ("room", "first picture s", "MB sent", "MB heap", "triangles", "calls", "textures",
              "million texels", "ms a picture, software")  # fmt: skip
    markdown = table(titles, [list(row.values()) for row in rows])
    publish("view", {"window": list(SIZE), "rows": rows}, markdown, target)


def called(stage: Path) -> str:
    """The name of a room's folder."""
    folder = stage.absolute().parent
    return folder.parent.name if folder.name == "out" else folder.name


def kitchen(folder: Path) -> Path:
    """A generated kitchen with all that lies about."""
    orusd("generate", "--type", "kitchen", "--seed", 5, "-o", folder / "kitchen")
    orusd("compose", folder / "kitchen/room.yaml", "-o", folder / "kitchen/out")
    return folder / "kitchen/out/scene.usda"


def measure(stage: Path) -> dict[str, Any]:
    """One room, from asking for the page until its picture is drawn, and what it took."""
    with (
        serving(room_app(stage, include_outside=True)) as server,
        opened("about:blank", webgl=True, size=SIZE) as page,
    ):
        began = time.perf_counter()
        page.evaluate(f"location.href = {json.dumps(server.address)}")
        page.wait("document.body?.dataset.ready == 'yes'", 120.0)
        page.evaluate(_DRAWN)
        seconds = time.perf_counter() - began
        said = page.evaluate(_SAID)
        picture = page.evaluate(
            "(() => {const room = document.getElementById('view').room, start = performance.now();"
            "for (let k = 0; k < 3; k += 1) room.codes(840, 760);"
            "return (performance.now() - start) / 3})()"
        )
    return {
        "first_s": seconds, "sent_MB": said["sent"] / 1e6, "heap_MB": said["heap"] / 1e6,
        "triangles": said["triangles"], "calls": said["calls"], "textures": said["textures"],
        "texels_M": said["texels"] / 1e6, "picture_ms": picture,
    }  # fmt: skip


if __name__ == "__main__":
    main()
