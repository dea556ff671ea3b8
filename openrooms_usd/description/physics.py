"""The ``physics`` section: what things weigh, how they collide, and which of them move."""

from typing import Annotated, Literal

from pydantic import Field

from openrooms_usd.description.model import Model, Number
from openrooms_usd.description.units import Length, Mass

Shapes = Literal["auto", "hull", "box"]
Motion = Literal["movable", "fixed"]
Friction = Annotated[Number, Field(ge=0, le=10)]


class PhysicsObject(Model):
    """What is known of one object."""

    body: Motion | None = None
    """Whether it can be moved; by default everything except built-in and hanging objects."""
    mass: Mass | None = None
    """Of the whole object, moving parts included; by default from its volume and materials."""
    shapes: Shapes | None = None
    """How its collision shapes are made; by default as for all objects."""
    friction: Friction | None = None
    """Static friction coefficient of the whole object; by default that of each part's material."""


class Physics(Model):
    """How things weigh, collide and move."""

    shapes: Shapes = "auto"
    """How collision shapes are made. Either convex hulls of connected pieces, cut and joined within
    the tolerance; or one convex hull per material; or one box per material."""
    tolerance: Annotated[Length, Field(gt=0, le=1)] = 0.01
    """Greatest deviation of collision shapes from the visible geometry."""
    gravity: Annotated[Number, Field(ge=0, le=100)] = 9.81
    """Downwards, m/s2."""
    objects: dict[str, PhysicsObject] = Field(default_factory=dict)
    """By the object's name; objects that are not listed take their defaults."""
