"""What is registered as entry point: an exporter that loads USD when it is used."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from openrooms_usd.convert import Report
from openrooms_usd.errors import InputError, StageError
from orusd_usdz.profiles import DEFAULT, PROFILES, Profile

if TYPE_CHECKING:
    from pxr import Usd


class UsdzExporter:
    """Writes a stage as one USDZ file."""

    keeps_layers = True

    def convert(self, stage: "Usd.Stage", destination: Path, options: Mapping[str, Any]) -> Report:
        """Write ``stage`` to the file ``destination``.

        Args:
            stage: The composed stage; it lies in a file.
            destination: The ``.usdz`` file.
            options: ``profile``: a name of `orusd_usdz.profiles.PROFILES`.

        Returns:
            What became of every prim.

        Raises:
            InputError: An option is not known, or the destination is no USDZ file.
            StageError: The stage needs what may not be in a USDZ file.
            OutputError: The file cannot be written.
        """
        profile = _profile(options)
        if destination.suffix.lower() != ".usdz":
            raise InputError(
                "the USDZ exporter writes one file", place=destination, remedy="end it in .usdz"
            )
        scene = stage.GetRootLayer().realPath
        if not scene:
            raise StageError("the stage lies in no file", remedy="save it first")
        if profile.is_plain:
            from orusd_usdz.adapting import write_plain

            return write_plain(stage, destination, profile)
        from openrooms_usd.package import package
        from orusd_usdz.leaving import leave_out

        report, edit = leave_out(stage, profile)
        package(Path(scene), destination, include_outside=True, edit=edit)
        return report


def _profile(options: Mapping[str, Any]) -> Profile:
    for name in options:
        if name != "profile":
            raise InputError(f"the USDZ exporter has no option {name!r}", remedy="use profile")
    name = options.get("profile", DEFAULT)
    if name not in PROFILES:
        raise InputError(f"no profile is named {name!r}", remedy=f"use {', '.join(PROFILES)}")
    return PROFILES[name]
