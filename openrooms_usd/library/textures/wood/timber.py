"""The face of a piece of wood: annual rings cut by it, pores, rays, figure, knots.

A tree is a bundle of cones about its pith. Where a face cuts the rings steeply they are nearly
straight lines, where it runs along them they are arches ("cathedrals"); a peeled veneer wanders
in and out of them.
"""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from openrooms_usd.library.textures.base import vocabulary as tx
from openrooms_usd.library.textures.wood.boards import Boards
from openrooms_usd.library.textures.wood.species import Cut, Timber

# Height of latewood above earlywood, depth of a pore: metres.
_RIDGE: Final = 15e-6
_PORE: Final = 60e-6
# Share of a ring at which it begins to darken, is darkest, and ends; and where it has early pores.
_LATE: Final = (0.35, 0.9, 0.97)
_EARLY: Final = (0.0, 0.06, 0.38)


@dataclass(frozen=True)
class Face:
    """The face of pieces of wood before joints and finish.

    Attributes:
        shade: (N, N) brightness, about 1.
        height: (N, N) metres.
        gloss: (N, N) what is added to the roughness.
        late: (N, N) share of latewood.
        knot: (N, N) how far inside a knot, metres; negative around it.
    """

    shade: tx.Field
    height: tx.Field
    gloss: tx.Field
    late: tx.Field
    knot: tx.Field

    def darker(self, factor: tx.Field) -> "Face":
        """The same with its brightness multiplied."""
        return replace(self, shade=self.shade * factor)

    def colored(self, order: tx.TextureParams, timber: Timber) -> tx.Field:
        """(N, N, 3) albedo: dark parts are redder than light ones."""
        drawn = np.array(timber.color) * order.rng.uniform(0.88, 1.12)
        mean = drawn if order.color is None else np.array(order.color)
        redness = np.array([1.0 - timber.redder, 1.0, 1.0 + timber.redder])
        return tx.with_mean(np.maximum(self.shade, 0.04)[..., None] ** redness, mean)


def face(order: tx.TextureParams, boards: Boards, timber: Timber, variety: float = 0.1) -> Face:
    """The face of pieces of one timber.

    Args:
        order: What is asked for.
        boards: The pieces, each cut from another place.
        timber: The species.
        variety: How much lighter or darker whole pieces are.
    """
    branches = knots(order, boards, timber.knots, timber.knot)
    uneven, streak, fibre, mottle = boards.cut(
        order,
        _unevenness(order, timber),
        tx.noise(order, *timber.pore),
        tx.noise(order, 0.0025, 0.2),
        (1.0 + 0.03 * tx.noise(order, 0.08, 0.5)) * (1.0 + _figure(order, timber)),
    )
    rings = _rings(order, boards, timber, uneven + 1.2 * branches.lift)
    late = _profile(rings, _LATE)
    pores = _pores(timber, streak, rings, late)
    tone = boards.each(order.rng.uniform(-1.0, 1.0, boards.count))
    inside = tx.smoothstep(-0.001, 0.002, branches.depth)
    shade = (
        (1.0 - timber.late * late)
        * (1.0 + 0.03 * fibre)
        * (1.0 - timber.pores * pores)
        * (1.0 + variety * tone)
        * mottle
        * (1.0 - inside * (0.45 + 0.2 * np.cos(branches.depth * (2.0 * np.pi / 0.0018))))
    )
    return Face(
        shade=shade,
        height=_RIDGE * late - _PORE * timber.pores * pores,
        gloss=0.012 * fibre + 0.1 * timber.pores * pores - 0.03 * (late - 0.5),
        late=late,
        knot=branches.depth,
    )


def lacquered(
    order: tx.TextureParams, wood: Face, timber: Timber, gloss: tuple[float, float]
) -> tx.Maps:
    """Planed, sanded and finished; no joint is felt."""
    roughness = tx.drawn_roughness(order, *gloss)
    return tx.finished(order, wood.colored(order, timber), wood.height, roughness + wood.gloss)


def _unevenness(order: tx.TextureParams, timber: Timber) -> tx.Field:
    """(N, N) how far rings lie beside where a round tree has them, metres."""
    fine = 0.0006 * tx.noise(order, 0.012, 0.12)
    if timber.cut == "peeled":
        return 0.011 * tx.noise(order, 0.16, 0.5) + fine
    return 0.003 * tx.noise(order, 0.07, 0.4) + fine


def _rings(order: tx.TextureParams, boards: Boards, timber: Timber, uneven: tx.Field) -> tx.Field:
    """(N, N) number of the ring: the rings of each piece's own tree."""
    ring = order.rng.uniform(*timber.ring, boards.count)
    radius = uneven if timber.cut == "peeled" else uneven + _radius(order, boards, timber.cut)
    rings = radius / boards.each(ring)
    # Good and bad years; less than one ring from one to the next, so that the order stays.
    years = order.rng.uniform(-0.35, 0.35, 256)
    years[-1] = years[0]
    return rings + np.interp((rings + 17.0 * boards.index) % 255.0, np.arange(256), years)


def _radius(order: tx.TextureParams, boards: Boards, cut: Cut) -> tx.Field:
    """(N, N) distance to the pith, metres; periodic along the grain over the picture."""
    rng, count = order.rng, boards.count
    flat = rng.random(count) < 0.5 if cut == "mixed" else np.full(count, cut == "flat")
    side = np.where(rng.random(count) < 0.5, -1.0, 1.0)
    pith = np.where(flat, rng.uniform(-0.1, 0.1, count), side * rng.uniform(0.15, 0.4, count))
    depth = np.where(flat, rng.uniform(0.02, 0.1, count), rng.uniform(0.0, 0.02, count))
    # About a metre, a whole number of times.
    turn = 2.0 * np.pi * tx.whole(order.size, 1.1) / order.size
    phase = rng.uniform(0.0, 2.0 * np.pi, (2, count))
    lean, bend = rng.uniform(0.004, 0.016, count), rng.uniform(0.0, 0.003, count)
    below = boards.each(depth) + boards.each(lean) * np.sin(
        turn * boards.along + boards.each(phase[0])
    )
    below += boards.each(bend) * np.sin(2.0 * turn * boards.along + boards.each(phase[1]))
    return np.hypot(boards.across - boards.each(pith), below)


