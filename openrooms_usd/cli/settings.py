"""The options of commands that render, made of the fields of `RenderSettings`."""

import functools
import re
from collections.abc import Callable, Mapping
from typing import Annotated, Any, Final, Literal, get_args, get_origin

import click

from openrooms_usd.cli.command import USUAL, section
from openrooms_usd.cli.console import Choice
from openrooms_usd.description.rendering import RenderSettings, flag_of, option_of

Command = Callable[..., Any]

RENDERER: Final = ("renderer", "options")
"""The settings that say what renders."""

_SECTIONS: Final = {
    "Quality": ("samples", "error", "seconds", "denoise", "denoise_light", "error_maps"),
    "Light": ("method", "bounces", "grid", "default_light"),
    "Camera": ("resolution", "field_of_view", "f_stop", "tone", "time_code"),
    "Renderer": (*RENDERER, "texture_side"),
}
"""Where ``--help`` lists an option; others are among the usual ones."""

_SIZE: Final = re.compile(r"(\d{1,9})[x×](\d{1,9})")
_VARIANT: Final = {"variant": "The backend: auto, cuda, llvm or scalar."}


def settings_options(
    *names: str,
    defaults: Mapping[str, Any] | None = None,
    helps: Mapping[str, str] | None = None,
    shorthands: Mapping[str, str] = _VARIANT,
) -> Callable[[Command], Command]:
    """Options that reach a command as ``settings``, a `RenderSettings`.

    Args:
        names: Fields of the settings, in the order in which ``--help`` lists them; those that say
            what renders follow.
        defaults: Values where nothing is given, other than the settings' own.
        helps: What an option means for this command, where that is more special.
        shorthands: Options of renderers that have a flag of their own: its help, by name.
    """
    usual, said = dict(defaults or {}), dict(helps or {})

    def decorate(command: Command) -> Command:
        @functools.wraps(command)
        def with_settings(*args: Any, **given: Any) -> Any:
            asked = {name: given.pop(name) for name in (*names, "renderer")}
            asked = usual | {name: value for name, value in asked.items() if value is not None}
            if options := _renderer_options(given, shorthands):
                asked["options"] = options
            return command(*args, settings=RenderSettings(**asked), **given)

        found: Command = with_settings
        found = _of_renderer(shorthands)(found)
        for name in reversed(names):
            found = section(_section(name), _option(name, usual.get(name), said.get(name)))(found)
        return found

    return decorate


def renderer_options(command: Command) -> Command:
    """Options that reach a command as ``renderer``, a name, and ``options``, values by name."""

    @functools.wraps(command)
    def with_renderer(*args: Any, **given: Any) -> Any:
        options = _renderer_options(given, _VARIANT)
        given["renderer"] = given["renderer"] or RenderSettings.model_fields["renderer"].default
        return command(*args, options=options, **given)

    return _of_renderer(_VARIANT)(with_renderer)


def _renderer_options(given: dict[str, Any], shorthands: Mapping[str, str]) -> dict[str, str]:
    """What is asked of the renderer, taken out of what a command is given."""
    short = {name: given.pop(name) for name in shorthands}
    said = {name: value for name, value in short.items() if value is not None}
    return said | dict(given.pop("pairs"))


def _of_renderer(shorthands: Mapping[str, str]) -> Callable[[Command], Command]:
    short = [
        click.option(f"--{name}", help=f"{text} Short for --option {name}=…")
        for name, text in shorthands.items()
    ]
    named = click.option(
        "--option",
        "pairs",
        multiple=True,
        callback=pairs_of,
        metavar="NAME=VALUE",
        help="An option of the renderer. Repeatable.",
    )
    return section("Renderer", _option("renderer"), named, *short)


def _section(name: str) -> str:
    """The section of ``--help`` that has the option of a field."""
    return next((title for title, fields in _SECTIONS.items() if name in fields), USUAL)


def _option(
    name: str, default: Any = None, text: str | None = None
) -> Callable[[Command], Command]:
    """The option of a field."""
    field = RenderSettings.model_fields[name]
    usual = field.get_default(call_default_factory=True) if default is None else default
    kind, flag = _plain_type(field.annotation), flag_of(name)
    said = text or field.description or ""
    if usual is not None and not isinstance(usual, bool):
        shown = "x".join(map(str, usual)) if isinstance(usual, tuple) else usual
        said += f"  [default: {shown}]"
    # What is not given is not in the settings: they know their own defaults.
    how: dict[str, Any] = {"help": said, "default": None}
    if unit := option_of(name).unit:
        how["metavar"] = unit.upper()
    if kind is bool:
        names = f"{flag}/--no-{flag[2:]}" if usual else flag
        how |= {"flag_value": True, "is_flag": True} if not usual else {}
        return click.option(names, name, **how)
    if get_origin(kind) is Literal:
        return click.option(flag, name, type=Choice(get_args(kind)), **how)
    if name == "channels":
        return click.option(flag, name, metavar="NAMES", **how)
    if get_origin(kind) is tuple:
        return click.option(flag, name, metavar="WxH", callback=_size, **how)
    return click.option(flag, name, type=kind, **how)


def _plain_type(annotation: Any) -> Any:
    """The type without what may be None and without limits."""
    parts = [part for part in get_args(annotation) if part is not type(None)]
    if get_origin(annotation) is Annotated:
        return _plain_type(parts[0])
    if get_origin(annotation) in (None, tuple, dict, Literal):
        return annotation
    return _plain_type(parts[0])


def _size(ctx: click.Context, param: click.Parameter, value: str | None) -> tuple[int, int] | None:
    """A size, such as ``640x480``."""
    if value is None:
        return None
    found = _SIZE.fullmatch(value.strip().lower())
    if found is None:
        raise click.BadParameter(f"{value!r} is not a size like 640x480", ctx, param)
    return int(found[1]), int(found[2])


def pairs_of(
    ctx: click.Context, param: click.Parameter, values: tuple[str, ...]
) -> tuple[tuple[str, str], ...]:
    """Names and values, from ``variant=llvm``; the last of a name counts."""
    found = []
    for text in values:
        name, equals, value = text.partition("=")
        if not (name and equals and value):
            raise click.BadParameter(f"{text!r} is not NAME=VALUE", ctx, param)
        found.append((name, value))
    return tuple(found)
