"""Wood: annual rings cut by a plank's face, fibres, pores; in panels or as a floor.

A tree is a bundle of cones about its pith. A plank's face lies at some distance from the pith, so
rings appear as nearly straight lines where the face cuts them steeply and as arches ("cathedrals")
where it runs along them. Grain runs along t.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from openrooms_usd.library.textures.maps import Maps, with_mean
from openrooms_usd.library.textures.noise import Field, smooth_noise, smoothstep
from openrooms_usd.library.textures.planks import Index, Planks, floor, panel


@dataclass(frozen=True)
class Species:
    """What distinguishes woods.

    Attributes:
        color: Mean base colour, scene-linear Rec.709.
        late: How much darker latewood is than earlywood, 0..1.
        ring: Range of ring widths, metres.
        pores: How much the pores show, 0..1.
        redder: How much redder the dark parts are.
    """

    color: tuple[float, float, float]
    late: float
    ring: tuple[float, float]
    pores: float
    redder: float


SPECIES: Final = {
    "oak": Species((0.40, 0.255, 0.135), 0.30, (0.004, 0.007), 1.0, 0.10),
    "ash": Species((0.50, 0.37, 0.23), 0.32, (0.005, 0.009), 0.8, 0.08),
    "beech": Species((0.50, 0.315, 0.185), 0.13, (0.004, 0.007), 0.35, 0.06),
    "pine": Species((0.56, 0.365, 0.175), 0.34, (0.006, 0.011), 0.1, 0.14),
    "cherry": Species((0.33, 0.15, 0.075), 0.20, (0.005, 0.009), 0.3, 0.10),
    "walnut": Species((0.165, 0.092, 0.052), 0.38, (0.006, 0.010), 0.7, 0.05),
}

# Height of latewood above earlywood, depth of a pore, of a floor's joint: metres.
_RIDGE: Final = 15e-6
_PORE: Final = 60e-6
_JOINT: Final = 0.4e-3
# Half width of the dark gap between floorboards, and of the bevel beside it: metres.
_GAP: Final = 0.7e-3
_BEVEL: Final = 2.5e-3
# Share of a ring at which it begins to darken, is darkest, and ends.
_RING_PROFILE: Final = (0.35, 0.9, 0.97)


def make_panel(
    rng: np.random.Generator,
    color: tuple[float, float, float] | None,
    roughness: float | None,
    resolution: int,
    size: float,
) -> Maps:
    """Furniture: staves glued edge to edge, planed and lacquered."""
    planks = panel(rng, resolution, size)
    return _wood(rng, planks, color, roughness, resolution, size, jointed=False)


def make_floor(
    rng: np.random.Generator,
    color: tuple[float, float, float] | None,
    roughness: float | None,
    resolution: int,
    size: float,
) -> Maps:
    """A floor: boards with staggered ends, dark gaps and a small bevel."""
    planks = floor(rng, resolution, size)
    return _wood(rng, planks, color, roughness, resolution, size, jointed=True)


def _wood(
    rng: np.random.Generator,
    planks: Planks,
    color: tuple[float, float, float] | None,
    roughness: float | None,
    resolution: int,
    size: float,
    *,
    jointed: bool,
) -> Maps:
    species = SPECIES[str(rng.choice(list(SPECIES)))]
    mean = np.array(species.color) * rng.uniform(0.88, 1.12) if color is None else np.array(color)
    gloss = rng.uniform(0.32, 0.5) if roughness is None else roughness
    tone = rng.uniform(-1.0, 1.0, planks.count)
    shifts = rng.integers(0, resolution, (2, planks.count))

    late = _latewood(rng, planks, shifts, species, resolution, size)
    blotch = _shifted(smooth_noise(rng, resolution, size, (0.08, 0.5)), planks.index, shifts)
    fibre = _shifted(smooth_noise(rng, resolution, size, (0.0025, 0.2)), planks.index, shifts)
    streak = _shifted(smooth_noise(rng, resolution, size, (0.0015, 0.012)), planks.index, shifts)
    pores = species.pores * smoothstep(0.9, 2.4, streak) * (1.0 - 0.6 * late)
    gap = _gap(planks, size / resolution) if jointed else np.zeros_like(late)

    dark = (
        (1.0 - species.late * late)
        * (1.0 + 0.03 * blotch + 0.035 * fibre)
        * (1.0 - 0.3 * pores)
        * (1.0 + (0.13 if jointed else 0.07) * tone[planks.index])
    )
    redness = np.array([1.0 - species.redder, 1.0, 1.0 + species.redder])
    albedo = with_mean(np.maximum(dark, 0.05)[..., None] ** redness, mean)
    height = _RIDGE * late - _PORE * pores
    if jointed:
        height = height - _JOINT * np.clip(1.0 - planks.edge / _BEVEL, 0.0, 1.0)
    return Maps(
        albedo=albedo * (1.0 - 0.75 * gap)[..., None],
        height=height,
        roughness=gloss + 0.015 * fibre + 0.12 * pores - 0.03 * (late - 0.5) + 0.3 * gap,
    )


def _latewood(
    rng: np.random.Generator,
    planks: Planks,
    shifts: Index,
    species: Species,
    resolution: int,
    size: float,
) -> Field:
    """(N, N) share of latewood: the rings of each plank's own tree."""
    radius = _radius(rng, planks, resolution) + _shifted(
        0.003 * smooth_noise(rng, resolution, size, (0.07, 0.4))
        + 0.0006 * smooth_noise(rng, resolution, size, (0.012, 0.12)),
        planks.index,
        shifts,
    )
    rings = radius / rng.uniform(*species.ring, planks.count)[planks.index]
    # Good and bad years; less than one ring from one to the next, so that the order stays.
    years = rng.uniform(-0.35, 0.35, 256)
    years[-1] = years[0]
    rings = rings + np.interp((rings + 17.0 * planks.index) % 255.0, np.arange(256), years)
    return _ring_profile(rings)


