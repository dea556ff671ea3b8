"""A manifest is what our renderer writes, or it is refused by place, whatever stands in it."""

import copy
import json
from collections.abc import Callable, Iterator
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from openrooms_usd.description.rendering import RenderSettings
from openrooms_usd.errors import InputError, OrusdError
from openrooms_usd.rendering import Legend, exr, render_stage
from openrooms_usd.rendering.bias import Bias
from openrooms_usd.rendering.coco import coco
from openrooms_usd.rendering.folder import is_render_manifest, listed_views
from openrooms_usd.rendering.manifest import FORMAT
from openrooms_usd.rendering.manifest_schema import (
    BiasEntry,
    GaussianEntry,
    LightEntry,
    read_manifest,
)
from openrooms_usd.rendering.reading import read_render
from openrooms_usd.rendering.relight import Relighting, relight
from openrooms_usd.rendering.scene.lights import Gaussian, LightRecord

BOX = np.array([[0.0, -1, 0, 2], [1, 0, 0, 3], [0, 0, 1, 1], [0, 0, 0, 1]])
LIGHTS = (
    LightRecord(
        0,
        "lamp",
        "/World/Lamp",
        "lamp",
        True,
        BOX,
        np.array([0.2, 0.3, 0.1]),
        np.array([900.0, 800, 500]),
        700.0,
        kelvin=2700.0,
        instance=2,
    ),
    LightRecord(
        1,
        "window",
        "/World/Portal",
        "opening",
        True,
        BOX,
        np.array([1.2, 1.5, 0]),
        np.array([5e3, 6e3, 7e3]),
        2e4,
        fit_error=0.25,
        gaussians=(
            Gaussian("sun", np.array([1e9, 9e8, 8e8]), np.array([0.0, 0.6, 0.8]), 1e4),
            Gaussian("sky", np.array([4e3, 5e3, 6e3]), np.array([0.0, 0.0, 1.0]), 0.0),
        ),
    ),
    LightRecord(2, "elsewhere", "", "elsewhere", True, np.eye(4), np.zeros(3), np.ones(3), 0.0),
)
CHANNELS = ("radiance", "depth", "instance", "semantic_nyu40")


@pytest.fixture
def render(renderer: Any, scene: Path, tmp_path: Path) -> Path:
    """What the driver writes of three lights and two views, with light channels beside it."""
    renderer.lights = LIGHTS
    renderer.legend = Legend(instance={1: "/World/Floor"}, category={1: "floor"})
    renderer.spoil = lambda name, pixels: np.ones_like(pixels)
    render_stage(
        scene, tmp_path / "out", RenderSettings(channels=CHANNELS, resolution=(8, 6), samples=1)
    )
    parts = {f"radiance_{light.number}": np.ones((6, 8, 3), np.float32) for light in LIGHTS}
    for view in ("left", "right"):
        exr.write_channels(tmp_path / "out" / view / "lights.exr", parts)
    return tmp_path / "out"


def change(render: Path, work: Callable[[dict[str, Any]], object]) -> None:
    manifest = json.loads((render / "manifest.json").read_text())
    work(manifest)
    (render / "manifest.json").write_text(json.dumps(manifest))


def use(render: Path) -> None:
    for view in read_render(render).each():
        assert {pixels.shape[:2] for pixels in view.pixels.values()} <= {(view.height, view.width)}
        assert view.labels("instance").max() == 1
        assert np.linalg.inv(view.K).any() and np.linalg.inv(view.world_from_camera).any()
    json.dumps(coco([render]), allow_nan=False)
    relight(render / "left", render.parent / "relit", Relighting({"lamp": 0.5}, {"lamp": 3000.0}))


def test_what_the_driver_writes_is_read_back(render: Path) -> None:
    use(render)
    found = read_render(render)
    assert list(found.views) == ["left", "right"]
    assert found.legend("instance") == {1: "/World/Floor"}
    for light, was in zip(found.lights, LIGHTS, strict=True):
        assert light.as_dict() == was.as_dict()
    assert (found.manifest.stage, found.manifest.format) == ("scene.usda", FORMAT)


PAIRS = [(LightEntry, LightRecord), (GaussianEntry, Gaussian), (BiasEntry, Bias)]


@pytest.mark.parametrize(("entry", "record"), PAIRS)
def test_what_is_read_has_the_names_under_which_it_is_written(entry: Any, record: Any) -> None:
    assert [*entry.model_fields] == [field.name for field in fields(record)]


def test_an_older_render_has_less(render: Path) -> None:
    later = (
        "lights",
        "bounces",
        "seed",
        "method",
        "renderer",
        "stop",
        "conventions",
        "report",
        "format",
    )

    def age(manifest: dict[str, Any]) -> None:
        for name in later:
            del manifest[name]
        for view in manifest["views"].values():
            for name in {*view} - {"resolution", "K", "world_from_camera", "channels"}:
                del view[name]

    change(render, age)
    scene = read_render(render)
    assert scene.lights == [] and scene.views["left"].pixels["depth"].shape == (6, 8, 1)
    assert len(coco([render])["annotations"]) == 2


