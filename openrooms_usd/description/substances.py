"""The nine categories of materials, as OpenRooms names them."""

from typing import Literal

Substance = Literal[
    "fabric",
    "leather",
    "metal",
    "paint",
    "plastic",
    "rough_stone",
    "rubber",
    "specular_stone",
    "wood",
]
