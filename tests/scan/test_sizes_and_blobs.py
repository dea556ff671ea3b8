"""What rough fits see, what all objects say of their size, and blobs of wrong labels."""

import numpy as np
import pytest

from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.points.planindex import PlanIndex
from openrooms_usd.scan.registration.evidence import Evidence
from openrooms_usd.scan.registration.fitting import AnnealingLevel, Fit, energies
from openrooms_usd.scan.registration.priors import PoseHypothesis
from openrooms_usd.scan.registration.scalelimits import Candidate, Sizes, sized
from openrooms_usd.scan.registration.supportheights import supports
from openrooms_usd.scan.registration.surroundings import ObjectSurroundings, walls_of
from openrooms_usd.scan.registration.template import Template, posed, template_of
from tests.scan.alignment_cases import CABINET, CHAIR, cad, room

# Two boards that are 3 cm apart, each 1 cm thick, with slats between them.
DOOR = (
    ((-0.40, -0.02, 0.0), (0.40, -0.01, 0.9)),
    ((-0.40, 0.02, 0.0), (0.40, 0.03, 0.9)),
    *(((x, -0.01, 0.0), (x + 0.02, 0.02, 0.9)) for x in np.arange(-0.4, 0.4, 0.1)),
)
PLACE = np.array([0.3, -0.2, 0.0, 0.4, 0.0, 0.0, 0.0])


def shape_of(blocks: tuple = CHAIR) -> Template:  # type: ignore[type-arg]
    return template_of(cad("thing", blocks), np.eye(3), np.ones(3))


def test_a_few_points_of_a_scan_lie_as_well_on_a_thin_cad_as_many() -> None:
    template = shape_of(DOOR)
    surface = template.points[np.abs(template.normals[:, 1]) > 0.9]
    evidence = Evidence(posed(surface, PLACE), 0.02)
    start = PoseHypothesis(PLACE, np.full(7, 0.1), np.zeros(3))
    few, many = (
        energies(
            template,
            evidence,
            ObjectSurroundings(),
            [start],
            PLACE[None],
            AnnealingLevel(0.07, count, 0, 1.0),
        )[0]
        for count in (150, len(template.points))
    )
    assert many < 5.0
    assert few < 15.0


def sizes(more: float, any_size: float = 30.0) -> Sizes:
    start = PoseHypothesis(PLACE, np.full(7, 0.1), np.zeros(3))
    free, true = (
        Candidate(SHAPE, start, ObjectSurroundings(), Fit(PLACE, value))
        for value in (any_size, any_size + more)
    )
    return Sizes(free, true)


SHAPE = shape_of()


@pytest.mark.parametrize(("others", "kept"), [(2.0, True), (200.0, False)])
def test_a_doubtful_object_has_its_true_size_where_the_others_have(
    others: float, kept: bool
) -> None:
    doubtful = sizes(10.0 if kept else 7.0)
    chosen = sized([doubtful, *[sizes(others)] * 12])
    assert chosen[0] is (doubtful.true if kept else doubtful.any)
    # Alone, what three scales save by fitting noise decides.
    assert sized([doubtful])[0] is (doubtful.any if kept else doubtful.true)


def test_differences_count_less_where_the_scan_is_bent() -> None:
    straight, bent = sizes(30.0), sizes(30.0, 300.0)
    assert sized([straight])[0] is straight.any
    assert sized([bent])[0] is bent.true


def test_without_a_true_size_any_is_taken() -> None:
    unknown = Sizes(sizes(0.0).any)
    assert sized([unknown]) == [unknown.any]
    assert sized([]) == []


def test_which_side_is_at_the_wall_counts_whether_it_was_hidden_or_not() -> None:
    around = ObjectSurroundings(None, 0.0, walls_of([room()]).near(np.array([2.0, 0.0]), 1.0))
    template = shape_of()
    place = np.array([2.5 - 0.5 * template.size[0], 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    seen, hidden = (
        around.rows(template, place, np.full(4, value, dtype=np.bool_)).energy
        for value in (False, True)
    )
    assert seen == pytest.approx(hidden)
    # The back is likelier there than the side.
    back = place + np.array(
        [0.5 * (template.size[0] - template.size[1]), 0, 0, -0.5 * np.pi, 0, 0, 0]
    )
    assert around.rows(template, back, np.zeros(4, dtype=np.bool_)).energy < seen - 1.0


def test_a_blob_of_wrong_labels_does_not_lower_an_object() -> None:
    rng = np.random.default_rng(3)
    shelf = rng.uniform([-0.4, -0.2, 1.0], [0.4, 0.2, 1.9], (4000, 3))
    blob = rng.uniform([-0.2, -0.2, 0.68], [0.2, 0.2, 0.76], (200, 3))
    boards = [rng.uniform([-0.4, -0.2, z], [0.4, 0.2, z + 0.01], (3000, 3)) for z in (0.67, 0.99)]
    parts = [np.concatenate([shelf, blob]), *boards]
    numbers = np.repeat([1, 2, 2], [len(part) for part in parts]).astype(np.int32)
    cloud = Cloud(np.concatenate(parts), instance=numbers)
    own = np.flatnonzero(numbers == 1)
    heights = supports(
        cloud, PlanIndex(cloud.points), own, Evidence(cloud.points[own], 0.02), bottom=0.9
    )
    assert heights == pytest.approx((0.675, 0.995), abs=0.02)
    clean = own[: len(shelf)]
    bare = supports(
        cloud, PlanIndex(cloud.points), clean, Evidence(cloud.points[clean], 0.02), bottom=0.9
    )
    assert bare == pytest.approx((0.995,), abs=0.02)


def test_what_goes_on_without_a_gap_ends_where_it_ends() -> None:
    surface = cad("cabinet", CABINET).surface.points + np.array([0.0, 0.0, 0.5])
    board = np.random.default_rng(5).uniform([-0.4, -0.2, 0.49], [0.4, 0.2, 0.5], (2000, 3))
    numbers = np.repeat([1, 2], [len(surface), len(board)]).astype(np.int32)
    cloud = Cloud(np.concatenate([surface, board]), instance=numbers)
    own = np.flatnonzero(numbers == 1)
    heights = supports(cloud, PlanIndex(cloud.points), own, Evidence(surface, 0.02), bottom=0.6)
    assert heights == pytest.approx((0.495, 0.0), abs=0.02)
