"""Which material things are made of: the tables name what exists, draws follow the weights."""

from collections.abc import Callable
from pathlib import Path
from typing import get_args

import numpy as np
import pytest

from openrooms_usd.description.room import RoomType
from openrooms_usd.description.substances import Substance
from openrooms_usd.errors import InputError
from openrooms_usd.furniture import CATEGORIES, part_of
from openrooms_usd.furniture.registry import records
from openrooms_usd.library.styles.assignment.annotations import files_of, read_annotation
from openrooms_usd.library.styles.assignment.kinds import kind_of, known_as
from openrooms_usd.library.styles.assignment.rooms import (
    ROOMS,
    USUAL,
    families_of,
    substance_of,
    surface_of,
)
from openrooms_usd.library.styles.assignment.weights import drawn, families_for
from openrooms_usd.library.styles.finishes import (
    FINISHES,
    METALS,
    PARTS,
    finishes_of,
    furniture_families,
)
from openrooms_usd.library.textures import FAMILIES, family_of
from openrooms_usd.library.textures import substance_of as substance_of_family
from tests.furniture.pieces import piece


def test_every_room_type_has_surfaces_of_families_that_exist() -> None:
    assert set(ROOMS) == set(get_args(RoomType))
    for room, surfaces in ROOMS.items():
        for place, substances in (("floor", surfaces.floor), ("wall", surfaces.wall)):
            for substance in substances:
                families = families_of(room, place, substance)  # type: ignore[arg-type]
                assert families, (room, place, substance)
                assert {substance_of_family(name) for name in families} == {substance}
        for (_, substance), families in surfaces.suited.items():
            assert {substance_of_family(name) for name in families} == {substance}


def test_families_are_used_where_people_have_them() -> None:
    tables = [(place, table) for place, by in USUAL.items() for table in by.values()]
    tables += [(place, t) for r in ROOMS.values() for (place, _), t in r.suited.items()]
    for place, table in tables:
        for name in table:
            # Cloth on a wall is the cloth of furniture.
            assert place in family_of(name).uses or substance_of_family(name) == "fabric"


def test_floors_have_the_substances_that_openrooms_lists(real: Callable[[str], Path]) -> None:
    text = real("labels/room_types.txt").read_text(encoding="utf-8")
    lines = [line for line in text.splitlines() if line[0] != "#"]
    assert len(lines) == len(ROOMS)
    for line in lines:
        room, _, listed = line.partition(":")
        surfaces = ROOMS[room.strip().replace(" ", "_")]
        floors = {word.strip() for word in listed.split(",")}
        assert set(surfaces.floor) == floors
        walls = {"paint", "rough_stone"} | ({"fabric"} & floors)
        assert set(surfaces.wall) == walls | ({"specular_stone"} if room == "bathroom" else set())


def test_names_are_drawn_by_their_weights_in_whatever_order() -> None:
    rng = np.random.default_rng(0)
    counts = [drawn(rng, {"a": 1.0, "b": 3.0, "c": 0.0}) for _ in range(4000)]
    assert counts.count("b") / 4000 == pytest.approx(0.75, abs=0.03)
    assert "c" not in counts
    first, second = (np.random.default_rng(5) for _ in range(2))
    assert [drawn(first, {"a": 1, "b": 2}) for _ in range(50)] == [
        drawn(second, {"b": 2, "a": 1}) for _ in range(50)
    ]


def test_rooms_draw_from_their_own_lists() -> None:
    rng = np.random.default_rng(1)
    floors = [surface_of("bathroom", "floor", rng)[1] for _ in range(300)]
    assert set(floors) == set(ROOMS["bathroom"].floor)
    assert {substance_of("gym", "ceiling", rng) for _ in range(20)} == {"paint"}
    garage = [surface_of("garage", "floor", rng)[0] for _ in range(200)]
    assert garage.count("cast_concrete") > 120 and "cobblestone" not in garage


@pytest.mark.parametrize(
    ("name", "kind"),
    [
        ("leg", "leg"),
        ("leg_1", "leg"),
        ("Leg.002", "leg"),
        ("leg12", "leg"),
        ("leg_1_2", "leg"),
        ("SeatCushion_3", "seat_cushion"),
        ("drawer front-04", "drawer_front"),
        ("17", ""),
        ("pied_avant", "pied_avant"),
    ],
)
def test_parts_that_differ_by_a_number_are_of_one_kind(name: str, kind: str) -> None:
    assert kind_of(name) == kind


def test_partnet_names_are_known_by_their_last_words() -> None:
    assert list(known_as("chair_seat_cushion")) == ["chair_seat_cushion", "seat_cushion", "cushion"]
    rng = np.random.default_rng(0)
    found = finishes_of("gadget", ["lamp_shade_cover", "door_handle", "gizmo", ""], rng)
    assert found["door_handle"] in ("steel", "brass", "black")
    assert found["gizmo"] == found[""] == found["lamp_shade_cover"] == "lacquer"


