"""Seats, desks, beds, soft things, stairs and fireplaces: what makes them what they are."""

from itertools import pairwise

import numpy as np
import pytest

from openrooms_usd.furniture import CATEGORIES, Parts, part_of, styles
from tests.furniture.pieces import caster, made, parts_of


def _top(parts: Parts, *wanted: str) -> float:
    return max(float(mesh.extent[1, 2]) for mesh in parts_of(parts, *wanted).values())


SEATS = [
    *(("office_chair", style, (0.38, 0.56)) for style in CATEGORIES["office_chair"].styles),
    *(("armchair", style, (0.36, 0.52)) for style in CATEGORIES["armchair"].styles),
    *(("bench", style, (0.4, 0.5)) for style in CATEGORIES["bench"].styles if style != "chest"),
]


@pytest.mark.parametrize(("name", "style", "span"), SEATS)
def test_one_sits_at_the_height_of_a_seat(name: str, style: str, span: tuple[float, float]) -> None:
    """What a ray from above the middle of the seat meets first."""
    parts = made(name, style).parts
    seats = parts_of(parts, "seat", "seat_cushion")
    middle = np.mean([mesh.extent.mean(axis=0) for mesh in seats.values()], axis=0)
    low = np.inf
    for mesh in seats.values():
        # Beside the middle, where planks may have a gap.
        start = np.array([[middle[0] + 0.03, middle[1] - 0.05, 3.0]])
        hit = caster(mesh).first_hit(start, np.array([[0.0, 0.0, -1.0]]))
        low = min(low, float(hit.distance[0]))
    assert span[0] < 3.0 - low < span[1]


@pytest.mark.parametrize("style", CATEGORIES["office_chair"].styles)
@pytest.mark.parametrize("seed", range(3))
def test_office_chairs_stand_on_five_castors(style: str, seed: int) -> None:
    parts = made("office_chair", style, seed).parts
    wheels = parts_of(parts, "wheel")
    assert len(wheels) == 5
    for mesh in wheels.values():
        assert mesh.extent[0, 2] == pytest.approx(0.0, abs=2e-3)
    others = {name: mesh for name, mesh in parts.items() if name not in wheels}
    assert min(mesh.extent[0, 2] for mesh in others.values()) > 0.02
    # The middle of the seat is above the five feet: it does not tip.
    feet = np.array([mesh.extent.mean(axis=0)[:2] for mesh in wheels.values()])
    seat = parts["seat_cushion"].extent.mean(axis=0)[:2]
    around = feet[np.argsort(np.arctan2(*(feet - feet.mean(axis=0)).T[::-1]))]
    edges = np.roll(around, -1, axis=0) - around
    to_seat = seat - around
    assert (edges[:, 0] * to_seat[:, 1] - edges[:, 1] * to_seat[:, 0] > 0.0).all()


@pytest.mark.parametrize("style", ["pedestal", "writing", "framed"])
@pytest.mark.parametrize("seed", range(4))
def test_desk_drawers_have_boxes_below_the_top(style: str, seed: int) -> None:
    desk = made("desk", style, seed)
    drawers = [joint for joint in desk.joints if part_of(joint.name) == "drawer"]
    assert drawers
    under = desk.parts["tabletop_0"].extent[0, 2]
    for joint in drawers:
        assert {part_of(mesh) for mesh in joint.meshes} == {"drawer_front", "drawer_box", "handle"}
        assert joint.axis == (0, -1, 0)
        assert joint.limits[1] > 0.2
        assert all(desk.parts[mesh].extent[1, 2] <= under + 1e-9 for mesh in joint.meshes)


