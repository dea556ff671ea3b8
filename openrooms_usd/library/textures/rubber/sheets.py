"""Rubber: compounds as they are, and mats and treads that are moulded of them."""

from collections.abc import Callable
from functools import partial
from typing import Final

from openrooms_usd.library.textures.base.family import Family, Order, Use
from openrooms_usd.library.textures.base.lattice import resolved
from openrooms_usd.library.textures.base.maps import Maps
from openrooms_usd.library.textures.base.recipe import fractal, noise
from openrooms_usd.library.textures.rubber import compound
from openrooms_usd.library.textures.rubber.compound import rubber
from openrooms_usd.library.textures.rubber.moulds import MOULDS, Mould


def _moulded(mould: Mould, order: Order) -> Maps:
    """A pattern pressed into rubber: dust lies in its hollows, feet polish its tops."""
    pitch = mould.pitch * float(order.rng.uniform(0.85, 1.15))
    relief = mould.relief(order, pitch)
    skin = noise(order, 0.0007)
    dust = fractal(order, 0.06, 0.3)
    hollow = 1.0 - relief
    shade = (1.0 + 0.06 * dust + 0.03 * skin) * (1.0 - mould.dark * hollow)
    depth = mould.depth * min(1.0, order.size / pitch) * order.rng.uniform(0.8, 1.2)
    height = depth * relief + 5e-6 * skin
    wear = 0.08 * hollow + 0.02 * dust
    return rubber(order, shade, height, mould.roughness, wear, mould.colors)


_FLOOR: Final[frozenset[Use]] = frozenset({"floor"})
_THINGS: Final[frozenset[Use]] = frozenset({"object"})
_BOTH: Final = _FLOOR | _THINGS

_COMPOUNDS: Final[dict[str, tuple[Callable[[Order], Maps], float, float, frozenset[Use]]]] = {
    "smooth_rubber": (compound.smooth, 0.0008, 0.25, _BOTH),
    "crumb_rubber": (compound.crumb, 0.002, 0.2, _FLOOR),
    "speckled_rubber": (compound.speckled, 0.002, 0.25, _FLOOR),
    "marbled_rubber": (compound.marbled, 0.003, 0.5, _FLOOR),
    "pebbled_rubber": (compound.pebbled, 0.003, 0.2, _FLOOR),
    "eva_foam": (compound.foam, 0.0011, 0.1, _BOTH),
    "sponge": (compound.sponge, 0.002, 0.15, _THINGS),
    "latex": (compound.latex, 0.004, 0.2, _THINGS),
}

FAMILIES: Final[dict[str, Family]] = {
    **{
        name: Family(resolved(make, detail), size, uses)
        for name, (make, detail, size, uses) in _COMPOUNDS.items()
    },
    **{
        name: Family(
            resolved(partial(_moulded, mould), mould.pitch / 4.0),
            mould.size,
            _FLOOR,
            grain=mould.grain,
        )
        for name, mould in MOULDS.items()
    },
}
