"""Numbers of a dataset, against counts by hand, and what is wrong with views."""

import json
from pathlib import Path

import numpy as np
import pytest

from openrooms_usd.dataset.plan import Job, PlannedRoom
from openrooms_usd.dataset.quality import assess, camera_faults
from openrooms_usd.dataset.records import SCENE
from openrooms_usd.dataset.stats import stats_of
from openrooms_usd.dataset.status import DEPTH_BINS, channel_seconds, material_names, tally
from openrooms_usd.dataset.store import Store, write_json
from openrooms_usd.rendering.contract import Image, View


def job(number: int, kind: str, variant: str) -> Job:
    room = PlannedRoom(f"{kind}_{number}", number, {"type": kind}, "train" if number else "test")
    return Job(room, variant, 0, f"{number} {variant}", (0, 1))


JOBS = [job(n, kind, v) for n, kind in ((0, "office"), (1, "gym")) for v in ("main", "mainDiffMat")]
LIGHTS = [
    {"kind": "lamp", "on": True, "lumen": 199.0, "kelvin": 2999.0},
    {"kind": "lamp", "on": True, "lumen": 200.0, "kelvin": 3000.0},
    {"kind": "lamp", "on": False, "lumen": 0.0, "kelvin": 3000.0},
    {"kind": "opening", "on": True, "lumen": 1e4, "kelvin": None},
    {"kind": "elsewhere", "on": True, "lumen": 7.0, "kelvin": None},
]


@pytest.fixture
def root(tmp_path: Path) -> Path:
    """Two rooms in two variants of two views; one view is not finished."""
    store = Store(tmp_path)
    store.write_plan(JOBS)
    for number, one in enumerate(JOBS):
        legend = {"category": {"5": "chair", "6": "chair", "7": "desk"}}
        entry = {"legend": legend, "lights": LIGHTS if one.variant == "main" else LIGHTS[2:]}
        report = {"approximated": 0, "losses": []}
        licences = ["CC0", "MIT"] if number == 1 else ["CC0"]
        shared = {"entry": entry, "report": report, "licences": licences, "files": {}}
        write_json(store.record_path(one, SCENE), {"key": one.key, **shared})
        for view in one.views[: 1 if number == 3 else 2]:
            error = {"estimated_robust_error": 0.1 * (number + 1)}
            channels = dict.fromkeys(("radiance", "direct_0", "direct_1"), error)
            channels["depth"] = {"estimated_robust_error": 0.0}
            record = {
                "unit": "",
                "room": "",
                "variant": "",
                "split": "",
                "source": {},
                "told": [],
                "quality": {"measures": {}, "faults": ["it is dark"] if view else []},
                "rejected": [],
                "entry": {"resolution": [], "K": [], "world_from_camera": [], "channels": channels},
                "pixels": {"floor": 10, "chair": view},
                "materials": {"wood/oak": 4, "wood/cork": 3, "other": view},
                "depth": [0, 2, 5],
                "files": {"a": {"sha256": "", "bytes": 100}, "b": {"sha256": "", "bytes": 1}},
            }
            timing = {
                "compose": 8.0,
                "translation": 4.0,
                "render": 2.0,
                "output": 1.0,
                "threads": 2,
                "channels": {"radiance": 1.0 + view},
            }
            store.finish(one, view, record, timing)
    return tmp_path


def test_everything_is_counted_once(root: Path) -> None:
    found = stats_of(root)
    assert found.rooms == {"office": 1, "gym": 1}
    assert found.splits == {"test": 1, "train": 1}
    assert found.views == {"main": 4, "mainDiffMat": 3}
    assert found.objects == {"chair": 4, "desk": 2}
    assert found.pixels == {"floor": 70, "chair": 3}
    assert found.materials == {"wood": 49, "other": 3}
    assert found.families == {"wood: oak": 28, "wood: cork": 21, "other": 3}
    assert found.depth_m == {"0": 0, "0.25": 14, "0.5": 35}
    assert found.licences == {"CC0": 2, "MIT": 1}
    assert found.faults == {"it is dark": 3}
    assert found.bytes == 7 * 101
    # Three of room 0, two of the same with other materials, two of room 1 and one of its other.
    errors = {name: pytest.approx(0.2) for name in ("direct_i", "radiance")}
    assert found.errors == errors
    assert found.high_errors["radiance"] == pytest.approx(0.34)
    # What the views of a job share was done once for them.
    assert found.seconds == {"compose": 32.0, "translation": 16.0, "render": 14.0, "output": 7.0}
    assert found.core_seconds == 2 * 69.0
    assert found.channel_seconds == {"radiance": pytest.approx(10 / 7)}