@pytest.mark.parametrize("style", CATEGORIES["desk"].styles)
def test_knees_fit_below_desks(style: str) -> None:
    """From the front, a person of 50 x 60 cm finds room in at least one place below the top."""
    parts = made("desk", style).parts
    width = CATEGORIES["desk"].styles[style].size or CATEGORIES["desk"].size
    x = np.linspace(-0.5 * width[0], 0.5 * width[0], 60)
    free = np.ones(len(x), dtype=bool)
    for mesh in parts.values():
        low, high = mesh.extent
        if low[2] < 0.58 and high[2] > 0.05 and low[1] < 0.1:
            free &= (x < low[0]) | (x > high[0])
    runs = np.split(free, np.flatnonzero(np.diff(free.astype(int))) + 1)
    longest = max(len(run) for run in runs if run.all())
    assert longest * (x[1] - x[0]) > 0.5


@pytest.mark.parametrize("style", CATEGORIES["bed"].styles)
@pytest.mark.parametrize("seed", range(2))
def test_beds_aremade(style: str, seed: int) -> None:
    """Pillows lie on the mattress at the back, under nothing; the cover lies before them."""
    bed = made("bed", style, seed)
    pairs = len(parts_of(bed.parts, "mattress"))
    assert pairs == (2 if style == "bunk" else 1)
    wide = bed.parts["mattress_0"].extent[1, 0] - bed.parts["mattress_0"].extent[0, 0]
    assert len(parts_of(bed.parts, "pillow")) == (2 if wide > 1.2 else 1) * pairs
    for i in range(pairs):
        mattress, blanket = (bed.parts[f"{part}_{i}"].extent for part in ("mattress", "blanket"))
        assert blanket[1, 2] > mattress[1, 2]
        pillow = bed.parts[f"pillow_{i * len(parts_of(bed.parts, 'pillow')) // pairs}"].extent
        assert pillow[:, 1].mean() > mattress[:, 1].mean() + 0.5
        assert pillow[0, 2] == pytest.approx(mattress[1, 2], abs=0.06)
        assert blanket[1, 1] < pillow[0, 1] + 0.02
        assert mattress[1, 2] - mattress[0, 2] > 0.1


@pytest.mark.parametrize("height", [0.45, 0.6, 1.0])
def test_low_beds_are_low(height: float) -> None:
    bed = made("bed", "platform", size=(1.4, 2.0, height))
    assert bed.parts["mattress_0"].extent[1, 2] < height - 0.1


def test_sheers_are_sheer_and_drapes_leave_the_window_free() -> None:
    layered = made("curtain", "layered").parts
    assert {part_of(name) for name in layered} >= {"sheer", "curtain", "rod", "ring", "bracket"}
    drapes = parts_of(made("curtain", "drapes").parts, "curtain")
    assert len(drapes) == 2
    left, right = sorted(mesh.extent[:, 0].tolist() for mesh in drapes.values())
    assert right[0] - left[1] > 0.4
    drawn = parts_of(made("curtain", "drawn").parts, "curtain")
    left, right = sorted(mesh.extent[:, 0].tolist() for mesh in drawn.values())
    assert right[0] - left[1] < 0.26
    # The sheer hangs between the drapes and the wall.
    sheer = layered["sheer"].extent
    assert all(mesh.extent[1, 1] < sheer[0, 1] for mesh in parts_of(layered, "curtain").values())


def test_a_sheer_behind_curtains_hangs_clear_of_the_board_of_a_window() -> None:
    board = 0.04  # so far it stands out of the wall
    _, depth, _ = CATEGORIES["curtain"].size
    for mesh in parts_of(made("curtain", "layered").parts, "sheer").values():
        assert mesh.extent[1, 1] < 0.5 * depth - board + 1e-3


@pytest.mark.parametrize("style", CATEGORIES["curtain"].styles)
def test_curtains_reach_the_wall(style: str) -> None:
    parts = made("curtain", style).parts
    back = max(mesh.extent[1, 1] for mesh in parts.values())
    assert max(m.extent[1, 1] for m in parts_of(parts, "bracket").values()) == pytest.approx(back)
    cloth = parts_of(parts, "curtain", "sheer", "slat", "blind")
    assert min(mesh.extent[0, 2] for mesh in cloth.values()) < 0.08


