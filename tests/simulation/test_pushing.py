"""The paper's push in closed form, and in both engines."""

import numpy as np
import pytest

from openrooms_usd import adapters
from openrooms_usd.simulation import pushing
from openrooms_usd.simulation.pushing import CARPET, STRONG, WAX, WEAK, Push, predicted, simulated
from tests.engines import ENGINES


def integrated(push: Push, step: float = 1e-6) -> float:
    """The same by Newton's second law in tiny steps, without knowing the phases."""
    drag = push.coefficient * pushing.GRAVITY
    way = speed = time = 0.0
    while time < pushing.PUSH + pushing.WAIT:
        pushed = time < pushing.PUSH and speed < pushing.SPEED
        if pushed:
            force = push.effort - drag * pushing.CABINET_MASS
            speed += step * force / (pushing.ROBOT_MASS + pushing.CABINET_MASS)
        elif time >= pushing.PUSH:
            speed = max(0.0, speed - step * drag)
            if speed == 0.0:
                break
        way += step * speed
        time += step
    return way


@pytest.mark.parametrize(
    "push", [Push(CARPET, WEAK), Push(WAX, STRONG), Push(CARPET, 400.0)], ids=str
)
def test_the_prediction_is_newtons_law(push: Push) -> None:
    assert predicted(push) == pytest.approx(integrated(push), rel=1e-3)


def test_a_motor_weaker_than_friction_moves_nothing() -> None:
    assert predicted(Push(CARPET, 14.0)) == 0.0


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("floor", [CARPET, WAX])
@pytest.mark.parametrize("effort", [WEAK, STRONG])
def test_engines_agree_with_it_within_five_percent(
    engine: str, floor: float, effort: float
) -> None:
    push = Push(floor, effort)
    found = simulated(push, adapters.load(adapters.ENGINES, engine), 0.002)
    assert found == pytest.approx(predicted(push), rel=0.05)


@pytest.mark.parametrize("engine", ENGINES)
def test_a_smaller_step_errs_less(engine: str) -> None:
    loaded = adapters.load(adapters.ENGINES, engine)
    push = Push(CARPET, STRONG)
    errors = [abs(simulated(push, loaded, step) - predicted(push)) for step in (0.004, 0.001)]
    assert errors[1] < 0.5 * errors[0]


def test_wax_lets_it_go_further() -> None:
    ways = np.array([predicted(Push(floor, STRONG)) for floor in (CARPET, WAX)])
    assert ways[1] > ways[0]
    # As the paper's own offsets, which are nothing that we fit.
    assert pushing.PAPER[WAX] > pushing.PAPER[CARPET]
