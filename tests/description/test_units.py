import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from openrooms_usd.description import parse_room
from openrooms_usd.description.units import DEGREES, METRES, degrees, metres

# A metre and a turn in each unit, stated anew.
IN_ONE_METRE = {"mm": 1000.0, "cm": 100.0, "m": 1.0, "in": 39.37007874015748, "ft": 3.28083989501}
IN_ONE_TURN = {"deg": 360.0, "°": 360.0, "rad": 2.0 * math.pi}

lengths = st.floats(-1000, 1000, allow_nan=False)
spaces = st.sampled_from(["", " ", "  "])


@given(lengths, st.sampled_from(sorted(IN_ONE_METRE)), spaces)
def test_a_length_is_the_same_in_every_unit(length: float, unit: str, space: str) -> None:
    assert metres(f"{length * IN_ONE_METRE[unit]!r}{space}{unit}") == pytest.approx(
        length, rel=1e-9, abs=1e-12
    )


@given(st.floats(-10, 10), st.sampled_from(sorted(IN_ONE_TURN)), spaces)
def test_an_angle_is_the_same_in_every_unit(turns: float, unit: str, space: str) -> None:
    assert degrees(f"{turns * IN_ONE_TURN[unit]!r}{space}{unit}") == pytest.approx(
        turns * 360.0, rel=1e-12, abs=1e-12
    )


@given(lengths)
def test_a_length_survives_the_file(length: float) -> None:
    room = parse_room(
        f"furniture: {{objects: [{{category: chair, at: [{length!r}, '{length!r}']}}]}}"
    )
    assert room.furniture.objects[0].at == (length, length)


@given(st.integers(-100_000, 100_000))
def test_centimetres_and_millimetres_are_exact(count: int) -> None:
    assert metres(f"{count} cm") == count / 100
    assert metres(f"{count} mm") == count / 1000


def test_every_unit_is_tested() -> None:
    assert set(METRES) == set(IN_ONE_METRE)
    assert set(DEGREES) == set(IN_ONE_TURN)


NO_LENGTHS = (
    *("", "cm", "1 parsec", "1,5 m", "1_0", "0x10", "1 m 2", "--1", "nan", "inf", "1e400 m"),
    *("1" * 65, True, None, [1], {"m": 1}, math.nan, math.inf, -math.inf, 10**400),
)


@pytest.mark.parametrize("given_", NO_LENGTHS, ids=lambda value: repr(value)[:20])
def test_what_is_no_length_is_refused(given_: object) -> None:
    with pytest.raises(ValueError, match="a length"):
        metres(given_)
