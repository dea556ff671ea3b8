"""Checks a stage: USD's own validators, then our rules, each with a code and a remedy.

What USD finds is an error anywhere. Our own rules are errors in the scenes that this package
writes; elsewhere they are warnings, because a stage that follows none of our habits is still a
stage.
"""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Final

from pxr import Usd

from openrooms_usd.progress import Progress, silent
from openrooms_usd.usd.files import layers
from openrooms_usd.usd.files.diagnostics import quiet, reading
from openrooms_usd.validation import stage_rules
from openrooms_usd.validation.model import Finding, Rule, Severity, Subject
from openrooms_usd.validation.physx_rules import PHYSX_RULES
from openrooms_usd.validation.room_rules import ROOM_RULES
from openrooms_usd.validation.stage_rules import core_findings

RULES: Final = (
    Rule(
        "equal-metadata",
        stage_rules.equal_metadata,
        "give every layer the root layer's metadata: USD converts nothing between layers",
    ),
    Rule(
        "absolute-path",
        stage_rules.absolute_paths,
        "write the path relative to the layer, starting with ./ or ../",
    ),
    Rule(
        "unanchored-path",
        stage_rules.unanchored_paths,
        "start the path with ./ or ../, so that it does not depend on search paths",
    ),
    Rule("one-definer", stage_rules.one_definer, "keep one def and change the others to over"),
    Rule(
        "below-instance",
        stage_rules.nothing_below_instances,
        "write on the instance's root, choose a variant there, or set instanceable = false",
    ),
    Rule(
        "orphan",
        stage_rules.no_orphans,
        "rename it to where the prim is now, or remove it",
        advice=True,
    ),
    Rule(
        "units",
        stage_rules.referenced_units,
        "USD does not convert units: orusd edit fix-units OUT writes the missing operations; first "
        "author metersPerUnit and upAxis in files without units",
        advice=True,
    ),
    Rule(
        "plausible",
        stage_rules.plausible,
        "write it in the units of the stage, as the message says",
        advice=True,
    ),
    Rule("extent", stage_rules.extents, "author extent from the points"),
    Rule(
        "subdivision-scheme",
        stage_rules.subdivision_schemes,
        'author uniform token subdivisionScheme = "none" for a polygonal mesh',
    ),
    Rule("material", stage_rules.materials, "bind a material to it or to a prim above it"),
    Rule("label", stage_rules.labels, "apply SemanticsLabelsAPI:category to it or above it"),
    Rule("kind", stage_rules.kinds, "give the prims above a component the kind group or assembly"),
    Rule("component", stage_rules.components, "publish it with a class and an extentsHint"),
    Rule(
        "nested-body",
        stage_rules.nested_bodies,
        "put the bodies beside each other and join them: the standard does not allow nested bodies",
    ),
    Rule(
        "articulation",
        stage_rules.articulations,
        "apply PhysicsArticulationRootAPI to the body that carries the others",
    ),
    *PHYSX_RULES,
    *(Rule(rule.code, rule.check, rule.remedy, advice=True) for rule in ROOM_RULES),
    Rule("contract", stage_rules.contract, "keep to the names in openrooms_usd/names.py"),
)


def validate_stage(path: Path, *, strict: bool = False) -> list[Finding]:
    """Check a stage against USD's rules and ours.

    Args:
        path: Any USD file.
        strict: Count warnings as errors.

    Returns:
        What is wrong, errors first; empty for a clean stage.

    Raises:
        InputError: The file is missing, is not USD, or holds what cannot be read at all.
    """
    with quiet():
        return check(layers.open_stage(path), strict=strict)


def check(stage: Usd.Stage, *, strict: bool = False, progress: Progress = silent) -> list[Finding]:
    """Check a stage that is open already; see `validate_stage`.

    Args:
        stage: The stage.
        strict: Count warnings as errors.
        progress: Called with the code of each rule.

    Raises:
        InputError: It holds what cannot be read at all.
    """
    subject = Subject(stage)
    with reading(subject.root.realPath or subject.root.identifier):
        found = [*core_findings(subject), *_house_findings(subject, progress)]
    if strict:
        found = [replace(finding, severity="error") for finding in found]
    return sorted(set(found))


def _house_findings(subject: Subject, progress: Progress) -> Iterator[Finding]:
    for number, rule in enumerate(RULES):
        progress(f"rule {rule.code}", number / len(RULES))
        for place, message in rule.check(subject):
            # Our rules do not apply to what users made themselves.
            strict = subject.ours and not rule.advice and not subject.is_by_hand(place)
            severity: Severity = "error" if strict else "warning"
            yield Finding(severity, rule.code, place, message, rule.remedy)
