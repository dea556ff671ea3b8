"""The coefficient of a pair of surfaces, and what each engine must be told to use it."""

from math import sqrt


def friction(a: float, b: float) -> float:
    """The coefficient between two surfaces: the geometric mean of their own.

    A material's coefficient is against the average counterface. In logarithms a pair is so the mean
    of both, as in the fit of the references (docs/explanation/friction.md); equal surfaces keep
    their own.
    """
    return sqrt(a * b)


def factor(coefficient: float) -> float:
    """What an engine that multiplies the coefficients of both (Bullet) must be given."""
    return sqrt(coefficient)
