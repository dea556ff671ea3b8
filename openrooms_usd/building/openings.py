"""Holes in walls: whether they fit, and how captured ones are made to fit."""

from collections.abc import Sequence

from openrooms_usd.building.shell import Hole
from openrooms_usd.building.walls import Wall

# What must stay of a wall beside and above a hole, and between two holes, metres.
MARGIN = 0.02
# A hole that begins lower than this stands on the floor.
STEP = 0.02
# Captured holes smaller than this are noise.
LEAST = 0.1
_ROUNDING = 1e-6


def free_span(wall: Wall) -> tuple[float, float]:
    """Between which x a hole passes through both faces of a wall and leaves the margins.

    Returns:
        The lowest and the highest x; the first is greater where no hole fits.
    """
    if wall.outer is None:
        return (wall.length, 0.0)
    return max(0.0, wall.outer[0]) + MARGIN, min(wall.length, wall.outer[1]) - MARGIN


def misfit(wall: Wall, height: float, hole: Hole) -> str | None:
    """Say why a hole does not fit into its wall.

    Args:
        wall: The wall.
        height: Floor to ceiling, metres.
        hole: What shall be cut.

    Returns:
        A phrase that follows the opening's name, or None when it fits.
    """
    low, high = free_span(wall)
    width = hole.right - hole.left
    if width > high - low + _ROUNDING:
        room = f"{max(0.0, high - low):.3f} m of its {wall.length:.3f} m are free"
        return f"is {width:.3f} m wide, but only {room}"
    if hole.left < low - _ROUNDING or hole.right > high + _ROUNDING:
        beside = "left" if hole.left < low else "right"
        return f"reaches beyond the {beside} end of the wall, seen from inside"
    if hole.top > height - MARGIN + _ROUNDING:
        return (
            f"reaches up to {hole.top:.3f} m, but the ceiling is at {height:.3f} m and "
            f"{100 * MARGIN:g} cm must stay above it"
        )
    return None


def too_close(a: Hole, b: Hole) -> bool:
    """Whether two holes of a wall overlap or leave less than the margin between them."""
    beside = max(a.left, b.left) - min(a.right, b.right)
    above = max(a.bottom, b.bottom) - min(a.top, b.top)
    return max(beside, above) < MARGIN - _ROUNDING


def clamped(wall: Wall, height: float, hole: Hole) -> Hole | None:
    """The part of a hole that fits into its wall; None when hardly any does."""
    low, high = free_span(wall)
    fitting = Hole(
        left=max(hole.left, low),
        right=min(hole.right, high),
        bottom=0.0 if hole.bottom < STEP else hole.bottom,
        top=min(hole.top, height - MARGIN),
    )
    least = min(fitting.right - fitting.left, fitting.top - fitting.bottom)
    return fitting if least >= LEAST else None


def around(holes: Sequence[Hole]) -> Hole:
    """The smallest hole that contains all of some holes."""
    return Hole(
        left=min(hole.left for hole in holes),
        right=max(hole.right for hole in holes),
        bottom=min(hole.bottom for hole in holes),
        top=max(hole.top for hole in holes),
    )
