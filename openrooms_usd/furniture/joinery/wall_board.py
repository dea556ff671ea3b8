"""Pictures and whiteboards: flat things on a wall; one board stands on wheels."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.joinery.boards import FRONT, board, profiled
from openrooms_usd.furniture.joinery.paintings import Painter, Rectangle, any_of, landscape, shapes
from openrooms_usd.furniture.joinery.pieces import (
    Build,
    Furniture,
    Joint,
    Parts,
    Size,
    numbered,
    part_of,
)
from openrooms_usd.furniture.joinery.posing import facing, turned
from openrooms_usd.furniture.joinery.posters import brushed_circle, poster
from openrooms_usd.geometry.mesh import Mesh, joined
from openrooms_usd.geometry.solids import cylinder, lathe
from openrooms_usd.geometry.sweeps import tube


def mitred(outer: Rectangle, bar: float, front: float, back: float) -> Mesh:
    """Four bars that meet at 45 degrees around a rectangle."""
    left, right, low, high = outer
    corners = [(left, low), (right, low), (right, high), (left, high)]
    inner = [
        (left + bar, low + bar),
        (right - bar, low + bar),
        (right - bar, high - bar),
        (left + bar, high - bar),
    ]
    middle = (0.0, 0.5 * (front + back), 0.0)
    edge = min(0.003, 0.2 * bar, 0.2 * (back - front))
    return joined(
        [
            profiled(
                [corners[i], corners[(i + 1) % 4], inner[(i + 1) % 4], inner[i]],
                back - front,
                FRONT,
                edge,
            ).moved(middle)
            for i in range(4)
        ]
    )


def _slab(inside: Rectangle, front: float, back: float) -> Mesh:
    left, right, low, high = inside
    return board((left, front, low), (right, back, high), 0.0004)


def _shrunk(outer: Rectangle, margin: float) -> Rectangle:
    left, right, low, high = outer
    return left + margin, right - margin, low + margin, high - margin


def _print(inside: Rectangle, front: float, rng: np.random.Generator) -> Parts:
    """A colour-field composition: a ground, one to three fields on it, an accent.

    Colours are laid on as sheets a third of a millimetre thick, as a screen print is.
    """
    left, right, low, high = inside
    wide, tall = right - left, high - low
    layer = 0.0004
    ground = _slab(inside, front, front + 0.003)
    fields, accents = [], []
    if rng.integers(2):  # stacked bands
        cuts = np.sort(rng.uniform(0.14, 0.86, 3)) * tall + low
        bands = [(low + 0.07 * tall, cuts[0]), (cuts[1] + 0.02 * tall, high - 0.07 * tall)]
        for a, b in bands:
            if b - a > 0.06 * tall:
                fields.append(
                    _slab(
                        (left + 0.08 * wide, right - 0.08 * wide, a, b),
                        front - layer,
                        front + 0.001,
                    )
                )
        accents.append(
            _slab(
                (left + 0.08 * wide, right - 0.08 * wide, cuts[1] - 0.045 * tall, cuts[1]),
                front - layer,
                front + 0.001,
            )
        )
    else:  # a sun over a hill
        r = float(rng.uniform(0.13, 0.2)) * min(wide, tall)
        x, z = (
            float(rng.uniform(a, b))
            for a, b in (
                (left + 0.3 * wide, right - 0.3 * wide),
                (low + 0.56 * tall, high - 1.3 * r),
            )
        )
        disc = turned(cylinder(r, 0.001 + layer, segments=36), "x", 90.0)
        accents.append(disc.moved((x, front + 0.001, z)))
        u = np.linspace(0.0, 1.0, 15)
        crest = low + tall * (0.3 + 0.1 * np.sin(2.0 * np.pi * (u + float(rng.uniform()))))
        hill = [
            (left, low),
            (right, low),
            *zip((left + wide * u[::-1]).tolist(), crest[::-1].tolist(), strict=True),
        ]
        fields.append(
            profiled(hill, 0.001 + layer, FRONT, 0.0).moved(
                (0.0, front + 0.5 * (0.001 - layer), 0.0)
            )
        )
    return {"canvas": ground, **numbered("field", fields), **numbered("accent", accents)}


def framed_as(paint: Painter, mat: tuple[float, float]) -> Build:
    """A picture behind a mat in a mitred frame.

    Args:
        paint: What is to be seen.
        mat: Least and greatest width of the mat, in parts of the picture's smaller side.
    """

    def build(size: Size, rng: np.random.Generator) -> Parts:
        width, depth, height = size
        whole = (-0.5 * width, 0.5 * width, 0.0, height)
        small = min(width, height)
        bar = float(rng.uniform(0.025, 0.045)) * small + 0.006
        front, back = -0.5 * depth, 0.5 * depth
        inner = _shrunk(whole, bar - 0.002)
        wide = float(rng.uniform(*mat)) * small
        sheet = front + 0.35 * depth
        window = mitred(inner, wide, sheet, sheet + 0.0022)
        rear = _slab(_shrunk(whole, 0.5 * bar), back - 0.004, back - 0.0005)
        image = paint(_shrunk(inner, wide - 0.003), sheet + 0.0026, rng)
        return {"frame": mitred(whole, bar, front, back), "mat": window, "back": rear, **image}

    return build


_ON_CANVAS: Final = any_of(_print, shapes, landscape, brushed_circle)


def canvas(size: Size, rng: np.random.Generator) -> Parts:
    """A stretched canvas without a frame: its paint goes to the edge."""
    width, depth, height = size
    whole = (-0.5 * width, 0.5 * width, 0.0, height)
    front, back = -0.5 * depth, 0.5 * depth
    bars = mitred(_shrunk(whole, 0.001), min(0.035, 0.12 * min(width, height)), front + 0.004, back)
    block = _slab(whole, front + 0.0014, front + 0.006)
    edges = mitred(whole, 0.0025, front + 0.004, back - 0.003)
    image = _ON_CANVAS(whole, front + 0.0014, rng)
    image["canvas"] = joined([block, edges])
    return {"frame": bars, **image}


_BY_ONE_HAND: Final[tuple[Painter, ...]] = (_print, shapes, landscape, brushed_circle)


def triptych(size: Size, rng: np.random.Generator) -> Parts:
    """Three narrow panels that hang side by side, of one hand."""
    width, depth, height = size
    gap = 0.035 * width
    wide = (width - 2.0 * gap) / 3.0
    paint = _BY_ONE_HAND[int(rng.integers(len(_BY_ONE_HAND)))]
    parts: dict[str, list[Mesh]] = {"frame": []}
    for i in range(3):
        left = -0.5 * width + i * (wide + gap)
        panel = (left, left + wide, 0.0, height)
        front = -0.5 * depth
        parts["frame"].append(mitred(panel, 0.012, front, 0.5 * depth))
        for name, mesh in paint(_shrunk(panel, 0.011), front + 0.3 * depth, rng).items():
            parts.setdefault(part_of(name), []).append(mesh)
    return {name: joined(meshes) for name, meshes in parts.items()}


framed = framed_as(any_of(_print, shapes, poster, brushed_circle, landscape), (0.02, 0.16))


def _board(outer: Rectangle, front: float, back: float) -> Parts:
    """An enamelled board in an aluminium frame with plastic corners."""
    left, right, low, high = outer
    rim = 0.018
    pads = [
        board((x - 0.014, front - 0.0008, z - 0.014), (x + 0.014, back, z + 0.014), 0.004)
        for x in (left + 0.014, right - 0.014)
        for z in (low + 0.014, high - 0.014)
    ]
    return {
        "frame": mitred(outer, rim, front, back),
        "board": _slab(_shrunk(outer, rim - 0.003), front + 0.3 * (back - front), back - 0.002),
        "corner": joined(pads),
    }


def _tray(
    left: float, right: float, z: float, front: float, back: float, rng: np.random.Generator
) -> Parts:
    """A ledge with pens and an eraser."""
    ledge = [
        board((left, front, z), (right, back, z + 0.004), 0.001),
        board((left, front, z), (right, front + 0.004, z + 0.012), 0.001),
    ]
    y = 0.5 * (front + back)
    places = left + (right - left) * np.array([0.12, 0.24, 0.36, 0.48][: int(rng.integers(2, 5))])
    pens = [
        tube([(x, y, z + 0.0125), (x + 0.115, y + 0.004, z + 0.0125)], 0.0085)
        for x in places.tolist()
    ]
    eraser = board((right - 0.24, y - 0.02, z + 0.004), (right - 0.12, y + 0.02, z + 0.036), 0.004)
    return {"tray": joined(ledge), **numbered("pen", pens), "eraser": eraser}


def wall(size: Size, rng: np.random.Generator) -> Parts:
    """A board with a ledge, for a wall."""
    width, depth, height = size
    whole = (-0.5 * width, 0.5 * width, 0.0, height)
    back = 0.5 * depth
    parts = _board(whole, back - 0.02, back)
    long = float(rng.uniform(0.3, 0.5)) * width
    return {**parts, **_tray(-0.5 * long, 0.5 * long, 0.004, -0.5 * depth, back - 0.012, rng)}


def glass(size: Size, rng: np.random.Generator) -> Parts:
    """A frameless pane held off the wall by four studs, a short ledge below its edge."""
    width, depth, height = size
    front, back = 0.5 * depth - 0.026, 0.5 * depth
    pane = board((-0.5 * width, front, 0.03), (0.5 * width, front + 0.006, height), 0.0012)
    margin = float(rng.uniform(0.05, 0.08))
    stud = lathe(
        [(0.0, 0.0), (0.011, 0.0), (0.011, 0.025), (0.014, 0.026), (0.014, 0.032), (0.0, 0.033)],
        segments=24,
    )
    places = [
        (x, z)
        for x in (margin - 0.5 * width, 0.5 * width - margin)
        for z in (0.03 + margin, height - margin)
    ]
    studs = [facing(stud, (x, back, z)) for x, z in places]
    ledge = _tray(-0.22 * width, 0.22 * width, 0.0, -0.5 * depth, front + 0.006, rng)
    hook = board((-0.2 * width, front + 0.006, 0.0), (0.2 * width, back, 0.05))
    return {"board": pane, **numbered("stud", studs), "bracket": hook, **ledge}


def mobile(size: Size, rng: np.random.Generator) -> Furniture:
    """A board that turns over between two posts on castors."""
    width, depth, height = size
    foot, post = 0.09, 0.018
    x = 0.5 * width - post
    low = 0.34 * height
    panel = (-x + post + 0.008, x - post - 0.008, low, height - 0.004)
    turning = _board(panel, -0.011, 0.011)
    turning["board"] = _slab(_shrunk(panel, 0.015), -0.0065, 0.0065)
    middle = 0.5 * (low + height)
    axles = [
        tube([(s * (x - post - 0.0095), 0.0, middle), (s * x, 0.0, middle)], 0.008) for s in (-1, 1)
    ]
    posts = [
        board((s * x - post, -post, foot - 0.01), (s * x + post, post, middle + 0.06), 0.004)
        for s in (-1, 1)
    ]
    beams = [
        board(
            (s * x - post, -0.5 * depth + 0.01, foot - 0.03),
            (s * x + post, 0.5 * depth - 0.01, foot),
            0.004,
        )
        for s in (-1, 1)
    ]
    cross = board((-x, -0.01, 0.22 * height), (x, 0.01, 0.22 * height + 0.03), 0.003)
    wheel = tube([(-0.01, 0.0, 0.0), (0.01, 0.0, 0.0)], 0.03, segments=18)
    wheels = [
        wheel.moved((s * x, t * (0.5 * depth - 0.03), 0.03)) for s in (-1, 1) for t in (-1, 1)
    ]
    long = float(rng.uniform(0.4, 0.6)) * width
    tray = _tray(-0.5 * long, 0.5 * long, 0.22 * height + 0.026, -0.09, -0.008, rng)
    return Furniture(
        {
            **turning,
            **numbered("stand", [*posts, *beams, *axles, cross]),
            **numbered("wheel", wheels),
            **tray,
        },
        (
            Joint(
                "board_0",
                "hinge",
                tuple(turning),
                (0.0, 0.0, middle),
                (1.0, 0.0, 0.0),
                (-180.0, 180.0),
            ),
        ),
    )
