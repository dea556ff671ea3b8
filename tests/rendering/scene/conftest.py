"""Stages opened with the core's own ray caster, and with renderers that bring a tracer."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import pytest
from pxr import Usd

from openrooms_usd.rendering import Image, RenderRequest, View
from openrooms_usd.rendering.context import RenderContext as OpenedStage
from openrooms_usd.rendering.contract import NO_OPTIONS
from tests.opening import open_with

Open = Callable[[Usd.Stage], OpenedStage]


class Dark:
    """A renderer without light, and without a tracer: what is exact is then the core's alone."""

    channels: tuple[str, ...] = ("radiance",)
    options: Mapping[str, str] = {}
    settings: Mapping[str, str] = {}
    conventions: Mapping[str, str] = {}
    backend, advice, tracer = "dark", "", None

    def open(self, scene: object, options: Mapping[str, str] = NO_OPTIONS) -> "Dark":
        return self

    def render(
        self, camera: object, request: RenderRequest, progress: Callable[[float], None]
    ) -> dict[str, Image]:
        black = np.zeros((request.height, request.width, 3), np.float32)
        return {"radiance": Image(black, 1, 0.0, 0.0)}


@pytest.fixture(params=["core", "scalar", "llvm"])
def open_stage(request: pytest.FixtureRequest) -> Open:
    """The core alone, and each of Mitsuba's backends that works on this machine."""
    if request.param == "core":
        return lambda stage: open_with(Dark(), stage)
    from orusd_mitsuba import MitsubaRenderer

    if request.param == "llvm":
        request.getfixturevalue("vectorized")
    return lambda stage: open_with(MitsubaRenderer(), stage, {"variant": request.param})


@pytest.fixture
def shoot(open_stage: Open) -> Callable[..., View]:
    """Render one camera of a stage: 32 by 24 pixels."""

    def render(stage: Usd.Stage, *channels: str, camera: str | None = "/Camera") -> View:
        request: Any = RenderRequest(camera, channels, width=32, height=24, samples=1)
        return open_stage(stage).render(request)

    return render
