"""The contract between the core and whatever renders: a scene goes in, images come out."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TYPE_CHECKING, Final, Protocol, runtime_checkable

from openrooms_usd.arrays import Array, Floats
from openrooms_usd.channels import definition
from openrooms_usd.description.rendering import CACHE as CACHE
from openrooms_usd.description.rendering import DEFAULT_BOUNCES as DEFAULT_BOUNCES
from openrooms_usd.description.rendering import DEFAULT_GRID as DEFAULT_GRID
from openrooms_usd.description.rendering import DEFAULT_SAMPLES as DEFAULT_SAMPLES
from openrooms_usd.description.rendering import REFERENCE as REFERENCE
from openrooms_usd.description.rendering import Method as Method
from openrooms_usd.rendering.bias import Bias
from openrooms_usd.rendering.halves import KeptHalves

if TYPE_CHECKING:
    from openrooms_usd.rendering.scene.arrays import Scene
    from openrooms_usd.rendering.scene.rays import RayTracer
    from openrooms_usd.usd.cameras import PinholeCamera, Projection

DEFAULT_RATE: Final = 24  # frames of a video a second

GUIDES: Final = ("base_color", "normal")
"""What a denoiser is guided by, named as the channels that tell it of pixels' centres."""

NO_OPTIONS: Final[Mapping[str, str]] = MappingProxyType({})

ViewProgress = Callable[[float], None]
"""Called with the finished fraction of a view, from 0 to 1."""


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
        error: Stop when the estimated robust error of the radiance (see `estimates`) is at most
            this.
        seconds: Stop after about this time.
        seed: Fixes every random number, together with the camera's path.
        bounces: At most this many scatterings on the way from a light to the camera.
        grid: Columns and rows of hemispheres for channels of the scope ``grid``.
        halves: Whether images shall have their two halves.
        method: How light is computed; one of those that the session has (`MethodicalSession`).
        measure_bias: Whether images shall have their bias where the method is not `REFERENCE`.
        guides: Whether the view shall have what a denoiser is guided by (`GUIDES`).
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
    method: Method = REFERENCE
    measure_bias: bool = True
    guides: bool = False


@dataclass(frozen=True)
class Image:
    """One channel of one camera.

    Attributes:
        pixels: (height, width, components) float32, top row first; of a grid the tiles'.
        samples: Samples a pixel.
        seconds: What it took to render.
        error: Estimated relative mean squared error; 0 where one ray is exact, None where samples
            give no estimate: a single one, or where none of them has met any light.
        replaced: Pixels in which the renderer put 0 where it found no number.
        halves: What it is the mean of, where that was asked for and there are two.
        bias: How far it is from the reference beyond noise; None if not measured, such as for the
            reference itself.
        robust_error: Estimated robust error, which no single pixel dominates; as ``error``.
    """

    pixels: Floats
    samples: int
    seconds: float
    error: float | None
    replaced: int = 0
    halves: KeptHalves | None = None
    bias: Bias | None = None
    robust_error: float | None = None


@dataclass(frozen=True)
class DenoisedImage:
    """The denoised version of an image, for people and networks: no measurement.

    Attributes:
        pixels: (height, width, components) float32.
        change: By how much its mean differs from the raw one
            (`openrooms_usd.rendering.channel_plan.EnergyChange`).
    """

    pixels: Floats
    change: Mapping[str, float | None]


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
        denoised: Denoised versions of some of these.
        projection: How its picture is made (`openrooms_usd.usd.cameras.Projection`).
        guides: What a denoiser is guided by, where that was asked for: by the channels of `GUIDES`
            (height, width, 3) means over all that a pixel and the lens see, not its centre alone.
    """

    camera: str | None
    width: int
    height: int
    K: Array
    world_from_camera: Array
    exposure: float | None
    images: Mapping[str, Image]
    denoised: Mapping[str, DenoisedImage] = field(default_factory=dict)
    guides: Mapping[str, Floats] = field(default_factory=dict)
    projection: "Projection" = "pinhole"

    def denoised_of(self, scope: str) -> dict[str, Floats]:
        """The denoised pixels of the channels of a scope, by name."""
        return {
            name: image.pixels
            for name, image in self.denoised.items()
            if definition(name).scope == scope
        }


class RenderSession(Protocol):
    """A scene that a renderer has opened once."""

    backend: str
    """What computes, for the record: such as ``mitsuba 3.9.1 llvm_ad_rgb``."""

    advice: str
    """What would make it faster on this machine, for people; empty when nothing would."""

    settings: Mapping[str, str]
    """What was chosen for its options, for the manifest, as far as the picture depends on it."""

    conventions: Mapping[str, str]
    """What its numbers mean where the table of channels does not say, for the manifest."""

    tracer: "RayTracer | None"
    """Finds the triangles of the exact channels; None leaves it to the core's ray caster."""

    def render(
        self,
        camera: "PinholeCamera",
        request: RenderRequest,
        progress: ViewProgress = lambda fraction: None,
    ) -> Mapping[str, Image]:
        """Render one camera.

        What is worth saying of the picture goes into the scene's report.

        Args:
            camera: What sees the scene, for the request's size.
            request: What to render; its channels are among those that the renderer names.
            progress: Called with the finished fraction, from 0 to 1.

        Returns:
            An image for each channel; of a channel of every light one for each light, named by
            `openrooms_usd.channels.numbered`.

        Raises:
            RenderError: The renderer cannot do it.
        """
        ...


@runtime_checkable
class MovingSession(Protocol):
    """A session that can follow what moves, where building the scene anew would take longer."""

    def move(self, scene: "Scene") -> None:
        """Render from now on what stands elsewhere.

        Args:
            scene: The scene that was opened, but for where triangles are (`Scene.placed`).
        """
        ...


@runtime_checkable
class GuidingSession(Protocol):
    """A session that can say what surfaces look like over whole pixels; else the core does."""

    def guides(self, camera: "PinholeCamera", request: RenderRequest) -> Mapping[str, Floats]:
        """Base colour and shading normal, the means over what a pixel and the lens see.

        Args:
            camera: What sees the scene, for the request's size.
            request: Its size.

        Returns:
            (height, width, 3) by the names of `GUIDES`; 0 counts where there is no surface. Empty
            where its backend cannot.
        """
        ...


@runtime_checkable
class MethodicalSession(Protocol):
    """A session that has more than one method; others have `REFERENCE` alone."""

    methods: tuple[Method, ...]
    """Those that it has here; the first is the default."""


class Renderer(Protocol):
    """Renders scenes; registered as an entry point ``openrooms_usd.renderers``.

    It gives light. Geometry, materials and labels are made by the core for every renderer, by one
    exact ray through each pixel's centre (`openrooms_usd.rendering.given.EXACT`).
    """

    channels: tuple[str, ...]
    """The names of the channels that its sessions give."""

    options: Mapping[str, str]
    """What may be asked of it: for people, by name."""

    def open(self, scene: "Scene", options: Mapping[str, str] = NO_OPTIONS) -> RenderSession:
        """Make what renders a scene, once.

        Args:
            scene: A translated stage: triangles, surfaces, lights, in world metres.
            options: Values by the names that `options` declares.

        Raises:
            InputError: An option has no such value.
            RenderError: The backend is not available.
            MissingPackageError: The renderer needs a package that is not installed.
        """
        ...