def _radius(rng: np.random.Generator, planks: Planks, resolution: int) -> Field:
    """(N, N) distance to the pith, metres; periodic along the grain."""
    count = planks.count
    along = (np.arange(resolution) + 0.5) / resolution
    pith = rng.uniform(-0.15, 0.15, count)
    depth = rng.uniform(0.02, 0.1, (count, 1))
    lean = rng.uniform(0.002, 0.016, (count, 1)) * np.sin(
        2.0 * np.pi * (along + rng.random((count, 1)))
    )
    bend = rng.uniform(0.0, 0.003, (count, 1)) * np.sin(
        4.0 * np.pi * (along + rng.random((count, 1)))
    )
    rows = np.arange(resolution)[:, None]
    return np.hypot(planks.across - pith[planks.index], (depth + lean + bend)[planks.index, rows])


def _ring_profile(rings: Field) -> Field:
    """Latewood of a ring number, averaged over the texel so that fine rings fade, not alias."""
    begin, dark, end = _RING_PROFILE
    share = np.linspace(0.0, 1.0, 129)
    profile = smoothstep(begin, dark, share) * (1.0 - smoothstep(dark, end, share))
    whole = np.concatenate([[0.0], np.cumsum((profile[1:] + profile[:-1]) / 2) / 128])

    def integral(x: Field) -> Field:
        turns = np.floor(x)
        return np.asarray(turns * whole[-1] + np.interp(x - turns, share, whole))

    step_t, step_s = np.gradient(rings)
    width = np.clip(np.abs(step_t) + np.abs(step_s), 0.02, 4.0)
    return np.asarray((integral(rings + width / 2) - integral(rings - width / 2)) / width)


def _gap(planks: Planks, texel: float) -> Field:
    """(N, N) share of each texel that is the gap between boards."""
    return np.clip((_GAP + texel / 2 - planks.edge) / texel, 0.0, 1.0)


def _shifted(field: Field, index: Index, shifts: Index) -> Field:
    """A periodic field, moved by another amount on each plank."""
    resolution = len(field)
    rows, columns = np.ogrid[:resolution, :resolution]
    row = (rows + shifts[0][index]) % resolution
    column = (columns + shifts[1][index]) % resolution
    return np.asarray(field[row, column])