def test_hundreds_of_unnamed_parts_share_one_finish() -> None:
    parts = [f"piece_{'abcdefghij'[i % 10] * (i // 10 + 1)}" for i in range(300)]
    found = finishes_of("chair", parts, np.random.default_rng(2))
    assert len(found) == 300 and len(set(found.values())) == 1


@pytest.mark.parametrize("substance", get_args(Substance))
def test_each_substance_has_families_for_furniture(substance: Substance) -> None:
    families = furniture_families(substance)
    assert families and set(families) <= set(FAMILIES[substance])
    assert set(families_for(substance, {"floor"})) <= set(FAMILIES[substance])


def written(tmp_path: Path, text: str, name: str = "ann.txt") -> Path:
    path = tmp_path / name
    path.write_text(text, encoding="utf-8")
    return path


def test_parts_by_number(tmp_path: Path) -> None:
    found = read_annotation(written(tmp_path, "# 4\n0 0 4\n1 6\n\n2 9\n3 7 5\n4 1\n"))
    assert found.numbered == {0: ("wood", "paint"), 1: ("metal",), 3: ("fabric", "leather")}
    assert found.substances("part3") == found.substances("lamp_part_3") == ("fabric", "leather")
    assert found.substances("part4") == () == found.substances("seat")
    assert found.lamps == {2} and found.is_lamp("part2") and not found.is_lamp("part1")


def test_the_count_beside_the_file_leaves_later_parts_out(tmp_path: Path) -> None:
    path = written(tmp_path, "0 0\n1 1\n2 2\n")
    assert set(read_annotation(path).numbered) == {0, 1, 2}
    written(tmp_path, "2\n", "matNum.txt")
    assert set(read_annotation(path).numbered) == {0, 1}
    assert [file.name for file in files_of(path)] == ["ann.txt", "matNum.txt"]


def test_parts_by_name(tmp_path: Path) -> None:
    text = "Chair\nchair_leg: wood, metal\nchair_seat:\nSeat Cushion:  fabric \n"
    found = read_annotation(written(tmp_path, text, "annoMatParts.txt"))
    assert found.named == {"chair_leg": ("wood", "metal"), "seat_cushion": ("fabric",)}
    assert found.substances("chair_leg_7") == ("wood", "metal")
    assert found.substances("SeatCushion") == ("fabric",)


def test_a_bad_model_says_so(tmp_path: Path) -> None:
    assert read_annotation(written(tmp_path, "!\n0 x\n")).bad


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("0 0\n1 10\n", r"ann.txt:2: there is no category 10\n"),
        ("0 0\n1\n", "ann.txt:2: expected the number of a part"),
        ("0 wood\n", "expected the number of a part and of its categories, found '0 wood'"),
        ("-1 2\n", "expected the number of a part"),
        ("²\n", "expected the number of a part"),
        ("Chair\nleg: wod\n", r"ann.txt:2: there is no category 'wod' \(did you mean 'wood'"),
        ("Chair\nleg: wood\narm\n", "ann.txt:3: expected a part and its categories"),
        ("\n \n", "the annotation is empty"),
    ],
)
def test_what_is_no_annotation_is_refused(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(InputError) as caught:
        read_annotation(written(tmp_path, text))
    caught.match(message)
    assert caught.value.remedy


def test_what_cannot_be_read_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such file"):
        read_annotation(tmp_path / "none.txt")
    (tmp_path / "ann.txt").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(InputError, match="expected the number of a part"):
        read_annotation(tmp_path / "ann.txt")


@pytest.mark.one_in(3, rest="long")
@pytest.mark.parametrize("name", sorted(CATEGORIES))
def test_every_part_of_every_style_has_a_finish(name: str) -> None:
    spec = CATEGORIES[name]
    for style in spec.styles:
        parts = {part_of(part) for part in piece(name, style).parts}
        for seed in range(6):
            finishes = finishes_of(name, parts, np.random.default_rng(seed))
            assert set(finishes) == parts
            assert set(finishes.values()) <= set(FINISHES)


def test_schemes_name_categories_and_finishes_that_exist() -> None:
    known = {*FINISHES, "metal"}
    for name, told in records():
        for scheme in told.schemes:
            assert set(scheme.finishes.values()) <= known, name
    assert set(PARTS.values()) <= known
    assert set(METALS) <= set(FINISHES)


def test_what_is_drawn_for_each_differs() -> None:
    assert FINISHES[PARTS["book"]].each
    for finish in FINISHES.values():
        if finish.each:
            assert len(finish.colors) > 1
            assert finish.choices > 1
