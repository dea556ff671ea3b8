"""Weaving: threads that go over and under each other. The warp runs along t, the weft along s.

Every thread is a tube whose height follows the weave: up where it lies on top, down where it is
covered. What one sees is the higher thread, with its own colour. Tubes are sums of functions of
rows and columns but for what varies along a thread, which is made a thread at a time.
"""

import math
from dataclasses import dataclass

import numpy as np

from openrooms_usd.arrays import Ints, Mask
from openrooms_usd.library.textures.base import lattice
from openrooms_usd.library.textures.base import vocabulary as tx

Pattern = Ints


@dataclass(frozen=True)
class Thread:
    """One set of threads.

    Attributes:
        density: Range of their number, a metre.
        slub: How unevenly thick they are along their length, share of their thickness.
        melange: Unevenness of their colour along their length.
        bend: How far they stray sideways, share of their distance.
        twist: Contrast of the plies that wind about them.
    """

    density: tuple[float, float]
    slub: float = 0.1
    melange: float = 0.1
    bend: float = 0.06
    twist: float = 0.0


@dataclass(frozen=True)
class Cloth:
    """A cloth without colour.

    Attributes:
        height: (N, N) in radii of a thread, about -1..1.5.
        is_warp: (N, N) whether the warp is on top.
        tone: (N, N) brightness of the thread on top, about 1.
    """

    height: tx.Field
    is_warp: Mask
    tone: tx.Field


def pattern(*rows: str) -> Pattern:
    """A weave drawn as weavers do: X where the warp is on top."""
    return np.array([[int(mark == "X") for mark in row] for row in rows], np.int64)


def twill(up: int, down: int) -> Pattern:
    """Diagonal ribs: each pick moves the order ``up`` over, ``down`` under by one end."""
    repeat = up + down
    row, column = np.ogrid[:repeat, :repeat]
    return np.asarray((column + row) % repeat < up, np.int64)


def satin(harnesses: int, move: int) -> Pattern:
    """Long floats of the warp, bound once a repeat at places that never touch."""
    row, column = np.ogrid[:harnesses, :harnesses]
    return np.asarray((column - move * row) % harnesses != 0, np.int64)


def pointed(weave: Pattern, width: int) -> Pattern:
    """A twill that turns and breaks every ``width`` ends: herringbone."""
    ends = np.arange(width)
    there = weave[:, ends % weave.shape[1]]
    return np.concatenate([there, 1 - there[:, ::-1]], axis=1)


def woven(
    rng: np.random.Generator,
    weave: Pattern,
    threads: tuple[Thread, Thread],
    counts: tuple[int, int],
    resolution: int,
    crimp: float = 0.45,
) -> Cloth:
    """Weave a cloth.

    Args:
        rng: Where unevenness comes from.
        weave: (p, q) 1 where the warp is on top; repeats.
        threads: Warp and weft.
        counts: How many ends and picks there are.
        resolution: Texels along each side.
        crimp: How far threads rise and sink, in radii.
    """
    ends, picks = counts
    lift: tx.Field = np.asarray(2 * weave - 1, np.float64)
    warp, warp_tone = _tubes(rng, crimp * lift, threads[0], (ends, picks), resolution)
    weft, weft_tone = _tubes(rng, -crimp * lift.T, threads[1], (picks, ends), resolution)
    is_warp = warp >= weft.T
    height = np.maximum(warp, weft.T)
    return Cloth(height, is_warp, np.where(is_warp, warp_tone, weft_tone.T))


def _tubes(
    rng: np.random.Generator,
    lift: tx.Field,
    thread: Thread,
    counts: tuple[int, int],
    resolution: int,
) -> tuple[tx.Field, tx.Field]:
    """(N, N) height in radii and tone of threads along axis 0."""
    across = lattice.phase(resolution, counts[0])
    number = np.floor(across).astype(np.int64)
    thick = 1.0 + thread.slub * _along(rng, resolution, counts, 6.0)
    stray = thread.bend * _along(rng, resolution, counts, 12.0)
    tone = 1.0 + thread.melange * (
        _along(rng, resolution, counts, 5.0) + 0.5 * rng.uniform(-1.0, 1.0, counts[0])
    )
    axis = _rise(lift, counts[1], resolution)[:, np.arange(counts[0]) % lift.shape[1]]
    aside = lattice.offset(across) + 2.0 * stray[:, number]
    # A parabola is round enough, and needs no root.
    height = (axis + thick - 0.5)[:, number] - aside**2 * (0.95 / thick)[:, number]
    return height, tone[:, number] * _plies(thread, counts, resolution)


def _rise(lift: tx.Field, crossings: int, resolution: int) -> tx.Field:
    """(N, q) height of a thread's axis: like a cosine from crossing to crossing."""
    along = lattice.phase(resolution, crossings)
    crossing = np.floor(along).astype(np.int64)
    share = along - crossing - 0.5
    other = np.where(share >= 0.0, crossing + 1, crossing - 1)
    here, there = lift[crossing % len(lift)], lift[other % len(lift)]
    eased = 0.5 - 0.5 * np.cos(np.pi * np.abs(share))
    return np.asarray(here + (there - here) * eased[:, None])


def _along(
    rng: np.random.Generator, resolution: int, counts: tuple[int, int], crossings: float
) -> tx.Field:
    """(N, threads) unevenness along each thread, with features of so many crossings.

    Drawn once a crossing and interpolated by its Fourier series: the same on all grids.
    """
    white = (tx.apart(rng).random((counts[1], counts[0])) - 0.5) * math.sqrt(12.0)
    frequency = np.arange(counts[1] // 2 + 1) / counts[1]
    kernel = np.exp(-2.0 * (0.35 * math.pi * crossings * frequency) ** 2)
    power = np.full(len(kernel), 2.0)
    power[0] = 1.0
    gain = math.sqrt(float(np.sum(power * kernel**2)) / counts[1]) * counts[1] / resolution
    series = np.fft.rfft(white, axis=0) * kernel[:, None]
    return np.clip(np.fft.irfft(series, n=resolution, axis=0) / gain, -2.5, 2.5)


def _plies(thread: Thread, counts: tuple[int, int], resolution: int) -> tx.Field:
    """(N, N) slanted stripes of the plies, one turn for each crossing thread."""
    if thread.twist == 0.0:
        return np.ones((resolution, 1))
    turn = 2.0 * np.pi * lattice.phase(resolution, counts[1])[:, None]
    slant = 2.5 * lattice.offset(lattice.phase(resolution, counts[0]))
    return np.asarray(
        1.0 + thread.twist * (np.sin(turn) * np.cos(slant) + np.cos(turn) * np.sin(slant))
    )
