"""The JSON Schema, judged by jsonschema, which knows nothing of our models."""

import copy
import json
import re
from importlib import resources
from pathlib import Path
from typing import Any

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st
from jsonschema import Draft202012Validator
from pydantic import ValidationError

from openrooms_usd.description import Room, parse_room, reading
from openrooms_usd.description.model import MISTAKE
from openrooms_usd.description.schema import (
    DATASET_FILE,
    FILE,
    dataset_schema,
    room_schema,
    schema_text,
)

REFERENCE = Path(__file__).parents[2] / "docs/reference"
TEXT = (REFERENCE / "description.md").read_text(encoding="utf-8")
FIELDS = (REFERENCE / "room-yaml.md").read_text(encoding="utf-8")
SNIPPETS = re.findall(r"^```yaml\n(.*?)^```$", TEXT, flags=re.MULTILINE | re.DOTALL)
ROOT = Path(__file__).parents[2]
VALIDATOR = Draft202012Validator(room_schema())
EXAMPLES = sorted(
    {
        *ROOT.glob("examples/**/room*.yaml"),
        *ROOT.glob("openrooms_usd/demo/*.yaml"),
        *ROOT.glob("openrooms_usd/description/*.yaml"),
    }
)


def data_of(path: Path) -> Any:
    data, mistakes = reading.read_yaml(path.read_text(encoding="utf-8"), path.name)
    assert not mistakes
    return json.loads(json.dumps(data))


def test_the_schema_is_a_schema() -> None:
    Draft202012Validator.check_schema(room_schema())
    assert room_schema()["$schema"].endswith("2020-12/schema")


def test_the_copy_that_is_shipped_is_fresh() -> None:
    shipped = resources.files("orusd_schemas").joinpath(FILE).read_text(encoding="utf-8")
    assert shipped == schema_text(), "run: orusd schema > schemas/orusd_schemas/room.schema.json"


def test_the_schema_of_datasets_is_one_and_fresh() -> None:
    Draft202012Validator.check_schema(dataset_schema())
    shipped = resources.files("orusd_schemas").joinpath(DATASET_FILE).read_text(encoding="utf-8")
    assert shipped == schema_text("dataset"), f"run: orusd schema dataset > .../{DATASET_FILE}"


def test_there_are_examples() -> None:
    assert len(EXAMPLES) >= 2


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.parent.name)
def test_every_example_is_valid(path: Path) -> None:
    assert [error.message for error in VALIDATOR.iter_errors(data_of(path))] == []


@pytest.mark.slow
@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.parent.name)
def test_a_typo_in_any_key_of_an_example_is_found(path: Path) -> None:
    data = data_of(path)
    for holder, key in keys_of(data):
        wrong = copy.deepcopy(data)
        step_into(wrong, holder)[f"{key}_"] = step_into(wrong, holder).pop(key)
        free = holder[-1:] in (("lamps",), ("overrides",)) or holder[-2:-1] == ("overrides",)
        assert VALIDATOR.is_valid(wrong) == free, (holder, key)


def keys_of(data: Any, at: tuple[Any, ...] = ()) -> list[tuple[tuple[Any, ...], str]]:
    """Every key below ``data`` with the path of the mapping that holds it."""
    inside = data.items() if isinstance(data, dict) else enumerate(data)
    found = [(at, key) for key in data] if isinstance(data, dict) else []
    for step, value in inside:
        if isinstance(value, (dict, list)):
            found += keys_of(value, (*at, step))
    return found


def step_into(data: Any, path: tuple[Any, ...]) -> Any:
    for step in path:
        data = data[step]
    return data


def test_every_key_is_explained() -> None:
    schema = room_schema()
    for name, model in schema["$defs"].items():
        assert model.get("description") or "enum" in model, name
        for key, field in model.get("properties", {}).items():
            assert key == "from" or "description" in field or "$ref" in field, (name, key)


BASE = """
layout:
  openings: [{kind: window, wall: 0, at: 120 cm, open: 5 deg}]
furniture:
  objects:
    - {category: chair, at: [1, 2.5], yaw: 1 rad, size: [50 cm, 0.5, 1], name: a}
    - {category: statue, at: [1, 2, 0], file: a.obj, up: Y}
materials: {floor: wood, walls: {family: paint, color: [0.5, 0.5, 1]}, overrides: {a: {all: wood}}}
lights: {environment: {file: sky.hdr, scale: 2}, lamps: {a: {lumen: 5, on: true}}}
cameras:
  resolution: [64, 48]
  views:
    - {eye: [0, 0, 1], target: [1, 1, 1], fov: 60 deg}
    - {from: select, count: 2, height: [1, 2]}
"""
ODD: tuple[Any, ...] = (
    *(None, True, False, 0, -1, 1, 2.5, 1e6, -1e10, 2**70, "", "1 cm", "90 deg", "x y", "chair"),
    *([], [1], [1, 2], [1, 2, 3], ["1 m", 2], {}, {"from": "file"}, {"from": "select"}, "select"),
    *("wood", {"family": "wood"}, {"family": 3}, "file", "from", 17.0, [[0, 0], [1, 0], [0, 1]]),
)


@pytest.mark.slow
@given(st.data())
def test_schema_and_models_agree_about_single_values(data: st.DataObject) -> None:
    """One value of a good description is replaced; both must say the same about the result.

    Beyond a schema are: what lies between fields, limits of quantities that are text, and numbers
    such as 17.0, which JSON takes for whole.
    """
    room = yaml.safe_load(BASE)
    holder, key = data.draw(st.sampled_from(keys_of(room)))
    step_into(room, holder)[key] = data.draw(st.sampled_from(ODD))
    by_schema = VALIDATOR.is_valid(room)
    try:
        Room.model_validate(room)
    except ValidationError as error:
        beyond = {MISTAKE, "value_error", "int_type"}
        text = {"greater_than", "greater_than_equal", "less_than", "less_than_equal"}
        kinds = {row["type"] for row in error.errors()}
        assert not by_schema or kinds <= beyond | text
    else:
        assert by_schema


@pytest.mark.parametrize("snippet", SNIPPETS, ids=lambda text: text.split(":", 1)[0])
def test_each_example_loads(snippet: str) -> None:
    parse_room(snippet)


def test_every_key_is_in_the_reference() -> None:
    models = room_schema()
    keys = {key for model in models["$defs"].values() for key in model.get("properties", {})}
    keys |= {key for key, field in models["properties"].items() if "deprecated" not in field}
    assert [key for key in sorted(keys) if f"| `{key}` |" not in FIELDS] == []
    assert len(SNIPPETS) > 8


def test_the_message_in_the_reference_is_real() -> None:
    shown = re.search(r"^```text\nerror: (.*?)^```$", TEXT, flags=re.MULTILINE | re.DOTALL)
    assert shown is not None
    wrong = (
        "name: a\n\nlayout:\n  hieght: 3\n\n\nfurniture:\n  objects:\n"
        "    - {category: chiar, at: [1, 1]}\n"
    )
    with pytest.raises(Exception, match="2 mistakes") as caught:
        parse_room(wrong)
    assert shown[1] == f"{caught.value}\n"
