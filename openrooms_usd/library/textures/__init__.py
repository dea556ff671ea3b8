"""Procedural materials: tileable maps of a stated physical size, endless by their number.

Each module of a substance has its families (`family.Family`); `catalogue` finds them by name,
`cache` writes what they make and remembers it. The arithmetic is in double precision and
draws only uniform numbers, so that the integers stored are the same on machines whose elementary
functions differ in the last place.

`base` is what all share; `fabric`, `leather`, `metal`, `paint`, `plastic`, `rough_stone`, `rubber`,
`specular_stone` and `wood` are the substances.
"""

from openrooms_usd.library.textures.base.family import Color, Family, TextureParams, Use
from openrooms_usd.library.textures.base.maps import Maps, TextureSet
from openrooms_usd.library.textures.cache import (
    MAPS,
    Material,
    cached,
    map_file,
    rendered_maps,
    write_set,
)
from openrooms_usd.library.textures.catalogue import FAMILIES, family_of, make, substance_of

__all__ = [
    "FAMILIES",
    "MAPS",
    "Color",
    "Family",
    "Maps",
    "Material",
    "TextureParams",
    "TextureSet",
    "Use",
    "cached",
    "family_of",
    "make",
    "map_file",
    "rendered_maps",
    "substance_of",
    "write_set",
]
