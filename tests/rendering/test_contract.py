"""What any renderer gets for nothing, what is asked of it, and what is refused in its stead."""

import re
from collections.abc import Callable, Mapping
from importlib.metadata import EntryPoint
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import Gf, Usd, UsdGeom, UsdLux

from openrooms_usd import adapters
from openrooms_usd.channels import CHANNELS, each
from openrooms_usd.description.rendering import RenderSettings
from openrooms_usd.errors import InputError, RenderError
from openrooms_usd.rendering import Image, RenderRequest, exr, render_stage
from openrooms_usd.rendering.context import RenderContext as OpenedStage
from openrooms_usd.rendering.contract import NO_OPTIONS
from openrooms_usd.rendering.given import EXACT, available
from openrooms_usd.rendering.scene.arrays import Scene
from openrooms_usd.rendering.scene.rays import CastingTracer
from tests.opening import open_with

SIZE = (16, 12)


class Even:
    """A renderer in a few lines: its light is the same everywhere."""

    channels: tuple[str, ...] = ("radiance",)
    options: Mapping[str, str] = {"nits": "how bright it is"}
    backend, advice, tracer = "even", "", None
    conventions: Mapping[str, str] = {"radiance": "even"}

    def open(self, scene: Scene, options: Mapping[str, str] = NO_OPTIONS) -> "Even":
        self.settings = {"nits": options.get("nits", "1")}
        self.asked: list[RenderRequest] = []
        return self

    def render(
        self, camera: Any, request: RenderRequest, progress: Callable[[float], None]
    ) -> dict[str, Image]:
        self.asked.append(request)
        progress(1.0)
        pixels = np.full((request.height, request.width, 3), float(self.settings["nits"]))
        return {"radiance": Image(pixels.astype(np.float32), 1, 0.0, 0.0)}


@pytest.fixture
def stage() -> Usd.Stage:
    """A square of 2 m that is seen from 3 m above, and a lamp that is off."""
    made = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageUpAxis(made, "Z")
    UsdGeom.SetStageMetersPerUnit(made, 1.0)
    mesh = UsdGeom.Mesh.Define(made, "/Board")
    mesh.CreatePointsAttr([Gf.Vec3f(x, y, 0) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))])
    mesh.CreateFaceVertexCountsAttr([4])
    mesh.CreateFaceVertexIndicesAttr([0, 1, 2, 3])
    mesh.CreateSubdivisionSchemeAttr("none")
    lamp = UsdLux.RectLight.Define(made, "/Lamp")
    lamp.CreateIntensityAttr(0.0)
    lamp.AddTranslateOp().Set(Gf.Vec3d(0, 0, 5))
    camera = UsdGeom.Camera.Define(made, "/Camera")
    camera.AddTranslateOp().Set(Gf.Vec3d(0, 0, 3))
    return made


@pytest.fixture
def file(stage: Usd.Stage, tmp_path: Path) -> Path:
    stage.GetRootLayer().Export(str(tmp_path / "board.usda"))
    return tmp_path / "board.usda"


@pytest.fixture
def even(monkeypatch: pytest.MonkeyPatch) -> Even:
    """Our renderer, registered beside those that are installed."""
    made, real, found = Even(), adapters.load, adapters.available

    def load(group: str, name: str) -> Any:
        return made if (group, name) == (adapters.RENDERERS, "even") else real(group, name)

    monkeypatch.setattr(adapters, "load", load)
    point = EntryPoint("even", "nowhere:Even", adapters.RENDERERS)
    monkeypatch.setattr(adapters, "available", lambda group: found(group) | {"even": point})
    return made


def request(*channels: str, **how: Any) -> RenderRequest:
    return RenderRequest("/Camera", channels, *SIZE, samples=1, **how)


def test_a_renderer_that_gives_light_alone_has_every_exact_channel(stage: Usd.Stage) -> None:
    opened = open_with(Even(), stage)
    images = opened.render(request(*EXACT, "radiance")).images
    assert set(images) == {*each(EXACT, len(opened.lights)), "radiance"}
    middle = {name: image.pixels[6, 8] for name, image in images.items()}
    assert middle["depth"] == pytest.approx(3.0)
    assert middle["normal"] == pytest.approx((0.0, 0.0, 1.0))
    assert opened.legend.instance[int(middle["instance"][0])] == "/Board"
    assert all(images[name].error == 0.0 for name in images)


def test_the_session_is_asked_for_its_own_channels_alone(stage: Usd.Stage) -> None:
    even = Even()
    opened = open_with(even, stage)
    opened.render(request("depth", "radiance", "instance"))
    opened.render(request("depth"))
    assert [asked.channels for asked in even.asked] == [("radiance",)]


def test_a_lamp_that_is_off_has_its_number_whoever_renders(stage: Usd.Stage) -> None:
    lights = open_with(Even(), stage).lights
    assert [(light.path, light.on) for light in lights] == [("/Lamp", False), ("", False)]


