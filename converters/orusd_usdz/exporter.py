"""What is registered as entry point: an exporter that loads USD when it is used."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pxr import Sdf, Usd, UsdLux

from openrooms_usd import claims
from openrooms_usd.errors import InputError, StageError
from openrooms_usd.exporters import Report
from openrooms_usd.spelling import did_you_mean
from openrooms_usd.usd.light.inputs import OLD, light_input, old_names
from orusd_usdz.profiles import DEFAULT, PROFILES, Profile

if TYPE_CHECKING:
    from pxr import Usd


class UsdzExporter:
    """Writes a stage as one USDZ file."""

    keeps_layers = True
    writes = (".usdz",)

    def convert(self, stage: "Usd.Stage", destination: Path, options: Mapping[str, Any]) -> Report:
        """Write ``stage`` to the file ``destination``.

        Args:
            stage: The composed stage; it lies in a file.
            destination: The ``.usdz`` file.
            options: ``profile``: a name of `orusd_usdz.profiles.PROFILES`.

        Returns:
            What became of every prim.

        Raises:
            InputError: An option is not known.
            StageError: The stage needs what may not be in a USDZ file.
            OutputError: The file cannot be written.
        """
        profile = _profile(options)
        scene = stage.GetRootLayer().realPath
        if not scene:
            raise StageError("the stage is not saved in a file", remedy="save it first")
        with claims.output(destination):
            if profile.is_plain:
                from orusd_usdz.adapting import write_plain

                return write_plain(stage, destination, profile)
            from openrooms_usd.package import package

            report, edit = leave_out(stage, profile)
            package(Path(scene), destination, include_outside=True, edit=edit)
            return report


def _profile(options: Mapping[str, Any]) -> Profile:
    for name in options:
        if name != "profile":
            raise InputError(f"the USDZ exporter has no option {name!r}", remedy="use profile")
    name = options.get("profile", DEFAULT)
    if name not in PROFILES:
        hint = did_you_mean(name, PROFILES)
        raise InputError(f"no profile is named {name!r}{hint}", remedy=f"use {', '.join(PROFILES)}")
    return PROFILES[name]


Edit = Callable[[Sdf.Layer], None]


def leave_out(stage: Usd.Stage, profile: Profile) -> tuple[Report, Edit]:
    """What becomes of every prim, and what to change in the copy of the root layer for it.

    Args:
        stage: The composed stage.
        profile: One that keeps layers.
    """
    report = Report()
    gone: list[Sdf.Path] = []
    domes: list[Sdf.Path] = []
    for prim in stage.Traverse():
        if prim.GetTypeName() in profile.without:
            gone.append(prim.GetPath())
            reason = f"programs without {prim.GetTypeName()} would show it as a lamp"
            report.add(prim.GetPath(), "skipped", f"left out: {reason}")
            continue
        lost = []
        asset = light_input(prim, "inputs:shaping:ies:file").Get()
        if asset and asset.path:
            lost.append("it shines evenly: USDZ archives hold no IES profiles")
        if prim.HasAPI(UsdLux.LightAPI) and (old := old_names(prim)):
            lost.append(f"{OLD}, which others ignore: {', '.join(old)}")
        report.say(prim.GetPath(), lost)
        if prim.GetRelationship(UsdLux.Tokens.portals).HasAuthoredTargets():
            domes.append(prim.GetPath())

    def edit(layer: Sdf.Layer) -> None:
        for path in gone:
            Sdf.CreatePrimInLayer(layer, path).active = False
        for path in domes if gone else ():
            Sdf.CreatePrimInLayer(layer, path)
            relationship = Sdf.RelationshipSpec(layer.GetPrimAtPath(path), UsdLux.Tokens.portals)
            relationship.targetPathList.ClearEditsAndMakeExplicit()

    return report, edit
