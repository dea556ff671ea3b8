"""The models: defaults, sources, and what must agree between fields."""

import subprocess
import sys
from typing import Any, get_args

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from openrooms_usd.description import Room, dump_room, named_objects, named_openings, parse_room
from openrooms_usd.description.cameras import LookAtCamera, PoseCamera, SelectedCameras
from openrooms_usd.description.furniture import FileObject, LibraryCategory, LibraryObject
from openrooms_usd.description.layout import Opening, PolygonLayout
from openrooms_usd.description.lights import ConstantEnvironment, FileEnvironment
from openrooms_usd.description.materials import MaterialChoice
from openrooms_usd.errors import DescriptionError


def test_the_shortest_description_is_one_line() -> None:
    assert parse_room("room: office") == Room(room="office")


@pytest.mark.parametrize(
    ("text", "kind"),
    [
        ("{category: chair, at: [0, 0]}", LibraryObject),
        ("{from: library, category: chair, at: [0, 0]}", LibraryObject),
        ("{category: statue, at: [0, 0], file: a.obj}", FileObject),
        ("{from: file, category: statue, at: [0, 0], file: a.obj}", FileObject),
    ],
)
def test_an_object_needs_no_from(text: str, kind: type) -> None:
    room = parse_room(f"furniture: {{objects: [{text}]}}")
    assert type(room.furniture.objects[0]) is kind


@pytest.mark.parametrize(
    ("text", "kind"),
    [
        ("{}", ConstantEnvironment),
        ("{illuminance: 0}", ConstantEnvironment),
        ("{file: a.exr}", FileEnvironment),
        ("{from: file, file: a.exr}", FileEnvironment),
    ],
)
def test_an_environment_needs_no_from(text: str, kind: type) -> None:
    assert type(parse_room(f"lights: {{environment: {text}}}").lights.environment) is kind


IDENTITY = "[[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0]]"


@pytest.mark.parametrize(
    ("text", "kind"),
    [
        ("{eye: [0, 0, 1], target: [1, 0, 1]}", LookAtCamera),
        (f"{{world_from_camera: {IDENTITY}}}", PoseCamera),
        ("{from: select}", SelectedCameras),
    ],
)
def test_only_selected_cameras_need_a_from(text: str, kind: type) -> None:
    assert type(parse_room(f"cameras: {{views: [{text}]}}").cameras.views[0]) is kind


def test_a_family_alone_is_a_look() -> None:
    materials = parse_room("materials: {floor: fabric, overrides: {}}").materials
    assert materials.floor == MaterialChoice(family="fabric")
    assert materials.walls is None
    given = "{floor: oak_planks, walls: {substance: paint, number: 3}, ceiling: {color: [1, 1, 1]}}"
    materials = parse_room(f"materials: {given}").materials
    assert materials.floor == MaterialChoice(family="oak_planks")
    assert materials.walls == MaterialChoice(substance="paint", number=3)
    assert materials.ceiling is not None and materials.ceiling.is_constant


@pytest.mark.parametrize(
    ("look", "message"),
    [
        ("{}", "give one of: family, substance, file, color"),
        ("{roughness: 0.5}", "give one of"),
        ("{file: a, color: [1, 1, 1]}", "color cannot be combined with file"),
        ("{family: denim, substance: metal}", "substance cannot be combined with family"),
        ("{family: denim, metallic: 1}", "metallic cannot be combined with family"),
        ("{substance: metal, metallic: 1}", "a constant needs a color too"),
        ("{color: [1, 1, 1], size: 1}", "a constant has no texture"),
    ],
)
def test_looks_that_contradict_themselves_are_refused(look: str, message: str) -> None:
    with pytest.raises(DescriptionError, match=message):
        parse_room(f"materials: {{floor: {look}}}")


def test_looks_and_scales_are_within_their_ranges() -> None:
    with pytest.raises(DescriptionError, match="the room has the looks 0 to 1"):
        parse_room("materials: {looks: 2, look: 2}")
    with pytest.raises(DescriptionError, match="the smaller factor comes first"):
        parse_room("materials: {scale: {color: [1.2, 0.8]}}")
    parse_room("materials: {looks: 2, look: 1, scale: {roughness: [0.8, 1.2]}}")


@pytest.mark.parametrize(
    "matrix",
    [
        "[[-1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0]]",
        "[[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0.9, 0]]",
        "[[1, 0, 0, 0], [0.1, 0.995, 0, 0], [0, 0, 1, 0]]",
        "[[0, 1, 0, 0], [1, 0, 0, 0], [0, 0, 1, 0]]",
    ],
)
def test_a_pose_must_be_a_rotation(matrix: str) -> None:
    with pytest.raises(DescriptionError, match="a rotation"):
        parse_room(f"cameras: {{views: [{{world_from_camera: {matrix}}}]}}")


def test_rotations_are_accepted() -> None:
    from scipy.spatial.transform import Rotation

    for rotation in Rotation.random(20, rng=0).as_matrix().round(6).tolist():
        rows = [[*row, 1.5] for row in rotation]
        parse_room(f"cameras: {{views: [{{world_from_camera: {rows}}}]}}")


