"""The contract between the driver and whatever renders: a request goes in, arrays come out."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final, Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.convert import Report
from openrooms_usd.render.estimates import Halves
from openrooms_usd.render.lights import LightRecord

if TYPE_CHECKING:
    from pxr import Usd

DEFAULT_BOUNCES: Final = 7
DEFAULT_SAMPLES: Final = 64
DEFAULT_RESOLUTION: Final = (640, 480)
DEFAULT_GRID: Final = (160, 120)

Bsdf = Literal["auto", "openrooms", "preview"]
"""How surfaces reflect: as each material says, all by OpenRooms' microfacet model, or all as
UsdPreviewSurface."""


@dataclass(frozen=True)
class RenderRequest:
    """What to render of one camera.

    Exactly one of ``samples``, ``error`` and ``seconds`` is given.

    Attributes:
        camera: The camera's prim path; None frames the scene itself.
        channels: Names from `openrooms_usd.channels.CHANNELS`.
        width: Pixels.
        height: Pixels.
        samples: Samples a pixel for the channels that need many.
        error: Stop when the radiance's estimated error (see the conventions) is at most this.
        seconds: Stop after about this time.
        seed: Fixes every random number, together with the camera's path.
        bounces: At most this many scatterings on the way from a light to the camera.
        grid: Columns and rows of hemispheres for channels of the scope ``grid``.
        halves: Whether images shall have their two halves.
    """

    camera: str | None
    channels: tuple[str, ...]
    width: int
    height: int
    samples: int | None = None
    error: float | None = None
    seconds: float | None = None
    seed: int = 0
    bounces: int = DEFAULT_BOUNCES
    grid: tuple[int, int] = DEFAULT_GRID
    halves: bool = False


@dataclass(frozen=True)
class Image:
    """One channel of one camera.

    Attributes:
        pixels: (height, width, components) float32, top row first; of a grid the tiles'.
        samples: Samples a pixel.
        seconds: What it took to render.
        error: Estimated relative mean squared error; 0 where one ray is exact, None where a single
            sample gives no estimate.
        replaced: Pixels in which the renderer put 0 where it found no number.
        halves: What it is the mean of, where that was asked for and there are two.
    """

    pixels: NDArray[np.float32]
    samples: int
    seconds: float
    error: float | None
    replaced: int = 0
    halves: Halves | None = None


@dataclass(frozen=True)
class View:
    """A rendered camera.

    Attributes:
        camera: The camera's prim path; None for the framing camera.
        width: Pixels.
        height: Pixels.
        K: (3, 3) intrinsics in pixels; the centre of the top-left pixel is (0.5, 0.5).
        world_from_camera: (4, 4) from the OpenCV camera frame to the world, metres.
        exposure: What previews multiply radiance by; None fits it to the picture.
        images: By channel name; a channel of every light once for each, such as ``direct_0``.
    """

    camera: str | None
    width: int
    height: int
    K: NDArray[np.float64]
    world_from_camera: NDArray[np.float64]
    exposure: float | None
    images: Mapping[str, Image]


@dataclass(frozen=True)
class Legend:
    """What the numbers in the label channels mean.

    Attributes:
        semantic: Number to OpenRooms-45 class name.
        semantic_nyu40: Number to NYU-40 class name.
        instance: Number to prim path.
        part: Number to prim path.
        material: Number to prim path.
        category: Number of an instance to our category name.
    """

    semantic: Mapping[int, str] = field(default_factory=dict)
    semantic_nyu40: Mapping[int, str] = field(default_factory=dict)
    instance: Mapping[int, str] = field(default_factory=dict)
    part: Mapping[int, str] = field(default_factory=dict)
    material: Mapping[int, str] = field(default_factory=dict)
    category: Mapping[int, str] = field(default_factory=dict)


class RenderSession(Protocol):
    """A stage that was opened once by a renderer."""

    backend: str
    """What computes, for the record: such as ``mitsuba 3.9.1 llvm_ad_rgb``."""

    advice: str
    """What would make it faster on this machine, for people; empty when nothing would."""

    bsdf: Bsdf
    """How surfaces reflect, which may be less than was asked for: the report says so."""

    cameras: tuple[str, ...]
    """Prim paths of the stage's cameras, sorted."""

    resolution: tuple[int, int]
    """Width and height that the stage's render settings ask for, or `DEFAULT_RESOLUTION`."""

    legend: Legend

    lights: tuple[LightRecord, ...]
    """The lights that channels of the scope ``light`` are given for, by their numbers."""

    report: Report
    """What became of every prim; rendering may add what became of a camera's picture."""

    def render(
        self, request: RenderRequest, progress: Callable[[float], None] = lambda fraction: None
    ) -> View:
        """Render one camera.

        Args:
            request: What to render.
            progress: Called with the finished fraction, from 0 to 1.

        Raises:
            RenderError: The renderer cannot do it.
        """
        ...


class Renderer(Protocol):
    """Renders USD stages; registered as an entry point ``openrooms_usd.renderers``."""

    channels: tuple[str, ...]
    """The names of the channels that it can give."""

    def open(
        self, stage: "Usd.Stage", *, variant: str = "auto", bsdf: Bsdf = "auto"
    ) -> RenderSession:
        """Translate a stage, once.

        Args:
            stage: The composed stage. Any stage: ours, or one that follows none of our names.
            variant: ``auto``, or a backend of this renderer.
            bsdf: How surfaces reflect.

        Raises:
            RenderError: The backend is not available.
        """
        ...
