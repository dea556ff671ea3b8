"""Pictures by rules, of lines: drawings, posters with letters, maps of towns, a brushed circle."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.joinery.paintings import Rectangle, canvas_of, disc_of, sheet_of
from openrooms_usd.furniture.joinery.pieces import Parts, numbered
from openrooms_usd.furniture.joinery.vessel import smooth_line
from openrooms_usd.geometry.mesh import Mesh, joined
from openrooms_usd.geometry.sweeps import tube

# A head in profile, looking to the left, and its closed eye, in a square from 0 to 1.
_PROFILE: Final = (
    (0.78, 0.02),
    (0.7, 0.12),
    (0.56, 0.16),
    (0.38, 0.15),
    (0.33, 0.22),
    (0.35, 0.27),
    (0.3, 0.3),
    (0.34, 0.345),
    (0.29, 0.38),
    (0.33, 0.43),
    (0.31, 0.46),
    (0.2, 0.5),
    (0.24, 0.57),
    (0.33, 0.68),
    (0.33, 0.78),
    (0.42, 0.9),
    (0.6, 0.96),
    (0.78, 0.9),
    (0.87, 0.74),
    (0.82, 0.55),
    (0.9, 0.36),
    (0.98, 0.2),
)
_EYE: Final = ((0.37, 0.635), (0.41, 0.6), (0.46, 0.595), (0.51, 0.62))


def _stroke(line: np.ndarray, front: float, wide: float) -> Mesh:
    """A line of ink along points (x, z): flat, and it may cross itself."""
    path = np.stack([line[:, 0], np.zeros(len(line)), line[:, 1]], axis=1)
    ink = tube(path, 0.5 * wide, segments=4)
    return ink.transformed(np.diag([1.0, 0.0006 / wide, 1.0])).moved((0.0, front, 0.0))


def _placed(points: np.ndarray, inside: Rectangle, margin: float) -> np.ndarray:
    """Points of a unit square brought into the middle of a rectangle, evenly scaled."""
    left, right, low, high = inside
    side = (1.0 - 2.0 * margin) * min(right - left, high - low)
    middle = np.array([0.5 * (left + right), 0.5 * (low + high)])
    return np.asarray(middle + side * (points - 0.5))


def line_drawing(inside: Rectangle, front: float, rng: np.random.Generator) -> Parts:
    """A face drawn in one line, or hills as lines that follow each other."""
    left, right, low, high = inside
    wide, tall = right - left, high - low
    pen = 0.008 * min(wide, tall)
    if rng.integers(2):
        lines = [np.array(smooth_line(line, count)) for line, count in ((_PROFILE, 90), (_EYE, 12))]
        if rng.integers(2):
            lines = [line * [-1.0, 1.0] + [1.0, 0.0] for line in lines]
        strokes = [_stroke(_placed(line, inside, 0.08), front, pen) for line in lines]
    else:
        x = np.linspace(0.06, 0.94, 26)
        phase = rng.uniform(0.0, 2.0 * np.pi, 3)
        peak = float(rng.uniform(0.3, 0.7))
        strokes = []
        for k in range(10):
            hill = np.exp(-(((x - peak) / 0.17) ** 2)) * (1.0 + 0.2 * np.sin(9.0 * k + 14.0 * x))
            wave = 0.012 * np.sin(9.0 * x + phase[0]) + 0.008 * np.sin(23.0 * x + phase[1] + k)
            z = 0.12 + 0.072 * k + 0.2 * hill * np.sin(np.pi * (k + 1.0) / 11.0) + wave
            line = np.stack([left + wide * x, low + tall * z], axis=1)
            strokes.append(_stroke(line, front, 0.7 * pen))
    return {"canvas": canvas_of(inside, front), "ink": joined(strokes)}


def brushed_circle(inside: Rectangle, front: float, rng: np.random.Generator) -> Parts:
    """A ring of one broad stroke that does not quite close, and a seal."""
    start = float(rng.uniform(0.0, 2.0 * np.pi))
    t = np.linspace(0.0, float(rng.uniform(5.3, 5.9)), 40)
    r = 0.36 * (1.0 + 0.03 * np.sin(3.0 * t + start))
    line = 0.5 + np.stack([r * np.cos(start + t), r * np.sin(start + t)], axis=1)
    broad = 0.06 + 0.05 * np.sin(np.pi * t / t[-1]) + 0.012 * np.sin(17.0 * t)
    along = np.gradient(line, axis=0)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    side = 0.5 * broad[:, None] * np.stack([-along[:, 1], along[:, 0]], axis=1)
    band = np.concatenate([line + side, (line - side)[::-1]])
    seal = np.array([(0.86, 0.02), (0.93, 0.02), (0.93, 0.09), (0.86, 0.09)])
    return {
        "canvas": canvas_of(inside, front),
        "ink": sheet_of(_placed(band, inside, 0.1), front, 0),
        "accent": sheet_of(_placed(seal, inside, 0.1), front, 0),
    }


def poster(inside: Rectangle, front: float, rng: np.random.Generator) -> Parts:
    """A sheet that announces something: a figure of discs, a headline, lines of letters."""
    left, right, low, high = inside
    wide, tall = right - left, high - low

    def bar(x0: float, z0: float, x1: float, z1: float) -> Mesh:
        corners = np.array([(x0, z0), (x1, z0), (x1, z1), (x0, z1)])
        return sheet_of(corners * [wide, tall] + np.array([left, low]), front, 2)

    letters = []
    for z, size in ((0.86, 0.07), (0.76, 0.07)):
        x = 0.08
        while x < float(rng.uniform(0.6, 0.88)):
            end = min(0.92, x + float(rng.uniform(0.05, 0.11)))
            letters.append(bar(x, z, end, z + size))
            x = end + 0.018
    letters += [
        bar(0.08, 0.15 - 0.028 * k, 0.92 - 0.3 * (k == 3), 0.16 - 0.028 * k) for k in range(4)
    ]
    count = int(rng.integers(2, 5))
    radius = 0.26 * min(wide, tall)
    middle = np.array([0.5 * (left + right), low + 0.45 * tall])
    fields = []
    for k in range(count):
        turn = 2.0 * np.pi * k / count + float(rng.uniform(0.0, 1.0))
        away = 0.5 * radius * (count > 2) * np.array([np.cos(turn), np.sin(turn)])
        at = middle + away
        share = (1.0 - 0.26 * k) if count < 3 else 0.6
        fields.append(disc_of((float(at[0]), float(at[1])), share * radius, front, k % 3))
    return {"canvas": canvas_of(inside, front), **numbered("field", fields), "ink": joined(letters)}


def street_map(inside: Rectangle, front: float, rng: np.random.Generator) -> Parts:
    """The streets of a town and its river."""
    left, right, low, high = inside
    size = np.array([right - left, high - low])
    corner = np.array([left, low])
    turn = float(rng.uniform(0.1, 0.7))
    streets = []
    for k in range(22):
        angle = turn + (np.pi / 2.0) * (k % 2) + float(rng.uniform(-0.06, 0.06)) * (k > 13)
        way, across = (np.array([np.cos(a), np.sin(a)]) for a in (angle, angle + 0.5 * np.pi))
        through = 0.5 + across * (((k // 2) + 0.5) / 11.0 - 0.5) * 1.3 + rng.uniform(-0.02, 0.02, 2)
        with np.errstate(divide="ignore"):
            ends = np.sort(np.stack([(0.02 - through) / way, (0.98 - through) / way]), axis=0)
        first, last = float(ends[0].max()), float(ends[1].min())
        if last - first > 0.15:
            line = through + way * np.linspace(first, last, 2)[:, None]
            width = 0.009 if k % 5 == 0 else 0.0045
            streets.append(_stroke(corner + size * line, front, width * float(size.min())))
    x = np.linspace(0.0, 1.0, 21)
    bed = float(rng.uniform(0.35, 0.6)) + 0.14 * np.sin(4.5 * x + float(rng.uniform(0.0, 6.0)))
    half = 0.035 + 0.012 * np.sin(7.0 * x)
    band = np.concatenate([np.stack([x, bed - half], 1), np.stack([x, bed + half], 1)[::-1]])
    return {
        "canvas": canvas_of(inside, front),
        "street": joined(streets),
        "river": sheet_of(corner + size * band, front, 1),
    }
