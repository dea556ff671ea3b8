"""USD's own validators, all of them, as findings."""

from collections.abc import Iterator, Sequence
from typing import Final

from pxr import Sdf, Usd, UsdShade, UsdValidation

from openrooms_usd.usd.files.diagnostics import UNREADABLE, plain, reason
from openrooms_usd.validation.model import Finding, Severity, Subject

_SEVERITY: Final[dict[UsdValidation.ValidationErrorType, Severity]] = {
    UsdValidation.ValidationErrorType.Error: "error",
    UsdValidation.ValidationErrorType.Warn: "warning",
}


def core_findings(subject: Subject) -> Iterator[Finding]:
    """Run every registered validator on a stage; what instances share is looked at once."""
    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    try:
        yield from _run(subject, validators)
    except UNREADABLE:
        # One that throws hides what the others found: a broken layer does it.
        for validator in validators:
            try:
                yield from _run(subject, [validator])
            except UNREADABLE as error:
                name = validator.GetMetadata().name
                yield Finding("error", name, subject.name(subject.root), reason(error))


def _run(subject: Subject, validators: Sequence[UsdValidation.Validator]) -> list[Finding]:
    context = UsdValidation.ValidationContext(validators)
    errors = list(context.Validate(subject.stage, Usd.PrimDefaultPredicate))
    shared = [prim for prim in subject.prims if prim.IsInstanceProxy()]
    if shared:
        errors += context.Validate(shared)
    return [
        Finding(severity, error.GetIdentifier(), _place(subject, error), _text(subject, error))
        for error in errors
        if (severity := _SEVERITY.get(error.GetType())) and not _is_materialx(error)
    ]


def _is_materialx(error: UsdValidation.ValidationError) -> bool:
    """Whether it says that a MaterialX node is unknown: this USD has no MaterialX."""
    if not error.GetIdentifier().endswith("ShaderSdrCompliance.MissingShaderIdInRegistry"):
        return False
    return any(
        str(UsdShade.Shader(site.GetProperty().GetPrim()).GetIdAttr().Get()).startswith("ND_")
        for site in error.GetSites()
        if site.IsProperty()
    )


def _place(subject: Subject, error: UsdValidation.ValidationError) -> str:
    for site in error.GetSites():
        if site.IsProperty():
            return str(site.GetProperty().GetPath())
        if site.IsPrim() and site.GetPrim().GetPath() != Sdf.Path.absoluteRootPath:
            return str(site.GetPrim().GetPath())
        if site.GetLayer():
            return subject.name(site.GetLayer())
    return subject.name(subject.root)


def _text(subject: Subject, error: UsdValidation.ValidationError) -> str:
    return plain(error.GetMessage()).replace(subject.home, "./")
