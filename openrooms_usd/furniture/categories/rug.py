"""Rugs: with a border, with fringes, round with rings, and in stripes."""

from itertools import pairwise
from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import ANY, filled, row
from openrooms_usd.furniture.joinery.boards import board
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style, numbered
from openrooms_usd.furniture.record import WIDE, BuiltCategory, Classes
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.curves import filleted, rectangle
from openrooms_usd.geometry.lofts import loft, ring, rounded_rectangle, superellipse
from openrooms_usd.geometry.mesh import Mesh, joined
from openrooms_usd.geometry.solids import box
from openrooms_usd.geometry.sweeps import extrude


def _field(width: float, depth: float, height: float, corner: float = 0.01) -> Mesh:
    outline = filleted(rectangle(width, depth), corner, closed=True)
    return extrude(outline, height, bevel=0.4 * min(height, corner))


def _frame(outer: np.ndarray, inner: np.ndarray, height: float) -> Mesh:
    """A flat ring with rounded upper edges between two outlines of as many points."""
    e = 0.35 * height
    middle = 0.5 * (outer + inner)
    share = e / np.linalg.norm(outer - middle, axis=1, keepdims=True)
    out, inn = outer + share * (middle - outer), inner + share * (middle - inner)
    rings = [
        ring(outer, 0.0),
        ring(outer, height - e),
        ring(out, height),
        ring(inn, height),
        ring(inner, height - e),
        ring(inner, 0.0),
    ]
    return loft(rings, closed=True)


def bordered(size: Size, rng: np.random.Generator) -> Parts:
    """A field with a border of another colour around it, and a line between them."""
    width, depth, height = size
    edge = float(np.clip(rng.uniform(0.06, 0.12) * min(width, depth), 0.03, 0.2))
    line = 0.22 * edge
    outlines = [
        rounded_rectangle(width - 2 * d, depth - 2 * d, 0.012, 3) for d in (0.0, edge, edge + line)
    ]
    return {
        "border": _frame(outlines[0], outlines[1], height),
        "trim": _frame(outlines[1], outlines[2], height),
        "rug": _field(width - 2 * (edge + line), depth - 2 * (edge + line), height),
    }


def fringed(size: Size, rng: np.random.Generator) -> Parts:
    """A woven field with knotted fringes at its short ends."""
    width, depth, height = size
    turned = depth > width
    if turned:
        width, depth = depth, width
    long = float(rng.uniform(0.05, 0.09)) * min(1.0, width)
    count = int(np.clip(round(depth / 0.016), 6, 120))
    pitch = depth / count
    strands: list[list[Mesh]] = [[], []]
    for k, side in enumerate((-1.0, 1.0)):
        for i in range(count):
            tuft = box((long, 0.45 * pitch, 0.3 * height), (0.5 * long, 0.0, 0.15 * height))
            shear = np.eye(3)
            shear[1, 0] = float(rng.uniform(-0.25, 0.25)) * min(1.0, pitch / 0.02)
            y = -0.5 * depth + pitch * (i + 0.5)
            inside = 1.0 - 2.0 * abs(y) / depth
            shear[1, 0] *= min(1.0, 6.0 * inside)
            whole = tuft.transformed(shear).transformed(np.diag([side, 1.0, 1.0]))
            strands[k].append(whole.moved((side * (0.5 * width - long), y, 0.0)))
    bands = max(0, int(rng.integers(0, 4)))
    inner = 0.5 * width - long
    parts: Parts = {
        "rug": _field(2.0 * inner, depth, 0.94 * height, 0.004),
        **numbered("fringe", [joined(group) for group in strands]),
    }
    places = inner - 0.05 - 0.11 * np.arange(bands) * min(1.0, width / 2.0)
    stripes = [
        board(
            (x - 0.02, -0.5 * depth + 0.001, 0.2 * height),
            (x + 0.02, 0.5 * depth - 0.001, height),
            0.001,
        )
        for x in [*places.tolist(), *(-places).tolist()]
    ]
    if not stripes:
        parts["rug"] = _field(2.0 * inner, depth, height, 0.004)
    parts |= numbered("trim", stripes)
    if turned:
        turn = [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]
        parts = {name: mesh.transformed(turn) for name, mesh in parts.items()}
    return parts


def round_(size: Size, rng: np.random.Generator) -> Parts:
    """A round or oval rug in rings, as braids are laid."""
    width, depth, height = size
    count = int(np.clip(round(0.5 * min(width, depth) / float(rng.uniform(0.12, 0.3))), 2, 6))
    shares = np.linspace(1.0, 0.0, count + 1)[:-1]
    outlines = [superellipse(width * s, depth * s, segments=56) for s in shares]
    rings = [_frame(a, b, height) for a, b in pairwise(outlines)]
    middle = extrude(outlines[-1], height, bevel=0.35 * height)
    bands = [*rings, middle]
    return {**numbered("rug", bands[::2]), **numbered("border", bands[1::2])}


def striped(size: Size, rng: np.random.Generator) -> Parts:
    """Stripes across its length, as in runners."""
    width, depth, height = size
    turned = depth > width
    if turned:
        width, depth = depth, width
    count = max(7, round(width / float(rng.uniform(0.12, 0.25))))
    shares = np.where(np.arange(count) % 2 == 0, 1.0, float(rng.uniform(0.3, 1.0)))
    edges = -0.5 * width + width * np.concatenate([[0.0], np.cumsum(shares) / shares.sum()])
    bands = [
        board((a, -0.5 * depth, 0.0), (b, 0.5 * depth, height), 0.3 * height)
        for a, b in pairwise(edges.tolist())
    ]
    parts = {**numbered("rug", bands[::2]), **numbered("border", bands[1::2])}
    if turned:
        turn = [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]
        parts = {name: mesh.transformed(turn) for name, mesh in parts.items()}
    return parts


def _longish(size: Size) -> bool:
    return max(size[:2]) > 1.3 * min(size[:2])


CATEGORY: Final = BuiltCategory(
    description="a carpet that lies on the floor",
    size=(2.0, 1.4, 0.012),
    min_size=(0.3, 0.3, 0.005),
    max_size=(8.0, 8.0, 0.05),
    styles={
        "bordered": Style(bordered),
        "fringed": Style(fringed, _longish),
        "round": Style(round_, lambda size: not _longish(size), (1.6, 1.6, 0.012)),
        "runner": Style(
            striped, lambda size: max(size[:2]) > 2.2 * min(size[:2]), (2.4, 0.8, 0.012)
        ),
    },
    size_variation=WIDE,
    alternative_supports=("wall",),
    mass_range=(3, 12),
    words="carpet floor_mat bathmat bath_mat mat door_mat doormat",
    lies_under=True,
    classes=Classes(ade20k="rug"),
    schemes=(scheme("carpet", carpet_border="border trim", linen="fringe"),),
    construction=(row(ANY, filled(220), "common"),),
    view_importance=0.0,
)
