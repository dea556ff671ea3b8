"""The ``lights`` section: the world outside and the lamps inside."""

from collections.abc import Iterator
from datetime import datetime
from typing import Annotated, Any, Final, Literal

from pydantic import Field, Tag

from openrooms_usd.description.model import (
    CheckedModel,
    FoundMistake,
    Model,
    Number,
    Switch,
    Whole,
    by_source,
    peek,
)
from openrooms_usd.description.moments import ClockTime, Day, UtcOffset, zone
from openrooms_usd.description.units import Angle

Positive = Annotated[Number, Field(gt=0, le=1e9)]
Radiance = Annotated[Number, Field(ge=0, le=1e9)]
Reflectance = Annotated[Number, Field(ge=0, le=1)]
Scene = Literal["street", "garden", "hills", "city", "courtyard"]
Storey = Annotated[Whole, Field(ge=0, le=60)]
Seed = Annotated[Whole, Field(ge=0, lt=2**63)]

WIDEST_BEAMS_DEG: Final = {"downlight": 120.0, "spot": 90.0, "batwing": 140.0}
"""Profiles that have a beam angle, and the widest of each."""


class ConstantEnvironment(CheckedModel):
    """The same radiance from everywhere outside."""

    source: Literal["constant"] = Field(default="constant", alias="from")
    color: tuple[Radiance, Radiance, Radiance] = (1.0, 1.0, 1.0)
    """Scene-linear Rec.709; only its hue matters when the illuminance is given."""
    illuminance: Number = Field(default=10_000.0, ge=0, le=1e9)
    """Horizontal illuminance under the open sky, lux; 0 is a black night."""

    @classmethod
    def disagreements(cls, given: Any) -> Iterator[FoundMistake]:
        """A black sky that shall shine."""
        if _is_black(peek(given, "color")) and peek(given, "illuminance") != 0:
            text = "a black sky gives no light; give a brighter color, or"
            yield FoundMistake(("color",), f"{text} illuminance: 0")


def _is_black(color: Any) -> bool:
    return isinstance(color, list | tuple) and bool(color) and not any(color)


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
    def disagreements(cls, given: Any) -> Iterator[FoundMistake]:
        """Two brightnesses at once."""
        if peek(given, "illuminance") is not None and peek(given, "scale") is not None:
            yield FoundMistake(
                ("scale",), "illuminance and scale both set the brightness; give one of them"
            )


class SkyEnvironment(Model):
    """Sun and sky of a place at a moment, over bare land."""

    source: Literal["sky"] = Field(default="sky", alias="from")
    latitude: Number = Field(ge=-90, le=90)
    """Degrees, positive northwards."""
    longitude: Number = Field(ge=-180, le=180)
    """Degrees, positive eastwards."""
    date: Day
    """Local date, such as 2026-06-21."""
    time: ClockTime
    """Local time, such as 14:30."""
    utc_offset: UtcOffset | None = None
    """Hours ahead of UTC, or a time zone such as Europe/Berlin, with daylight saving time. By
    default the whole hours nearest to solar time."""
    turbidity: Number = Field(default=3.0, ge=1, le=10)
    """Haze: 2 very clear, 3 clear, 6 hazy, 10 thick haze."""
    overcast: Switch = False
    """Clouds over the whole sky and no sun."""
    ground: tuple[Reflectance, Reflectance, Reflectance] = (0.2, 0.2, 0.2)
    """Reflectance of the ground outside, scene-linear Rec.709."""
    north: Angle = 0.0
    """Direction of north: 0 along +Y, counter-clockwise from above."""
    illuminance: Positive | None = None
    """Horizontal illuminance to scale it to, lux; by default that of the date and time."""

    @property
    def moment(self) -> datetime:
        """The moment, with its offset from UTC."""
        local = datetime.fromisoformat(f"{self.date}T{self.time}")
        return local.replace(tzinfo=zone(self.utc_offset, self.longitude))


