"""Rooms in the browser: ``view.png``, ``lamps.png``, ``traced.png`` and ``times.jpg``."""

import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from OpenImageIO import ROI, ImageBuf, ImageBufAlgo, ImageSpec

from benchmarks.scenes import orusd
from openrooms_usd.view.room import room_app
from openrooms_usd.view.server import serving
from tests.chromium import Page, opened

SIZE = (1180, 760)
# What the panel takes of it, and one picture of a strip.
PANEL_PX = 340
PART = (300, 271)
KITCHEN = ("kitchen", 5)
TEXEL, PATHS, PATHS_OF_A_TIME = 0.06, 512, 256
EXAMPLE = Path("openrooms_usd/demo")
# The example's own sky is a picture; these are of its garden.
TIMES = {"morning": "08:30", "noon": "13:00", "evening": "20:15"}
OUTSIDE = (
    "{{from: outside, scene: garden, near: false, latitude: 50, longitude: 10, utc_offset: 2, "
    'date: 2026-06-21, time: "{time}"}}'
)


def draw(folder: Path, target: Path) -> None:
    """Compose a kitchen and the example, bake the example, and take pictures of their pages.

    Args:
        folder: For what is made on the way.
        target: The folder of the pictures.
    """
    kitchen, example = folder / "view_kitchen", folder / "view_example"
    if not (kitchen / "out/scene.usda").is_file():
        orusd("generate", "--type", KITCHEN[0], "--seed", KITCHEN[1], "-o", kitchen)
        orusd("compose", kitchen / "room.yaml", "-o", kitchen / "out")
    if not (example / "lit/baked.usda").is_file():
        orusd("compose", EXAMPLE / "room.yaml", "-o", example / "out")
        _bake(example / "out", example / "lit")
    with _page(kitchen / "out/scene.usda") as page:
        page.click_on("#overview")
        page.evaluate(
            "document.querySelectorAll('#doors input').forEach(one => {"
            "one.value = one.max; one.dispatchEvent(new Event('input'))})"
        )
        page.evaluate("document.querySelectorAll('#doors details').forEach(one => one.open = true)")
        page.evaluate("document.getElementById('doors').scrollIntoView()")
        _take(page, target / "view.png")
    with _page(example / "out/scene.usda", [example / "lit"]) as page:
        for window in ("door_0", "window_0", "window_1", "elsewhere"):
            page.evaluate(
                f"document.getElementById('share-{window}').value = 0.02;"
                f"document.getElementById('share-{window}').dispatchEvent(new Event('input'))"
            )
        page.evaluate("document.getElementById('meter').click()")
        page.evaluate("document.getElementById('lamps').scrollIntoView()")
        _take(page, target / "lamps.png")
        page.click_on("#trace")
        page.wait("document.body.dataset.traced == 1", 300.0)
        _take(page, target / "traced.png")
    _draw_times(folder / "view_times", target / "times.jpg")


def _draw_times(folder: Path, target: Path) -> None:
    """The example at three times of a day, beside each other, each as the exposure fits."""
    folder.mkdir(exist_ok=True)
    text = (EXAMPLE / "room.yaml").read_text()
    out = folder / "out"
    for name, time in TIMES.items():
        if not (folder / name / "baked.usda").is_file():
            sky = f"environment: {OUTSIDE.format(time=time)}"
            (folder / "room.yaml").write_text(re.sub("environment: {from: file.*", sky, text))
            orusd("compose", folder / "room.yaml", "-o", out)
            _bake(out, folder / name, PATHS_OF_A_TIME)
        # One inside the other, so that its sky may be shown.
        out = out / "later"
    lit = [folder / name for name in TIMES]
    strip = ImageBuf(ImageSpec(PART[0] * len(TIMES), PART[1], 3, "uint8"))
    with _page(folder / "out/scene.usda", lit) as page:
        page.click_on("#camera-sitting")
        for number in range(len(TIMES)):
            page.evaluate(
                f"import('orusd/panel.js').then(panel => panel.slide('time', {number}))"
                ".then(() => document.getElementById('meter').click())"
            )
            _take(page, folder / "time.png")
            seen = ImageBuf(str(folder / "time.png"))
            room = ROI(0, SIZE[0] - PANEL_PX, 0, SIZE[1], 0, 1, 0, 3)
            seen = ImageBufAlgo.cut(seen, room)
            seen = ImageBufAlgo.resize(seen, roi=ROI(0, PART[0], 0, PART[1], 0, 1, 0, 3))
            ImageBufAlgo.paste(strip, PART[0] * number, 0, 0, 0, seen)
    strip.write(str(target))


def _bake(out: Path, lit: Path, paths: int = PATHS) -> None:
    orusd(
        "bake", out / "scene.usda", "-o", lit, "--texel", TEXEL, "--spp", paths, "--method", "cache"
    )


@contextmanager
def _page(stage: Path, light: Sequence[Path] = ()) -> Iterator[Page]:
    """The page of a stage in a browser, while a block runs."""
    with (
        serving(room_app(stage, light=light)) as server,
        opened(server.address, webgl=True, size=SIZE) as page,
    ):
        page.wait("document.body.dataset.ready == 'yes'", 60.0)
        yield page


def _take(page: Page, target: Path) -> None:
    page.evaluate("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")
    page.screenshot(target)
