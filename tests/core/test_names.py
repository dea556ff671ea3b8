"""What several modules must say alike is said once."""

import ast
import re
from pathlib import Path

from openrooms_usd import names
from openrooms_usd.description.layout import PolygonLayout
from openrooms_usd.generation.kit import Kit

ROOT = Path(__file__).parents[2]


def heights(path: Path) -> list[str]:
    """Places that give a height the value of a usual one: constants, defaults, arguments."""
    found: list[str] = []
    text = path.read_text("utf-8")
    if not re.search(r"(?i)height[^\n]*\b(2\.60*|3\.0*|3)\b", text):
        return found
    for node in ast.walk(ast.parse(text)):
        given: list[tuple[str, ast.expr | None]] = []
        if isinstance(node, ast.Assign):
            given = [(ast.unparse(target), node.value) for target in node.targets]
        elif isinstance(node, ast.AnnAssign):
            given = [(ast.unparse(node.target), node.value)]
        elif isinstance(node, ast.keyword):
            given = [(node.arg or "", node.value)]
        elif isinstance(node, ast.arguments):
            last = node.args[len(node.args) - len(node.defaults) :]
            given = [(a.arg, d) for a, d in zip(last, node.defaults, strict=True)]
            given += [(a.arg, d) for a, d in zip(node.kwonlyargs, node.kw_defaults, strict=True)]
        for name, value in given:
            # A field of a model has its default inside of a call.
            inner = [value, *(k.value for k in getattr(value, "keywords", ()))]
            numbers = {v.value for v in inner if isinstance(v, ast.Constant)}
            if "height" in name.lower() and numbers & {names.ROOM_HEIGHT, names.SCANNED_HEIGHT}:
                found.append(f"{path.relative_to(ROOT)}: {name}")
    return found


def test_the_usual_height_of_rooms_stands_in_one_place() -> None:
    found = [
        place
        for folder in ("openrooms_usd", "schemas", "converters")
        for path in sorted((ROOT / folder).rglob("*.py"))
        for place in heights(path)
    ]
    assert found == [
        "openrooms_usd/names.py: ROOM_HEIGHT",
        "openrooms_usd/names.py: SCANNED_HEIGHT",
        # A fact of the OpenRooms release.
        "converters/orusd_openrooms/scenes/shell.py: RELEASE_HEIGHT_M",
    ]
    assert PolygonLayout().height == names.ROOM_HEIGHT
    assert Kit.__dataclass_fields__["height"].default == names.ROOM_HEIGHT
    # What is found in a wall must fit into it.
    assert names.SCANNED_HEIGHT >= names.ROOM_HEIGHT