def test_lights_are_counted_in_every_variant(root: Path) -> None:
    found = stats_of(root)
    assert found.lights == {"lamp, off": 4, "opening": 4, "elsewhere": 4, "lamp": 4}
    assert found.lamps_a_room == {"0": 2, "2": 2}
    assert found.lamp_lumen == {"100": 2, "200": 2}
    assert found.lamp_kelvin == {"2500": 2, "3000": 2}
    assert found.opening_lumen == {"10000": 4}


def test_records_that_tell_less_are_counted_as_far_as_they_tell(root: Path) -> None:
    store = Store(root)
    for one in JOBS:
        for view, record in list(store.records(one)):
            del record["materials"], record["depth"]
            store.finish(one, view, record, {"render": 3.0})
    found = stats_of(root)
    assert (found.materials, found.depth_m) == ({}, {})
    assert (found.seconds["render"], found.core_seconds) == (21.0, 21.0)


@pytest.mark.parametrize(
    "text", ["3", "[]", '{"key": "0 main", "render": null}', '{"key": "0 main", "channels": 3}']
)
def test_times_that_are_none_are_none(root: Path, text: str) -> None:
    store, seconds = Store(root), stats_of(root).seconds["render"]
    store.timing_path(JOBS[0], 0).write_text(text)
    assert stats_of(root).seconds["render"] == seconds - 2.0


def view_of(**images: list[list[float]]) -> View:
    pixels = {name: np.array(rows, np.float32)[..., None] for name, rows in images.items()}
    made = {name: Image(rows, 1, 0.5, 0.0) for name, rows in pixels.items()}
    return View(None, 3, 2, np.eye(3), np.eye(4), None, made)


def test_pixels_are_those_of_the_picture() -> None:
    view = view_of(semantic=[[4, 4, 7], [0, 7, 4]], material=[[1, 2, 2], [0, 3, 1]])
    found = tally(view, {4: "chair", 7: "wall"}, {1: "wood/oak", 2: "other", 3: "wood/oak"})
    assert found["pixels"] == {"chair": 3, "wall": 2}
    assert found["materials"] == {"other": 2, "wood/oak": 3}
    nothing = {"pixels": {}, "instances": None, "materials": {}, "depth": []}
    assert tally(view_of(), {4: "chair"}, {}) == nothing


def test_depths_fall_into_bins_of_a_quarter_metre() -> None:
    found = tally(view_of(depth=[[0.0, 0.1, 0.25], [0.49, 0.5, 0.7]]), {}, {})["depth"]
    assert found == [1, 2, 2]
    far = tally(view_of(depth=[[9.99, 10.0, 1e6]]), {}, {})["depth"]
    assert len(far) == DEPTH_BINS
    assert far[-2:] == [1, 2]


def test_seconds_of_lights_are_those_of_one() -> None:
    assert channel_seconds(view_of(direct_0=[[1]], direct_1=[[1]], radiance=[[1]])) == {
        "radiance": 0.5,
        "direct_i": 0.5,
    }


def test_materials_are_counted_as_what_their_prims_say() -> None:
    from pxr import Sdf, Usd

    stage = Usd.Stage.CreateInMemory()
    for name, values in {"a": ("wood", "oak"), "b": ("metal", ""), "c": ("", "")}.items():
        prim = stage.DefinePrim(f"/{name}", "Material")
        for key, value in zip(("category", "family"), values, strict=True):
            attribute = prim.CreateAttribute(f"openrooms:material:{key}", Sdf.ValueTypeNames.Token)
            attribute.Set(value)
    found = material_names(stage, {1: "/a", 2: "/b", 3: "/c", 4: "/nowhere"})
    assert found == {1: "wood/oak", 2: "metal", 3: "other", 4: "other"}


