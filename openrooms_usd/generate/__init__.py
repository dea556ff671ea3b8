"""Rooms from nothing: pure functions of a room type, a seed and a few wishes."""

from openrooms_usd.generate.expansion import expanded
from openrooms_usd.generate.rooms import Generated, generate
from openrooms_usd.generate.writing import write

__all__ = ["Generated", "expanded", "generate", "write"]
