"""The JSON Schemas of room.yaml and dataset.yaml: editors complete and check by them."""

import json
from typing import Any, Final

from pydantic.json_schema import GenerateJsonSchema

from openrooms_usd.description.dataset import Dataset
from openrooms_usd.description.model import Model
from openrooms_usd.description.room import Room
from openrooms_usd.names import FORMER_SECTIONS

FILE: Final = "room.schema.json"
DATASET_FILE: Final = "dataset.schema.json"
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
    schema = _schema(Room, "room")
    for former, present in FORMER_SECTIONS.items():
        said = {"deprecated": True, "description": f"The former name of `{present}`."}
        schema["properties"][former] = schema["properties"][present] | said
        schema.setdefault("not", {"anyOf": []})["anyOf"].append({"required": [former, present]})
    return schema


def dataset_schema() -> dict[str, Any]:
    """The JSON Schema (draft 2020-12) of a dataset.yaml."""
    return _schema(Dataset, "dataset")


def schema_text(name: str = "room") -> str:
    """A JSON Schema as the text of a file.

    Args:
        name: ``room`` or ``dataset``.
    """
    schema = dataset_schema() if name == "dataset" else room_schema()
    return json.dumps(schema, indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def _schema(model: type[Model], name: str) -> dict[str, Any]:
    schema = model.model_json_schema(schema_generator=_Untitled)
    _limit_numbers(schema)
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "$id": f"urn:openrooms-usd:{name}",
        **schema,
        "title": f"{name}.yaml",
    }


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
