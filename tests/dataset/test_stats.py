"""Numbers of a dataset, against counts by hand."""

from pathlib import Path

import numpy as np
import pytest

from openrooms_usd.dataset.plan import Job, PlannedRoom
from openrooms_usd.dataset.records import SCENE
from openrooms_usd.dataset.stats import class_pixels, stats_of
from openrooms_usd.dataset.store import Store, write_json
from openrooms_usd.render.contract import Image, View


def job(number: int, kind: str, variant: str) -> Job:
    room = PlannedRoom(f"{kind}_{number}", number, {"type": kind}, "train" if number else "test")
    return Job(room, variant, 0, f"{number} {variant}", (0, 1))


JOBS = [job(n, kind, v) for n, kind in ((0, "office"), (1, "gym")) for v in ("main", "mainDiffMat")]


@pytest.fixture
def root(tmp_path: Path) -> Path:
    """Two rooms in two variants of two views; one view is not finished."""
    store = Store(tmp_path)
    store.write_plan(JOBS)
    for number, one in enumerate(JOBS):
        legend = {"category": {"5": "chair", "6": "chair", "7": "desk"}}
        report = {"approximated": 0, "losses": []}
        shared = {"entry": {"legend": legend}, "report": report, "licences": [], "files": {}}
        write_json(store.record_path(one, SCENE), {"key": one.key, **shared})
        for view in one.views[: 1 if number == 3 else 2]:
            error = {"estimated_robust_error": 0.1 * (number + 1)}
            channels = {"radiance": error, "depth": {"estimated_robust_error": 0.0}}
            record = {
                "unit": "",
                "room": "",
                "variant": "",
                "split": "",
                "source": {},
                "told": [],
                "quality": {"measures": {}, "faults": []},
                "entry": {"resolution": [], "K": [], "world_from_camera": [], "channels": channels},
                "pixels": {"floor": 10, "chair": view},
                "files": {"a": {"sha256": "", "bytes": 100}, "b": {"sha256": "", "bytes": 1}},
            }
            timing = {"compose": 8.0, "translation": 4.0, "render": 2.0, "output": 1.0}
            store.finish(one, view, record, timing)
    return tmp_path


def test_everything_is_counted_once(root: Path) -> None:
    found = stats_of(root)
    assert found.rooms == {"office": 1, "gym": 1}
    assert found.splits == {"test": 1, "train": 1}
    assert found.views == {"main": 4, "mainDiffMat": 3}
    assert found.objects == {"chair": 4, "desk": 2}
    assert found.pixels == {"floor": 70, "chair": 3}
    assert found.bytes == 7 * 101
    assert found.errors == {"radiance": pytest.approx(0.2)}
    # What the views of a job share was done once for them.
    assert found.seconds == {"compose": 32.0, "translation": 16.0, "render": 14.0, "output": 7.0}


def test_pixels_of_classes_are_those_of_the_picture() -> None:
    numbers = np.array([[4, 4, 7], [0, 7, 4]], np.float32)[..., None]
    view = View(None, 3, 2, np.eye(3), np.eye(4), None, {"semantic": Image(numbers, 1, 0.0, 0.0)})
    assert class_pixels(view, {4: "chair", 7: "wall"}) == {"chair": 3, "wall": 2}
    assert class_pixels(View(None, 3, 2, np.eye(3), np.eye(4), None, {}), {4: "chair"}) == {}
