"""What is under a plan: what was found in scans and other captures, and its pictures."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import OpenImageIO
import pytest
from pxr import Usd

import openrooms_usd as ou
from openrooms_usd import names
from openrooms_usd.building.shell import Hole
from openrooms_usd.description import load_room
from openrooms_usd.description.layout import Partition
from openrooms_usd.importing import import_capture
from openrooms_usd.view.plan.corners import move_wall
from openrooms_usd.view.plan.document import Document
from openrooms_usd.view.plan.drawing import Drawing
from openrooms_usd.view.plan.fittings import add_opening, set_height
from openrooms_usd.view.plan.pictures import from_above, heights, of_wall
from openrooms_usd.view.plan.session import Session, Taken, WallChoice, room_file

BOX = ((0.0, 0.0), (5.0, 0.0), (5.0, 4.0), (0.0, 4.0))


def pixels(png: bytes, folder: Path) -> np.ndarray:
    """(H, W, 4) of a picture."""
    (folder / "read.png").write_bytes(png)
    read = OpenImageIO.ImageInput.open(str(folder / "read.png"))
    return np.asarray(read.read_image("uint8"))


def scan_of(corners: np.ndarray, height: float, folder: Path) -> Path:
    """The points of an empty room, with a hole where a door is in wall 0."""
    step = 0.03
    low, high = corners.min(axis=0), corners.max(axis=0)
    x, y = np.meshgrid(np.arange(low[0], high[0], step), np.arange(low[1], high[1], step))
    points = [np.column_stack([x.ravel(), y.ravel(), np.full(x.size, z)]) for z in (0.0, height)]
    for start, end in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        length = float(np.linalg.norm(end - start))
        u, z = np.meshgrid(np.arange(0, length, step), np.arange(0, height, step))
        plan = start + u.reshape(-1, 1) / length * (end - start)
        points.append(np.column_stack([plan, z.ravel()]))
    np.savez(folder / "scan.npz", points=np.concatenate(points))
    return folder / "scan.npz"


def test_points_are_seen_where_they_are_from_above(tmp_path: Path) -> None:
    points = np.array([[1.0, 3.0, 1.2]] * 9 + [[4.0, 1.0, 1.2]] * 9 + [[2.0, 2.0, 0.1]] * 9)
    picture = from_above(points, (0.0, 5.0, 0.0, 4.0), 2.6)
    alpha = pixels(picture.png, tmp_path)[..., 3]
    cell = 5.0 / alpha.shape[1]
    rows, columns = np.nonzero(alpha)
    assert sorted(
        zip(((columns + 0.5) * cell).round(1), (4 - (rows + 0.5) * cell).round(1), strict=True)
    ) == [(1.0, 3.0), (4.0, 1.0)]
    assert from_above(points, (0.0, 5.0, 0.0, 4.0), 2.6).png == picture.png


@pytest.mark.parametrize("corners", [BOX, BOX[::-1]])
def test_a_wall_is_seen_from_inside_in_the_colours_of_its_points(
    corners: tuple[tuple[float, float], ...], tmp_path: Path
) -> None:
    plan = Drawing(corners, 2.6)
    for number in range(4):
        wall = plan.seen(number)
        # 1 m from the left end and 2 m up, as somebody inside sees it; one is far before the wall.
        at = wall.to_plan(np.array([[1.0, 0.05], [1.0, -1.0]]))
        points = np.column_stack([at, [2.0, 2.0]])
        colors = np.array([[200, 100, 50], [0, 0, 255]], np.uint8)
        shown = pixels(of_wall(points, colors, wall, 2.6).png, tmp_path)
        (row,), (column,) = np.nonzero(shown[..., 3])
        assert shown[row, column].tolist() == [200, 100, 50, 255]
        assert (column + 0.5) * wall.length / shown.shape[1] == pytest.approx(1.0, abs=0.04)
        assert 2.6 - (row + 0.5) * 2.6 / shown.shape[0] == pytest.approx(2.0, abs=0.04)
        left, right = wall.to_plan(np.array([[0.0, 0.0], [1.0, 0.0]]))
        middle = np.array([2.5, 2.0])
        ahead, to_right = left - middle, right - left
        assert ahead[0] * to_right[1] - ahead[1] * to_right[0] < 0.0


def test_an_absurd_wall_is_no_absurd_picture(tmp_path: Path) -> None:
    plan = Drawing(((0.0, 0.0), (1e9, 0.0), (1e9, 4.0), (0.0, 4.0)), 1e6)
    points = np.array([[1.0, 0.0, 1.0]])
    assert max(pixels(of_wall(points, None, plan.seen(0), 1e6).png, tmp_path).shape) <= 1000


def test_floor_and_ceiling_are_peaks_of_the_heights() -> None:
    points = np.column_stack([np.zeros((90, 2)), np.repeat([0.01, 1.0, 2.51], [40, 10, 40])])
    told = heights(points)
    counts = np.array(told["counts"])
    assert np.flatnonzero(counts == 40).tolist() == [0, 125] and told["step"] == 0.02
    assert heights(np.empty((0, 3)))["counts"] == []


@pytest.mark.slow
def test_a_scan_is_drawn_over_and_nothing_is_looked_for_in_it_any_more(tmp_path: Path) -> None:
    scan = scan_of(np.array(BOX), 2.5, tmp_path)
    file = room_file(scan, tmp_path / "room")
    document = Document(file)
    found = document.saved
    assert found.area == pytest.approx(20.0, abs=0.4)
    assert found.height == pytest.approx(2.5, abs=0.05)
    plan = set_height(move_wall(found, 0, 0.4), 2.44)
    plan = add_opening(plan, Hole(1.0, 2.0, 0.0, 2.0), wall=0)
    document.save(plan)
    room = load_room(file)
    assert room.layout.source == "scan" and room.furniture.source == "scan"
    ou.compose(file, tmp_path / "out")
    stage = Usd.Stage.Open(str(tmp_path / "out/scene.usda"))
    floor = stage.GetPrimAtPath(names.ROOM).GetAttribute(names.ROOM_FLOOR).Get()
    assert np.allclose(np.array(floor), plan.corners, atol=1e-4)
    (reported,) = json.loads((tmp_path / "out/report.json").read_text())["layout"]["rooms"]
    assert reported["ceiling_height"] == 2.44
    (door,) = reported["openings"]
    assert (door["type"], door["confidence"], door["wall"]) == ("door", 1.0, 0)
    again = Document(file)
    assert again.saved.as_section() == plan.as_section()
    # What was found is still there to be taken.
    assert again.under.found["0"].as_section() == found.as_section()


def test_a_scan_in_which_no_room_is_found_begins_as_a_box(tmp_path: Path) -> None:
    x, y = np.meshgrid(np.arange(0, 4, 0.05), np.arange(0, 3, 0.05))
    floor = np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])
    np.savez(tmp_path / "scan.npz", points=floor)
    (tmp_path / "room.yaml").write_text("layout: {from: scan, scan: scan.npz, unit: m}\n")
    session = Session(tmp_path / "room.yaml")
    told = session.state()
    assert told["found"] == {} and any("draw the room" in note for note in told["notes"])
    assert len(told["corners"]) == 4 and told["area"] == pytest.approx(12.0, rel=0.15)
    session.document.save(move_wall(session.history.now, 0, 0.1))
    ou.compose(tmp_path / "room.yaml", tmp_path / "out", only="layout")


def test_a_folder_a_description_and_a_scan_all_have_a_room(tmp_path: Path) -> None:
    scan = scan_of(np.array(BOX), 2.5, tmp_path)
    file = room_file(scan, tmp_path / "room")
    assert room_file(tmp_path / "room") == room_file(file) == file
    file.write_text(f"{file.read_text()}# mine\n")
    for source, out, said in (
        (scan, None, "needs a folder"),
        (file, tmp_path / "other", "edited in place"),
        (scan, tmp_path / "room", "the folder already has a room"),
    ):
        with pytest.raises(ou.OrusdError, match=said):
            room_file(source, out)


@pytest.mark.slow
def test_a_roomplan_export_keeps_its_walls_openings_and_names(
    real: Callable[[str], Path], tmp_path: Path
) -> None:
    source = real("real_dev/data/roomplan_library/Room.json")
    file = import_capture("roomplan", source, tmp_path / "room").file
    ou.compose(file, tmp_path / "before", only="layout")
    document = Document(file)
    assert any(isinstance(one, Partition) for one in document.saved.partitions)
    document.save(set_height(document.saved, 2.9))
    ou.compose(file, tmp_path / "after", only="layout")

    def openings(out: Path) -> dict[str, list[float]]:
        stage = Usd.Stage.Open(str(out / "scene.usda"))
        return {
            prim.GetName(): [
                prim.GetAttribute(f"openrooms:opening:{side}").Get() for side in ("width", "height")
            ]
            for prim in stage.GetPrimAtPath(names.OPENINGS).GetChildren()
        }

    before, after = openings(tmp_path / "before"), openings(tmp_path / "after")
    assert before.keys() == after.keys() and len(before) >= 3
    for name, size in before.items():
        assert after[name] == pytest.approx(size, abs=2e-4)


@pytest.mark.long
@pytest.mark.slow
def test_rooms_of_a_scan_are_taken_one_by_one_or_together(
    real: Callable[[str], Path], tmp_path: Path
) -> None:
    source = real("real_dev/data/laser_offset/scan.ply")
    session = Session(room_file(source, tmp_path / "room"))
    assert set(session.state()["found"]) == {"0", "1", "all"}
    take = session.app().commands["take"]
    areas = {room: take.run(Taken(room=room))["area"] for room in ("1", "all", "0")}
    assert areas["all"] > areas["0"] > areas["1"]
    session.history.undo()
    flat = session.history.now
    (inner, *_) = flat.partitions
    shown = session.app().commands["elevation"].run(WallChoice(partition=inner.name))
    assert shown["wall"] == inner.name and shown["png"]
    session.document.save(flat)
    ou.compose(session.document.file, tmp_path / "out", only="layout")
