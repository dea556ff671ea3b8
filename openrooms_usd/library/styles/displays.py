"""Pictures that screens show, drawn by rules: a desktop with windows, a still of a film."""

from collections.abc import Callable, Mapping
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array, Bytes

# Columns of a picture; screens of rooms are seen by few pixels.
WIDTH: Final = 384
# Of text in windows: its height and the gap between lines, as shares of the picture's width.
_LINE_SHARE: Final = 0.006
_LEADING_SHARE: Final = 0.016
# What films leave of the levels of their pictures.
_FILM_LEVEL: Final = 0.75


def picture(shows: str, aspect: float, rng: np.random.Generator) -> Bytes:
    """What a screen shows.

    Args:
        shows: A key of `SHOWN`.
        aspect: Width over height.
        rng: Draws it.

    Returns:
        (H, W, 3) sRGB, 8 bits; its brightest white is what the screen's luminance is said of.
    """
    height = max(8, round(WIDTH / aspect))
    encoded = SHOWN[shows](height, rng)
    return (np.clip(encoded, 0.0, 1.0) * 255.0 + 0.5).astype(np.uint8)


def _desktop(height: int, rng: np.random.Generator) -> Array:
    """A wallpaper of two colours, one or two windows with lines of text, a bar below."""
    y, x = _grid(height)
    first, second = _hue(rng, 0.45), _hue(rng, 0.35)
    bend = 0.5 + 0.5 * np.sin(2.5 * x + 3.0 * y + rng.uniform(0.0, 6.0))
    shown = first + (second - first) * bend[..., None]
    for _ in range(int(rng.integers(1, 3))):
        left, top = rng.uniform(0.03, 0.35), rng.uniform(0.03, 0.2)
        _window(
            shown,
            x,
            y,
            (left, top, left + rng.uniform(0.4, 0.6), top + rng.uniform(0.5, 0.68)),
            rng,
        )
    shown[y > 0.95] = (0.12, 0.13, 0.16)
    for k in range(7):
        icon = (np.abs(x - (0.36 + 0.045 * k)) < 0.013) & (np.abs(y - 0.975) < 0.015)
        shown[icon] = _hue(rng, 0.7)
    return shown


def _window(
    shown: Array,
    x: Array,
    y: Array,
    box: tuple[float, float, float, float],
    rng: np.random.Generator,
) -> None:
    """Draw a window over a picture: a title bar and lines of text or code."""
    left, top, right, bottom = box
    inner = (x > left) & (x < right) & (y > top) & (y < bottom)
    dark = rng.random() < 0.35
    shown[inner] = (0.13, 0.14, 0.17) if dark else (0.97, 0.97, 0.97)
    shown[inner & (y < top + 0.035)] = (0.22, 0.23, 0.27) if dark else (0.85, 0.86, 0.88)
    line = top + 0.07
    while line < min(bottom, 0.95) - 0.03:
        start = left + 0.02 + 0.03 * int(rng.integers(0, 3)) * dark
        end = min(start + rng.uniform(0.1, right - left - 0.06), right - 0.02)
        text = (x > start) & (x < end) & (np.abs(y - line) < _LINE_SHARE)
        ink = _hue(rng, 0.75) if dark else np.array([0.35, 0.36, 0.38])
        if rng.random() < 0.88:
            # Words are parted by gaps.
            words = np.sin(x * 260.0 + line * 900.0) > -0.7
            shown[text & words] = ink
        line += _LEADING_SHARE * rng.choice([1.0, 1.0, 1.0, 2.0])


def _film(height: int, rng: np.random.Generator) -> Array:
    """A landscape: a sky with a low sun, ranges of hills that grow paler, black bars."""
    y, x = _grid(height)
    high, low = _hue(rng, 0.35), np.array([0.98, rng.uniform(0.6, 0.8), rng.uniform(0.35, 0.6)])
    horizon = rng.uniform(0.5, 0.65)
    fade = np.clip(y / horizon, 0.0, 1.0)[..., None] ** 1.5
    shown = high + (low - high) * fade
    sun = np.exp(-(((x - rng.uniform(0.2, 0.8)) / 0.16) ** 2 + ((y - horizon + 0.06) / 0.1) ** 2))
    shown = shown + sun[..., None] * np.array([0.5, 0.4, 0.25])
    ink = _hue(rng, 0.12)
    for k in range(3):
        waves = sum(
            rng.uniform(0.01, 0.035) / n * np.sin(n * 5.0 * x + rng.uniform(0.0, 6.0))
            for n in (1, 2, 4)
        )
        hills = y > horizon + 0.09 * k - 0.02 + waves
        shown[hills] = ink + (low - ink) * (0.45, 0.2, 0.04)[k]
    shown[(y < 0.09) | (y > 0.91)] = 0.0
    # Films are darker than pages.
    return np.asarray(_FILM_LEVEL * shown)


SHOWN: Final[Mapping[str, Callable[[int, np.random.Generator], Array]]] = {
    "desktop": _desktop,
    "film": _film,
}


def _grid(height: int) -> tuple[Array, Array]:
    """Row and column of every pixel, 0 to 1 from the upper left."""
    y, x = np.mgrid[0:height, 0:WIDTH]
    return (y + 0.5) / height, (x + 0.5) / WIDTH


def _hue(rng: np.random.Generator, value: float) -> Array:
    """A colour of a brightness, neither grey nor garish."""
    turn = 2.0 * np.pi * (rng.uniform() + np.arange(3) / 3.0)
    return np.asarray(value * (1.0 + 0.45 * np.cos(turn)))
