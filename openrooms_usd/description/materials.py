"""The ``materials`` section: what things are made of."""

from collections.abc import Iterator
from typing import Annotated, Any, Final, get_args

from pydantic import BeforeValidator, Field

from openrooms_usd.description.families import FamilyName
from openrooms_usd.description.model import (
    CheckedModel,
    FoundMistake,
    Number,
    PrimName,
    Whole,
    peek,
)
from openrooms_usd.description.substances import Substance
from openrooms_usd.description.units import PositiveLength

Unit = Annotated[Number, Field(ge=0, le=1)]
Factor = Annotated[Number, Field(ge=0.1, le=10)]
Size = Annotated[PositiveLength, Field(ge=1e-3, le=1e3)]

# What says of what kind a material is, and what it goes with.
_KINDS: Final = ("family", "substance", "file", "color")
_CLASHES: Final = {
    "file": ("family", "number", "color", "roughness", "metallic"),
    "family": ("substance", "metallic"),
}


class MaterialChoice(CheckedModel):
    """One material: of the library, of files, or a constant; omitted keys are drawn."""

    family: FamilyName | None = None
    """A family of the library, or a substance: then a family of it is drawn."""
    substance: Substance | None = None
    """The substance; without a family, one of this substance is drawn."""
    number: Annotated[Whole, Field(ge=0, lt=2**31)] | None = None
    """Which material of the family: its own seed."""
    color: tuple[Unit, Unit, Unit] | None = None
    """Mean base colour, scene-linear Rec.709; by default drawn from the family's range."""
    roughness: Unit | None = None
    """Mean perceptual roughness; by default drawn from the family's range."""
    metallic: Unit | None = None
    """0 dielectric to 1 metal; makes it a constant, without textures."""
    size: Size | None = None
    """Width that one repeat of the textures covers; by default the family's own."""
    file: str | None = Field(default=None, min_length=1)
    """A folder with textures, or a MaterialX file, relative to the description."""

    @property
    def is_constant(self) -> bool:
        """Whether it has no textures."""
        return self.metallic is not None or not (self.family or self.substance or self.file)

    @classmethod
    def disagreements(cls, given: Any) -> Iterator[FoundMistake]:
        """Keys that contradict each other, and a material of which nothing is said."""
        has = {name for name in cls.model_fields if peek(given, name) is not None}
        if not has & {*_KINDS}:
            yield FoundMistake((), f"give one of: {', '.join(_KINDS)}")
        if "metallic" in has and not has & {"color", "family", "file"}:
            yield FoundMistake(("metallic",), "a constant needs a color too")
        for first, others in _CLASHES.items():
            for other in others:
                if {first, other} <= has:
                    yield FoundMistake((other,), f"{other} cannot be combined with {first}")
        constant = "metallic" in has or not has & {"family", "substance", "file"}
        if "size" in has and constant:
            yield FoundMistake(("size",), "a constant has no texture, so size has no effect")
        if "number" in has and constant and "file" not in has:
            yield FoundMistake(
                ("number",), "number selects a member of a family; a constant has none"
            )


def _look(given: Any) -> Any:
    """A name alone stands for a look of which nothing else is fixed."""
    if isinstance(given, str):
        return {"family": given}
    if not isinstance(given, (dict, MaterialChoice)):
        substances = ", ".join(get_args(Substance))
        raise ValueError(
            f"a family, a substance ({substances}), or a mapping with family, color and roughness"
        )
    return given


AnyLook = Annotated[
    MaterialChoice, BeforeValidator(_look, json_schema_input_type=MaterialChoice | FamilyName)
]


class Scale(CheckedModel):
    """By how much drawn materials may be brighter, tinted or rougher than they were made."""

    color: tuple[Factor, Factor] = (1.0, 1.0)
    """Smallest and greatest factor of each primary of the base colour."""
    roughness: tuple[Factor, Factor] = (1.0, 1.0)
    """Smallest and greatest factor of the roughness."""

    @classmethod
    def disagreements(cls, given: Any) -> Iterator[FoundMistake]:
        """Ranges that end before they begin."""
        for name in cls.model_fields:
            ends = peek(given, name)
            if not isinstance(ends, (list, tuple)) or len(ends) != 2:
                continue
            if all(isinstance(end, (int, float)) for end in ends) and ends[0] > ends[1]:
                yield FoundMistake((name,), "the smaller factor comes first")


class Materials(CheckedModel):
    """Materials of the room and overrides for objects; the rest follows from tables."""

    floor: AnyLook | None = None
    """The floor: a family, a substance, or a look; by default the usual one of the room type."""
    walls: AnyLook | None = None
    """All walls."""
    ceiling: AnyLook | None = None
    """The ceiling; by default white paint."""
    accents: dict[PrimName, AnyLook] = Field(default_factory=dict)
    """Walls that differ from the others: the name of a wall, such as wall_2, or of a partition,
    then the material."""
    trim: AnyLook | None = None
    """Skirting, cornice, rails and wainscot; by default white lacquer."""
    beams: AnyLook | None = None
    """Beams or grids below the ceiling; by default wood, and white for grids."""
    cladding: dict[PrimName, AnyLook] = Field(default_factory=dict)
    """The name of a cladding of the layout, then its material; by default tiles."""
    overrides: dict[str, dict[str, AnyLook]] = Field(default_factory=dict)
    """Object name, then part name (or ``all``), then the material."""
    annotations: dict[str, Annotated[str, Field(min_length=1)]] = Field(default_factory=dict)
    """Object name or category, then a file that annotates the materials of its parts."""
    scale: Scale = Field(default_factory=Scale)
    """Factors of colour and roughness, drawn for each material."""
    looks: Whole = Field(default=1, ge=1, le=64)
    """Number of looks, which are variants: ``default``, ``look_1`` and so on."""
    look: Whole = Field(default=0, ge=0, lt=64)
    """Which of them is shown; 0 is the default one."""
    resolution: Whole = Field(default=512, ge=16, le=8192)
    """Texels along each side of a procedural texture."""
    texture_size: Annotated[PositiveLength, Field(ge=0.05, le=20)] | None = None
    """The physical side length that each procedural texture covers; by default its family's own."""

    @property
    def surfaces(self) -> list[MaterialChoice | None]:
        """What is said of the room itself."""
        plain = [self.floor, self.walls, self.ceiling, self.trim, self.beams]
        return [*plain, *self.accents.values(), *self.cladding.values()]

    @classmethod
    def disagreements(cls, given: Any) -> Iterator[FoundMistake]:
        """A look to show that the room does not have."""
        looks, look = peek(given, "looks"), peek(given, "look")
        count = 1 if looks is None else looks
        if isinstance(count, int) and isinstance(look, int) and look >= count:
            yield FoundMistake(("look",), f"the room has the looks 0 to {count - 1}")
