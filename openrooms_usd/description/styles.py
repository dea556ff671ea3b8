"""The styles that a room may be furnished in."""

from typing import Literal

InteriorStyle = Literal["scandinavian", "mid_century", "industrial", "rustic", "traditional"]
