"""The YAML subset: YAML 1.2 meanings, limits, and nothing that harms."""

import math
from typing import Any

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from openrooms_usd.description import parse_room, reading
from openrooms_usd.errors import DescriptionError, OrusdError


def read(text: str) -> dict[str, Any]:
    data, mistakes = reading.read_yaml(text, "room.yaml")
    assert not mistakes, [str(mistake) for mistake in mistakes]
    return data


def refusal_of(text: str | bytes) -> str:
    with pytest.raises(DescriptionError) as caught:
        parse_room(text)
    return str(caught.value)


@pytest.mark.parametrize(
    ("text", "meaning"),
    [
        ("on", "on"),
        ("off", "off"),
        ("yes", "yes"),
        ("No", "No"),
        ("true", True),
        ("False", False),
        ("'true'", "true"),
        ("~", None),
        ("null", None),
        ("", None),
        ("1:30", "1:30"),
        ("1_000", "1_000"),
        ("2024-01-01", "2024-01-01"),
        ("017", 17),
        ("0o17", 15),
        ("0x1F", 31),
        ("-12", -12),
        ("+.5", 0.5),
        ("1.", 1.0),
        ("1e3", 1000.0),
        ("-1.5E-2", -0.015),
        (".inf", math.inf),
        ("-.Inf", -math.inf),
        ("=", "="),
        ("<<", "<<"),
        ("!!str 5", "5"),
        ("! 5", "5"),
        ("!!float 5", 5),
        ("!!int 5", 5),
        ("!!null ''", None),
        ("!!bool true", True),
        ("!!seq [1]", [1]),
        ("!!map {a: 1}", {"a": 1}),
        ('"\\u00e4\\n"', "ä\n"),
        ("|\n  a\n  b", "a\nb\n"),
        ("9" * 101, "9" * 101),
    ],
)
def test_scalars_mean_what_yaml_1_2_says(text: str, meaning: Any) -> None:
    value = read(f"key: {text}\n")["key"]
    assert value == meaning
    assert type(value) is type(meaning) or isinstance(value, (dict, list))


def test_nan_is_a_number() -> None:
    assert math.isnan(read("key: .nan")["key"])


def test_on_is_a_key() -> None:
    assert read("on: floor\nno: 1\ny: 2") == {"on": "floor", "no": 1, "y": 2}


json_like = st.recursive(
    st.none()
    | st.booleans()
    | st.integers(-(10**20), 10**20)
    | st.floats(allow_nan=False, allow_infinity=False)
    | st.text(st.characters(codec="utf-8", exclude_categories=["Cc", "Cs"]), max_size=20),
    lambda inner: (
        st.lists(inner, max_size=4)
        | st.dictionaries(st.text("abc_ :-", max_size=4), inner, max_size=4)
    ),
    max_leaves=20,
)


@pytest.mark.slow
@given(st.dictionaries(st.text("abcdef", min_size=1), json_like, min_size=1))
def test_json_means_in_yaml_what_it_means_in_json(data: dict[str, Any]) -> None:
    import json

    assert read(json.dumps(data, ensure_ascii=False)) == data


@pytest.mark.slow
@given(st.dictionaries(st.text("abcdef", min_size=1), json_like, min_size=1))
def test_positions_are_those_of_the_node_tree(data: dict[str, Any]) -> None:
    """PyYAML's composer says where each value stands; it is another way through the parser."""
    text = yaml.safe_dump(data, allow_unicode=True)
    node = yaml.compose(text, Loader=yaml.SafeLoader)
    assert isinstance(node, yaml.MappingNode)
    found = read(text)
    assert isinstance(found, reading.Mapping)
    for key, value in node.value:
        assert found.keys_at[key.value] == (key.start_mark.line + 1, key.start_mark.column + 1)
        assert found.values_at[key.value] == (
            value.start_mark.line + 1,
            value.start_mark.column + 1,
        )