SHAPE = (12, 16)


def view(**changed: object) -> View:
    """A sound view, with some channels in place of its own; None leaves one out."""
    channels: dict[str, object] = {
        "radiance": np.full((*SHAPE, 3), 200.0),
        "depth": np.full((*SHAPE, 1), 2.0),
        "valid": np.ones((*SHAPE, 1)),
        "instance": np.arange(SHAPE[0] * SHAPE[1]).reshape(*SHAPE, 1) % 5,
    } | changed
    images = {
        name: Image(np.asarray(pixels, np.float32), 4, 0.0, 0.1, robust_error=0.05)
        for name, pixels in channels.items()
        if pixels is not None
    }
    return View("/c", SHAPE[1], SHAPE[0], np.eye(3), np.eye(4), 1e-3, images)


def one_near() -> np.ndarray:
    depth = np.full((*SHAPE, 1), 2.0)
    depth[0, 0] = 0.01
    return depth


@pytest.mark.parametrize(
    ("changed", "fault"),
    [
        ({"radiance": np.full((*SHAPE, 3), 0.01)}, "it is dark"),
        ({"radiance": np.full((*SHAPE, 3), 3e3)}, "most of it is brighter than white"),
        ({"depth": one_near()}, "the camera is inside an object"),
        ({"depth": np.full((*SHAPE, 1), 0.2)}, "an object blocks the camera"),
        ({"valid": np.zeros((*SHAPE, 1))}, "it is empty"),
        ({"instance": np.ones((*SHAPE, 1))}, "it shows only one object"),
        ({"normal": np.full((*SHAPE, 3), np.nan)}, "not all values are finite in normal"),
    ],
)
def test_each_fault_is_found_alone(changed: dict[str, np.ndarray], fault: str) -> None:
    assert assess(view(**changed))["faults"] == [fault]


def test_what_is_no_number_is_no_measure() -> None:
    holed = np.full((*SHAPE, 3), 200.0)
    holed[3, 4] = np.nan
    found = assess(view(radiance=holed))
    assert found["faults"] == ["not all values are finite in radiance"]
    json.dumps(found, allow_nan=False)


def test_a_sound_view_has_none() -> None:
    found = assess(view(), error=0.1)
    assert found["faults"] == []
    assert found["measures"] == {
        "bright_nits": 200.0,
        "blown_share": 0.0,
        "error": 0.05,
        "seen_share": 1.0,
        "nearest_m": 2.0,
        "close_share": 0.0,
        "instances": 4,
    }


def test_noise_is_held_against_the_budget_alone() -> None:
    assert assess(view(), error=0.01)["faults"] == ["it is noisier than requested"]


def test_channels_that_are_not_asked_for_are_not_missed() -> None:
    found = assess(view(radiance=None, depth=None, valid=None, instance=None))
    assert found == {"measures": {}, "faults": []}


def test_a_channel_that_is_not_there_or_empty_is_missed() -> None:
    nothing = np.zeros((*SHAPE, 3))
    black = view(normal=nothing, base_color=nothing)
    found = assess(black, asked=("normal", "base_color", "part"))
    # Black things there are; surfaces without a normal there are not.
    assert found["faults"] == ["no values in normal, part"]
    lit = view(irradiance=nothing)
    assert assess(lit, asked=("irradiance",))["faults"] == ["no values in irradiance"]
    dark = view(irradiance=nothing, radiance=nothing)
    assert assess(dark, asked=("irradiance",))["faults"] == ["it is dark"]
    # Outside there are no normals.
    empty = view(valid=np.zeros((*SHAPE, 1)), normal=nothing)
    assert assess(empty, asked=("normal",))["faults"] == ["it is empty"]


def test_faults_of_light_are_not_the_cameras() -> None:
    dark = view(radiance=np.zeros((*SHAPE, 3)), depth=one_near())
    assert camera_faults(dark) == ["the camera is inside an object"]
