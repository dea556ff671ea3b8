"""Fabrics: woven, knitted (loops in columns, along t, and rows), of standing or matted fibres."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any, Final

import numpy as np

from openrooms_usd.arrays import Mask
from openrooms_usd.library.textures.base import lattice
from openrooms_usd.library.textures.base import vocabulary as tx
from openrooms_usd.library.textures.fabric import dyes
from openrooms_usd.library.textures.fabric.dyes import COLORS, NATURALS, Dye
from openrooms_usd.library.textures.fabric.pile import PILED
from openrooms_usd.library.textures.fabric.weave import (
    Cloth,
    Pattern,
    Thread,
    pattern,
    pointed,
    satin,
    twill,
    woven,
)
from openrooms_usd.tables import read_table

# Height of a loop, in wales, and courses a wale's width holds.
_LOOP_HEIGHT_WALES: Final = 0.42
_COURSES_PER_WALE: Final = 1.25
# Wales of a cable, of its ground with it, and courses from one crossing of strands to the next.
_CABLE_WALES: Final = 6
_REPEAT_WALES: Final = 10
_CROSSING_COURSES: Final = 8


def _plain_side(across: tx.Field, along: tx.Field) -> tx.Field:
    """Height 0..1 of the face: each loop's two legs lean apart, so that columns of V appear.

    Args:
        across: Place in wales.
        along: Place in courses, broadcast against ``across``.
    """
    half = lattice.offset(2.0 * across)
    lean = 0.9 * np.abs(lattice.offset(across))
    leg = lattice.offset(along - lean)
    return np.asarray((1.0 - 0.75 * half**2) * (1.0 - 0.6 * leg**2))


def _purl_side(across: tx.Field, along: tx.Field) -> tx.Field:
    """Height 0..1 of the back: rows of arcs."""
    arc = lattice.offset(along + 0.18 * np.cos(2.0 * np.pi * across))
    return np.asarray((1.0 - 0.8 * arc**2) * (0.75 + 0.25 * np.cos(4.0 * np.pi * across)))


def _rib(across: tx.Field, along: tx.Field) -> tx.Field:
    """Two wales of the face, two of the back, which draws in and lies deeper."""
    place = across / 4.0
    raised = np.clip(0.5 + 2.2 * np.cos(2.0 * np.pi * (place - 0.25)), 0.0, 1.0)
    face = _plain_side(across, along) + 1.1
    return np.asarray(raised * face + (1.0 - raised) * 0.8 * _purl_side(across, along))


def _cable(across: tx.Field, along: tx.Field) -> tx.Field:
    """Ropes of two strands that cross over each other, on a ground of the back."""
    place = across % _REPEAT_WALES - _REPEAT_WALES / 2
    turn = np.pi * along / _CROSSING_COURSES
    height = 0.7 * _purl_side(across, along)
    for strand in (0.0, 0.5):
        angle = turn + 2.0 * np.pi * strand
        aside = place - 0.25 * _CABLE_WALES * np.cos(angle)
        round_off = 1.0 - (aside / (0.27 * _CABLE_WALES)) ** 2
        # What lies aside is level; in the middle one strand is over the other.
        loops = 0.75 * _plain_side(aside + 0.5, along)
        rope = loops + 1.4 * np.sqrt(np.maximum(round_off, 0.0)) + 0.9 * np.sin(angle) + 0.3
        height = np.maximum(height, np.where(round_off > 0.0, rope, 0.0))
    return np.asarray(height)


def _make(
    stitch: Callable[[tx.Field, tx.Field], tx.Field],
    wale: tuple[float, float],
    repeat: tuple[int, int],
    depth: float,
    order: tx.TextureParams,
) -> tx.Maps:
    """A knitted fabric with whole repeats of wales and courses.

    Args:
        stitch: Height of a place in wales and courses.
        wale: Range of a wale's width, metres.
        repeat: Wales and courses after which the fabric repeats.
        depth: What a height of one is, in wales.
        order: What is asked for.
    """
    n, rng = order.resolution, order.rng
    mean = tx.mean_color(order, COLORS + NATURALS)
    pitch = float(rng.uniform(*wale))
    wales = lattice.whole(order, pitch, repeat[0])
    courses = lattice.whole(order, pitch / _COURSES_PER_WALE, repeat[1])
    uneven = 0.10 * tx.noise(order, 6.0 * pitch) + 0.05 * tx.noise(order, 1.2 * pitch)
    # Courses rise against the rows.
    height = stitch(lattice.phase(n, wales), -lattice.phase(n, courses)[:, None] + uneven)
    hairs = tx.noise(order, 0.3 * pitch)
    low = float(height.min())
    share = (height - low) / max(float(height.max()) - low, 1e-9)
    shade = (0.35 + 0.65 * np.sqrt(share)) * (1.0 + 0.08 * hairs)
    unit = depth * lattice.spacing(order, pitch, wales)
    return tx.Maps(
        albedo=tx.tinted(np.maximum(shade, 0.05), mean),
        height=unit * (height + 0.05 * hairs) + 0.15 * pitch * tx.noise(order, 0.05),
        roughness=tx.around(tx.drawn_roughness(order, 0.84, 0.94), -0.06 * share),
    )


KNITTED: Final[dict[str, tx.Family]] = {
    name: tx.Family(
        lattice.resolved(partial(_make, stitch, wale, repeat, _LOOP_HEIGHT_WALES), 0.5 * wale[0]),
        size,
        frozenset({"textile", "furniture"}),
        grain=True,
        laid=4 if size < 0.15 else 2,
    )
    for name, stitch, wale, repeat, size in (
        ("jersey_knit", _plain_side, (0.0013, 0.0016), (1, 1), 0.1),
        ("rib_knit", _rib, (0.0022, 0.0027), (4, 1), 0.16),
        ("cable_knit", _cable, (0.0036, 0.0042), (_REPEAT_WALES, 2 * _CROSSING_COURSES), 0.24),
    )
}


Figure = Callable[[int, int], Mask]
Shape = Callable[[tx.TextureParams], tx.Field]


@dataclass(frozen=True)
class Fabric:
    """A woven fabric.

    Attributes:
        size: Usual physical size of its picture, metres.
        weave: Its pattern.
        warp: Its ends.
        weft: Its picks.
        dye: Colours of ends and picks.
        roughness: Range of its mean.
        relief: Height of a thread's tube, share of its radius.
        crimp: How far threads rise and sink, in radii.
        hollow: How dark the hollows between threads are, 0..1.
        fuzz: How much hairs blur it.
        wrinkle: Standard deviation of the height over a few centimetres, metres.
        figure: Where, over (picks, ends), the weave is turned to its other face.
        shape: (N, N) relief on top of that of threads, metres.
        uses: Where people have it.
    """

    size: float
    weave: Pattern
    warp: Thread
    weft: Thread
    dye: Dye = dyes.PLAIN
    roughness: tuple[float, float] = (0.8, 0.92)
    relief: float = 0.7
    crimp: float = 0.45
    hollow: float = 0.5
    fuzz: float = 0.05
    wrinkle: float = 60e-6
    figure: Figure | None = None
    shape: Shape | None = None
    uses: frozenset[tx.Use] = frozenset({"textile", "furniture"})


def make(fabric: Fabric, order: tx.TextureParams) -> tx.Maps:
    """A cloth with whole repeats of its weave and of its stripes on each side."""
    rng = order.rng
    end_colors, pick_colors = fabric.dye.drawn(order)
    ends = _count(order, fabric.warp, fabric.weave.shape[1], len(end_colors))
    picks = _count(order, fabric.weft, fabric.weave.shape[0], len(pick_colors))
    weave = fabric.weave
    if fabric.figure is not None:
        whole_cloth = np.tile(weave, (picks // len(weave), ends // weave.shape[1]))
        weave = np.where(fabric.figure(picks, ends), 1 - whole_cloth, whole_cloth)
    threads = (fabric.warp, fabric.weft)
    cloth = woven(rng, weave, threads, (ends, picks), order.resolution, fabric.crimp)
    hollow = np.clip(0.5 + 0.5 * cloth.height, 0.0, 1.0)
    hairs = tx.noise(order, 0.0009)
    shade = cloth.tone * (1.0 - fabric.hollow * (1.0 - hollow)) * (1.0 + fabric.fuzz * hairs)
    colors = _colored(cloth, end_colors, pick_colors, (ends, picks))
    pitch = min(1.0 / fabric.warp.density[0], order.size / max(ends, picks))
    height = 0.5 * fabric.relief * pitch * cloth.height + fabric.wrinkle * tx.noise(order, 0.05)
    if fabric.shape is not None:
        height = height + fabric.shape(order)
    rough = tx.drawn_roughness(order, *fabric.roughness)
    mean = None if order.color is None else np.array(order.color)
    return tx.Maps(
        albedo=tx.tinted(colors * np.maximum(shade, 0.05)[..., None], mean),
        height=height,
        roughness=tx.around(rough, -0.06 * hollow),
    )


def _count(order: tx.TextureParams, thread: Thread, weave: int, stripes: int) -> int:
    pitch = 1.0 / order.rng.uniform(*thread.density)
    return lattice.whole(order, pitch, math.lcm(weave, stripes))


def _colored(cloth: Cloth, ends: tx.Field, picks: tx.Field, counts: tuple[int, int]) -> tx.Field:
    """(N, N, 3) colour of the thread on top."""
    resolution = len(cloth.height)
    end = np.floor(lattice.phase(resolution, counts[0])).astype(np.int64) % len(ends)
    pick = np.floor(lattice.phase(resolution, counts[1])).astype(np.int64) % len(picks)
    return np.where(cloth.is_warp[..., None], ends[end][None], picks[pick][:, None])


def medallions(picks: int, ends: int) -> Mask:
    """Lobed flowers within ogees, every second row moved by half."""
    columns = 2
    rows = 2 * max(1, round(columns * picks / ends / 2))
    t, s = np.meshgrid(lattice.phase(picks, rows), lattice.phase(ends, columns), indexing="ij")
    figure = np.zeros(s.shape, np.bool_)
    for moved in (0.0, 0.5):
        x, y = lattice.offset(s + moved), lattice.offset(t / 2 + moved / 1.0) * 1.2
        radius, angle = np.hypot(x, y), np.arctan2(x, y)
        petals = 0.34 * (1.0 + 0.28 * np.cos(6.0 * angle))
        ring = np.abs(radius - 0.56 - 0.05 * np.cos(12.0 * angle)) < 0.045
        figure |= ((radius < petals) & (radius > 0.10)) | (radius < 0.055) | ring
    vine = np.abs(np.abs(np.cos(np.pi * s)) - np.abs(np.sin(np.pi * t / 2))) < 0.10
    return np.asarray(figure | vine)


def waffle(order: tx.TextureParams) -> tx.Field:
    """Square hollows between ridges, deepest in their middles."""
    count = lattice.whole(order, 0.0055)
    ridge = np.abs(lattice.offset(lattice.phase(order.resolution, count)))
    deep = lattice.spacing(order, 0.0055, count) * 0.28
    return np.asarray(deep * np.maximum(ridge[:, None], ridge) ** 1.5)


def puckers(order: tx.TextureParams) -> tx.Field:
    """Stripes that lie flat, and stripes that were woven slack and ripple."""
    count = lattice.whole(order, 0.008)
    slack = tx.smoothstep(-0.35, 0.35, np.cos(2.0 * np.pi * lattice.phase(order.resolution, count)))
    return np.asarray(0.00018 * slack * (tx.noise(order, 0.006, 0.004) + 0.3))


# Cloths whose pictures are as wide are laid twice along each side, all others four times; metres.
_WIDE_M: Final = 0.2
_PATTERNED: Final = (dyes.HOUNDSTOOTH, dyes.TARTAN, dyes.TICKING, dyes.SEERSUCKER)


def _yarn(per_cm: float, **options: float) -> Thread:
    return Thread((93.0 * per_cm, 107.0 * per_cm), **options)


_WEAVES: Final[Mapping[str, Callable[..., Pattern]]] = {
    "pattern": pattern,
    "twill": twill,
    "satin": satin,
    "pointed_twill": lambda up, down, width: pointed(twill(up, down), width),
}
_NAMED: Final = {"medallions": medallions, "waffle": waffle, "puckers": puckers}


def _fabric(told: dict[str, Any]) -> Fabric:
    """A cloth of the table."""
    weave, *given = told.pop("weave")
    made: dict[str, Any] = {name: _yarn(**told.pop(name)) for name in ("warp", "weft")}
    made["dye"] = getattr(dyes, told.pop("dye", "PLAIN"))
    made |= {name: _NAMED[told.pop(name)] for name in ("figure", "shape") if name in told}
    made |= {"uses": frozenset(told.pop("uses"))} if "uses" in told else {}
    return Fabric(weave=_WEAVES[weave](*given), **made, **told)


WOVEN: Final = {n: _fabric(told) for n, told in read_table(__file__, "cloths.toml").items()}


def _family(fabric: Fabric) -> tx.Family:
    finest = 1.0 / max(fabric.warp.density[1], fabric.weft.density[1])
    # What has a large pattern shows its repeat, as it should.
    drawn = fabric.figure is not None or fabric.dye in _PATTERNED
    laid = 1 if drawn else 4 if fabric.size < _WIDE_M else 2
    make_cloth = lattice.resolved(partial(make, fabric), finest)
    return tx.Family(make_cloth, fabric.size, fabric.uses, grain=True, laid=laid)


FAMILIES: Final[dict[str, tx.Family]] = {
    **{name: _family(fabric) for name, fabric in WOVEN.items()},
    **KNITTED,
    **PILED,
}