def test_anchors_stand_for_what_they_name() -> None:
    assert read("a: &one {b: [1, &two 2]}\nc: [*one, *two]") == {
        "a": {"b": [1, 2]},
        "c": [{"b": [1, 2]}, 2],
    }


@pytest.mark.parametrize("text", ["a: &x [*x]", "a: &x {b: {c: *x}}", "&x a: *y", "a: &x {*x : 1}"])
def test_anchors_that_cannot_be_written_out_are_refused(text: str) -> None:
    message = refusal_of(text)
    assert "contains itself" in message or "is not defined above" in message


def test_amplifying_anchors_are_refused() -> None:
    laughs = "a0: &a0 [ha, ha, ha, ha, ha, ha, ha, ha, ha, ha]\n" + "".join(
        f"a{i + 1}: &a{i + 1} [{', '.join([f'*a{i}'] * 10)}]\n" for i in range(12)
    )
    assert "more than 1,000,000 values" in refusal_of(laughs)


def test_anchors_nest_no_deeper_than_text() -> None:
    chain = "a0: &a0 [1]\n" + "".join(f"a{i + 1}: &a{i + 1} [*a{i}]\n" for i in range(2000))
    assert "nested more than 32 levels deep" in refusal_of(chain)
    deep = f"a: &deep {'[' * 20}{']' * 20}\n"
    assert "nested" not in refusal_of(f"{deep}c: {'[' * 11}*deep{']' * 11}")
    assert "nested" in refusal_of(f"{deep}c: {'[' * 12}*deep{']' * 12}")


@pytest.mark.parametrize("opening", ["[", "- ", "{a: ", "a: [{b: [", "? "])
def test_deep_nesting_is_refused(opening: str) -> None:
    for count in (40, 100_000):
        assert "1 mistake" in refusal_of(opening * count)
    assert "nested more than 32 levels deep" in refusal_of("a:\n " + "- " * 100_000)


def test_too_many_values_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reading, "MAX_VALUES", 1000)
    assert "more than 1,000 values" in refusal_of(f"a: [{'0,' * 1000}]")
    assert "more than" not in refusal_of(f"a: [{'0,' * 990}]")


def test_a_huge_file_is_refused() -> None:
    assert "larger than 16 MiB" in refusal_of(b"#" * (16 * 2**20 + 1))


@given(st.binary(max_size=200))
def test_no_bytes_break_the_reader(data: bytes) -> None:
    try:
        parse_room(data)
    except OrusdError as error:
        assert str(error)


WORDS = "layout polygon from objects furniture views cameras lamps at 0 1.5 .nan true null select"
PIECES = (
    *"{}[]:,-?&*!|>%@`#'\"\\\n\t ",
    ": ",
    "- ",
    "\n  ",
    "&a ",
    "*a",
    "!!",
    "<<",
    "---\n",
    "ä",
    "\0",
)
yaml_like = st.lists(st.sampled_from((*PIECES, *WORDS.split())), max_size=60).map("".join)


@given(yaml_like)
def test_no_text_breaks_the_reader(text: str) -> None:
    try:
        parse_room(text)
    except OrusdError as error:
        assert str(error)


SECTIONS = "name room seed layout furniture materials lights cameras"
FIELDS = (
    "from polygon openings objects views environment lamps overrides file kind wall at size on "
    "name category eye target world_from_camera height floor color scale illuminance fov family"
)
fields = st.sampled_from(FIELDS.split())
values = st.recursive(
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats()
    | st.sampled_from(["chair", "select", "file", "roomplan", "1 m", "wood", "floor", "chair_0"]),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(fields, inner, max_size=4),
    max_leaves=25,
)


@pytest.mark.slow
@given(st.dictionaries(st.sampled_from(SECTIONS.split()), values, min_size=1))
def test_no_data_breaks_the_models(data: dict[str, Any]) -> None:
    try:
        parse_room(yaml.safe_dump(data))
    except OrusdError as error:
        assert "function" not in str(error)
        assert "Input should" not in str(error)
