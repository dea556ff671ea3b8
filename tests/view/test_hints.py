"""What people do with things of a scan are hints of its room.yaml, in the frame of the scan."""

from pathlib import Path

import numpy as np
import pytest

from openrooms_usd.description import load_room
from openrooms_usd.edits.snapping import Spot
from openrooms_usd.errors import InputError
from openrooms_usd.view.corrections import corrections
from openrooms_usd.view.hints import Hints
from tests.edits.test_arranging import is_a, objects
from tests.end_to_end.test_scanned_room import AT, AWAY, HEADING, SCAN_FROM_ROOM, cloud

pytestmark = pytest.mark.slow


@pytest.fixture
def hints(tmp_path: Path) -> Hints:
    np.savez(tmp_path / "scan.npz", **cloud())
    file = tmp_path / "room.yaml"
    file.write_text(
        "layout: {from: scan, scan: scan.npz}\n"
        "# all that the scan shows\nalignment: {from: scan}\nmaterials: {floor: oak_planks}\n"
    )
    target = corrections(file).target
    assert isinstance(target, Hints) and target.scene == tmp_path / "composed/scene.usda"
    return target


def listed(hints: Hints) -> list[dict]:
    return load_room(hints.file).as_dict()["alignment"]["objects"]


def test_a_thing_is_called_something_else_moved_copied_and_left_out(hints: Hints) -> None:
    (name,) = objects(hints.scene)
    assert is_a(hints.scene, name)[0] == "table"
    one = hints.relabel(name, "desk")
    assert is_a(hints.scene, one.name)[0] == "desk"
    (row,) = listed(hints)
    assert (row["instance"], row["category"]) == (1, "desk")
    # Where the table was put into the cloud, by the numbers that the cloud was made of.
    wanted = SCAN_FROM_ROOM @ (AT + np.array([0.0, 0.0, 0.37])) + AWAY
    assert np.abs(np.array(row["box"]["center"]) - wanted).max() < 0.05
    w, _, _, z = row["box"]["rotation_wxyz"]
    turned = 2.0 * np.degrees(np.arctan2(z, w)) - np.degrees(HEADING) - 20.0
    assert abs((turned + 90.0) % 180.0 - 90.0) < 3.0

    centers = []
    for x in (one.x, one.x + 0.1):
        (name,) = objects(hints.scene)
        hints.place(name, Spot(x, one.y, one.yaw), size=None, snap=False)
        centers.append(listed(hints)[0]["box"]["center"])
    assert np.linalg.norm(np.subtract(*centers)) == pytest.approx(0.1, abs=0.005)
    (name,) = objects(hints.scene)

    copy = hints.duplicate(name).name
    assert set(objects(hints.scene)) == {name, copy}
    hints.remove(name)
    assert listed(hints) == [] and set(objects(hints.scene)) == {copy}
    text = hints.file.read_text()
    assert text.startswith("layout: {from: scan, scan: scan.npz}\n# all that the scan shows\n")
    assert text.endswith("materials: {floor: oak_planks}\n")


def test_what_is_not_there_is_refused(hints: Hints) -> None:
    before = hints.file.read_bytes()
    with pytest.raises(InputError, match="no such object"):
        hints.remove("sofa")
    assert hints.file.read_bytes() == before
