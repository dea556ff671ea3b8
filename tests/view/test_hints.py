"""What people do with things of a scan are hints of its room.yaml, in the frame of the scan."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

from openrooms_usd.cli import orusd
from openrooms_usd.description import load_room
from openrooms_usd.edits.snapping import PlanPoint
from openrooms_usd.errors import InputError
from openrooms_usd.usd.files.layers import open_stage
from openrooms_usd.view.corrections import Hints, corrections
from tests.edits.test_arranging import box, is_a, objects
from tests.end_to_end.test_scanned_room import AT, AWAY, HEADING, SCAN_FROM_ROOM, cloud

pytestmark = pytest.mark.slow


@pytest.fixture
def hints(tmp_path: Path) -> Hints:
    np.savez(tmp_path / "scan.npz", **cloud())  # type: ignore[arg-type]
    file = tmp_path / "room.yaml"
    file.write_text(
        "layout: {from: scan, scan: scan.npz}\n"
        "# all that the scan shows\nfurniture: {from: scan}\nmaterials: {floor: oak_planks}\n"
    )
    target = corrections(file).target
    assert isinstance(target, Hints) and target.scene == tmp_path / "composed/scene.usda"
    return target


def listed(hints: Hints) -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = load_room(hints.file).as_dict()["furniture"]["objects"]
    return found


def check_box(box: dict[str, Any]) -> None:
    """It is where the table was put into the cloud, by the numbers that the cloud was made of."""
    wanted = SCAN_FROM_ROOM @ (AT + np.array([0.0, 0.0, 0.37])) + AWAY
    assert np.abs(np.array(box["center"]) - wanted).max() < 0.05
    w, _, _, z = box["rotation_wxyz"]
    turned = 2.0 * np.degrees(np.arctan2(z, w)) - np.degrees(HEADING) - 20.0
    assert abs((turned + 90.0) % 180.0 - 90.0) < 3.0


def test_a_thing_is_called_something_else_moved_copied_and_left_out(hints: Hints) -> None:
    (name,) = objects(hints.scene)
    assert is_a(hints.scene, name)[0] == "table"
    one = hints.relabel(name, "desk")
    assert is_a(hints.scene, one.name)[0] == "desk"
    (row,) = listed(hints)
    assert row == {"instance": 1, "category": "desk"}
    centers = []
    for x in (one.x, one.x + 0.1):
        (name,) = objects(hints.scene)
        hints.place(name, PlanPoint(x, one.y, one.yaw), size=None, snap=False)
        (row,) = listed(hints)
        centers.append(row["box"]["center"])
        if x == one.x:
            check_box(row["box"])
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


@pytest.mark.long
def test_a_real_scan_without_cads_is_corrected(tmp_path: Path, real: Callable[[str], Path]) -> None:
    """Points with classes and without instances: boxes say which thing is meant, and where."""
    folder = real("scan2cad_scene0470_00") / "Assets/scannet-sample/scene0470_00"
    call = ["import", "scannet", str(folder), "-o", str(tmp_path / "room")]
    assert CliRunner().invoke(orusd, call, catch_exceptions=False).exit_code == 0
    file = tmp_path / "room/room.yaml"
    target = corrections(file).target
    assert isinstance(target, Hints)
    before = {name: box(target.scene, name) for name in objects(target.scene)}
    chairs = [name for name in before if is_a(target.scene, name)[0] == "chair"]
    # Boxes choose points a little otherwise than classes do.
    target._change(open_stage(target.scene), lambda rows: rows)
    assert len(listed(target)) >= len(before) - 1  # the lamp is no thing of the scan
    after = {name: box(target.scene, name) for name in objects(target.scene)}
    lost, kept = before.keys() - after.keys(), before.keys() & after.keys()
    apart = [np.abs(after[name] - before[name]).max() for name in kept]
    print(f"{len(kept)} of {len(before)} are kept, moved by {np.median(apart):.3f} m")
    print(f"lost {lost}, at most {max(apart):.3f} m")
    assert len(lost) <= 1 and not after.keys() - before.keys()
    one = target.relabel(chairs[0], "armchair")
    assert is_a(target.scene, one.name)[0] == "armchair"
    target.remove(one.name)
    assert not {one.name, chairs[0]} & objects(target.scene).keys()
