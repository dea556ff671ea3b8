"""Soft things as closed thin solids: pillows, covers laid over a bed, curtains in folds."""

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.geometry.normals import with_normals
from openrooms_usd.geometry.sweeps import sheet
from openrooms_usd.geometry.vectors import points_at

# Wide curtains have as many folds as this, and broader ones.
_FOLDS = 26


def ripples(x: Array, y: Array, scale: float, rng: np.random.Generator) -> Array:
    """Smooth chance between about -1 and 1 over a surface: a few waves in all directions.

    Args:
        x: Any shape, metres.
        y: The same shape, metres.
        scale: Wavelength, metres.
        rng: Draws directions and phases.
    """
    total = np.zeros(np.broadcast_shapes(x.shape, y.shape))
    for _ in range(5):
        turn, phase = rng.uniform(0.0, 2.0 * np.pi, 2)
        wave = 2.0 * np.pi / (scale * rng.uniform(0.7, 1.5))
        total += np.sin(wave * (np.cos(turn) * x + np.sin(turn) * y) + phase)
    return total / 3.0


def pillow(
    width: float, depth: float, thick: float, rng: np.random.Generator, *, divisions: int = 14
) -> Mesh:
    """A filled case: plump in the middle, a seam all around that is drawn in between its corners.

    Args:
        width: Along X, from corner to corner, metres.
        depth: Along Y, metres.
        thick: Along Z, metres.
        rng: Draws its creases.
        divisions: Quads along each side.

    Returns:
        The closed mesh, its middle in the origin.
    """
    t = np.sin(0.5 * np.pi * np.linspace(-1.0, 1.0, divisions + 1))
    u, v = np.meshgrid(t, t)
    inside = (1.0 - u**2) * (1.0 - v**2)
    x = 0.5 * width * u * (1.0 - 0.07 * (1.0 - v**2))
    y = 0.5 * depth * v * (1.0 - 0.07 * (1.0 - u**2))
    height = 0.5 * thick * inside**0.46
    top, bottom = (height * (1.0 + 0.06 * ripples(x, y, 0.3 * width, rng)) for _ in range(2))
    scale = 0.5 * thick / np.array([top.max(), bottom.max()])
    return _case(x, y, scale[0] * top, -scale[1] * bottom)


def _case(x: Array, y: Array, top: Array, bottom: Array) -> Mesh:
    """Two grids that meet at their rims."""
    rows, columns = x.shape
    upper = np.arange(x.size).reshape(x.shape)
    lower = upper.copy()
    inner = (slice(1, rows - 1), slice(1, columns - 1))
    lower[inner] = x.size + np.arange((rows - 2) * (columns - 2)).reshape(rows - 2, columns - 2)
    points = np.concatenate(
        [points_at(x, y, top).reshape(-1, 3), points_at(x, y, bottom)[inner].reshape(-1, 3)]
    )
    above, below = (
        np.stack([n[:-1, :-1], n[:-1, 1:], n[1:, 1:], n[1:, :-1]], axis=-1).reshape(-1, 4)
        for n in (upper, lower)
    )
    indices = np.concatenate([above, below[:, ::-1]]).reshape(-1)
    mesh = Mesh(
        points=points,
        counts=np.full(2 * len(above), 4, dtype=np.int32),
        indices=indices.astype(np.int32),
        st=points[indices, :2].astype(np.float32),
    )
    return with_normals(mesh, crease=65.0)


