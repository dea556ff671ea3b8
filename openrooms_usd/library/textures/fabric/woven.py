"""Fabrics: woven, knitted, and of standing or matted fibres."""

from functools import partial
from typing import Final

from openrooms_usd.library.textures.base.family import Family
from openrooms_usd.library.textures.base.lattice import resolved
from openrooms_usd.library.textures.fabric import dyes
from openrooms_usd.library.textures.fabric.cloths import Fabric, make, medallions, puckers, waffle
from openrooms_usd.library.textures.fabric.knit import KNITTED
from openrooms_usd.library.textures.fabric.pile import PILED
from openrooms_usd.library.textures.fabric.weave import Thread, pattern, pointed, satin, twill

# Cloths whose pictures are as wide are laid twice along each side, all others four times; metres.
_WIDE_M: Final = 0.2
_PATTERNED: Final = (dyes.HOUNDSTOOTH, dyes.TARTAN, dyes.TICKING, dyes.SEERSUCKER)


def _yarn(per_cm: float, **options: float) -> Thread:
    return Thread((93.0 * per_cm, 107.0 * per_cm), **options)


WOVEN: Final = {
    "linen": Fabric(
        0.12, pattern("X.", ".X"), _yarn(15, slub=0.22, melange=0.18, bend=0.12),
        _yarn(13, slub=0.28, melange=0.2, bend=0.12), dyes.NATURAL,
    ),
    # Duck: ends go in pairs.
    "canvas": Fabric(
        0.1, pattern("XX..", "..XX"), _yarn(18, twist=0.12), _yarn(10, twist=0.12, slub=0.06),
        dyes.NATURAL, wrinkle=20e-6,
    ),
    "twill": Fabric(0.1, twill(2, 2), _yarn(18, melange=0.06), _yarn(15, melange=0.06)),
    "herringbone": Fabric(
        0.15, pointed(twill(2, 2), 12), _yarn(11, twist=0.1), _yarn(10, twist=0.1), dyes.TWO_TONE,
        fuzz=0.09,
    ),
    "houndstooth": Fabric(
        0.16, twill(2, 2), _yarn(9, twist=0.1), _yarn(9, twist=0.1), dyes.HOUNDSTOOTH, fuzz=0.08,
    ),
    "tartan": Fabric(
        0.2, twill(2, 2), _yarn(12, melange=0.06), _yarn(12, melange=0.06), dyes.TARTAN, fuzz=0.07,
    ),
    "satin": Fabric(
        0.06, satin(8, 3), _yarn(34, melange=0.05, slub=0.05), _yarn(24, melange=0.05), dyes.SILK,
        roughness=(0.3, 0.42), relief=0.25, crimp=0.3, hollow=0.25, fuzz=0.01, wrinkle=120e-6,
    ),
    "basket_weave": Fabric(
        0.16, pattern("XXX...", "XXX...", "XXX...", "...XXX", "...XXX", "...XXX"),
        _yarn(7, twist=0.14, slub=0.12), _yarn(7, twist=0.14, slub=0.12), fuzz=0.08,
    ),
    "denim": Fabric(
        0.08, twill(3, 1), _yarn(25, melange=0.16, slub=0.14), _yarn(17, melange=0.06), dyes.INDIGO,
        crimp=0.4, fuzz=0.1,
    ),
    "ticking": Fabric(
        0.1, twill(2, 1), _yarn(24, melange=0.04), _yarn(16, melange=0.04), dyes.TICKING, crimp=0.4,
    ),
    "damask": Fabric(
        0.09, satin(5, 2), _yarn(30, melange=0.03, slub=0.04), _yarn(30, melange=0.03, slub=0.04),
        dyes.TWO_TONE, roughness=(0.42, 0.55), relief=0.4, crimp=0.3, hollow=0.3, fuzz=0.02,
        figure=medallions,
    ),
    "waffle_weave": Fabric(
        0.11, pattern("X.", ".X"), _yarn(13), _yarn(13), dyes.NATURAL, relief=0.5, shape=waffle,
    ),
    "seersucker": Fabric(
        0.096, pattern("X.", ".X"), _yarn(30, melange=0.04), _yarn(26, melange=0.04),
        dyes.SEERSUCKER, relief=0.4, hollow=0.35, shape=puckers,
    ),
    # Thick hard yarns, for floors.
    "sisal": Fabric(
        0.25, pattern("XX..", "..XX"), _yarn(3.2, slub=0.1, melange=0.15, twist=0.2),
        _yarn(2.6, slub=0.16, melange=0.25, twist=0.25), dyes.NATURAL, roughness=(0.86, 0.95),
        hollow=0.65, fuzz=0.16, uses=frozenset({"floor"}),
    ),
    # Ribs: picks far thicker than the ends that cover them.
    "repp": Fabric(
        0.1, pattern("X.", ".X"), _yarn(26, melange=0.05), _yarn(6, slub=0.1), crimp=0.75,
    ),
}  # fmt: skip


def _family(fabric: Fabric) -> Family:
    finest = 1.0 / max(fabric.warp.density[1], fabric.weft.density[1])
    # What has a large pattern shows its repeat, as it should.
    drawn = fabric.figure is not None or fabric.dye in _PATTERNED
    laid = 1 if drawn else 4 if fabric.size < _WIDE_M else 2
    make_cloth = resolved(partial(make, fabric), finest)
    return Family(make_cloth, fabric.size, fabric.uses, grain=True, laid=laid)


FAMILIES: Final[dict[str, Family]] = {
    **{name: _family(fabric) for name, fabric in WOVEN.items()},
    **KNITTED,
    **PILED,
}
