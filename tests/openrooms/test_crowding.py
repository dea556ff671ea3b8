"""Views with more lights than the released loaders have room for, and what else hinders them."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from openrooms_usd.errors import InputError
from openrooms_usd.rendering.reading import RenderedScene, read_render
from orusd_openrooms.readers import read_view_names
from tests.openrooms.synthetic import WINDOW, write_exr
from tests.openrooms.synthetic import write_dataset as write

LIGHTS = "LightSource/main_xml/scene0000_00"


@pytest.fixture(scope="module")
def crowded(render: RenderedScene, tmp_path_factory: pytest.TempPathFactory) -> RenderedScene:
    """Five windows: the first view sees four of them, the second two."""
    folder = tmp_path_factory.mktemp("crowded") / "day"
    shutil.copytree(render.folder, folder)
    manifest = json.loads((folder / "manifest.json").read_text())
    window = next(light for light in manifest["lights"] if light["number"] == WINDOW)
    more = [window | {"number": n, "name": f"window_{n}", "path": f"/W{n}"} for n in (3, 4, 5, 6)]
    manifest["lights"] += more
    (folder / "manifest.json").write_text(json.dumps(manifest))
    for name, seen in (("view_0", (1, 3, 4, 5)), ("view_1", (3, 4))):
        lights = render.views[name].lights
        layers = {f"{kind}_{n}": rows[n] for kind, rows in lights.items() for n in rows}
        for n in (WINDOW, 3, 4, 5, 6):
            layers |= {f"{kind}_{n}": rows[WINDOW] for kind, rows in lights.items()}
            mask = np.zeros_like(lights["mask"][WINDOW])
            mask[: 2 + n] = float(n in seen)
            layers[f"mask_{n}"] = mask
        write_exr(folder / name / "lights.exr", layers)
    return read_render(folder)


def boxes(root: Path, frame: int) -> list[str]:
    return sorted(path.name for path in (root / LIGHTS / f"light_{frame}").glob("box*.dat"))


def test_crowded_views_are_left_out_and_listed(crowded: RenderedScene, tmp_path: Path) -> None:
    summary = write([crowded], tmp_path)
    assert summary.frames == {"main_xml": [1]}
    # Of the second view, which is the first now.
    assert boxes(tmp_path, 1) == [f"box{n}.dat" for n in (0, 1, 3, 4, 5, 6)]
    assert (tmp_path / "scenes/xml/scene0000_00/cam.txt").read_text().startswith("1\n")
    assert read_view_names(tmp_path / "scenes/xml/scene0000_00/views.json") == ["view_1"]
    (note,) = (note for note in summary.notes if "left out" in note)
    assert note.startswith(
        "scene0000_00: view_0 is left out: it has more than 3 windows or 7 lamps"
    )


def test_other_views_are_judged_by_themselves(
    crowded: RenderedScene, render: RenderedScene, tmp_path: Path
) -> None:
    """A second set of views may have the names of the first."""
    splits = ("main_xml", "main_xml1")
    first = write([crowded, render], tmp_path / "first", splits=splits)
    assert first.frames == {"main_xml": [1], "main_xml1": [1, 2]}
    second = write([render, crowded], tmp_path / "second", splits=splits)
    assert second.frames == {"main_xml": [1, 2], "main_xml1": [1]}
    assert any(note.startswith("scene0000_00, xml1: view_0 is left") for note in second.notes)


def test_the_least_lights_are_dropped_on_request(crowded: RenderedScene, tmp_path: Path) -> None:
    summary = write([crowded], tmp_path, crowded="drop")
    assert summary.frames == {"main_xml": [1, 2]}
    # Window 1 is the smallest of those that are seen; of the unseen one is there.
    assert boxes(tmp_path, 1) == [f"box{n}.dat" for n in (0, 3, 4, 5, 6)]
    assert len(boxes(tmp_path, 2)) == 6
    assert any("view_0 is without its weakest lights, 1:" in note for note in summary.notes)


def test_all_lights_stay_on_request(crowded: RenderedScene, tmp_path: Path) -> None:
    assert write([crowded], tmp_path, crowded="keep").frames == {"main_xml": [1, 2]}
    assert len(boxes(tmp_path, 1)) == 6


def test_a_scene_of_which_nothing_is_left_is_refused(
    crowded: RenderedScene, tmp_path: Path
) -> None:
    views = {"view_0": crowded.views["view_0"]}
    with pytest.raises(InputError, match="all of its views have more than 3") as error:
        write([RenderedScene(crowded.folder, crowded.manifest, views)], tmp_path)
    assert "--crowded drop" in str(error.value.remedy)


def test_what_hinders_loaders_is_said(render: RenderedScene, tmp_path: Path) -> None:
    notes = write([render], tmp_path / "split").notes
    assert any("in which the published loaders find no pictures" in note for note in notes)
    # The synthetic cameras have a focal length of 0.9 widths: 58.11 degrees are near enough.
    assert not any("field of view" in note for note in notes)
    merged = write([render], tmp_path / "merged", layout="merged").notes
    assert not any("find no pictures" in note for note in merged)


def test_a_matrix_for_all_scenes_is_that_of_the_first(
    render: RenderedScene, tmp_path: Path
) -> None:
    write([render], tmp_path / "data")
    shutil.copytree(render.folder, tmp_path / "wide")
    manifest = json.loads((tmp_path / "wide/manifest.json").read_text())
    for view in manifest["views"].values():
        view["K"][0][0] = view["K"][1][1] = 40.0
    (tmp_path / "wide/manifest.json").write_text(json.dumps(manifest))
    first = (tmp_path / "data/scenes/intrinsic.txt").read_bytes()
    other = read_render(tmp_path / "wide")
    notes = write([other], tmp_path / "data", scene="scene0001_00").notes
    assert any(note.startswith("scenes/intrinsic.txt is that of other cameras") for note in notes)
    assert any("the field of view is 77.32 degrees" in note for note in notes)
    assert any("use --fov 57.95" in note for note in notes)
    assert (tmp_path / "data/scenes/intrinsic.txt").read_bytes() == first
    # A scene that is written again may change what it wrote itself.
    assert not any("other cameras" in note for note in write([other], tmp_path / "own").notes)