def test_what_we_do_not_know_is_let_through(render: Path) -> None:
    def add(manifest: dict[str, Any]) -> None:
        manifest["mood"] = {"deep": [1, {"x": None}]}
        manifest["views"]["left"]["mood"] = manifest["lights"][0]["mood"] = "good"

    change(render, add)
    use(render)


def paths(value: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """To everything in a manifest; of lists to their ends, of views and channels to one."""
    if path:
        yield path
    keys: Any = ()
    if isinstance(value, dict):
        keys = [k for k in value if k not in ("right", "depth", "semantic_nyu40", "conventions")]
    elif isinstance(value, list):
        keys = sorted({0, len(value) - 1} & set(range(len(value))))
    for key in keys:
        yield from paths(value[key], (*path, key))


GONE = object()
ODD = {
    "gone": GONE,
    "null": None,
    "true": True,
    "negative": -1,
    "zero": 0,
    "huge": 10**400,
    "large": 1e308,
    "tiny": 1e-320,
    "text": "..",
    "absolute": "/etc/passwd",
    "list": [],
    "nested": [[[1.0]]],
    "mapping": {"..": {}},
    "infinite": float("inf"),
    "surrogate": "\ud800",
}


@pytest.mark.one_in(225)
@pytest.mark.parametrize("number", range(len(ODD)), ids=ODD)
def test_any_mutation_is_read_or_refused(render: Path, number: int) -> None:
    whole = json.loads((render / "manifest.json").read_text())
    odd, cases, refused = [*ODD.values()][number], [*paths(whole)], 0
    assert len(cases) > 150
    # Each odd thing in some of all places; the first in all of them.
    for path in cases[number % 5 :: 5] if number else cases:
        manifest = copy.deepcopy(whole)
        holder = manifest
        for step in path[:-1]:
            holder = holder[step]
        if odd is GONE:
            del holder[path[-1]]
        else:
            holder[path[-1]] = odd
        (render / "manifest.json").write_text(json.dumps(manifest))
        try:
            use(render)
        except OrusdError as error:
            refused += 1
            assert all(line.isprintable() for line in str(error).split("\n"))
        listed_views(render)
    assert refused > 8


def view(name: str, value: Any) -> Callable[[dict[str, Any]], object]:
    return lambda manifest: manifest["views"]["left"].update({name: value})


def light(name: str, value: Any, number: int = 1) -> Callable[[dict[str, Any]], object]:
    return lambda manifest: manifest["lights"][number].update({name: value})


def sun(name: str, value: Any) -> Callable[[dict[str, Any]], object]:
    return lambda manifest: manifest["lights"][1]["gaussians"][0].update({name: value})


def named(name: str) -> Callable[[dict[str, Any]], object]:
    return lambda manifest: manifest["views"].update({name: manifest["views"].pop("left")})


K = [[50.0, 0.0, 20.0], [0.0, 50.0, 15.0], [0.0, 0.0, 1.0]]
WRONG = [
    (view("K", [[1, 0], [0, 1]]), "views.left.K"),
    (view("K", [[0.0, 0, 20], *K[1:]]), "views.left.K"),
    (view("K", [K[0], [3.0, 50, 15], K[2]]), "views.left.K"),
    (view("K", [[True, 0, 20], *K[1:]]), "views.left.K[0][0]"),
    (view("K", [["50", 0, 20], *K[1:]]), "views.left.K[0][0]"),
    (view("K", [[1e300, 0, 20], *K[1:]]), "views.left.K[0][0]"),
    (view("world_from_camera", np.zeros((4, 4)).tolist()), "views.left.world_from_camera"),
    (view("world_from_camera", (2 * np.eye(4)).tolist()), "views.left.world_from_camera"),
    (view("resolution", [0, 6]), "views.left.resolution[0]"),
    (view("resolution", [8.5, 6]), "views.left.resolution[0]"),
    (view("resolution", [32768, 32768]), "views.left.resolution"),
    (view("resolution", [8]), "views.left.resolution"),
    (view("resolution", [8, 6, 4]), "views.left.resolution"),
    (view("exposure", "bright"), "views.left.exposure"),
    (view("files", {"channels": "../left/channels.exr"}), "views.left.files.channels"),
    (view("files", {"channels": "/left/channels.exr"}), "views.left.files.channels"),
    (view("files", {"channels": "left\\..\\channels.exr"}), "views.left.files.channels"),
    (view("files", {"channels": "right/channels.exr"}), "views"),
    (view("fits", {"files": {"environment_sg": "right/a.npy"}}), "views"),
    (named(".."), 'views[".."]'),
    (named(""), "views['']"),
    (named("a/b"), "views['a/b']"),
    (named("x" * 300), "views"),
    (light("number", 0), "lights"),
    (light("name", "lamp"), "lights"),
    (light("kind", "candle"), "lights[1].kind"),
    (light("on", 1), "lights[1].on"),
    (light("world_from_box", np.zeros((4, 4)).tolist()), "lights[1].world_from_box"),
    (light("size", [1.0, -1.0, 0.0]), "lights[1].size[1]"),
    (light("radiance", [1.0, 1.0]), "lights[1].radiance"),
    (light("environment", "../window.exr"), "lights[1].environment"),
    (light("environment", "left/window.exr"), "lights"),
    (light("gaussians", [{"name": "sun"}]), "lights[1].gaussians[0].amplitude"),
    (sun("name", "moon"), "lights[1].gaussians[0].name"),
    (sun("axis", [0.0, 0.0, 0.0]), "lights[1].gaussians[0].axis"),
    (sun("sharpness", -1.0), "lights[1].gaussians[0].sharpness"),
    (lambda m: m["legend"].update(instance={"one": "/World"}), "legend.instance.one"),
    (lambda m: m["legend"].update(instance={"1": 1}), "legend.instance"),
    (lambda m: m.update(format="1"), "format"),
]


@pytest.mark.parametrize(("work", "place"), WRONG)
def test_what_is_wrong_is_named(render: Path, work: Any, place: str) -> None:
    change(render, work)
    with pytest.raises(InputError) as refused:
        use(render)
    path, _, found = str(refused.value.place).rpartition(": ")
    assert path == str(render / "manifest.json")
    assert found.replace('"', "'").startswith(place.replace('"', "'"))
    assert refused.value.remedy == "render again" and "uple" not in refused.value.message


@pytest.mark.parametrize(
    ("data", "said"),
    [
        (b"", "not readable as JSON"),
        (b"{", "not readable as JSON"),
        (b"[" * 100_000, "not readable as JSON"),
        (b'{"generator": "openrooms_usd 1", "views": {"a": NaN}}', "NaN"),
        (b'{"generator": "openrooms_usd 1", "views": {"a": 1' + b"0" * 5000 + b"}}", "JSON"),
        (b"[]", "not the manifest of a render"),
        (b'{"views": {"left": {}}}', "not the manifest of a render"),
        (b'{"generator": "somebody", "views": {"left": {}}}', "not the manifest of a render"),
        (b'{"generator": "openrooms_usd 1", "views": {}}', "no finished view"),
        (b'{"generator": "openrooms_usd 1", "views": [1]}', "no finished view"),
        (b'{"generator": "openrooms_usd 1", "view": "left"}', "no finished view"),
    ],
)
def test_what_is_no_manifest(tmp_path: Path, data: bytes, said: str) -> None:
    (tmp_path / "manifest.json").write_bytes(data)
    with pytest.raises(InputError, match=said):
        read_manifest(tmp_path)
    assert not is_render_manifest(tmp_path) and listed_views(tmp_path) == {}


def test_a_byte_that_is_no_text_harms_only_its_word(render: Path) -> None:
    data = (render / "manifest.json").read_bytes()
    (render / "manifest.json").write_bytes(data.replace(b"World/Floor", b"World/Fl\xffor"))
    assert read_render(render).legend("instance") == {1: "/World/Fl\ufffdor"}


def test_a_manifest_of_a_newer_version_says_so(render: Path) -> None:
    for version in (FORMAT + 1, 10**1000):
        change(render, lambda manifest, version=version: manifest.update(format=version, lights=3))
        with pytest.raises(InputError, match="a newer version"):
            read_manifest(render)
        assert is_render_manifest(render)


def test_whose_manifest_it_is(render: Path, tmp_path: Path) -> None:
    relight(render / "left", tmp_path / "relit", Relighting({"lamp": 0.5}))
    assert is_render_manifest(render)
    assert not is_render_manifest(tmp_path / "relit")
    assert not is_render_manifest(tmp_path / "none")


def test_relighting_replaces_no_manifest_of_others(render: Path, tmp_path: Path) -> None:
    (tmp_path / "web").mkdir()
    (tmp_path / "web/manifest.json").write_text('{"name": "my app", "view": 1}')
    with pytest.raises(OrusdError, match="would be replaced"):
        relight(render / "left", tmp_path / "web", Relighting({"lamp": 0.5}))
    assert [path.name for path in (tmp_path / "web").iterdir()] == ["manifest.json"]


def test_names_that_no_folder_can_have_are_no_views(render: Path) -> None:
    change(render, lambda manifest: manifest["views"].update({"..": {}, "": {}, "a/b": {}}))
    assert listed_views(render).keys() == {"left", "right"}


@pytest.mark.slow
def test_many_lights_in_many_views_are_read_in_no_time(render: Path) -> None:
    lights = [replace(LIGHTS[0], number=n, name=f"lamp_{n}").as_dict() for n in range(100)]
    seen = [{"number": n, "camera_from_box": BOX.tolist()} for n in range(100)]

    def grow(manifest: dict[str, Any]) -> None:
        entry = {**manifest["views"]["left"], "lights": seen, "files": None, "channels": {}}
        manifest |= {"lights": lights, "views": {f"view_{n}": entry for n in range(100)}}

    change(render, grow)
    assert len(read_manifest(render).views) == 100
