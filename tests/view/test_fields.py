"""What people do with things of a room as fields of its room.yaml: it composes, the rest stays."""

import hashlib
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from openrooms_usd.description import load_room
from openrooms_usd.edits.snapping import PlanPoint
from openrooms_usd.errors import OrusdError
from openrooms_usd.view.corrections import corrections
from openrooms_usd.view.describing import Described
from openrooms_usd.view.fields import Fields
from tests.edits.test_arranging import box, is_a, objects
from tests.edits.test_assigning import worn

SEAT = "/World/Furniture/chair_1/Geometry/seat"
OAK = {"family": "oak_planks", "number": 3}
COMMENT = "# what the owner said\n"


@pytest.fixture
def fields(composed_demo: Path, tmp_path: Path) -> Fields:
    shutil.copytree(composed_demo.parents[1], tmp_path / "room")
    file = tmp_path / "room/room.yaml"
    file.write_text(COMMENT + file.read_text())
    return Fields(Described(file, tmp_path / "room/out/scene.usda"))


def test_an_object_is_moved_and_all_else_stays(fields: Fields) -> None:
    before = fields.file.read_text()
    fields.place("chair_1", PlanPoint(3.0, 2.2, 45.0), size=None, snap=False)
    assert box(fields.scene, "chair_1").mean(axis=0)[:2] == pytest.approx((3.0, 2.2), abs=2e-3)
    text = fields.file.read_text()
    assert text.startswith(COMMENT) and text.split("objects:")[0] == before.split("objects:")[0]
    changed = load_room(fields.file).as_dict()
    chair = changed["furniture"]["objects"][2]
    assert (chair["at"], chair["yaw"]) == ([3.0, 2.2], 45.0)
    chair |= {"at": [2.6, 1.5], "yaw": 90.0}
    fields.file.write_text(before)
    assert load_room(fields.file).as_dict() == changed


def test_edits_have_no_part_in_it(fields: Fields) -> None:
    edits = fields.scene.parent / "layers/edits.usda"
    before = hashlib.sha256(edits.read_bytes()).hexdigest()
    fields.place("desk", PlanPoint(1.5, 2.7, 0.0), size=(1.4, 0.7, 0.8), snap=True)
    assert box(fields.scene, "desk")[1] == pytest.approx((2.2, 3.0, 0.8), abs=1e-4)
    fields.assign(SEAT, "category", OAK)
    assert hashlib.sha256(edits.read_bytes()).hexdigest() == before


@pytest.mark.slow
def test_names_stay_when_others_come_and_go(fields: Fields) -> None:
    copy = fields.duplicate("chair_0").name
    assert copy == "chair_0_copy" and objects(fields.scene)[copy]
    fields.remove("chair_0")
    assert set(objects(fields.scene)) == {"desk", "chair_1", "table_lamp_0", copy}
    fields.relabel("chair_1", "stool")
    assert is_a(fields.scene, "chair_1")[0] == "stool"
    meshes = is_a(fields.scene, copy)[1]
    fields.remake(copy, "shell", None, keep_size=True)
    assert is_a(fields.scene, copy)[1] != meshes
    assert load_room(fields.file).as_dict()["furniture"]["objects"][-1]["style"] == "shell"


@pytest.mark.one_in(6)
@pytest.mark.parametrize(
    ("path", "scope", "said"),
    [
        (SEAT, "part", {"overrides": {"chair_1": {"seat": OAK}}}),
        (SEAT, "alike", {"overrides": {"chair_0": {"seat": OAK}, "chair_1": {"seat": OAK}}}),
        (SEAT, "category", {"overrides": {"chair_0": {"all": OAK}, "chair_1": {"all": OAK}}}),
        ("/World/Room/Floor", "part", {"floor": OAK}),
        ("/World/Room/Walls/wall_1", "part", {"accents": {"wall_1": OAK}}),
        ("/World/Room/Walls/wall_1", "category", {"walls": OAK}),
    ],
)
def test_materials_are_fields_of_their_section(
    path: str, scope: str, said: dict[str, object], fields: Fields
) -> None:
    before = worn(fields.scene)
    done = fields.assign(path, scope, OAK)  # type: ignore[arg-type]
    assert load_room(fields.file).as_dict()["materials"] == said
    after = worn(fields.scene)
    changed = {path for path in after if after[path] != before[path]}
    assert changed == set(done.parts) and {after[path] for path in changed} == {("oak_planks", 3)}
    fields.unassign(path, scope)  # type: ignore[arg-type]
    assert worn(fields.scene) == before


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda f: f.relabel("chair_1", "chiar"), "did you mean 'chair'"),
        (lambda f: f.remake("chair_1", "rococo", None, keep_size=True), "no chair has the style"),
        (lambda f: f.remove("desk"), "no object is named 'desk'"),
        (lambda f: f.assign(SEAT, "part", {"family": "oak_plank"}), "did you mean 'oak_planks'"),
        (lambda f: f.place("door_0", PlanPoint(1, 1, 0), size=None, snap=True), "no such object"),
    ],
)
def test_what_compose_refuses_is_refused_in_its_words_and_nothing_is_written(
    change: Callable[[Fields], object], words: str, fields: Fields
) -> None:
    before = fields.file.read_bytes()
    with pytest.raises(OrusdError) as error:
        change(fields)
    assert words in str(error.value) and fields.file.read_bytes() == before


@pytest.mark.slow
def test_it_is_taken_back_and_composed(fields: Fields) -> None:
    held = corrections(fields.file, out=fields.scene.parent)
    where, text = box(fields.scene, "chair_1"), fields.file.read_bytes()
    held.done(lambda: {"it": held.target.remove("chair_1")})
    assert "chair_1" not in objects(fields.scene)
    held.commands()["undo"].run(held.commands()["undo"].model())
    assert fields.file.read_bytes() == text
    assert box(fields.scene, "chair_1") == pytest.approx(where, abs=1e-9)


def test_relative_places_stay_relative(fields: Fields) -> None:
    text = fields.file.read_text().replace(
        "{category: chair, at: [2.6, 1.5], yaw: 90 deg}",
        "{category: chair, name: chair_1, at: [0, -1.0], yaw: 0, relative_to: desk}",
    )
    fields.file.write_text(text)
    fields.described.compose()
    fields.place("chair_1", PlanPoint(2.5, 0.9, 30.0), size=None, snap=False)
    assert box(fields.scene, "chair_1").mean(axis=0)[:2] == pytest.approx((2.5, 0.9), abs=1e-3)
    row = load_room(fields.file).as_dict()["furniture"]["objects"][2]
    assert row["relative_to"] == "desk" and row["at"] == pytest.approx([1.0, -0.6])
