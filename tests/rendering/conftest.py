"""A renderer without a renderer: known arrays for every channel, so that the driver is tested."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from openrooms_usd import adapters
from openrooms_usd.channels import CHANNELS, RENDERED
from openrooms_usd.exporters import Report
from openrooms_usd.rendering import Image, Legend, RenderRequest, View, opening
from openrooms_usd.rendering.context import RenderContext
from openrooms_usd.rendering.contract import NO_OPTIONS
from openrooms_usd.rendering.scene.lights import LightRecord
from openrooms_usd.usd.cameras import PinholeCamera


def numbers(name: str, height: int, width: int, seed: int) -> np.ndarray:
    """Plausible values of a channel, a function of its name and the seed alone."""
    channel = CHANNELS[name]
    rng = np.random.default_rng([seed, *name.encode()])
    shape = (height, width, len(channel.components))
    if channel.kind == "label":
        return rng.integers(0, 2**24, shape).astype(np.float32)
    scale = {"nit": 1e5, "m": 9.0}.get(channel.unit, 1.0)
    values = rng.random(shape) * scale
    if channel.unit == "1" and channel.components == ("X", "Y", "Z"):
        values = 2 * values - 1
        values /= np.linalg.norm(values, axis=-1, keepdims=True)
    return values.astype(np.float32)


GUIDE_SEED = 17
"""Of guides: they are no channels of the same names."""


def _guides(request: RenderRequest) -> dict[str, np.ndarray]:
    return {
        name: numbers(name, request.height, request.width, GUIDE_SEED)
        for name in ("base_color", "normal")
    }


class FakeRenderer:
    """Satisfies the contract, and is what the driver opens; a test may set what it gives."""

    channels = RENDERED
    options: Mapping[str, str] = {"bsdf": "how surfaces reflect"}
    backend = "fake 1.0"
    advice = ""
    settings: Mapping[str, str] = {"bsdf": "auto"}
    conventions: Mapping[str, str] = {"bsdf": "auto: as each material says"}
    tracer = None
    cameras: tuple[str, ...] = ("/World/Cameras/left", "/World/Cameras/right")
    requested: tuple[str, ...] = ()
    resolution = (40, 30)
    legend = Legend(
        semantic={44: "floor", 5: "desk"},
        instance={1: "/World/Room/Floor", 10: "/World/Furniture/desk", 2: "/World/Room/Ceiling"},
        category={10: "desk"},
    )
    lights: tuple[LightRecord, ...] = ()
    exposure: float | None = None
    opened = 0

    def __init__(self) -> None:
        self.report = Report()
        self.report.add("/World/Room/Floor", "translated")
        self.report.add("/World/Odd", "skipped", "no such thing")
        self.requests: list[RenderRequest] = []
        self.spoil: Callable[[str, np.ndarray], np.ndarray] = lambda name, pixels: pixels

    def open(self, scene: object, options: Mapping[str, str] = NO_OPTIONS) -> "FakeRenderer":
        self.opened += 1
        return self

    def render(self, request: RenderRequest, progress: Callable[[float], None]) -> View:
        self.requests.append(request)
        progress(0.5)
        images = {
            name: Image(
                self.spoil(name, numbers(name, request.height, request.width, request.seed)),
                samples=request.samples or 1,
                seconds=0.25,
                error=0.01 if name == "radiance" else 0.0,
            )
            for name in request.channels
        }
        progress(1.0)
        return View(
            camera=request.camera,
            width=request.width,
            height=request.height,
            K=np.array([[50.0, 0, 20], [0, 50, 15], [0, 0, 1]]),
            world_from_camera=np.eye(4),
            exposure=self.exposure,
            images=images,
            guides=_guides(request) if request.guides else {},
        )


class FakeContext(RenderContext):
    """A stage that a fake renderer has opened: cameras, legend and lights are the fake's."""

    def __init__(self, path: Any, stage: Any, scene: Any, renderer: Any, plan: Any) -> None:
        self.path, self.stage, self.plan, self.settings = path, stage, plan, plan.settings
        self.session = renderer.open(scene)
        self.cameras, self.legend, self.report = renderer.cameras, renderer.legend, renderer.report
        self.resolution = self.settings.resolution or renderer.resolution
        self._sources = renderer.lights
        self.__dict__["lights"] = renderer.lights

    def camera(self, path: str | None, size: tuple[int, int] | None = None) -> PinholeCamera:
        return PinholeCamera(np.eye(3), np.eye(4))

    def picture(self, camera: Any, request: RenderRequest, progress: Any = None) -> View:
        view: View = self.session.render(request, progress)  # type: ignore[call-arg, assignment]
        return view


@pytest.fixture
def renderer(monkeypatch: pytest.MonkeyPatch) -> FakeRenderer:
    fake = FakeRenderer()
    monkeypatch.setattr(adapters, "load", lambda group, name: fake)
    # What the scene is does not matter: cameras, legend and lights are the fake's too.
    monkeypatch.setattr(opening, "RenderContext", FakeContext)
    monkeypatch.setattr(opening, "translate", lambda stage, **how: None)
    monkeypatch.setattr(opening, "asked_cameras", lambda stage: fake.requested)
    return fake


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    path = tmp_path / "scene.usda"
    path.write_text('#usda 1.0\n(\n    defaultPrim = "World"\n)\ndef Xform "World"\n{\n}\n')
    return path


def snapshot(folder: Path) -> dict[str, bytes]:
    """All files below a folder but the timing."""
    return {
        path.relative_to(folder).as_posix(): path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.is_file() and path.name != "timing.json"
    }


@pytest.fixture(name="snapshot")
def snapshot_fixture() -> Callable[[Path], dict[str, bytes]]:
    return snapshot


@pytest.fixture(name="numbers")
def numbers_fixture() -> Callable[[str, int, int, int], np.ndarray]:
    return numbers
