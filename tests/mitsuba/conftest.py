"""Sessions of every backend that works here, and stages to try them on."""

from collections.abc import Callable
from types import ModuleType
from typing import Any

import pytest
from pxr import Usd

from openrooms_usd.arrays import Floats
from openrooms_usd.rendering import View
from orusd_mitsuba import variants
from tests.mitsuba.rendering import session_of, shown

Open = Callable[[Usd.Stage], Any]

# Some tests import modules that import Dr.Jit: which library it loads is chosen before.
variants.choose()


@pytest.fixture(params=["scalar", "llvm"])
def variant(request: pytest.FixtureRequest) -> str:
    """Each backend; those that do not work on this machine are skipped."""
    if request.param == "llvm":
        request.getfixturevalue("vectorized")
    return str(request.param)


@pytest.fixture(scope="module")
def mi(vectorized: str) -> ModuleType:
    """Mitsuba with its fastest backend, which vectorizes."""
    import mitsuba

    mitsuba.set_variant(vectorized)
    return mitsuba


@pytest.fixture
def prepare(request: pytest.FixtureRequest) -> Callable[[str], Any]:
    """Switch to a backend, and give Mitsuba."""

    def switch(name: str) -> Any:
        if name != "scalar":
            request.getfixturevalue("vectorized")
        import mitsuba as mi

        from orusd_mitsuba.plugins import openrooms_bsdf

        mi.set_variant(variants.choose(name).variant)
        openrooms_bsdf.register(str(mi.variant()))
        return mi

    return switch


@pytest.fixture
def open_stage(variant: str) -> Open:
    return lambda stage: session_of(stage, variant=variant)


@pytest.fixture
def shoot(open_stage: Open) -> Callable[..., View]:
    """Render one camera of a stage: 32 by 24 pixels and one sample unless it says otherwise."""

    def render(stage: Usd.Stage, *channels: str, **how: Any) -> View:
        samples = {} if {"error", "seconds"} & set(how) else {"samples": 1}
        how = {"width": 32, "height": 24} | samples | how
        return shown(open_stage(stage), *channels, **how)  # type: ignore[no-any-return]

    return render


class Lit:
    """A stage with all that the integrators of light need, for the fastest backend here."""

    def __init__(self, stage: Usd.Stage, bsdf: str = "auto") -> None:
        import mitsuba as mi

        mi.set_variant(variants.choose("auto").variant)
        from openrooms_usd.rendering.scene.models import with_model
        from openrooms_usd.rendering.scene.sources import sources_of
        from openrooms_usd.rendering.scene.translate import translate
        from orusd_mitsuba.plugins.build import Builder
        from orusd_mitsuba.transport.light_index import LightIndex
        from orusd_mitsuba.transport.white import white_first

        self.stage = stage
        self.scene = with_model(translate(stage), bsdf)
        builder = Builder(self.scene.origin)
        self.built = builder.scene(self.scene)
        self.sources = sources_of(self.scene)
        self.index = LightIndex(self.sources, self.built, self.scene.origin)
        self.first = white_first(self.scene, self.built, builder)
        self.builder = builder

    def camera(self, width: int, height: int, path: str = "/Camera") -> Any:
        from openrooms_usd.usd.cameras import read_camera

        return read_camera(self.stage.GetPrimAtPath(path), width, height)

    def cache(self, bounces: int = 7) -> Any:
        """The `RoomLight` of the room, filled anew."""
        from orusd_mitsuba.cache.room_light import RoomLight

        return RoomLight(self.scene, self.built, self.builder, self.index, self.first, bounces)

    def paths(self, depth: int = 8, size: tuple[int, int] = (32, 24), **how: Any) -> Any:
        """The `PathIntegrator` of ``/Camera``; `depth` counts segments, scatterings and one."""
        from orusd_mitsuba.transport.path_integrator import PathIntegrator

        eye = self.camera(*size, path=how.pop("path", "/Camera"))
        return PathIntegrator(self.built, self.index, eye, *size, self.scene.origin, depth, **how)

    def direct(self, samples: int, seed: int = 0, size: tuple[int, int] = (16, 16)) -> Floats:
        """(4 L, height, width, 3) of `DirectIntegrator`."""
        from orusd_mitsuba.direct.integrator import DirectIntegrator

        known = self.scene, self.built, self.sources, self.index, self.first
        return DirectIntegrator(*known, self.camera(*size), *size)(samples, seed)

    def lights(self, samples: int, seed: int = 0, size: tuple[int, int] = (16, 16)) -> Any:
        """The channels that `finish` makes of it, without the picture's axes."""
        from orusd_mitsuba.direct.control_variate import finish

        found = finish(self.direct(samples, seed, size))
        return {name: values.reshape(len(self.sources), -1, 3) for name, values in found.items()}


@pytest.fixture(scope="session")
def lit(vectorized: str) -> type[Lit]:
    return Lit


@pytest.fixture
def few_surfels(monkeypatch: pytest.MonkeyPatch) -> None:
    """Few surfels, filled by few paths, and no file."""
    from openrooms_usd.rendering import light_store
    from orusd_mitsuba.cache import filling, population

    monkeypatch.setattr(light_store, "places", lambda scene: ())
    monkeypatch.setattr(filling, "_SURFELS", 600)
    monkeypatch.setattr(population, "_CANDIDATES", 1 << 14)
    monkeypatch.setattr(population, "_WALKERS", 1 << 13)
