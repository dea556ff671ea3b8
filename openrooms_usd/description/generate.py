"""Sections that are made from nothing: a shell, and what stands in it."""

from typing import Literal

from pydantic import Field

from openrooms_usd.description.model import Model, Number
from openrooms_usd.description.units import PositiveLength


class GeneratedLayout(Model):
    """A shell as rooms of its type have it, drawn by the seed."""

    source: Literal["generate"] = Field(alias="from")
    area: Number | None = Field(default=None, ge=2, le=400)
    """Floor area, square metres; by default drawn for the room type."""
    wall_thickness: PositiveLength = Field(default=0.2, ge=0.01, le=2)
    """Thickness of the walls, outwards from the polygon."""


class GeneratedFurniture(Model):
    """Furniture as rooms of its type have it, drawn by the seed."""

    source: Literal["generate"] = Field(alias="from")

    @property
    def objects(self) -> tuple[()]:
        """Listed objects: none; `openrooms_usd.generation.expanded` makes a list of it."""
        return ()
