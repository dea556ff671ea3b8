"""CADs keep their proportions: what does not fit is built anew, or a box stands for it."""

import numpy as np
import pytest

from openrooms_usd.furniture import CATEGORIES
from openrooms_usd.library.models.cads import furniture_cads, merged
from openrooms_usd.scan.models.cad import CadModel
from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.registration.alignment import align
from openrooms_usd.scan.registration.evidence import Evidence
from openrooms_usd.scan.registration.hints import Box, Hint
from openrooms_usd.scan.registration.scalelimits import SCALES, sizes_of, turns_of
from openrooms_usd.scan.registration.selection import CadSelection
from openrooms_usd.steps.alignment.captured import sizes_of as sizes_of_category
from tests.scan.alignment_cases import CHAIR, SENSOR_ORIGINS, Block, Placed, cad, room, scan

UP = np.eye(3)


def built(category: str) -> list[CadModel]:
    """What the library builds for a category."""
    made = []
    for one in furniture_cads((category,)):
        model = one.model()
        vertices, faces = merged(model, model.file_from_object)
        sizes, suits = sizes_of_category(category), CATEGORIES[category].styles[one.style].suits
        made.append(CadModel(one.id, category, vertices, faces, up="Z", sizes=sizes, suits=suits))
    return made


def test_a_cad_of_known_size_is_scaled_by_little() -> None:
    chair = CadModel("c", "chair", *mesh_of(CHAIR), unit=1.0)
    own = np.ptp(chair.extent, axis=0)
    assert turns_of(chair, UP, 0.61 * own)
    assert turns_of(chair, UP, 1.59 * own)
    assert not turns_of(chair, UP, own * [1.0, 1.0, 0.5])
    assert not turns_of(chair, UP, own * 1.7)
    assert sizes_of(chair, UP, own) == pytest.approx(np.outer(SCALES, own))


def test_a_cad_without_unit_keeps_its_proportions() -> None:
    chair = CadModel("c", "chair", *mesh_of(CHAIR))
    own = np.ptp(chair.extent, axis=0)
    assert turns_of(chair, UP, 0.08 * own)
    assert not turns_of(chair, UP, own * [0.4, 0.4, 0.08])


def test_depth_that_nobody_saw_is_no_reason_to_refuse() -> None:
    cabinet = built("cabinet")[0]
    assert turns_of(cabinet, UP, np.array([1.8, 0.05, 0.9])) == [0]
    assert turns_of(cabinet, UP, np.array([0.05, 1.8, 0.9])) == [1]
    assert not turns_of(cabinet, UP, np.array([1.8, 0.6, 0.05]))


def test_headings_and_styles_are_those_that_are_natural() -> None:
    """A pedestal desk is no narrower than 1 m, and a bunk bed no lower than a door handle."""
    desk = next(model for model in built("desk") if model.id == "desk.pedestal")
    assert turns_of(desk, UP, np.array([0.63, 1.16, 0.75])) == [1]
    beds = CadSelection(Cloud(np.zeros((1, 3))), built("bed"), {})
    size = np.array([1.5, 1.94, 0.9])
    box = Box(0.5 * size, size, np.array([1.0, 0.0, 0.0, 0.0]))
    evidence = Evidence(np.random.default_rng(1).random((200, 3)) * size, 0.02)
    hint = Hint(1, choices=(("bed",),))
    chosen = beds.candidates(hint, np.zeros(0, np.intp), evidence, box)
    assert "bed.bunk" not in {model.id for model, _ in chosen}


def test_what_fits_no_category_is_a_box_of_its_size() -> None:
    """A slab on legs is no table of 6 cm, and a cube of 2 m no chair."""
    cube: tuple[Block, ...] = (((-0.8, -0.8, 0.0), (0.8, 0.8, 2.6)),)
    cloud = scan([Placed(cube, (0.0, 0.3, 0.0), 0.0)], SENSOR_ORIGINS)
    models = [*built("chair"), *built("box")]
    hint = Hint(1, word="chair", choices=(("chair",), ("guitar",)))
    found = align(cloud, [hint], models, [room()]).objects[0]
    assert (found.category, found.word, found.cad) == ("box", "chair", "box.plain")
    assert found.pose.scale * [0.4, 0.3, 0.3] == pytest.approx([1.6, 1.6, 2.6], abs=0.08)


@pytest.mark.slow
def test_own_cads_come_first_where_their_proportions_do() -> None:
    cloud = scan([Placed(CHAIR, (0.2, 0.1, 0.0), 0.4)], SENSOR_ORIGINS)
    squat = cad("chair_squat", CHAIR, scale=np.array([0.4, 0.4, 2.0]))
    own = cad("chair_own", CHAIR, scale=np.array([1.1, 1.1, 1.1]))
    models = [*built("chair"), *built("box"), squat, own]
    hint = Hint(1, word="chair", choices=(("chair",),))
    assert align(cloud, [hint], models, [room()]).objects[0].cad == "chair_own"
    found = align(cloud, [hint], models[:-1], [room()]).objects[0]
    assert found.cad.startswith("chair.")
    low, high = sizes_of_category("chair")
    size = found.pose.scale * np.ptp(next(m for m in models if m.id == found.cad).extent, axis=0)
    assert (size >= low - 1e-9).all()
    assert (size <= high + 1e-9).all()


def mesh_of(blocks: tuple[Block, ...]) -> tuple[np.ndarray, np.ndarray]:
    made = cad("c", blocks)
    return made.vertices, made.faces


def test_a_table_of_which_only_the_top_was_seen_stands_on_the_floor() -> None:
    """Unless something else is below it, on which it may lie."""
    top: tuple[Block, ...] = (((-0.5, -0.3, 0.42), (0.5, 0.3, 0.46)),)
    stand: tuple[Block, ...] = (((-0.4, -0.2, 0.0), (0.4, 0.2, 0.38)),)
    hint = Hint(1, word="table", choices=(("coffee_table",),))
    models = [*built("coffee_table"), *built("box")]
    for below, category in (((), "coffee_table"), ((stand,), "box")):
        blocks = [Placed(one, (0.2, 0.2, 0.0), 0.0) for one in (top, *below)]
        found = align(scan(blocks, SENSOR_ORIGINS), [hint], models, [room()]).objects[0]
        assert found.category == category
    size = models[0].sizes
    assert size is not None
    assert size[0][2] > 0.1
