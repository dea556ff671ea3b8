"""The hand of the benchmark of annotation ends at the truth, and counts what it does."""

import numpy as np
import pytest

from benchmarks.annotation import Hand, draw_openings, draw_outline
from benchmarks.real.truth import Hole as TrueHole
from openrooms_usd.description.layout import Opening
from openrooms_usd.view.plan.drawing import Drawing

BOX = ((0.0, 0.0), (5.0, 0.0), (5.0, 4.0), (0.0, 4.0))
L_SHAPE = np.array([(0, 0), (6, 0), (6, 3), (4.2, 3), (4.2, 5), (0, 5)], float)


def turned(angle: float) -> np.ndarray:
    """(4, 4) a truth that lies elsewhere and otherwise than the plan."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0, 1.5], [s, c, 0, -0.7], [0, 0, 1, 0], [0, 0, 0, 1]])


@pytest.mark.parametrize("limit", [0.2, 0.06])
def test_a_box_becomes_the_room_in_few_operations(limit: float) -> None:
    hand = Hand(Drawing(BOX, 2.6), np.eye(4))
    assert draw_outline(hand, L_SHAPE, limit)
    away = np.linalg.norm(hand.plan.polygon[:, None] - L_SHAPE[None], axis=2).min(axis=1)
    assert away.max() < limit and len(hand.plan.corners) == 6
    assert 4 <= hand.operations <= 8 and hand.clicks >= hand.operations
    again = Hand(hand.plan, np.eye(4))
    assert draw_outline(again, L_SHAPE, limit) and again.operations == 0


def test_a_false_opening_is_closed_a_wrong_one_named_and_a_missing_one_drawn() -> None:
    level = turned(0.4)
    hand = Hand(Drawing(BOX, 2.6), level)
    back = np.linalg.inv(level)

    def hole(kind: str, a: tuple[float, float], b: tuple[float, float]) -> TrueHole:
        ends = np.array([(*a, 0.0, 1.0), (*b, 0.0, 1.0)]) @ back.T
        return TrueHole(kind, (tuple(ends[0, :2]), tuple(ends[1, :2])), 0.9, 2.1)

    true = [hole("window", (1, 0), (2.5, 0)), hole("door", (5, 1), (5, 2))]
    openings = (
        Opening(kind="door", wall=0, at=1.75, width=1.5, height=1.2, sill=0.9),
        Opening(kind="window", wall=2, at=2.0, width=1.0, height=1.0, sill=0.9),
    )
    hand.plan = Drawing(BOX, 2.6, openings)
    assert draw_openings(hand, true, 0.7)
    assert hand.operations == 3
    assert sorted((one.kind, one.wall) for one in hand.plan.openings) == [
        ("door", 1), ("window", 0),
    ]  # fmt: skip
