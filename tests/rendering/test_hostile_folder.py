"""What lies in the folder of a run can be anything: nothing of it is harmed."""

import hashlib
import json
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from openrooms_usd import atomic, claims, ledger
from openrooms_usd.errors import OutputError
from openrooms_usd.rendering import render_stage


@pytest.fixture
def home(tmp_path: Path) -> Path:
    """A folder with somebody's files, of which the run's folder is only one."""
    (tmp_path / "home" / "out").mkdir(parents=True)
    for name in ("channels.exr", "thesis.txt", "photos/channels.exr", "photos/a.jpg"):
        (tmp_path / "home" / name).parent.mkdir(exist_ok=True)
        (tmp_path / "home" / name).write_text(f"irreplaceable {name}")
    return tmp_path / "home"


def listed(views: Any, real: dict[str, Any] | None = None) -> str:
    return json.dumps({"generator": "openrooms_usd 0", "format": 1, **(real or {}), "views": views})


@pytest.mark.one_in(3)
@pytest.mark.parametrize(
    "name", ["..", "", ".", "../photos", "photos", "out", "/", "a/../..", "left/../..", "~", "\0"]
)
@pytest.mark.parametrize("whole", [False, True])
def test_a_manifest_that_names_folders_of_others(
    name: str, whole: bool, home: Path, renderer: Any, scene: Path, snapshot: Callable[..., Any]
) -> None:
    """Also where all else is right, the ledger knows it, and the named folder looks like a view."""
    out = home / "out"
    real = {}
    if whole:
        render_stage(scene, out, cameras=["left"])
        real = json.loads((out / "manifest.json").read_text())
    entry = real["views"]["left"] if whole else {}
    text = listed({name: entry, "left": entry}, real)
    (out / "manifest.json").write_text(text)
    with (out / ledger.RENDER_FILE).open("a") as forged:
        forged.write(f"{hashlib.sha256(text.encode()).hexdigest()}  manifest.json\n")
    (out / "photos").mkdir()
    (out / "photos" / "channels.exr").write_text("irreplaceable")
    absolute = home / "photos"
    before = {path: data for path, data in snapshot(home).items() if not path.startswith("out/")}
    render_stage(scene, out, cameras=["right"])
    after = snapshot(home)
    assert {path: after.get(path) for path in before} == before
    assert after["out/photos/channels.exr"] == b"irreplaceable"
    assert "out/right/channels.exr" in after
    assert absolute.is_dir()


@pytest.mark.parametrize("kind", ["link", "broken link", "file", "pipe", "folder of others"])
def test_what_has_the_name_of_a_view(
    kind: str, home: Path, renderer: Any, scene: Path, snapshot: Callable[..., Any]
) -> None:
    """Refused before anything is rendered, and the next run is not hindered."""
    target = home / "out" / "left"
    make: dict[str, Callable[[], object]] = {
        "link": lambda: target.symlink_to(home / "photos"),
        "broken link": lambda: target.symlink_to(home / "nowhere"),
        "file": lambda: target.write_text("mine"),
        "pipe": lambda: os.mkfifo(target),
        "folder of others": lambda: (home / "photos").rename(target),
    }
    make[kind]()
    if kind != "pipe":
        before = snapshot(home)
    with pytest.raises(OutputError, match=r"w(ill not|ould) be replaced"):
        render_stage(scene, home / "out")
    assert renderer.requests == []
    if kind != "pipe":
        assert snapshot(home) == before
    render_stage(scene, home / "out", cameras=["right"])
    assert (home / "out" / "right" / "channels.exr").is_file()


def test_notes_in_a_view_stop_the_run_and_those_in_an_old_view_stay(
    renderer: Any, scene: Path, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    render_stage(scene, out)
    (out / "left" / "notes.txt").write_text("mine")
    renderer.requests.clear()
    with pytest.raises(OutputError, match=r"'notes.txt' in it was not written"):
        render_stage(scene, out)
    assert renderer.requests == []
    summary = render_stage(scene, out, cameras=["right"])
    assert summary.stay == (out / "left",)
    assert [path.name for path in (out / "left").iterdir()] == ["notes.txt"]


def test_a_picture_that_was_changed_is_not_removed(
    renderer: Any, scene: Path, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    render_stage(scene, out)
    (out / "left" / "depth.png").write_bytes(b"painted over")
    assert render_stage(scene, out, cameras=["right"]).stay == (out / "left",)
    assert [path.name for path in (out / "left").iterdir()] == ["depth.png"]


def test_an_earlier_view_behind_a_link_stays(renderer: Any, scene: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    render_stage(scene, out)
    (out / "left").rename(tmp_path / "elsewhere")
    (out / "left").symlink_to(tmp_path / "elsewhere")
    count = len(list((tmp_path / "elsewhere").iterdir()))
    assert render_stage(scene, out, cameras=["right"]).stay == (out / "left",)
    assert len(list((tmp_path / "elsewhere").iterdir())) == count > 3


@pytest.mark.parametrize("name", ["layers", "openings", "lights"])
def test_a_camera_cannot_have_the_name_of_another_folder(
    name: str, renderer: Any, scene: Path, tmp_path: Path, snapshot: Callable[..., Any]
) -> None:
    """A room may lie in the folder that is rendered to: its layers are no view."""
    out = tmp_path / "out"
    with claims.claimed(out):
        atomic.write_text(out / "layers" / "lights" / "channels.exr", "a layer's")
        atomic.write_text(out / "layers" / "edits.usda", "adopted")
    before = snapshot(out)
    renderer.cameras = (f"/World/Cameras/{name}",)
    with pytest.raises(OutputError, match="a view cannot be named"):
        render_stage(scene, out)
    assert snapshot(out) == before


def test_a_room_in_the_folder_of_a_render_stays(
    renderer: Any, scene: Path, tmp_path: Path, snapshot: Callable[..., Any]
) -> None:
    out = tmp_path / "out"
    with claims.claimed(out):
        atomic.write_text(out / "layers" / "lights" / "channels.exr", "a layer's")
    before = snapshot(out)
    render_stage(scene, out)
    render_stage(scene, out, cameras=["left"])
    after = snapshot(out)
    assert {path: after.get(path) for path in before} == before


@pytest.mark.parametrize(
    ("name", "is_first"),
    [
        ("contact_sheet.png", True),
        ("timing.json", True),
        ("manifest.json", True),
        ("contact_sheet.png", False),
        ("manifest.json", False),
    ],
)
def test_a_list_of_others_or_one_that_was_changed(
    name: str, is_first: bool, renderer: Any, scene: Path, tmp_path: Path
) -> None:
    if not is_first:
        render_stage(scene, tmp_path)
        renderer.requests.clear()
    (tmp_path / name).write_text("mine")
    with pytest.raises(OutputError, match="would be replaced"):
        render_stage(scene, tmp_path)
    assert renderer.requests == []
    assert (tmp_path / name).read_text() == "mine"
