"""What distinguishes woods: rings, pores, rays, the waves of their fibres, knots.

Where in a ring the pores lie and how wide the rays are: R. B. Hoadley, Identifying Wood, 1990.
"""

from dataclasses import dataclass
from typing import Final, Literal

from openrooms_usd.library.textures.base import vocabulary as tx

Cut = Literal["flat", "quarter", "mixed", "peeled"]


@dataclass(frozen=True)
class Timber:
    """What distinguishes woods.

    Attributes:
        color: Mean base colour, scene-linear Rec.709.
        late: How much darker latewood is than earlywood, 0..1.
        ring: Range of ring widths, metres.
        pores: How dark the pores are, 0..1.
        pore: Width and length of a pore's cut, metres.
        porous: Whether pores lie in the earlywood or all over the ring.
        redder: How much redder the dark parts are.
        cut: How faces lie in the tree.
        flecks: How strong the rays show, positive lighter, negative darker.
        fleck: Width and length of a ray's cut, metres, and its angle to the grain, radians.
        curl: How strong waves across the grain show, and their distance, metres.
        ribbon: How strong stripes of interlocked grain show, and their width, metres.
        streaks: How dark streaks of heartwood are.
        knots: Knots on a square metre.
        knot: Range of their radii, metres.
    """

    color: tx.Color
    late: float
    ring: tuple[float, float]
    pores: float
    pore: tuple[float, float] = (0.0012, 0.012)
    porous: Literal["ring", "diffuse"] = "diffuse"
    redder: float = 0.08
    cut: Cut = "flat"
    flecks: float = 0.0
    fleck: tuple[float, float, float] = (0.0009, 0.004, 0.0)
    curl: tuple[float, float] = (0.0, 0.01)
    ribbon: tuple[float, float] = (0.0, 0.01)
    streaks: float = 0.0
    knots: float = 0.0
    knot: tuple[float, float] = (0.006, 0.014)


# Mean colours of oiled or lacquered heartwood.
OAK: Final = Timber(
    (0.40, 0.255, 0.135), 0.28, (0.003, 0.006), 0.55, (0.001, 0.011), "ring", 0.10, "mixed"
)
ASH: Final = Timber((0.50, 0.37, 0.23), 0.40, (0.005, 0.010), 0.45, (0.0012, 0.014), "ring")
BEECH: Final = Timber(
    (0.50, 0.315, 0.185), 0.07, (0.003, 0.006), 0.10, redder=0.06, cut="mixed", flecks=-0.22
)
PINE: Final = Timber((0.56, 0.365, 0.175), 0.34, (0.004, 0.009), 0.03, redder=0.16)
LARCH: Final = Timber((0.44, 0.26, 0.125), 0.42, (0.002, 0.004), 0.02, redder=0.18, cut="quarter")
WALNUT: Final = Timber(
    (0.165, 0.092, 0.052), 0.14, (0.007, 0.014), 0.32, (0.0011, 0.007), redder=0.05, streaks=0.2
)
MAPLE: Final = Timber((0.58, 0.43, 0.28), 0.07, (0.005, 0.012), 0.03, redder=0.12)
SAPELE: Final = Timber(
    (0.23, 0.105, 0.06),
    0.06,
    (0.006, 0.010),
    0.35,
    (0.0008, 0.006),
    cut="quarter",
    ribbon=(0.13, 0.016),
)
ZEBRANO: Final = Timber(
    (0.42, 0.27, 0.135), 0.8, (0.009, 0.016), 0.3, (0.001, 0.012), redder=0.1, cut="quarter"
)
BIRCH: Final = Timber((0.57, 0.43, 0.27), 0.15, (0.0025, 0.005), 0.0, redder=0.12, cut="peeled")
