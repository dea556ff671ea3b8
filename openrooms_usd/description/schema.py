"""The JSON Schema of room.yaml, from which editors complete and check while one types."""

import json
from typing import Any, Final

from pydantic.json_schema import GenerateJsonSchema

from openrooms_usd.description.room import Room

FILE: Final = "room.schema.json"
HINT: Final = f"# yaml-language-server: $schema=./{FILE}"
"""The first line of a room.yaml that lies beside its schema."""

# pydantic keeps the limits of lengths and angles beside the choice between number and text, under
# its own names.
_LIMITS: Final = {
    "gt": "exclusiveMinimum",
    "ge": "minimum",
    "lt": "exclusiveMaximum",
    "le": "maximum",
}


class _Untitled(GenerateJsonSchema):
    """Leaves out titles that only repeat the key."""

    def field_title_should_be_set(self, schema: Any) -> bool:
        """Never."""
        return False


def room_schema() -> dict[str, Any]:
    """The JSON Schema (draft 2020-12) of a description.

    What needs more than one field, such as that a polygon must not cross itself, is beyond it:
    `openrooms_usd.description.load_room` checks that too.
    """
    schema = Room.model_json_schema(schema_generator=_Untitled)
    _limit_numbers(schema)
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "$id": "urn:openrooms-usd:room",
        **schema,
        "title": "room.yaml",
    }


def schema_text() -> str:
    """The JSON Schema as the text of a file."""
    return json.dumps(room_schema(), indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def _limit_numbers(node: Any) -> None:
    """Give each limit to the number that it is for."""
    if isinstance(node, dict):
        for ours, theirs in _LIMITS.items():
            if ours in node and "anyOf" in node:
                limit = node.pop(ours)
                for choice in node["anyOf"]:
                    if choice.get("type") == "number":
                        choice[theirs] = limit
    for child in node.values() if isinstance(node, dict) else node:
        if isinstance(child, (dict, list)):
            _limit_numbers(child)
