"""NVIDIA's validator, as the tests ask it."""

from pathlib import Path

import usd_validation_nvidia as nvidia
from pxr import Usd

# Rules that do not fit a room, each with the reason. None of them does more than warn.
LEFT_OUT = {
    "IndexedPrimvarChecker": "advice about size: texture coordinates are one for each corner",
    "WeldChecker": "parts of one mesh that touch are solids of their own: welded they would smear",
    "DefaultPrimChecker": "/Render stands beside /World, where UsdRender has its settings",
}


def nvidia_issues(scene: Path | Usd.Stage, *, without: dict[str, str] = LEFT_OUT) -> list[str]:
    """What usd-validation-nvidia finds in a stage by all of its rules but some, warnings too.

    Args:
        scene: A file, or a stage that is open.
        without: The rules that are not asked, each with the reason.

    Returns:
        ``SEVERITY Rule place: message``, sorted.
    """
    engine = nvidia.ValidationEngine()
    for name in without:
        engine.disable_rule(getattr(nvidia, name))
    issues = engine.validate(scene if isinstance(scene, Usd.Stage) else str(scene)).issues()
    return sorted(
        f"{issue.severity.name} {issue.rule.__name__ if issue.rule else '-'} "
        f"{issue.at.as_str() if issue.at else '-'}: {issue.message}"
        for issue in issues
        if issue.severity is not nvidia.IssueSeverity.NONE
    )
