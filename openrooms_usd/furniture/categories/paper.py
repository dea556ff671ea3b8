"""Paper: loose sheets, letters, a pad, a sheet crumpled to a ball."""

from dataclasses import replace
from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import ANY, filled, row, solid
from openrooms_usd.furniture.joinery.boards import board
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style, numbered
from openrooms_usd.furniture.joinery.posing import at_rest, turned
from openrooms_usd.furniture.joinery.prints import Print, label_lines
from openrooms_usd.furniture.placements import on
from openrooms_usd.furniture.record import BuiltCategory, Classes
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.mesh import Mesh, joined
from openrooms_usd.geometry.solids import sphere
from openrooms_usd.geometry.sweeps import sheet, tube
from openrooms_usd.geometry.vectors import points_at

_FLAT: Final = "sheets pad letters"


def _page(width: float, depth: float, rng: np.random.Generator) -> tuple[Mesh, list[Mesh]]:
    """A sheet about the origin with the lines that are printed on it."""
    u, v = np.meshgrid(np.linspace(-0.5, 0.5, 5), np.linspace(-0.5, 0.5, 6))
    curl = 0.0012 * np.clip(np.abs(u) + np.abs(v) - 0.75, 0.0, None) / 0.25
    mesh = sheet(points_at(width * u, depth * v, 0.0006 + curl), 0.0005)
    page = Print((width, depth))
    lines = [page.bar((0.12, 0.86), (0.5, 0.885))]
    lines += label_lines(page, (0.12, 0.88, 0.3 + 0.2 * float(rng.uniform()), 0.8), 11, rng)
    thin = np.diag([1.0, 1.0, 0.35, 1.0])
    thin[:3, 3] = (-0.5 * width, -0.5 * depth, 0.0007)
    return mesh, [line.transformed(thin) for line in lines]


def sheets(size: Size, rng: np.random.Generator) -> Parts:
    """A few sheets, one over the other, none quite straight."""
    width, depth, height = size
    turn, count = 5.0, 3
    c, s = np.cos(np.radians(turn)), np.sin(np.radians(turn))
    # A sheet turned by the largest angle fills the box.
    wide = (width * c - depth * s) / (c * c - s * s)
    long = (depth * c - width * s) / (c * c - s * s)
    papers, text = [], []
    for k, angle in enumerate((turn, float(rng.uniform(-3.0, 3.0)), -turn)):
        mesh, lines = _page(wide, long, rng)
        at = (0.0, 0.0, (height - 0.0017) * k / (count - 1))
        papers.append(turned(mesh, "z", angle).moved(at))
        if k == count - 1:
            text = [turned(line, "z", angle).moved(at) for line in lines]
    return {"paper": joined(papers), "text": joined(text)}


def pad(size: Size, rng: np.random.Generator) -> Parts:
    """A pad or a notebook with a spiral along its upper edge."""
    width, depth, height = size
    x, y = 0.5 * width, 0.5 * depth
    loop = 0.5 * height
    block = board((-x, -y, 0.0), (x, y - loop, 0.82 * height), 0.0008)
    page = Print((width, depth - loop))
    page.lines += label_lines(page, (0.1, 0.9, 0.3, 0.9), 9, rng)
    lift = np.eye(4)
    lift[:3, 3] = (-x, -y, 0.82 * height)
    turns = 12
    t = np.linspace(0.0, 2.0 * np.pi * turns, 7 * turns + 1)
    wire = points_at(
        0.92 * width * (t / t[-1] - 0.5),
        y - loop + (loop - 0.0008) * np.cos(t),
        loop + (loop - 0.0008) * np.sin(t),
    )
    return {
        "pages": block,
        "text": joined(page.lines).transformed(lift),
        "wire": tube(wire, 0.0007, segments=4),
    }


def letters(size: Size, rng: np.random.Generator) -> Parts:
    """Letters in their envelopes, askew."""
    width, depth, height = size
    thick = height / 3.0
    found, windows = [], []
    for k in range(3):
        wide, long = width * (1.0 - 0.06 * (k % 2)), depth * (1.0 - 0.1 * (k // 2))
        cover = board(
            (-0.5 * wide, -0.5 * long, k * thick),
            (0.5 * wide, 0.5 * long, (k + 0.96) * thick),
            0.0006,
        )
        slip = (0.5 * (width - wide) * (1 if k % 2 else -1), 0.5 * (depth - long), 0.0)
        found.append(cover.moved(slip))
        if k == 2:
            page = Print((wide, long))
            page.fields.append(page.bar((0.08, 0.2), (0.42, 0.5)))
            page.lines += label_lines(page, (0.11, 0.38, 0.24, 0.46), 3, rng, 1)
            page.titles.append(page.bar((0.84, 0.72), (0.94, 0.92)))
            up = np.eye(4)
            up[:3, 3] = (slip[0] - 0.5 * wide, slip[1] - 0.5 * long, height - 0.04 * thick - 0.0002)
            windows.append(page.parts(up))
    return {**numbered("envelope", found), **windows[0]}


def crumpled(size: Size, rng: np.random.Generator) -> Parts:
    """A sheet crumpled to a ball."""
    ball = sphere(0.5 * float(np.mean(size)), segments=14)
    dents = 1.0 + 0.22 * rng.uniform(-1.0, 1.0, len(ball.points))
    same = np.unique(ball.points.round(6), axis=0, return_inverse=True)[1].ravel()
    return at_rest({"ball": replace(ball, points=ball.points * dents[same][:, None])}, size)


CATEGORY: Final = BuiltCategory(
    description="sheets of paper, a pad, or letters",
    size=(0.23, 0.31, 0.006),
    min_size=(0.06, 0.06, 0.005),
    max_size=(0.5, 0.5, 0.1),
    styles={
        "sheets": Style(sheets),
        "pad": Style(pad, size=(0.15, 0.21, 0.012)),
        "letters": Style(letters, size=(0.23, 0.13, 0.009)),
        "crumpled": Style(
            crumpled,
            lambda size: size[2] > 0.5 * size[0],
            (0.085, 0.08, 0.07),
            mass_range=(0.002, 0.05),
        ),
    },
    lies_under=True,
    support="surface",
    mass_range=(0.02, 0.6),
    words="papers envelope envelopes letter letters document documents notepad sheet_of_paper",
    classes=Classes(nyu40="paper"),
    schemes=(
        scheme(
            "white_paper",
            envelope="envelope",
            white_paper="field",
            package="title",
            print="text",
            steel="wire",
        ),
    ),
    construction=(
        row("wire", solid(2000), "common", "metal"),
        row("ball", filled(40), "common"),
        row(ANY, solid(550), "common"),
    ),
    placements=(
        on("in_bin", styles="crumpled", pose="flat", max_groups=8, max_variants=4),
        on("desk", styles=_FLAT, pose="flat", cluster="writing", max_groups=3),
        on(
            "dining_table worktop cabinet_top side_table",
            pose="flat",
            styles="letters sheets",
            clutter=2,
            weight=0.35,
        ),
        on("coffee_table", styles=_FLAT, pose="flat", clutter=3, weight=0.3, max_groups=1),
        on("drawer", "office", styles=_FLAT, pose="flat", weight=0.5),
        on("shelf", "office", styles="pad letters", pose="stacked", count=(1, 3), weight=0.5),
    ),
)