def cover(
    half: float,
    span: tuple[float, float],
    level: float,
    drop: tuple[float, float],
    thick: float,
    rng: np.random.Generator,
    *,
    radius: float = 0.03,
    puff: float = 0.008,
) -> Mesh:
    """A cloth laid over a bed: flat on top, hanging down at its sides and at its near end.

    Args:
        half: Half of the width of the bed's top, metres.
        span: Y of its near end, over which it hangs, and of its far end, where it lies.
        level: Z of its upper side where it lies flat, metres.
        drop: How far it hangs down at the sides and at the near end, metres; 0 to lie only.
        thick: Metres.
        rng: Draws its creases.
        radius: Of the bend at the edges, metres.
        puff: How far creases rise, metres.

    Returns:
        The closed mesh.
    """
    s = _samples(half, drop[0], half / 7.0)
    s = np.concatenate([-s[::-1], s[1:]])
    near, far = span
    t = _samples(far - near, drop[1], half / 7.0) - (far - near)
    beyond_x = np.maximum(np.abs(s) - half, 0.0)[None, :] * np.sign(s)
    beyond_y = np.minimum(0.0, -np.maximum(t, 0.0))[::-1, None]
    flat_x = np.clip(s, -half, half)[None, :]
    flat_y = (near + np.maximum(-t, 0.0))[::-1, None]
    distance = np.hypot(beyond_x, beyond_y)
    x, y = np.broadcast_arrays(flat_x, flat_y)
    fall = np.maximum(distance, 1e-12)
    turn = np.minimum(distance / radius, 0.5 * np.pi)
    hanging = np.maximum(distance - 0.5 * np.pi * radius, 0.0)
    waves = ripples(x, y, 0.35, rng)
    # What hangs waves outwards, more so towards its hem.
    out = radius * np.sin(turn) + hanging * (0.06 + 0.05 * waves)
    z = level - radius * (1.0 - np.cos(turn)) - hanging
    z = z + puff * ripples(x, y, 0.3, rng) * np.cos(turn) * (hanging == 0.0)
    grid = points_at(x + out * beyond_x / fall, y + out * beyond_y / fall, z)
    return sheet(grid, thick)


def _samples(flat: float, drop: float, step: float) -> Array:
    """Distances from the middle over the edge to the hem, denser where it bends."""
    inner = np.linspace(0.0, flat, max(3, round(flat / step)))
    if drop <= 0.0:
        return inner
    bend = flat + 0.05 * np.array([0.25, 0.5, 0.75, 1.0])
    hang = np.linspace(flat + 0.05, flat + max(drop, 0.08), 4)[1:]
    return np.concatenate([inner, bend, hang])


def folded(
    span: tuple[float, float],
    z: tuple[float, float],
    y: float,
    depth: float,
    pitch: float,
    thick: float,
    rng: np.random.Generator,
) -> Mesh:
    """A curtain: cloth in upright folds, tight at its heading and fuller towards its hem.

    Args:
        span: From which x to which it reaches, metres.
        z: Of its hem and its heading, metres.
        y: Of its middle, metres.
        depth: Of its deepest folds from front to back, metres.
        pitch: Usual width of a fold, metres.
        thick: Of the cloth, metres.
        rng: Draws the folds.

    Returns:
        The closed mesh.
    """
    width = span[1] - span[0]
    count = min(_FOLDS, max(2, round(width / pitch)))
    u = np.linspace(0.0, 1.0, 8 * count + 1)
    v = np.array([0.0, 0.3, 0.65, 0.9, 1.0])  # from the hem upwards
    # Each fold is a little wider or deeper than the next, and wanders on its way down.
    wide = np.cumsum(np.concatenate([[0.0], rng.uniform(0.75, 1.25, count)]))
    turns = np.interp(u, wide / wide[-1], np.arange(count + 1.0))
    deep = np.interp(turns, np.arange(count + 1.0), rng.uniform(0.7, 1.0, count + 1))
    drift = np.interp(turns, np.arange(count + 1.0), rng.uniform(-0.35, 0.35, count + 1))
    drift *= 4.0 * u * (1.0 - u)
    phase = 2.0 * np.pi * turns[None, :] + drift[None, :] * (1.0 - v[:, None]) * 2.0
    amplitude = (0.5 * depth - 0.5 * thick) * (0.55 + 0.45 * (1.0 - v[:, None]) ** 0.7)
    ahead = amplitude * (deep + 0.02 * (1.0 - deep)) * np.sin(phase)
    # Cloth that is pushed together bulges sideways at its crests.
    x = span[0] + width * u + 0.1 * (width / count) * np.sin(2.0 * phase)
    rise = np.broadcast_to((z[0] + (z[1] - z[0]) * v)[:, None], x.shape)
    return sheet(points_at(x, y + ahead, rise), thick)
