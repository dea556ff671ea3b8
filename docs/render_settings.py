"""Writes docs/reference/settings.md from `RenderSettings`: ``python -m docs.render_settings``."""

from collections.abc import Iterator
from pathlib import Path
from typing import Final, Literal, get_args, get_origin, get_type_hints

from openrooms_usd.description.rendering import (
    Budget,
    Rendering,
    RenderSettings,
    flag_of,
    limits_of,
    option_of,
)

PAGE: Final = Path(__file__).with_name("reference") / "settings.md"

_INTRODUCTION: Final = """\
# Settings of a render

Every setting has one name: it is a keyword argument of `ou.render`, `ou.open_renderer` and their \
like, a field of `ou.RenderSettings`, and an option of `orusd render`. Commands and functions that \
make something else of a stage take those that make a difference there: `probe`, `bake`, \
`compare`, `render --path`; `--help` lists them. In a dataset.yaml some stand under `budget`, some \
under `rendering` ([datasets](../howto/datasets.md)). This page is written by `python -m \
docs.render_settings`.

| name | option | type | default | limits | in dataset.yaml | what |
|---|---|---|---|---|---|---|
"""


def page() -> str:
    """The page's text."""
    return _INTRODUCTION + "".join(_rows())


def _rows() -> Iterator[str]:
    kinds = get_type_hints(RenderSettings)
    for name, field in RenderSettings.model_fields.items():
        default = field.get_default(call_default_factory=True)
        flag = "--option NAME=VALUE" if name == "options" else flag_of(name)
        cells = (
            f"`{name}`",
            f"`{flag}`",
            _type(kinds[name]) + (f", {unit}" if (unit := option_of(name).unit) else ""),
            "" if default is None else f"`{default}`",
            " to ".join(f"{limit:,}" for limit in limits_of(name) or ()),
            next((part for part, model in _PARTS.items() if name in model.model_fields), ""),
            " ".join((field.description or "").split()),
        )
        yield f"| {' | '.join(cells)} |\n"


_PARTS: Final = {"`budget`": Budget, "`rendering`": Rendering}


def _type(kind: object) -> str:
    """The type as people say it."""
    known = {int: "whole number", float: "number", bool: "true or false", str: "name"}
    if kind in known:
        return known[kind]  # type: ignore[index]
    if get_origin(kind) is Literal:
        return " or ".join(f"`{choice}`" for choice in get_args(kind))
    if get_origin(kind) is dict:
        return "values by name"
    if get_origin(kind) is tuple:
        return "names" if Ellipsis in get_args(kind) else "width and height"
    return _type(next(part for part in get_args(kind) if part is not type(None)))


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
