"""How likely openings are, by what a wall shows."""

from dataclasses import replace

import pytest

from openrooms_usd.scan.openings.cellcounts import CELL_M
from openrooms_usd.scan.openings.detection import LIKELY
from openrooms_usd.scan.openings.judgement import likelihood
from openrooms_usd.scan.openings.rectangles import Rectangle
from openrooms_usd.scan.openings.wallholes import Proposal

EVIDENCE = {"hole": 0.95, "framed": 0.9, "walled": 0.95, "headroom": 0.5}
DOORWAY = Proposal("door", Rectangle(0, 82, 40, 74), **EVIDENCE, threshold=1.0)
CLOSED = Proposal(
    "door", Rectangle(0, 82, 40, 74), framed=0.9, walled=0.95, solid=1.0, leaf=0.9, headroom=0.5
)
PANE = Proposal("window", Rectangle(36, 88, 40, 90), **EVIDENCE, recess=0.4)


@pytest.mark.parametrize("clear", [DOORWAY, CLOSED, PANE])
def test_what_is_clear_is_likely(clear: Proposal) -> None:
    assert likelihood(clear) > 0.75


@pytest.mark.parametrize("clear", [DOORWAY, CLOSED, PANE])
@pytest.mark.parametrize("share", ["framed", "walled"])
def test_less_wall_around_is_less_likely(clear: Proposal, share: str) -> None:
    assert likelihood(replace(clear, **{share: 0.2})) < likelihood(clear)


@pytest.mark.parametrize(
    "doubtful",
    [
        # A compartment of a shelf, a niche under the ceiling, a recess before which things stand,
        # a picture behind a desk.
        replace(PANE, where=Rectangle(40, 56, 40, 68), recess=0.95, framed=0.55, clutter=0.5),
        replace(PANE, where=Rectangle(112, 118, 40, 80), recess=0.95, headroom=0.05),
        replace(DOORWAY, hole=0.6, recess=0.5, threshold=0.0, blocked=1.0, framed=0.7),
        replace(CLOSED, leaf=0.4, blocked=1.0, clutter=0.3, where=Rectangle(0, 96, 40, 80)),
    ],
)
def test_what_furniture_explains_is_not_built(doubtful: Proposal) -> None:
    assert likelihood(doubtful) < LIKELY


def test_a_view_far_behind_serves_as_well_as_a_threshold() -> None:
    seen = replace(DOORWAY, threshold=0.0, beyond=0.8)
    assert likelihood(seen) == pytest.approx(likelihood(DOORWAY))
    assert likelihood(replace(seen, beyond=0.0)) < likelihood(seen)


def test_cells_are_of_the_size_that_these_rectangles_assume() -> None:
    assert pytest.approx(0.025) == CELL_M
