"""Prims that are left out of a copy of a scene whose layers stay as they are."""

from collections.abc import Callable

from pxr import Sdf, Usd, UsdLux

from openrooms_usd.convert import Report
from orusd_usdz.profiles import Profile

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
            reason = f"programs that know no {prim.GetTypeName()} would take it for a lamp"
            report.add(prim.GetPath(), "skipped", f"left out: {reason}")
            continue
        asset = UsdLux.ShapingAPI(prim).GetShapingIesFileAttr().Get()
        if asset and asset.path:
            reason = "it shines evenly: USDZ archives hold no IES profiles"
            report.add(prim.GetPath(), "approximated", reason)
        else:
            report.add(prim.GetPath(), "translated")
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
