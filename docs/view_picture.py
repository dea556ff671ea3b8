"""Rooms in the browser, as it shows them: ``view.png``, ``lamps.png`` and ``traced.png``."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from benchmarks.scenes import orusd
from openrooms_usd.view.room import room_app
from openrooms_usd.view.server import serving
from tests.chromium import Page, opened

SIZE = (1180, 760)
KITCHEN = ("kitchen", 5)
TEXEL, PATHS = 0.06, 512


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
        orusd("compose", "openrooms_usd/demo/room.yaml", "-o", example / "out")
        orusd("bake", example / "out/scene.usda", "-o", example / "lit", "--texel", TEXEL,
              "--spp", PATHS, "--method", "cache")  # fmt: skip
    scratch = folder / "chromium"
    with _page(kitchen / "out/scene.usda", scratch) as page:
        page.click_on("#overview")
        page.evaluate(
            "document.querySelectorAll('#doors input').forEach(one => {"
            "one.value = one.max; one.dispatchEvent(new Event('input'))})"
        )
        page.evaluate("document.querySelectorAll('#doors details').forEach(one => one.open = true)")
        page.evaluate("document.getElementById('doors').scrollIntoView()")
        _take(page, target / "view.png")
    with _page(example / "lit/baked.usda", scratch) as page:
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


@contextmanager
def _page(stage: Path, scratch: Path) -> Iterator[Page]:
    """The page of a stage in a browser, while a block runs."""
    with (
        serving(room_app(stage, include_outside=True)) as server,
        opened(server.address, scratch, webgl=True, size=SIZE) as page,
    ):
        page.wait("document.body.dataset.ready == 'yes'", 60.0)
        yield page


def _take(page: Page, target: Path) -> None:
    page.evaluate("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")
    page.screenshot(target)
