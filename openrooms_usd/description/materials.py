"""The ``materials`` section: what things are made of."""

from typing import Annotated, Any, Literal, get_args

from pydantic import BeforeValidator, Field

from openrooms_usd.description.model import Model, Number, Whole
from openrooms_usd.description.units import PositiveLength

Family = Literal["wood", "paint", "fabric"]
Unit = Annotated[Number, Field(ge=0, le=1)]


class Look(Model):
    """One material: a family, and what of it is fixed rather than drawn by the seed."""

    family: Family
    """The procedural family."""
    color: tuple[Unit, Unit, Unit] | None = None
    """Mean base colour, scene-linear Rec.709; by default drawn from the family's range."""
    roughness: Unit | None = None
    """Mean perceptual roughness; by default drawn from the family's range."""


def _look(given: Any) -> Any:
    """A family alone stands for a look of which nothing is fixed."""
    if isinstance(given, str):
        return {"family": given}
    if not isinstance(given, (dict, Look)):
        families = ", ".join(get_args(Family))
        raise ValueError(f"a family ({families}), or a mapping with family, color and roughness")
    return given


AnyLook = Annotated[Look, BeforeValidator(_look, json_schema_input_type=Look | Family)]


class Materials(Model):
    """Materials of the room and overrides for objects; the rest follows from category rules."""

    floor: AnyLook = Look(family="wood")
    """The floor: a family, or a look with more of it fixed."""
    walls: AnyLook = Look(family="paint")
    """All walls."""
    ceiling: AnyLook = Look(family="paint")
    """The ceiling."""
    overrides: dict[str, dict[str, AnyLook]] = Field(default_factory=dict)
    """Object name, then part name (or ``all``), then the material."""
    resolution: Whole = Field(default=512, ge=16, le=8192)
    """Texels along each side of a procedural texture."""
    texture_size: PositiveLength = Field(default=1.0, ge=0.05, le=20)
    """The physical side length that one procedural texture covers."""
