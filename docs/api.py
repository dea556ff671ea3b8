"""Writes docs/reference/api.md from the docstrings of the public names: ``python -m docs.api``."""

import ast
import inspect
import re
import textwrap
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from typing import Any, Final

import openrooms_usd as ou

PAGE: Final = Path(__file__).with_name("reference") / "api.md"

# What public functions give, by the module that defines it: no names of `ou`.
_GIVEN: Final = {
    "openrooms_usd.edits.objects": ("Visible", "SceneObject", "ScenePart"),
    "openrooms_usd.edits.views": ("SceneCamera", "SceneLight", "SceneMaterial"),
}
# What pydantic and our own checks call.
_INNER: Final = ("disagreements", "located", "model_post_init")
_HEAD: Final = """\
# Reference of the Python interface

Made from the docstrings (`python -m docs.api`). [Use Python](../howto/python.md) shows how the
functions belong together. Every error is an `ou.OrusdError`. Paths may be `str` or `Path`; a
`Scene`, a `Render` and a `View` stand for their files. Poses are (4, 4) matrices for column
vectors, from the named frame to the world: Z up, metres.
"""
_SECTION: Final = re.compile(
    r"^(Args|Attributes|Returns|Yields|Raises):\n((?:    .*\n|\n(?=    ))+)", re.MULTILINE
)
_ENTRY: Final = re.compile(r"^(?:\*{0,2})(\w+): ")
_BOLD: Final = r"**\1**: "


def page() -> str:
    """The whole page."""
    functions = [name for name in ou.__all__ if inspect.isfunction(getattr(ou, name))]
    classes = [name for name in ou.__all__ if inspect.isclass(getattr(ou, name))]
    given = [getattr(import_module(home), name) for home, names in _GIVEN.items() for name in names]
    robots = filter(inspect.isfunction, (getattr(ou.robots, name) for name in dir(ou.robots)))
    return "\n".join(
        [
            _HEAD,
            "## Functions\n",
            *(_function(f"ou.{name}", getattr(ou, name), "###") for name in functions),
            "## Classes\n",
            *(_class(f"ou.{name}", getattr(ou, name)) for name in classes),
            *(_class(one.__name__, one) for one in given),
            "## Robots\n",
            _text(ou.robots),
            *(_function(f"ou.robots.{one.__name__}", one, "###") for one in robots),
        ]
    )


def _function(name: str, function: Any, level: str) -> str:
    return f"{level} {name}\n\n```text\n{_signature(name, function)}\n```\n\n{_text(function)}"


def _class(name: str, kind: type) -> str:
    (owner,) = re.findall(r"[A-Z][a-z]+$", name)
    methods = [_member(owner.lower(), *row) for row in _members(kind)]
    return "\n".join([f"### {name}\n\n{_text(kind)}", *methods])


def _members(kind: type) -> Iterator[tuple[str, Any]]:
    """Public methods and properties of a class, with those of bases that have no entry."""
    mro = [base for base in kind.__mro__ if base.__module__.startswith("openrooms_usd")]
    shown = {name for names in _GIVEN.values() for name in names}
    ours = [base for base in mro if base is kind or base.__name__ not in shown]
    known = {name: value for base in reversed(ours) for name, value in vars(base).items()}
    for name, value in known.items():
        plain = getattr(value, "__func__", value)
        if name.startswith("_") or name in _INNER:
            continue
        if inspect.isfunction(plain) or isinstance(value, property):
            yield name, plain


def _member(owner: str, name: str, value: Any) -> str:
    if isinstance(value, property):
        return f"#### {owner}.{name}\n\n{_text(value)}"
    return _function(f"{owner}.{name}", value, "####")


def _signature(name: str, function: Any) -> str:
    """What it takes and gives, as the source has it, on lines that fit."""
    node = ast.parse(textwrap.dedent(inspect.getsource(function))).body[0]
    assert isinstance(node, ast.FunctionDef), name
    node.args.args = [arg for arg in node.args.args if arg.arg not in ("self", "cls")]
    for arg in (one for one in ast.walk(node.args) if isinstance(one, ast.arg)):
        arg.annotation = _unquoted(arg.annotation)
    text = f"{name}({ast.unparse(node.args)}) -> {ast.unparse(_unquoted(node.returns))}"
    parts = re.split(r", (?=\*{0,2}\w+:|\*,)", text)
    return text if len(text) <= 96 else ",\n    ".join(parts)


def _unquoted(annotation: ast.expr | None) -> ast.expr:
    """An annotation without the quotes of what is imported for type checkers alone."""
    if isinstance(annotation, ast.Constant) and isinstance(annotation.value, str):
        return ast.parse(annotation.value, mode="eval").body
    return annotation or ast.Constant(None)


def _text(thing: Any) -> str:
    """A docstring as Markdown: what it takes, gives and raises as lists."""
    text = _SECTION.sub(_listed, f"{inspect.getdoc(thing) or ''}\n")
    return text.replace("``", "`").rstrip() + "\n"


def _listed(section: re.Match[str]) -> str:
    title, body = section[1], textwrap.dedent(section[2]).strip()
    entries = [" ".join(entry.split()) for entry in re.split(r"\n(?=\S)", body)]
    if title in ("Returns", "Yields"):
        return f"{title}: {' '.join(entries)}\n"
    return "\n".join([f"{title}:\n", *(f"- {_ENTRY.sub(_BOLD, entry)}" for entry in entries), ""])


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
