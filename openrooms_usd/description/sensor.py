"""The ``sensor`` section of dataset.yaml: what a real camera would make of the views."""

from collections.abc import Iterator
from typing import Annotated, Any, Literal

from pydantic import Field

from openrooms_usd.description.cameras import Range
from openrooms_usd.description.model import CheckedModel, Found, Model, Number, Switch, Whole, peek
from openrooms_usd.description.units import PositiveLength

_Coefficient = Annotated[Number, Field(ge=-10, le=10)]


class Distortion(Model):
    """A lens that bends straight lines, by OpenCV's model."""

    k1: _Coefficient = 0.0
    """Radial, of r^2; negative for barrels."""
    k2: _Coefficient = 0.0
    """Radial, of r^4."""
    p1: _Coefficient = 0.0
    """Tangential, by the vertical."""
    p2: _Coefficient = 0.0
    """Tangential, by the horizontal."""
    k3: _Coefficient = 0.0
    """Radial, of r^6."""


class Noise(Model):
    """A sensor that counts electrons."""

    iso: Annotated[Number, Field(ge=100, le=1e6)] = 400.0
    """Sensitivity; at 100, the least, a white pixel fills its well, at 200 half of it."""
    full_well: Annotated[Number, Field(ge=10, le=1e7)] = 15_000.0
    """Electrons that a pixel holds: photons times quantum efficiency."""
    read_noise: Annotated[Number, Field(ge=0, le=1e4)] = 3.0
    """Standard deviation of what reading adds, electrons."""
    bits: Annotated[Whole, Field(ge=1, le=16)] = 12
    """Of the numbers that are read."""
    black: Annotated[Number, Field(ge=0, le=0.5)] = 1 / 64
    """The number of no light, as a share of the greatest: noise below it is kept."""


class DepthCamera(Model):
    """A depth camera that projects a pattern."""

    model: Literal["structured_light"] = "structured_light"
    """How it measures."""
    range: Range = (0.5, 5.0)
    """The nearest and the farthest depth that it tells."""
    baseline: PositiveLength = 0.075
    """How far right of the camera the projector is."""
    noise: Annotated[Number, Field(ge=0, le=100)] = 1.0
    """Times the noise that was measured of the first Kinect; 0 for none."""
    steps: Switch = True
    """Whether disparity comes in steps."""
    missing: Switch = True
    """Whether there is no depth in shadows of the projector, and on what is slanted, dark or a
    mirror."""


class Sensor(CheckedModel):
    """What is written beside the truth of every view."""

    distortion: Distortion | None = None
    """Of the lens; by default none."""
    noise: Noise | None = None
    """Of the photograph; by default none."""
    depth: DepthCamera | None = None
    """A depth camera in the place of the view's; by default none."""
    exposure_value: Annotated[Number, Field(ge=-10, le=30)] | None = None
    """EV100 of the photographs; by default the camera's, or fitted to each picture."""
    seed: Whole = Field(default=0, ge=0, lt=2**63)
    """Draws the noise, and nothing else."""

    @classmethod
    def disagreements(cls, given: Any) -> Iterator[Found]:
        """A sensor that does nothing."""
        if all(peek(given, name) is None for name in ("distortion", "noise", "depth")):
            yield Found((), "a sensor has distortion, noise or depth")
