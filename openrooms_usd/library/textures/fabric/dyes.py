"""Colours of threads: one for all, or stripes of several in the warp, the weft or both."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from openrooms_usd.library.textures.base import vocabulary as tx
from openrooms_usd.tables import read_table

_PALETTES: Final = read_table(__file__, "palettes.toml")

COLORS: Final[tuple[tx.Color, ...]] = _PALETTES["dyes_colors"]
NATURALS: Final[tuple[tx.Color, ...]] = _PALETTES["dyes_naturals"]
_CREAM: Final[tx.Color] = (0.62, 0.58, 0.49)
_BLACK: Final[tx.Color] = (0.035, 0.035, 0.038)


@dataclass(frozen=True)
class Dye:
    """What colours the threads have.

    Attributes:
        ends: Stripes of the warp, a letter a thread, ``a`` being the palette's first; repeated.
            One of the choices is drawn.
        picks: The same of the weft, drawn together with the warp's.
        palettes: Colours to draw from.
    """

    ends: tuple[str, ...]
    picks: tuple[str, ...]
    palettes: tuple[tuple[tx.Color, ...], ...]

    def drawn(self, order: tx.TextureParams) -> tuple[tx.Field, tx.Field]:
        """(p, 3) and (q, 3) colours of the ends and picks of one repeat."""
        choice = int(order.rng.integers(len(self.ends)))
        palette = np.array(self.palettes[int(order.rng.integers(len(self.palettes)))])
        palette = palette * order.rng.uniform(0.85, 1.15)
        return palette[_numbers(self.ends[choice])], palette[_numbers(self.picks[choice])]


def _numbers(letters: str) -> list[int]:
    return [ord(letter) - ord("a") for letter in letters]


def _one(*palettes: tuple[tx.Color, ...]) -> Dye:
    return Dye(("a",), ("b" if len(palettes[0]) > 1 else "a",), palettes)


def _checked(setts: tuple[str, ...], *palettes: tuple[tx.Color, ...]) -> Dye:
    return Dye(setts, setts, palettes)


def _pivoted(half: str) -> str:
    """A sett that runs to its pivot and back, as tartans do."""
    return half + half[::-1]


PLAIN: Final = _one(*((color,) for color in COLORS))
NATURAL: Final = _one(*((color,) for color in NATURALS))
# Two colours that are near each other, as of weft and warp of one upholstery cloth.
TWO_TONE: Final = _one(
    ((0.42, 0.41, 0.39), (0.17, 0.17, 0.175)),
    ((0.50, 0.44, 0.34), (0.25, 0.19, 0.13)),
    ((0.14, 0.19, 0.27), (0.34, 0.37, 0.40)),
    ((0.36, 0.35, 0.25), (0.16, 0.19, 0.12)),
    ((0.40, 0.22, 0.15), (0.22, 0.10, 0.07)),
)
INDIGO: Final = _one(
    ((0.035, 0.058, 0.12), (0.50, 0.50, 0.49)),
    ((0.018, 0.025, 0.055), (0.36, 0.38, 0.41)),
    ((0.11, 0.17, 0.28), (0.56, 0.56, 0.55)),
    ((0.028, 0.028, 0.03), (0.30, 0.30, 0.30)),
)
HOUNDSTOOTH: Final = _checked(
    ("aaaabbbb",),
    (_CREAM, _BLACK),
    (_CREAM, (0.16, 0.08, 0.045)),
    ((0.5, 0.5, 0.5), (0.05, 0.07, 0.12)),
)
TARTAN: Final = _checked(
    (
        _pivoted("a" * 14 + "b" * 3 + "a" * 3 + "b" * 8 + "c" * 10 + "d" * 2),
        _pivoted("a" * 10 + "c" * 14 + "b" * 2 + "c" * 4 + "b" * 7 + "d" * 3),
        _pivoted("c" * 12 + "a" * 4 + "c" * 3 + "a" * 3 + "b" * 16 + "d" * 2),
    ),
    ((0.33, 0.022, 0.02), (0.018, 0.025, 0.07), (0.02, 0.065, 0.03), (0.62, 0.56, 0.35)),
    ((0.02, 0.055, 0.035), (0.02, 0.03, 0.085), (0.025, 0.025, 0.025), (0.50, 0.40, 0.09)),
    ((0.45, 0.37, 0.26), (0.03, 0.03, 0.03), (0.60, 0.56, 0.48), (0.38, 0.03, 0.03)),
    ((0.24, 0.25, 0.26), (0.07, 0.075, 0.08), (0.42, 0.42, 0.41), (0.55, 0.18, 0.04)),
)
TICKING: Final = Dye(
    (
        "a" * 12 + "b" * 3 + "a" * 3 + "b" * 9 + "a" * 3 + "b" * 3,
        "a" * 9 + "b" * 2 + "a" * 3 + "b" * 2,
    ),
    ("a", "a"),
    (
        ((0.66, 0.63, 0.55), (0.04, 0.065, 0.15)),
        ((0.66, 0.63, 0.55), (0.05, 0.05, 0.052)),
        ((0.64, 0.61, 0.53), (0.33, 0.055, 0.045)),
        ((0.60, 0.57, 0.50), (0.09, 0.15, 0.09)),
    ),
)
SEERSUCKER: Final = Dye(
    ("a" * 12 + "b" * 12,),
    ("a",),
    (
        ((0.66, 0.66, 0.65), (0.10, 0.19, 0.38)),
        ((0.66, 0.66, 0.65), (0.22, 0.22, 0.22)),
        ((0.66, 0.65, 0.63), (0.46, 0.13, 0.14)),
        ((0.64, 0.64, 0.60), (0.14, 0.27, 0.13)),
    ),
)
SILK: Final = _one(
    ((0.62, 0.58, 0.50),),
    ((0.45, 0.42, 0.39),),
    ((0.25, 0.03, 0.045),),
    ((0.03, 0.05, 0.14),),
    ((0.05, 0.13, 0.09),),
    ((0.50, 0.36, 0.12),),
    ((0.32, 0.22, 0.30),),
    ((0.04, 0.04, 0.042),),
)
