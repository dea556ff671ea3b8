"""docs/description.md: its examples load, and it leaves no key out."""

import re
from pathlib import Path

import pytest

from openrooms_usd.description import parse_room
from openrooms_usd.description.schema import room_schema

TEXT = (Path(__file__).parents[2] / "docs" / "description.md").read_text(encoding="utf-8")
SNIPPETS = re.findall(r"^```yaml\n(.*?)^```$", TEXT, flags=re.MULTILINE | re.DOTALL)


@pytest.mark.parametrize("snippet", SNIPPETS, ids=lambda text: text.split(":", 1)[0])
def test_each_example_loads(snippet: str) -> None:
    parse_room(snippet)


def test_every_key_is_in_the_reference() -> None:
    models = room_schema()
    keys = {key for model in models["$defs"].values() for key in model.get("properties", {})}
    keys |= set(models["properties"])
    assert [key for key in sorted(keys) if f"`{key}`" not in TEXT] == []
    assert len(SNIPPETS) > 8


def test_the_message_in_the_reference_is_real() -> None:
    shown = re.search(r"^```text\nerror: (.*?)^```$", TEXT, flags=re.MULTILINE | re.DOTALL)
    assert shown is not None
    wrong = (
        "name: a\n\nlayout:\n  hieght: 3\n\n\nalignment:\n  objects:\n"
        "    - {category: chiar, at: [1, 1]}\n"
    )
    with pytest.raises(Exception, match="2 mistakes") as caught:
        parse_room(wrong)
    assert shown[1] == f"{caught.value}\n"