def test_the_driver_writes_all_of_it(even: Even, file: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    summary = render_stage(
        file, out, RenderSettings(renderer="even", resolution=SIZE, options={"nits": "3"})
    )
    stored = exr.read_channels(out / "Camera" / "channels.exr")
    usual = {name for name in available(even.channels) if not CHANNELS[name].extra}
    assert set(stored) == usual - {"denoised"}
    assert (stored["radiance"] == 3.0).all()
    manifest = summary.manifest
    assert manifest["renderer"] == {"name": "even", "backend": "even", "nits": "3"}
    assert manifest["conventions"]["radiance"] == "even"
    assert (out / "contact_sheet.png").is_file()


@pytest.mark.parametrize("channel", ["irradiance", "direct_i", "diffuse", "environment"])
def test_a_channel_that_nobody_gives_is_refused_with_who_does(
    channel: str, even: Even, file: Path, stage: Usd.Stage, tmp_path: Path
) -> None:
    with pytest.raises(InputError, match=channel) as caught:
        render_stage(file, tmp_path / "out", RenderSettings(renderer="even", channels=[channel]))
    assert "--renderer mitsuba" in str(caught.value)
    assert not (tmp_path / "out").exists()
    with pytest.raises(RenderError, match=channel):
        open_with(even, stage).render(request(channel))


def test_a_channel_that_no_renderer_gives_says_so(
    even: Even, file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    point = EntryPoint("even", "nowhere:Even", adapters.RENDERERS)
    monkeypatch.setattr(adapters, "available", lambda group: {"even": point})
    with pytest.raises(InputError, match="no installed renderer gives it"):
        render_stage(
            file, tmp_path / "out", RenderSettings(renderer="even", channels=["irradiance"])
        )


def test_a_renderer_that_does_not_keep_its_word_is_told_so(stage: Usd.Stage) -> None:
    class Boasting(Even):
        channels = ("radiance", "irradiance")

    with pytest.raises(RenderError, match="gave nothing for the channel 'irradiance'"):
        open_with(Boasting(), stage).render(request("radiance", "irradiance"))


def test_an_option_that_a_renderer_does_not_declare(even: Even, file: Path, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="'even' has no option 'variant'") as caught:
        render_stage(
            file, tmp_path / "out", RenderSettings(renderer="even", options={"variant": "llvm"})
        )
    assert "it has: nits" in str(caught.value)
    assert not (tmp_path / "out").exists()


def test_a_method_that_the_renderer_does_not_have(even: Even, file: Path, tmp_path: Path) -> None:
    def render(**how: Any) -> Any:
        settings = RenderSettings(renderer="even", resolution=SIZE, **how)
        summary = render_stage(file, tmp_path / "out", settings)
        return summary.manifest["method"]

    with pytest.raises(RenderError, match="even does not have the method 'cache'"):
        render(method="cache")
    with pytest.raises(InputError, match="one of: cache, reference"):
        render(method="magic")
    assert not (tmp_path / "out").exists()
    assert render() == render(method="reference") == "reference"
    even.methods = ("cache", "reference")  # type: ignore[attr-defined]
    assert (render(), render(method="cache")) == ("reference", "cache")
    assert even.asked[-1].method == "cache"


def test_a_tracer_of_its_own_finds_what_the_core_then_computes(stage: Usd.Stage) -> None:
    class Tracing(Even):
        def open(self, scene: Scene, options: Mapping[str, str] = NO_OPTIONS) -> "Tracing":
            super().open(scene, options)
            self.tracer = Counting(scene)
            return self

    class Counting(CastingTracer):
        calls = 0

        def rays(self, origins: Any, directions: Any) -> Any:
            self.calls += 1
            return super().rays(origins, directions)

    even = Tracing()
    own = open_with(even, stage).render(request("depth", "instance")).images
    assert even.tracer.calls == 1
    core = open_with(Even(), stage).render(request("depth", "instance")).images
    assert all(np.array_equal(own[name].pixels, core[name].pixels) for name in core)


def test_the_renderer_of_the_documentation_renders(stage: Usd.Stage) -> None:
    page = (Path(__file__).parents[2] / "docs/howto/renderers.md").read_text("utf-8")
    (code,) = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    made: dict[str, Any] = {}
    exec(code, made)
    opened = open_with(made["FogRenderer"](), stage, {"nits": "7"})
    images = opened.render(request("radiance", "depth", "mask_i")).images
    assert (images["radiance"].pixels == 7.0).all()
    assert images["depth"].pixels.max() == pytest.approx(3.0)


def test_a_camera_or_a_size_that_is_none(stage: Usd.Stage) -> None:
    opened: OpenedStage = open_with(Even(), stage)
    with pytest.raises(RenderError, match="no such camera"):
        opened.render(RenderRequest("/Other", ("radiance",), *SIZE, samples=1))
    with pytest.raises(RenderError, match="0x12"):
        opened.render(RenderRequest("/Camera", ("radiance",), 0, 12, samples=1))


class _Both:
    methods = ("reference", "cache")
    backend = "both"


@pytest.mark.parametrize(
    ("channels", "size", "samples", "views", "method"),
    [
        (("radiance",), (320, 240), 64, 1, "reference"),
        (("radiance",), (640, 480), 64, 1, "cache"),
        (("radiance",), (320, 240), 64, 2, "cache"),
        (("environment",), (64, 48), 16, 1, "cache"),
        (("depth",), (4096, 4096), 64, 9, "reference"),
    ],
)
def test_large_renders_take_the_cache(
    channels: tuple[str, ...], size: tuple[int, int], samples: int, views: int, method: str
) -> None:
    from openrooms_usd.rendering.given import choose_method
    from openrooms_usd.rendering.plan import paths_of

    request = RenderRequest(None, channels, *size, samples=samples)
    paths = paths_of(request, views)
    session: Any = _Both()
    assert choose_method(None, session, paths) == method
    assert choose_method("reference", session, paths) == "reference"


def test_advice_is_logged_before_anything_is_rendered_and_once(
    stage: Usd.Stage, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(Even, "advice", "install more")
    for _ in range(2):
        open_with(Even(), stage)
    assert [record.getMessage() for record in caplog.records] == ["install more"]
