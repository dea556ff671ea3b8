"""A minute of somebody who corrects a plan in the browser: ``docs/plan.webm``.

The plan of a simulated scan is spoiled first: a corner and a wall stand elsewhere, no opening is
left, and the room is too high. Then real mouse events put it right.
"""

from pathlib import Path
from typing import Final

import numpy as np
import OpenImageIO

import openrooms_usd as ou
from docs.plan_picture import scanned_room
from openrooms_usd.building.shell import Hole
from openrooms_usd.description.layout import Opening
from openrooms_usd.rendering.paths.video import Encoder, writing
from openrooms_usd.view.plan.corners import move_corner, move_wall
from openrooms_usd.view.plan.document import Document
from openrooms_usd.view.plan.drawing import Drawing
from openrooms_usd.view.plan.fittings import hole_in, remove_opening, set_height
from openrooms_usd.view.plan.session import Session
from openrooms_usd.view.server import serving
from tests.chromium import Page, opened

Place = tuple[float, float]

SIZE: Final = (1120, 720)
RATE: Final = 8
# Little moves: a picture that stands for itself is needed only now and then.
_WHOLE: Final = 160
# The mouse is not in pictures of a page: an arrow follows it.
_ARROW: Final = """
const arrow = document.createElement("div");
arrow.style.cssText = "position:fixed;z-index:9;pointer-events:none;width:0;height:0;left:0;top:0;"
  + "border:9px solid transparent;border-top-color:#d00;border-left-color:#d00";
document.body.append(arrow);
addEventListener("pointermove", (e) => {
  arrow.style.left = `${e.clientX}px`; arrow.style.top = `${e.clientY}px`;
}, true);
"""


class Hand:
    """Moves the mouse as slowly as people do, and films it."""

    def __init__(self, page: Page, film: Encoder, folder: Path) -> None:
        self._page, self._film, self._still = page, film, folder / "frame.png"
        self._at: Place = (SIZE[0] / 2, SIZE[1] / 2)

    def rest(self, seconds: float) -> None:
        """Look for a while."""
        self._page.screenshot(self._still)
        read = np.asarray(OpenImageIO.ImageBuf(str(self._still)).get_pixels(OpenImageIO.UINT8))
        for _ in range(round(seconds * RATE)):
            self._film.add(np.ascontiguousarray(read[..., :3]))

    def go(self, to: Place, seconds: float = 1.4) -> None:
        """Move to a place."""
        steps = max(2, round(seconds * RATE))
        start = np.array(self._at)
        for step in range(1, steps + 1):
            # Slow at both ends.
            share = 0.5 - 0.5 * np.cos(np.pi * step / steps)
            x, y = start + share * (np.array(to) - start)
            self._page.page.mouse.move(float(x), float(y))
            self.rest(1 / RATE)
        self._at = to

    def click(self, to: Place) -> None:
        """Go there and click."""
        self.go(to)
        self._page.click(*to)
        self.rest(1.6)

    def drag(self, start: Place, end: Place) -> None:
        """Go to the one and drag it to the other."""
        self.go(start)
        self._page.page.mouse.down()
        self.go(end, 2.2)
        self._page.page.mouse.up()
        self.rest(1.6)


def draw(folder: Path, kind: str, seed: int, target: Path) -> None:
    """Film how a spoiled plan becomes right again, and see that it composes.

    Args:
        folder: For what is made on the way.
        kind: The type of the room.
        seed: Of the room.
        target: The film.
    """
    file = scanned_room(folder, kind, seed, "film")
    right = Document(file).under.found["0"]
    corner = 2
    Document(file).save(_spoiled(right, corner))
    session = Session(file)
    with (
        serving(session.app()) as server,
        opened(server.address, size=SIZE) as page,
        writing(target, SIZE, RATE, whole=_WHOLE) as film,
    ):
        page.wait("document.getElementById('points')?.dataset.loaded")
        page.evaluate(_ARROW)
        hand = Hand(page, film, folder)
        hand.rest(2.0)
        _correct(page, hand, right, corner)
        _cross(page, hand)
        hand.click(page.middle("#save"))
        hand.rest(3.0)
    ou.compose(file, folder / "composed", only="layout")


def _spoiled(plan: Drawing, corner: int) -> Drawing:
    for _ in plan.openings:
        plan = remove_opening(plan, 0)
    x, y = plan.corners[corner]
    plan = move_corner(plan, corner, (x + 0.55, y - 0.4))
    return set_height(move_wall(plan, 0, -0.45), 2.95)


def _correct(page: Page, hand: Hand, right: Drawing, corner: int) -> None:
    """One drag after the other."""
    hand.drag(page.middle(f"[data-corner='{corner}']"), _at(page, "#plan", *right.corners[corner]))
    start, end = right.ends(0)
    x, y = (float(v) for v in 0.5 * (start + end))
    hand.drag(page.middle("[data-wall='0']"), _at(page, "#plan", x, y))
    hand.drag(_at(page, "#heights", 0.5, 2.95), _at(page, "#heights", 0.5, right.height))
    for opening in right.openings:
        _cut(page, hand, right, opening)


def _cross(page: Page, hand: Hand) -> None:
    """A corner that is dragged across a wall: what compose would say is told, and it is undone."""
    where = page.middle("[data-corner='0']")
    hand.drag(where, (where[0] - 300.0, where[1] - 260.0))
    hand.rest(2.5)
    page.key("Control+z")
    hand.rest(1.5)


def _cut(page: Page, hand: Hand, right: Drawing, opening: Opening) -> None:
    """Draw an opening a little too small, and pull its right edge to where it belongs."""
    hole: Hole = hole_in(right, opening)
    hand.click(page.middle(f"[data-wall='{opening.wall}']"))
    short = hole.right - 0.25 * (hole.right - hole.left)
    hand.drag(
        _at(page, "#elevation", hole.left, hole.top),
        _at(page, "#elevation", short, max(hole.bottom, 0.03)),
    )
    grip = page.middle("[data-edge$=':right']")
    hand.drag(grip, (_at(page, "#elevation", hole.right, 1.0)[0], grip[1]))


def _at(page: Page, drawing: str, x: float, y: float) -> Place:
    """Where a point in metres is on the screen."""
    left, top = page.evaluate(
        f"(() => {{ const p = new DOMPoint({x}, {y}).matrixTransform("
        f"document.querySelector('{drawing} > g').getScreenCTM()); return [p.x, p.y] }})()"
    )
    return left, top
