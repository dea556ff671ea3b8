"""One module removes and renames: read from the syntax trees."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
OWNER = ROOT / "openrooms_usd" / "removal.py"
SOURCES = [
    path
    for folder in ("openrooms_usd", "schemas", "converters", "docs", "examples")
    for path in sorted((ROOT / folder).rglob("*.py"))
    if path != OWNER
]
# Whatever they are called on.
METHODS = {"unlink", "rmdir", "rmtree", "rename", "symlink_to", "hardlink_to"}
# Of these modules, since other things have methods of the same name.
FUNCTIONS = {
    "os": {"remove", "removedirs", "renames", "replace", "truncate", "unlink", "rmdir", "rename"},
    "shutil": {"move", "copy", "copy2", "copyfile", "copytree", "rmtree"},
}
# Sources without any of these are not parsed.
WORDS = re.compile(rf"\b(os|shutil)\b|\.(replace|{'|'.join(METHODS)})\(")


def calls(source: str) -> Iterator[tuple[int, str]]:
    """The places that remove, rename or replace files."""
    if not WORDS.search(source):
        return
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.ImportFrom) and node.module in FUNCTIONS:
            yield from ((node.lineno, a.name) for a in node.names if a.name in METHODS)
        if not isinstance(node, ast.Call) or not isinstance(node.func, ast.Attribute):
            continue
        owner = node.func.value.id if isinstance(node.func.value, ast.Name) else ""
        if owner == "removal":
            continue
        # ``Path.replace`` takes one argument, ``str.replace`` two.
        is_path = node.func.attr == "replace" and len(node.args) == 1 and not node.keywords
        if node.func.attr in METHODS or node.func.attr in FUNCTIONS.get(owner, ()) or is_path:
            yield node.lineno, ast.unparse(node.func)


@pytest.mark.parametrize(
    "source",
    [
        "shutil.rmtree(out)",
        "os.remove(path)",
        "(out / name).unlink()",
        "beside.replace(target)",
        "from os import unlink",
        "path.rename(other)",
    ],
)
def test_the_search_finds(source: str) -> None:
    assert list(calls(source))


def test_the_search_passes_over_texts_and_the_owner() -> None:
    text = "'a'.replace('b', 'c'); removal.rename(a, b); replace(view, name=1)"
    assert not list(calls(text))


def test_nobody_else_removes_or_renames() -> None:
    found = [
        f"{path.relative_to(ROOT)}:{line}: {call}"
        for path in SOURCES
        for line, call in calls(path.read_text(encoding="utf-8"))
    ]
    assert found == []
