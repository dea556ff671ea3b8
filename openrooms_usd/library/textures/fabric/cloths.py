"""How a woven fabric is made of its weave, its threads, its dyes and its finish."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.library.textures.base.family import Order, Use
from openrooms_usd.library.textures.base.lattice import offset, phase, spacing, whole
from openrooms_usd.library.textures.base.maps import Maps
from openrooms_usd.library.textures.base.noise import Field, smoothstep
from openrooms_usd.library.textures.base.recipe import drawn_roughness, noise
from openrooms_usd.library.textures.base.tints import around, tinted
from openrooms_usd.library.textures.fabric import dyes
from openrooms_usd.library.textures.fabric.dyes import Dye
from openrooms_usd.library.textures.fabric.weave import Cloth, Pattern, Thread, woven

Figure = Callable[[int, int], NDArray[np.bool_]]
Shape = Callable[[Order], Field]


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
    uses: frozenset[Use] = frozenset({"textile", "furniture"})


def make(fabric: Fabric, order: Order) -> Maps:
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
    hairs = noise(order, 0.0009)
    shade = cloth.tone * (1.0 - fabric.hollow * (1.0 - hollow)) * (1.0 + fabric.fuzz * hairs)
    colors = _colored(cloth, end_colors, pick_colors, (ends, picks))
    pitch = min(1.0 / fabric.warp.density[0], order.size / max(ends, picks))
    height = 0.5 * fabric.relief * pitch * cloth.height + fabric.wrinkle * noise(order, 0.05)
    if fabric.shape is not None:
        height = height + fabric.shape(order)
    rough = drawn_roughness(order, *fabric.roughness)
    mean = None if order.color is None else np.array(order.color)
    return Maps(
        albedo=tinted(colors * np.maximum(shade, 0.05)[..., None], mean),
        height=height,
        roughness=around(rough, -0.06 * hollow),
    )


def _count(order: Order, thread: Thread, weave: int, stripes: int) -> int:
    pitch = 1.0 / order.rng.uniform(*thread.density)
    return whole(order, pitch, math.lcm(weave, stripes))


def _colored(cloth: Cloth, ends: Field, picks: Field, counts: tuple[int, int]) -> Field:
    """(N, N, 3) colour of the thread on top."""
    resolution = len(cloth.height)
    end = np.floor(phase(resolution, counts[0])).astype(np.int64) % len(ends)
    pick = np.floor(phase(resolution, counts[1])).astype(np.int64) % len(picks)
    return np.where(cloth.is_warp[..., None], ends[end][None], picks[pick][:, None])


def medallions(picks: int, ends: int) -> NDArray[np.bool_]:
    """Lobed flowers within ogees, every second row moved by half."""
    columns = 2
    rows = 2 * max(1, round(columns * picks / ends / 2))
    t, s = np.meshgrid(phase(picks, rows), phase(ends, columns), indexing="ij")
    figure = np.zeros(s.shape, np.bool_)
    for moved in (0.0, 0.5):
        x, y = offset(s + moved), offset(t / 2 + moved / 1.0) * 1.2
        radius, angle = np.hypot(x, y), np.arctan2(x, y)
        petals = 0.34 * (1.0 + 0.28 * np.cos(6.0 * angle))
        ring = np.abs(radius - 0.56 - 0.05 * np.cos(12.0 * angle)) < 0.045
        figure |= ((radius < petals) & (radius > 0.10)) | (radius < 0.055) | ring
    vine = np.abs(np.abs(np.cos(np.pi * s)) - np.abs(np.sin(np.pi * t / 2))) < 0.10
    return np.asarray(figure | vine)


def waffle(order: Order) -> Field:
    """Square hollows between ridges, deepest in their middles."""
    count = whole(order, 0.0055)
    ridge = np.abs(offset(phase(order.resolution, count)))
    deep = spacing(order, 0.0055, count) * 0.28
    return np.asarray(deep * np.maximum(ridge[:, None], ridge) ** 1.5)


def puckers(order: Order) -> Field:
    """Stripes that lie flat, and stripes that were woven slack and ripple."""
    count = whole(order, 0.008)
    slack = smoothstep(-0.35, 0.35, np.cos(2.0 * np.pi * phase(order.resolution, count)))
    return np.asarray(0.00018 * slack * (noise(order, 0.006, 0.004) + 0.3))
