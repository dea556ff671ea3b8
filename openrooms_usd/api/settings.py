"""The keyword arguments of functions that render: the fields of `RenderSettings`."""

import inspect
import textwrap
from collections.abc import Callable, Iterable, Mapping
from typing import Any, Final, TypeVar, get_type_hints

from openrooms_usd.description.rendering import RenderSettings
from openrooms_usd.errors import InputError
from openrooms_usd.spelling import did_you_mean

_Function = TypeVar("_Function", bound=Callable[..., Any])

STAGE: Final = ("time_code", "default_light", "texture_side", "renderer", "options")
PROBE: Final = ("resolution", "samples", "seed", "bounces", *STAGE)
BAKE: Final = ("samples", "seed", "bounces", "method", *STAGE)
FILM: Final = ("resolution", "samples", "seed", "bounces", "method", "tone", "denoise", *STAGE)
ALL: Final = tuple(RenderSettings.model_fields)

# Doc strings are as wide as our lines.
_WIDTH: Final = 100


def takes_settings(*names: str, **said: str) -> Callable[[_Function], _Function]:
    """Let ``help`` and editors show the settings that a function takes as ``**fields``.

    Args:
        *names: Of fields of `RenderSettings`.
        **said: What a field means for this function, where that is more special.
    """

    def decorate(function: _Function) -> _Function:
        signature = inspect.signature(function)
        own = [p for p in signature.parameters.values() if p.kind is not p.VAR_KEYWORD]
        fields = [_parameter(name) for name in names]
        function.__signature__ = signature.replace(  # type: ignore[attr-defined]
            parameters=[*own, *fields]
        )
        rows = [(name, said.get(name) or _help(name)) for name in names]
        function.__doc__ = _with_arguments(function.__doc__ or "", rows)
        return function

    return decorate


def settings_of(
    settings: RenderSettings | None, fields: Mapping[str, Any], names: Iterable[str] = ALL
) -> RenderSettings:
    """The settings that the arguments give; None stands for the defaults.

    Args:
        settings: What is asked for.
        fields: What is asked for in other words than these.
        names: The fields that make a difference here.

    Raises:
        InputError: There is no such field, or it makes no difference here.
    """
    known = list(names)
    for name in fields:
        if name not in known:
            raise InputError(
                f"there is no argument {name!r}{did_you_mean(name, known)}",
                remedy=f"there are: {', '.join(known)}",
            )
    if settings is not None and not isinstance(settings, RenderSettings):
        raise InputError(
            f"expected ou.RenderSettings, found {type(settings).__name__}",
            place="settings",
            remedy="give ou.RenderSettings(samples=16), or the arguments themselves",
        )
    given = {name: value for name, value in fields.items() if value is not None}
    return (settings or RenderSettings()).replace(**given)


def _parameter(name: str) -> inspect.Parameter:
    default = RenderSettings.model_fields[name].get_default(call_default_factory=True)
    kind = get_type_hints(RenderSettings)[name]
    return inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=default, annotation=kind)


def _help(name: str) -> str:
    """What the field is, in one paragraph."""
    return " ".join((RenderSettings.model_fields[name].description or "").split())


def _with_arguments(doc: str, rows: Iterable[tuple[str, str]]) -> str:
    """A docstring whose part ``Args`` ends with some more rows."""
    lines = [
        textwrap.fill(f"{name}: {text}", _WIDTH, initial_indent=" " * 8, subsequent_indent=" " * 12)
        for name, text in rows
    ]
    head, returns, tail = doc.partition("\n\n    Returns:")
    return f"{head}\n" + "\n".join(lines) + returns + tail