def test_blinds_suit_shallow_boxes() -> None:
    assert set(styles("curtain", (1.2, 0.08, 1.5))) == {"sheer", "sheers", "roller", "venetian"}
    assert "roller" not in styles("curtain", (2.0, 0.2, 2.3))


@pytest.mark.parametrize("style", CATEGORIES["rug"].styles)
def test_rugs_are_thin_and_whole(style: str) -> None:
    """From above, rays meet the rug over its outline but for corners and fringes."""
    size = CATEGORIES["rug"].styles[style].size or CATEGORIES["rug"].size
    parts = made("rug", style).parts
    rng = np.random.default_rng(0)
    starts = rng.uniform(-0.5, 0.5, (2000, 3)) * [0.84 * size[0], 0.84 * size[1], 0] + [0, 0, 1]
    if style == "round":
        starts = starts[np.linalg.norm(starts[:, :2] / size[:2], axis=1) < 0.48]
    nearest = np.full(len(starts), np.inf)
    for mesh in parts.values():
        hits = caster(mesh).first_hit(starts, np.tile([0.0, 0.0, -1.0], (len(starts), 1)))
        nearest = np.minimum(nearest, hits.distance)
    assert np.isfinite(nearest).all()
    assert nearest.max() - nearest.min() < size[2]


def test_pillows_stand_or_lie_as_their_box_asks() -> None:
    for size in ((0.45, 0.16, 0.4), (0.45, 0.4, 0.16)):
        mesh = made("pillow", "square", size=size).parts["pillow"]
        rim = np.abs(mesh.points[:, 0]) > 0.21
        spread = np.ptp(mesh.points[rim], axis=0)
        thin = 1 if size[1] < size[2] else 2
        assert spread[thin] < 0.6 * size[thin]
        assert spread[3 - thin] > 0.9 * size[3 - thin]


@pytest.mark.parametrize("style", ["solid", "open_treads"])
@pytest.mark.parametrize("height", [0.7, 2.2, 3.0])
def test_stairs_climb_in_even_steps(style: str, height: float) -> None:
    parts = parts_of(made("stairs", style, size=(1.0, 2.8, height)).parts, "step")
    tops = [float(parts[f"step_{i}"].extent[1, 2]) for i in range(len(parts))]
    rises = [b - a for a, b in pairwise([0.0, *tops])]
    assert rises == pytest.approx([rises[0]] * len(rises), rel=0.02)
    assert 0.14 < rises[0] < 0.22
    fronts = [float(mesh.extent[0, 1]) for mesh in parts.values()]
    assert fronts == sorted(fronts)
    assert tops[-1] == pytest.approx(height)


def test_handrails_are_90_cm_above_the_steps() -> None:
    parts = made("stairs", "railed").parts
    rail = next(iter(parts_of(parts, "handrail").values())).extent
    assert rail[1, 2] - _top(parts, "step") == pytest.approx(0.9, abs=0.03)


@pytest.mark.parametrize("style", CATEGORIES["fireplace"].styles)
def test_a_fire_has_a_hollow_to_burn_in(style: str) -> None:
    """A ray from the front at the height of the logs goes deep, once the door is out of the way."""
    fireplace = made("fireplace", style)
    moving = {mesh for joint in fireplace.joints for mesh in joint.meshes}
    logs = parts_of(fireplace.parts, "log")
    level = np.mean([mesh.extent[:, 2].mean() for mesh in logs.values()]) + 0.12
    front = min(mesh.extent[0, 1] for mesh in fireplace.parts.values())
    first = np.inf
    for name, mesh in fireplace.parts.items():
        if name in moving:
            continue
        hit = caster(mesh).first_hit(np.array([[0.0, -3.0, level]]), np.array([[0.0, 1.0, 0.0]]))
        first = min(first, float(hit.distance[0]))
    assert first - 3.0 > front + 0.2
    assert bool(moving) == (style == "stove")