def test_the_models_check_what_python_gives_them() -> None:
    opening = Opening(kind="door", wall=9)
    with pytest.raises(ValidationError, match="no wall 9"):
        PolygonLayout(openings=(opening,))
    with pytest.raises(ValidationError, match="no object is named"):
        Room.model_validate({"lights": {"lamps": {"lamp": {}}}})


def test_captured_names_are_not_known_yet() -> None:
    parse_room(
        "furniture:\n  from: roomplan\n  file: a.json\n"
        "  objects: [{category: chair, at: [0, 0], on: captured}]\n"
        "lights: {lamps: {y: {on: false}}}"
    )


def thing(category: str, name: str | None = None) -> dict[str, Any]:
    return {"category": category, "at": [0, 0]} | ({"name": name} if name else {})


def names_of(*things: dict[str, Any]) -> list[str]:
    room = Room.model_validate({"furniture": {"objects": things}})
    return [name for name, _ in named_objects(room.furniture.objects)]


def test_default_names_count_within_a_category() -> None:
    assert names_of(thing("chair"), thing("table"), thing("chair"), thing("chair", "throne")) == [
        "chair_0",
        "table_0",
        "chair_1",
        "throne",
    ]


def test_default_names_skip_names_that_are_used() -> None:
    assert names_of(thing("chair"), thing("chair", "chair_0"), thing("chair")) == [
        "chair_1",
        "chair_0",
        "chair_2",
    ]
    late = [thing("chair"), thing("chair"), thing("table", "chair_0")]
    assert names_of(*late) == ["chair_2", "chair_1", "chair_0"]


def test_a_name_for_one_renames_no_other() -> None:
    chairs = [thing("chair") for _ in range(4)]
    before = names_of(*chairs)
    for index in range(4):
        after = names_of(*chairs[:index], thing("chair", "throne"), *chairs[index + 1 :])
        assert after == [*before[:index], "throne", *before[index + 1 :]]


@given(
    st.lists(
        st.tuples(
            st.sampled_from(["chair", "table"]),
            st.none() | st.sampled_from([f"{c}_{i}" for c in ("chair", "table") for i in range(4)]),
        ),
        unique_by=lambda pair: pair[1] or object(),
        max_size=12,
    )
)
def test_names_are_unique_and_given_names_are_kept(pairs: list[tuple[str, str | None]]) -> None:
    names = names_of(*(thing(category, name) for category, name in pairs))
    assert len(set(names)) == len(names)
    assert all(given in (None, name) for name, (_, given) in zip(names, pairs, strict=True))


def test_openings_are_named_by_their_kind() -> None:
    openings = [Opening(kind=kind, wall=0) for kind in ("window", "door", "window")]
    names = [name for name, _ in named_openings(openings)]
    assert names == ["window_0", "door_0", "window_1"]


@pytest.mark.slow
def test_ten_thousand_objects_load() -> None:
    row = "    - {category: chair, at: [1.5, 2.5], yaw: 30 deg, size: [50 cm, 50 cm, 0.9]}\n"
    room = parse_room("furniture:\n  objects:\n" + row * 10_000)
    assert named_objects(room.furniture.objects)[-1][0] == "chair_9999"


def test_reading_descriptions_imports_nothing_heavy() -> None:
    code = (
        "import sys, openrooms_usd.description as d; d.parse_room('room: office'); "
        "print({'numpy', 'pxr', 'scipy', 'shapely', 'trimesh', 'mitsuba', 'OpenImageIO'} "
        "& set(sys.modules))"
    )
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert found.stdout.strip() == "set()"


@pytest.mark.parametrize("file", ["1e5", "0o17", "0x1F", ".inf", "true", "on", "- a", "a: b", "é"])
def test_text_that_looks_like_something_else_survives_the_file(file: str) -> None:
    room = Room.model_validate({"lights": {"environment": {"file": file}}})
    assert parse_room(dump_room(room)) == room


names = st.from_regex(r"[A-Za-z_][A-Za-z0-9_]{0,8}", fullmatch=True)
texts = st.text(st.characters(codec="utf-8", exclude_categories=["Cc", "Cs"]), min_size=1)
metres = st.floats(-1000, 1000)
sizes = st.floats(0.01, 1000)
objects = st.one_of(
    st.fixed_dictionaries(
        {"category": st.sampled_from(get_args(LibraryCategory)), "at": st.tuples(metres, metres)},
        optional={"yaw": st.floats(-3600, 3600), "style": texts, "size": st.tuples(*[sizes] * 3)},
    ),
    st.fixed_dictionaries(
        {"category": names, "at": st.tuples(metres, metres, metres), "file": texts},
        optional={"up": st.sampled_from("YZ"), "unit": sizes},
    ),
)
rooms = st.fixed_dictionaries(
    {},
    optional={
        "name": names,
        "seed": st.integers(0, 2**63 - 1),
        "furniture": st.fixed_dictionaries({"objects": st.lists(objects, max_size=4)}),
        "lights": st.fixed_dictionaries(
            {"environment": st.fixed_dictionaries({"file": texts, "scale": st.floats(1e-6, 1e9)})}
        ),
        "cameras": st.just({"views": [{"from": "select"}], "resolution": [320, 240]}),
    },
)


@given(rooms)
def test_a_room_survives_the_file(data: dict[str, Any]) -> None:
    room = Room.model_validate(data)
    assert parse_room(dump_room(room)) == room