class OutsideEnvironment(SkyEnvironment):
    """Houses, gardens, trees and hills under the sky of a place at a moment."""

    source: Literal["outside"] = Field(default="outside", alias="from")  # type: ignore[assignment]
    latitude: Number = Field(default=50.0, ge=-90, le=90)
    """Degrees, positive northwards."""
    longitude: Number = Field(default=10.0, ge=-180, le=180)
    """Degrees, positive eastwards."""
    date: Day = "2026-06-21"
    """Local date."""
    time: ClockTime = "14:00"
    """Local time."""
    scene: Scene
    """The surroundings outside the windows."""
    storey: Storey = 0
    """The storey of the room; 0 is level with the ground."""
    facing: Angle = 90.0
    """Direction of the front of the house, where the street or the garden lies: counter-clockwise
    from +X, seen from above."""
    clouds: Reflectance = 0.3
    """The share of the sky that clouds cover."""
    near: Switch = True
    """Whether objects near the windows are geometry, which shows parallax."""
    seed: Seed | None = None
    """Seed of the surroundings and clouds; by default the room's seed."""


Environment = Annotated[
    Annotated[ConstantEnvironment, Tag("constant")]
    | Annotated[FileEnvironment, Tag("file")]
    | Annotated[SkyEnvironment, Tag("sky")]
    | Annotated[OutsideEnvironment, Tag("outside")],
    by_source("constant", file="file", scene="outside", latitude="sky"),
]


class Lamp(CheckedModel):
    """What a lamp emits."""

    lumen: Number | None = Field(default=None, ge=0, le=1e6)
    """Luminous flux; by default the usual one of its category."""
    kelvin: Number | None = Field(default=None, ge=1000, le=20_000)
    """Colour temperature; by default drawn by the seed: warm at home, cooler where people work."""
    color: tuple[Radiance, Radiance, Radiance] | None = None
    """The hue of a coloured lamp in place of kelvin, scene-linear Rec.709."""
    radiance: tuple[Radiance, Radiance, Radiance] | None = None
    """Of its bulbs, nits of each primary, scene-linear Rec.709, in place of lumen and kelvin."""
    profile: str | None = Field(default=None, min_length=1)
    """Light distribution: downlight, spot, batwing, bare bulb, or an IES file (LM-63, type C)
    relative to this description; by default evenly from all bulbs. It follows the bulbs' frame,
    down if the lamp is upright, and keeps the lumen."""
    beam: Number | None = Field(default=None, ge=5, le=140)
    """Beam angle of a downlight, a spot or a batwing, degrees: at half of the peak intensity; for a
    batwing between its wings."""
    on: Switch = True
    """A lamp that is off keeps its geometry and is dark."""

    @classmethod
    def disagreements(cls, given: Any) -> Iterator[FoundMistake]:
        """Two brightnesses or two hues at once."""
        if peek(given, "radiance") is not None:
            for key in ("lumen", "kelvin", "color", "profile"):
                if peek(given, key) is not None:
                    yield FoundMistake((key,), f"radiance already sets it; omit {key}")
        elif peek(given, "color") is not None and peek(given, "kelvin") is not None:
            yield FoundMistake(
                ("kelvin",), "color and kelvin both set the colour; give one of them"
            )
        if _is_black(peek(given, "color")):
            text = "a black lamp gives no light; give a brighter color, or on: false"
            yield FoundMistake(("color",), text)
        widest = WIDEST_BEAMS_DEG.get(str(peek(given, "profile")))
        beam = peek(given, "beam")
        if beam is not None and widest is None:
            yield FoundMistake(("beam",), f"only {', '.join(WIDEST_BEAMS_DEG)} have a beam angle")
        elif isinstance(beam, int | float) and beam > (widest or 0.0):
            yield FoundMistake(("beam",), f"at most {widest:g} degrees")


class Screen(Model):
    """A screen that shows something."""

    on: Switch = True
    """Whether it is on; screens that are not listed are off."""
    nits: Positive = 200.0
    """Luminance of its white, cd/m2."""
    shows: Literal["desktop", "film"] | None = None
    """A desktop with windows, or a still of a film; by default a film on televisions."""


class Lights(Model):
    """The environment and the lamps."""

    environment: Environment = Field(default_factory=ConstantEnvironment)
    """Light from outside, through the openings."""
    lamps: dict[str, Lamp] = Field(default_factory=dict)
    """By the object's name; lamps that are not listed take their defaults."""
    screens: dict[str, Screen] = Field(default_factory=dict)
    """Televisions, monitors and laptops that are on, by the object's name."""
