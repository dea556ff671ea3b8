"""Names the prims of a stage that are not in the picture, and why."""

from collections.abc import Iterator
from typing import Final

from pxr import Usd, UsdGeom, UsdLux

from openrooms_usd.convert import Report
from openrooms_usd.usd.frames import TIME
from openrooms_usd.usd.rendersettings import asked_purposes

# Prims that shape others, or belong to other uses of a stage; nothing is lost without them.
_SILENT: Final = frozenset(
    {
        "", "Xform", "Scope", "Camera", "Material", "Shader", "NodeGraph", "GeomSubset",
        "PointInstancer", "Backdrop", "SkelRoot", "Skeleton", "SkelAnimation", "BlendShape",
    }
)  # fmt: skip
_SILENT_FAMILIES: Final = ("Render", "Physics")
_PURPOSE: Final = "its purpose is"


def report_unseen(stage: Usd.Stage, report: Report) -> None:
    """Add a row for each prim that might be expected in a picture and is not in the report.

    Args:
        stage: The composed stage.
        report: Rows of what was translated; more are added.
    """
    known = {path for path, _, _ in report.rows}
    for prim, reason in _hidden(stage):
        if str(prim.GetPath()) not in known:
            report.add(prim.GetPath(), "skipped", reason)


def is_aside(reason: str) -> bool:
    """Whether a prim is left out for its purpose: no picture lacks what only aids other uses."""
    return reason.startswith(_PURPOSE)


def _hidden(stage: Usd.Stage) -> Iterator[tuple[Usd.Prim, str]]:
    instancers: list[str] = []
    for prim in stage.Traverse():
        kind = str(prim.GetTypeName())
        if prim.IsA(UsdGeom.PointInstancer):
            targets = UsdGeom.PointInstancer(prim).GetPrototypesRel().GetTargets()
            instancers += map(str, targets)
        if prim.IsA(UsdGeom.Gprim) or prim.HasAPI(UsdLux.LightAPI):
            inside = any(str(prim.GetPath()).startswith(target) for target in instancers)
            if not inside:
                yield prim, _why(prim)
        elif kind not in _SILENT and not kind.startswith(_SILENT_FAMILIES):
            yield prim, f"{kind} has no place in a picture"


def _why(prim: Usd.Prim) -> str:
    shown = UsdGeom.Imageable(prim)
    if shown and shown.ComputeVisibility(TIME) == UsdGeom.Tokens.invisible:
        return "invisible"
    purpose = shown.ComputePurpose() if shown else UsdGeom.Tokens.default_
    if purpose not in asked_purposes(prim.GetStage()):
        return f"{_PURPOSE} {purpose}"
    return f"{prim.GetTypeName() or 'it'} has nothing to draw"
