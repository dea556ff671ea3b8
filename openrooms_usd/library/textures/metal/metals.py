"""What metals reflect at normal incidence, scene-linear Rec.709, and the metal of an order.

Silver, aluminium, gold, copper, iron, chromium, nickel and titanium: the set after S. Lagarde that
Unity's Metal Reflectance node documents; brass is alloy C260 of a set in wide use. Sets made from
other measurements differ (iron up to 0.9, titanium 0.44). Steel, bronze and zinc, absent from these
or disputed, are chosen by eye. Oxides and patina are dielectrics with a diffuse colour.
"""

from typing import Final

import numpy as np

from openrooms_usd.library.textures.base import vocabulary as tx

SILVER: Final[tx.Color] = (0.97, 0.96, 0.91)
ALUMINIUM: Final[tx.Color] = (0.91, 0.92, 0.92)
GOLD: Final[tx.Color] = (1.0, 0.77, 0.34)
COPPER: Final[tx.Color] = (0.95, 0.64, 0.54)
BRASS: Final[tx.Color] = (0.91, 0.78, 0.42)
BRONZE: Final[tx.Color] = (0.74, 0.55, 0.38)
IRON: Final[tx.Color] = (0.56, 0.57, 0.58)
STEEL: Final[tx.Color] = (0.60, 0.58, 0.55)
CHROMIUM: Final[tx.Color] = (0.55, 0.56, 0.55)
NICKEL: Final[tx.Color] = (0.66, 0.61, 0.53)
ZINC: Final[tx.Color] = (0.66, 0.68, 0.71)
TITANIUM: Final[tx.Color] = (0.54, 0.50, 0.45)


def drawn_metal(order: tx.TextureParams, *metals: tx.Color) -> tx.Field:
    """(3,) one of some metals; or the colour asked for."""
    metal = metals[int(order.rng.integers(len(metals)))]
    return tx.drawn_color(order, (metal,), 0.03)


def bare(
    order: tx.TextureParams, metal: tx.Field, shade: tx.Field, height: tx.Field, roughness: tx.Field
) -> tx.Maps:
    """Metal without corrosion, ``shade`` (N, N) lighter or darker, never above 1."""
    albedo = np.minimum(metal * np.clip(shade, 0.1, 1.2)[..., None], 1.0)
    return tx.finished(order, albedo, height, roughness, 1.0)
