"""Lobes at their best places: moved together, one exchanged for another, and moved again.

All axes and sharpnesses of a point move by damped Gauss-Newton steps (K. Levenberg 1944, D.
Marquardt 1963), with the best colours that are not negative after each, as long as it pays. All
that a step needs of the cells are the products of the lobes and their slopes with one another and
with the light. Where steps end, another lobe of the set may still be wanted more than one of these.
"""

from dataclasses import dataclass, fields
from typing import Final

import numpy as np

from openrooms_usd.arrays import Floats, Ints
from openrooms_usd.geometry.lobe_pursuit import CELLS, MAX_SHARPNESS, most_wanted, raised

_MIN_SHARPNESS: Final = 0.1
# Steps at most, before the exchange and after it; after two in a row that take less than this share
# of what was left a point is done.
_MAX_STEPS: Final = 20
_MIN_GAIN_SHARE: Final = 0.03
_POOR_STEPS: Final = 2
# Sweeps over the colours of all lobes, after which they hardly change: at first, and after a step.
_SWEEPS: Final = (6, 3)
# The largest turn of an axis and change of a sharpness's logarithm in one step.
_MAX_TURN: Final = 0.3
# Cells of one product of rows.
_PIECE: Final = 128
# The damping at first, and what it is multiplied by after a step that helps, and one that does not.
_DAMPING: Final = np.float32(3.0)
_BOLDER: Final = np.float32(0.3)
_SHYER: Final = np.float32(4.0)
# (4, cells): sharpness (axis . d - 1) and its slopes are sums of these.
_FORMS: Final = np.concatenate([np.ones_like(CELLS[:, :1]), CELLS], axis=1).T.copy()


@dataclass(eq=False)
class Lobes:
    """Of P points with K lobes each, and what they and their slopes have in common with the light.

    The slopes are those by the sharpness's logarithm and by two turns of the axis, of the colour 1.

    Attributes:
        axes: (P, K, 3) unit.
        sharpness: (P, K).
        colors: (P, K, 3).
        products: (P, 4 K, 4 K) of the lobes, then the slopes of each kind, with one another.
        target: (P, 4 K, 3) of the same with the light.
        loss: (P,) weighed sum of squares of what is left.
    """

    axes: Floats
    sharpness: Floats
    colors: Floats
    products: Floats
    target: Floats
    loss: Floats

    def of(self, points: Ints) -> "Lobes":
        """Those of some points."""
        return Lobes(*(getattr(self, field.name)[points] for field in fields(self)))

    def put(self, points: Ints, lobes: "Lobes") -> None:
        """Set those of some points."""
        for field in fields(self):
            getattr(self, field.name)[points] = getattr(lobes, field.name)


def refined(axes: Floats, sharpness: Floats, light: Floats, weights: Floats, room: Floats) -> Lobes:
    """Lobes moved, then one of each point exchanged and all moved again where that is better.

    Args:
        axes: (P, K, 3) to begin with.
        sharpness: (P, K).
        light: (P, cells, 3) to be made of lobes.
        weights: (P, cells) of squared differences.
        room: (P, 4 K, cells) to work in.
    """
    root = np.sqrt(weights)
    light = light * root[..., None]
    lobes = _colored(axes, sharpness, np.zeros_like(axes), light, root, room, _SWEEPS[0])
    _move(lobes, light, root, room)
    others = _colored(*_exchanged(lobes, light, root), light, root, room, _SWEEPS[0])
    _move(others, light, root, room)
    better = np.flatnonzero(others.loss < lobes.loss)
    lobes.put(better, others.of(better))
    return lobes


def _exchanged(lobes: Lobes, light: Floats, root: Floats) -> tuple[Floats, Floats, Floats]:
    """Axes, sharpness and colours where the most wanted lobe stands for the one missed least.

    What is lost with a lobe, the others' colours being the best then, is the square of its colour
    over its entry in the diagonal of the inverse Gram matrix (B. Hassibi, D. Stork, Second Order
    Derivatives for Network Pruning: Optimal Brain Surgeon, 1992).

    Args:
        lobes: Fitted.
        light: (P, cells, 3) times ``root``.
        root: (P, cells) of the weights.
    """
    count, points = lobes.sharpness.shape[1], np.arange(len(root))
    gram = lobes.products[:, :count, :count]
    ridge = 1e-6 * np.einsum("pkk->p", gram) / count
    inverse = np.linalg.inv(gram + ridge[:, None, None] * np.eye(count, dtype=np.float32))
    lost = (lobes.colors**2).sum(axis=2) / np.einsum("pkk->pk", inverse)
    which = np.argmin(lost, axis=1)
    shapes = raised(lobes.sharpness[..., None] * (lobes.axes @ CELLS.T - 1.0))
    left = light * root[..., None] - (shapes.swapaxes(1, 2) @ lobes.colors) * root[..., None] ** 2
    axes, sharpness, colors = lobes.axes.copy(), lobes.sharpness.copy(), lobes.colors.copy()
    axes[points, which], sharpness[points, which] = most_wanted(left, root**2)
    colors[points, which] = 0.0
    return axes, sharpness, colors


