"""A renderer that gives known numbers at once, so that what surrounds rendering can be tested."""

from collections.abc import Callable
from typing import Any

FAKE = "fake"


class FakeRenderer:
    """Satisfies the contract of renderers, and is its own session."""

    backend, advice, bsdf = "fake", "", "auto"
    resolution = (16, 12)

    def __init__(self) -> None:
        from openrooms_usd.channels import RENDERED
        from openrooms_usd.convert import Report
        from openrooms_usd.render import Legend

        self.channels = RENDERED
        self.cameras: tuple[str, ...] = ()
        self.report = Report()
        self.legend = Legend(
            instance={1: "/World/Furniture/desk", 2: "/World/Room/Floor"}, category={1: "desk"},
            semantic={1: "floor", 5: "desk"}, semantic_nyu40={1: "wall"}, material={1: "/World/M"},
        )  # fmt: skip
        self.lights = _lights()

    def open(self, stage: Any, *, variant: str = "auto", bsdf: str = "auto") -> "FakeRenderer":
        """The cameras of a stage, whatever else it holds."""
        prims = stage.Traverse()
        paths = [str(prim.GetPath()) for prim in prims if prim.GetTypeName() == "Camera"]
        self.cameras = tuple(sorted(paths))
        return self

    def render(self, request: Any, progress: Callable[[float], None] = lambda part: None) -> Any:
        """Ramps."""
        import numpy as np

        from openrooms_usd.channels import definition, each
        from openrooms_usd.render import Image, View
        from openrooms_usd.render.run import shape_of

        images = {}
        for name in each(request.channels, len(self.lights)):
            shape, exact = shape_of(name, request), definition(name).kind != "light"
            ramp = np.linspace(0, 1, int(np.prod(shape)), dtype=np.float32).reshape(shape)
            images[name] = Image(np.ones_like(ramp) if exact else ramp, 1, 0.0, 0.0)
        K = np.array([[20.0, 0, 8], [0, 20, 6], [0, 0, 1]])
        return View(request.camera, request.width, request.height, K, np.eye(4), None, images)


def _lights() -> tuple[Any, ...]:
    import numpy as np

    from openrooms_usd.render.lights import LightRecord

    pose, size, nits = np.eye(4), np.array([0.3, 0.5, 0.2]), np.array([9.0, 8, 5])
    lamp = LightRecord(
        0, "lamp", "/World/Furniture/desk", "lamp", True, pose, size, nits, 100.0, 3000.0, 1
    )
    elsewhere = LightRecord(
        1, "elsewhere", "", "elsewhere", True, np.eye(4), np.zeros(3), np.zeros(3), 0.0
    )
    return lamp, elsewhere


def install() -> None:
    """Let this process find the fake renderer by its name."""
    from openrooms_usd import adapters

    own = adapters.load

    def load(group: str, name: str) -> Any:
        if (group, name) == (adapters.RENDERERS, FAKE):
            return FakeRenderer()
        return own(group, name)

    adapters.load = load