def _profile(rings: tx.Field, rise: tuple[float, float, float]) -> tx.Field:
    """A part of each ring, averaged over the texel so that fine rings fade, not alias."""
    begin, full, end = rise
    share = np.linspace(0.0, 1.0, 129)
    profile = tx.smoothstep(begin, full, share) * (1.0 - tx.smoothstep(full, end, share))
    total = np.concatenate([[0.0], np.cumsum((profile[1:] + profile[:-1]) / 2) / 128])

    def integral(x: tx.Field) -> tx.Field:
        turns = np.floor(x)
        return np.asarray(turns * total[-1] + np.interp(x - turns, share, total))

    step_t, step_s = np.gradient(rings)
    width = np.clip(np.abs(step_t) + np.abs(step_s), 0.02, 4.0)
    return np.asarray((integral(rings + width / 2) - integral(rings - width / 2)) / width)


def _pores(timber: Timber, streak: tx.Field, rings: tx.Field, late: tx.Field) -> tx.Field:
    if timber.porous == "ring":
        early = _profile(rings, _EARLY)
        return tx.smoothstep(-0.3, 1.6, streak) * early + 0.4 * tx.smoothstep(1.6, 2.6, streak)
    return tx.smoothstep(0.9, 2.4, streak) * (1.0 - 0.5 * late)


def _figure(order: tx.TextureParams, timber: Timber) -> tx.Field:
    """(N, N) what rays, curls, ribbons and streaks add to the brightness."""
    figure = np.zeros((order.resolution, order.resolution))
    if timber.flecks:
        rays = tx.fibres(order.rng, order.resolution, order.size, *timber.fleck)
        figure += timber.flecks * tx.smoothstep(1.0, 1.9, rays)
    if timber.curl[0]:
        figure += timber.curl[0] * _waves(order, timber.curl[1])
    if timber.ribbon[0]:
        width = timber.ribbon[1]
        figure += timber.ribbon[0] * np.tanh(tx.noise(order, width, 0.5))
        figure += 0.3 * timber.ribbon[0] * tx.noise(order, width / 2, 0.05)
    if timber.streaks:
        figure -= timber.streaks * tx.smoothstep(0.1, 1.9, tx.noise(order, 0.03, 0.6))
    return figure


def _waves(order: tx.TextureParams, distance: float) -> tx.Field:
    """(N, N) waves across the grain that end and begin again, about -1..1."""
    count = tx.whole(order.size, distance)
    place = (np.arange(order.resolution)[:, None] + 0.5) / order.resolution * count
    bent = 0.6 * tx.noise(order, 0.07, 0.05) + 0.12 * tx.noise(order, 0.012, 0.03)
    strength = tx.smoothstep(-2.2, 1.2, tx.noise(order, 0.05, 0.12))
    return np.asarray(strength * np.sin(2.0 * np.pi * (place + bent)))


# How far the grain feels a knot, in its radii across and along.
_REACH: tuple[float, float] = (3.0, 7.0)


@dataclass(frozen=True)
class Knots:
    """Knots of a surface.

    Attributes:
        lift: (N, N) by how much rings are moved around them, in radii of the knot.
        depth: (N, N) how far inside a knot, metres; negative around it.
    """

    lift: tx.Field
    depth: tx.Field


def knots(
    order: tx.TextureParams, boards: Boards, density: float, radius: tuple[float, float]
) -> Knots:
    """Knots by chance; each stays on its own piece.

    Args:
        order: What is asked for.
        boards: The pieces.
        density: How many there are on a square metre.
        radius: Range of their radii, metres.
    """
    shape = (order.resolution, order.resolution)
    found = Knots(np.zeros(shape), np.full(shape, -1.0))
    for size in order.rng.uniform(*radius, round(density * order.size**2)):
        _grow(order, boards, found, float(size))
    return found


def _grow(order: tx.TextureParams, boards: Boards, found: Knots, size: float) -> None:
    texel = order.size / order.resolution
    middle = order.rng.uniform(0.0, order.size, 2)
    oval = order.rng.uniform(1.0, 1.5)
    reach = [min(far * size, order.size / 2 - texel) for far in _REACH]
    columns, rows = (
        np.arange(int((at - far) // texel), int((at + far) // texel) + 1)
        for at, far in zip(middle, reach, strict=True)
    )
    across = (columns + 0.5) * texel - middle[0]
    along = ((rows + 0.5) * texel - middle[1])[:, None] / oval
    window = np.ix_(rows % order.resolution, columns % order.resolution)
    own = boards.index[window] == boards.index[tuple((middle[::-1] / texel).astype(int))]
    # Fades out to nothing at the reach, so that the window leaves no edge.
    far = np.hypot(across / reach[0], along * oval / reach[1])
    fade = np.clip(1.0 - far, 0.0, 1.0)
    lift = size * np.exp(-((across / size) ** 2 + (along / (2.5 * size)) ** 2) / 2.0) * fade
    found.lift[window] += lift * own
    inside = np.where(own, size - np.hypot(across, along), -1.0)
    found.depth[window] = np.maximum(found.depth[window], inside)