def _move(lobes: Lobes, light: Floats, root: Floats, room: Floats) -> None:
    """Improve axes and sharpnesses by Levenberg's and Marquardt's steps."""
    damping, poor = np.full(len(light), _DAMPING), np.zeros(len(light), dtype=np.int64)
    for _ in range(_MAX_STEPS):
        going = np.flatnonzero(poor < _POOR_STEPS)
        if not len(going):
            break
        now = lobes.of(going)
        axes, sharpness = _stepped(now, damping[going])
        tried = _colored(
            axes, sharpness, now.colors, light[going], root[going], room[: len(going)], _SWEEPS[1]
        )
        better = tried.loss < now.loss
        lobes.put(going[better], tried.of(np.flatnonzero(better)))
        damping[going] *= np.where(better, _BOLDER, _SHYER)
        well = tried.loss < (1.0 - _MIN_GAIN_SHARE) * now.loss
        poor[going] = np.where(well, 0, poor[going] + 1)


def _colored(
    axes: Floats,
    sharpness: Floats,
    colors: Floats,
    light: Floats,
    root: Floats,
    room: Floats,
    sweeps: int,
) -> Lobes:
    """Lobes with the best colours that are not negative, by coordinate descent.

    Args:
        axes: (P, K, 3).
        sharpness: (P, K).
        colors: (P, K, 3) to begin with.
        light: (P, cells, 3) times ``root``.
        root: (P, cells) of the weights.
        room: (P, 4 K, cells) to work in.
        sweeps: How many.
    """
    count = sharpness.shape[1]
    np.matmul(_slopes(axes, sharpness), _FORMS, out=room[:, count:])
    raised(room[:, count : 2 * count], out=room[:, :count])
    room[:, :count] *= root[:, None]
    kinds = room.reshape(len(room), 4, count, -1)
    kinds[:, 1:] *= kinds[:, :1]
    products, target = _products(room), room @ light
    gram, aims, colors = products[:, :count, :count], target[:, :count], colors.copy()
    lengths = np.maximum(np.einsum("pkk->pk", gram), 1e-20)[..., None]
    for _ in range(sweeps):
        for k in range(count):
            step = (aims[:, k] - (gram[:, k, None] @ colors)[:, 0]) / lengths[:, k]
            colors[:, k] = np.maximum(colors[:, k] + step, 0.0)
    loss = np.einsum("pnc,pnc->p", light, light)
    loss += np.einsum("pkc,pkc->p", colors, gram @ colors - 2.0 * aims)
    return Lobes(axes, sharpness, colors, products, target, loss)


def _products(rows: Floats) -> Floats:
    """(P, N, N) of the rows of (P, N, cells), in pieces that BLAS gives to one thread.

    Where it shares a product out, as it does on processors without AVX-512, the last bits are other
    ones for another number of threads.
    """
    pieces = (rows[..., at : at + _PIECE] for at in range(0, rows.shape[-1], _PIECE))
    return np.asarray(sum(piece @ piece.swapaxes(1, 2) for piece in pieces))


def _slopes(axes: Floats, sharpness: Floats) -> Floats:
    """(P, 3 K, 4) of a lobe's logarithm, in `_FORMS`: by sharpness's logarithm and by turns.

    The first of them is the logarithm itself.
    """
    ways = np.stack([axes, *_tangents(axes)], axis=1)
    first = np.zeros_like(ways[..., :1])
    first[:, 0] = -1.0
    slopes = np.concatenate([first, ways], axis=-1) * sharpness[:, None, :, None]
    return np.asarray(slopes.reshape(len(axes), -1, 4))


def _stepped(lobes: Lobes, damping: Floats) -> tuple[Floats, Floats]:
    """Axes and sharpness after one step of all of them, the colours held.

    How a lobe changes does not depend on its colour but for a factor. So the normal matrix is that
    of the slopes, times the products of the colours.
    """
    points, count = lobes.sharpness.shape
    colors = np.tile(lobes.colors, (1, 3, 1))
    normal = lobes.products[:, count:, count:] * (colors @ colors.swapaxes(1, 2))
    left = lobes.target[:, count:] - lobes.products[:, count:, :count] @ lobes.colors
    diagonal = np.einsum("pkk->pk", normal)
    diagonal *= 1.0 + damping[:, None]
    diagonal += 1e-6 * diagonal.mean(axis=1, keepdims=True) + 1e-20
    step = np.linalg.solve(normal, (left * colors).sum(axis=2, keepdims=True))
    wider, *turns = np.clip(step.reshape(points, 3, count, 1), -_MAX_TURN, _MAX_TURN).swapaxes(0, 1)
    axes = lobes.axes + sum(
        turn * way for turn, way in zip(turns, _tangents(lobes.axes), strict=True)
    )
    axes[..., 2] = np.maximum(axes[..., 2], 0.0)
    axes /= np.linalg.norm(axes, axis=-1, keepdims=True)
    return axes, np.clip(lobes.sharpness * np.exp(wider[..., 0]), _MIN_SHARPNESS, MAX_SHARPNESS)


def _tangents(axes: Floats) -> tuple[Floats, Floats]:
    """Two unit vectors across each axis of the upper hemisphere (J. Frisvad 2012)."""
    x, y, z = np.moveaxis(axes, -1, 0)
    share = -1.0 / (1.0 + z)
    both = x * y * share
    return (
        np.stack([1.0 + x * x * share, both, -x], axis=-1),
        np.stack([both, 1.0 + y * y * share, -y], axis=-1),
    )
