"""The ``lights`` section: the world outside and the lamps inside."""

from collections.abc import Iterator
from typing import Annotated, Any, Literal

from pydantic import Field, Tag

from openrooms_usd.description.model import (
    CheckedModel,
    Found,
    Model,
    Number,
    Switch,
    by_source,
    peek,
)
from openrooms_usd.description.units import Angle

Positive = Annotated[Number, Field(gt=0, le=1e9)]
Radiance = Annotated[Number, Field(ge=0, le=1e9)]


class ConstantEnvironment(Model):
    """The same radiance from everywhere outside."""

    source: Literal["constant"] = Field(default="constant", alias="from")
    color: tuple[Radiance, Radiance, Radiance] = (1.0, 1.0, 1.0)
    """Scene-linear Rec.709; only its hue matters when the illuminance is given."""
    illuminance: Number = Field(default=10_000.0, ge=0, le=1e9)
    """Horizontal illuminance under the open sky, lux; 0 is a black night."""


class FileEnvironment(CheckedModel):
    """A panorama in latitude-longitude layout (HDR or EXR)."""

    source: Literal["file"] = Field(default="file", alias="from")
    file: str = Field(min_length=1)
    """The picture, relative to this description."""
    illuminance: Positive | None = None
    """Horizontal illuminance to scale it to, lux; excludes scale."""
    scale: Positive | None = None
    """Nits for one unit of its pixels; 1 by default."""
    rotate: Angle = 0.0
    """Rotation about the vertical, counter-clockwise from above."""

    @classmethod
    def disagreements(cls, given: Any) -> Iterator[Found]:
        """Two brightnesses at once."""
        if peek(given, "illuminance") is not None and peek(given, "scale") is not None:
            yield Found(
                ("scale",), "illuminance and scale both say how bright it is; give one of them"
            )


Environment = Annotated[
    Annotated[ConstantEnvironment, Tag("constant")] | Annotated[FileEnvironment, Tag("file")],
    by_source("constant", file="file"),
]


class Lamp(Model):
    """What a lamp emits."""

    lumen: Number | None = Field(default=None, ge=0, le=1e6)
    """Luminous flux; by default as its category usually has."""
    kelvin: Number | None = Field(default=None, ge=1000, le=20_000)
    """Colour temperature; by default drawn by the seed between 4000 K and 8000 K."""
    on: Switch = True
    """A lamp that is off keeps its geometry and is dark."""


class Lights(Model):
    """The environment and the lamps."""

    environment: Environment = Field(default_factory=ConstantEnvironment)
    """What shines in through the openings."""
    lamps: dict[str, Lamp] = Field(default_factory=dict)
    """By the object's name; lamps that are not listed take their defaults."""
