"""What the sections that come from a capture have in common: the file, and how to read it."""

from typing import Annotated, Final, Literal

from pydantic import Field

from openrooms_usd.description.model import CheckedModel

# The importers that a section names by `from` alone.
CAPTURES: Final = ("roomplan", "scan2cad", "boxes")

Option = Annotated[str, Field(max_length=4096)]


class CapturedSection(CheckedModel):
    """A section that an importer fills from a foreign file."""

    source: str = Field(alias="from")
    file: str = Field(min_length=1)
    """The captured file, relative to this description."""
    options: dict[str, Option] = Field(default_factory=dict)
    """What is asked of the importer, as `orusd import KIND --help` lists it; paths are relative to
    this description."""

    @property
    def reader(self) -> str:
        """The name of the importer."""
        return self.source

    @property
    def asked(self) -> dict[str, str]:
        """All that is asked of the importer."""
        return self.options


class ImportedSection(CapturedSection):
    """A section that an importer of some installed package fills."""

    source: Literal["capture"] = Field(alias="from")
    importer: str = Field(min_length=1)
    """The importer's name, as `orusd import --help` lists it."""

    @property
    def reader(self) -> str:
        """The name of the importer."""
        return self.importer
