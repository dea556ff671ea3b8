"""A scene that stays open for many pictures, by any camera, as arrays."""

import logging
from collections.abc import Iterable, Iterator, Mapping
from contextlib import ExitStack
from dataclasses import dataclass, replace
from functools import partial
from types import TracebackType
from typing import TYPE_CHECKING, Any, Final, Self

from openrooms_usd.api.camera import Camera, rigid_of
from openrooms_usd.api.given import AnyPath, path_of, unknown_name, usd_file
from openrooms_usd.api.rendered import Render, form_of, open_render
from openrooms_usd.api.settings import ALL, settings_of, takes_settings
from openrooms_usd.errors import InputError
from openrooms_usd.progress import Progress, silent

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike, NDArray

    from openrooms_usd.description.rendering import RenderSettings
    from openrooms_usd.edits.views import SceneCamera
    from openrooms_usd.rendering.context import RenderContext
    from openrooms_usd.rendering.contract import View as RenderedImages

_LOG: Final = logging.getLogger("openrooms_usd")

PICTURE: Final = (
    "channels",
    "resolution",
    "samples",
    "error",
    "seconds",
    "seed",
    "bounces",
    "method",
    "grid",
    "error_maps",
    "denoise",
    "denoise_light",
    "f_stop",
    "tone",
    "storage",
)
"""The settings that may be others for each picture; the rest belong to the opened scene."""


@dataclass(frozen=True, eq=False, repr=False)
class Picture(Mapping[str, "NDArray[Any]"]):
    """What a camera sees, in memory: channels by name, as arrays (the shapes are those of `View`).

    Attributes:
        images: What was rendered, with samples and errors of each channel.
    """

    images: "RenderedImages"

    def __getitem__(self, channel: str) -> "NDArray[Any]":
        """The pixels of a channel; the denoised version of one as ``denoised/<channel>``.

        Raises:
            UnknownNameError: The picture has no such channel.
        """
        if channel not in [*self]:
            raise unknown_name("channel", channel, self, repr(self))
        name = channel.removeprefix("denoised/")
        found = self.images.denoised if name != channel else self.images.images
        return form_of(name, found[name].pixels)

    def __iter__(self) -> Iterator[str]:
        yield from self.images.images
        yield from (f"denoised/{name}" for name in self.images.denoised)

    def __len__(self) -> int:
        return len(self.images.images) + len(self.images.denoised)

    def __repr__(self) -> str:
        return f"Picture({self.images.width}x{self.images.height}: {', '.join(self)})"

    @property
    def K(self) -> "NDArray[np.float64]":  # noqa: N802
        """(3, 3) intrinsics in pixels; the centre of the top-left pixel is (0.5, 0.5)."""
        return self.images.K

    @property
    def world_from_camera(self) -> "NDArray[np.float64]":
        """(4, 4) from the camera (x right, y down, z forward) to the world, metres."""
        return self.images.world_from_camera

    def error(self, channel: str) -> float | None:
        """The estimated robust error of a channel; 0 where one ray is exact, None without one.

        Raises:
            UnknownNameError: The picture has no such channel.
        """
        if channel not in self.images.images:
            raise unknown_name("channel", channel, self.images.images, repr(self))
        return self.images.images[channel].robust_error


class OpenRenderer:
    """A scene that is open for a renderer. Made by `open_renderer`; close it, or use ``with``.

    The first picture of each kind compiles what renders it; others with equal settings do not.
    """

    def __init__(self, context: "RenderContext", held: ExitStack) -> None:
        self._opened: RenderContext | None = context
        self._held = held

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def __repr__(self) -> str:
        if self._opened is None:
            return "OpenRenderer(closed)"
        return f"OpenRenderer({str(self._opened.path)!r}, cameras: {', '.join(self.cameras)})"

    def close(self) -> None:
        """Release the scene and what was compiled for it."""
        self._opened = None
        self._held.close()

    @property
    def cameras(self) -> tuple[str, ...]:
        """The names of the scene's own cameras."""
        return tuple(self._context.views)

    @property
    def lights(self) -> tuple[str, ...]:
        """The names of the lights; their places are the numbers in the names of channels."""
        return tuple(light.name for light in self._context.lights)

    def legend(self, channel: str) -> dict[int, str]:
        """What the numbers of a label channel mean: such as ``semantic``.

        Raises:
            UnknownNameError: It is not the name of a label channel.
        """
        found = vars(self._context.legend)
        if channel not in found:
            raise unknown_name("label channel", channel, found, repr(self))
        return dict(found[channel])

    @takes_settings(*PICTURE[1:])
    def render(
        self,
        camera: "str | Camera | SceneCamera",
        channels: str | Iterable[str] | None = None,
        **fields: Any,
    ) -> Picture:
        """Render what a camera sees; nothing is written.

        Args:
            camera: A name among `cameras`, a prim path, one of `Scene.cameras`, or any camera.
            channels: Names (docs/reference/channels.md); by default those that the scene was opened
                for.
            **fields: Other settings than those that the scene was opened with, by name:

        Returns:
            Arrays by the channel's name.

        Raises:
            InputError: A name is unknown, or a number is outside its limits.
            RenderError: The renderer cannot do it.
        """
        if isinstance(camera, Camera) and "resolution" in fields:
            raise InputError(
                "this camera already has a size", place="resolution", remedy="give it to ou.Camera"
            )
        context = self._with(channels, fields)
        return Picture(self._shot(context, camera)())

    def render_batch(
        self,
        cameras: "Iterable[str | Camera | SceneCamera]",
        channels: str | Iterable[str] | None = None,
        **fields: Any,
    ) -> Iterator[Picture]:
        """Render many cameras, one after the other; each is rendered when it is asked for.

        Args:
            cameras: As of `render`.
            channels: As of `render`.
            **fields: As of `render`.
        """
        context = self._with(channels, fields)
        for camera in [cameras] if isinstance(cameras, str | Camera) else cameras:
            yield Picture(self._shot(context, camera)())

    def write(
        self,
        out: AnyPath,
        cameras: str | Iterable[str | Camera] | Mapping[str, Camera] | None = None,
        *,
        progress: Progress = silent,
        **fields: Any,
    ) -> Render:
        """Render into files, as `render` and ``orusd render`` write them, byte for byte.

        Args:
            out: The folder to write.
            cameras: Names among `cameras`, or cameras by the names of their views; by default all
                that the scene has.
            progress: Called with the view's name and the finished fraction of the whole.
            **fields: As of `render`.

        Raises:
            InputError: A name is unknown, or a number is outside its limits.
            OutputError: The folder cannot be written.
            RenderError: The renderer cannot do it.
        """
        from openrooms_usd import claims, ledger
        from openrooms_usd.rendering import folder
        from openrooms_usd.rendering.driver import write_views

        context, target = self._with(None, fields), path_of(out)
        views = {
            name: self._shot(context, replace(one, name=name) if isinstance(one, Camera) else one)
            for name, one in _named(self.cameras if cameras is None else cameras).items()
        }
        folder.check_view_names(target, views)
        if not views:
            raise InputError("no camera is given", place="cameras", remedy="name a camera")
        if earlier := folder.listed_views(target) - views.keys():
            _LOG.warning("%s: this render replaces %s", target, ", ".join(sorted(earlier)))
        folder.check_writable(target)
        with claims.claimed(target, ledger.RENDER_FILE) as kept:
            write_views(context, target, kept, views, progress)
        return open_render(target)

    def move(self, motions: Mapping[str, "ArrayLike"]) -> None:
        """Move objects for the pictures that follow; the files of the scene do not change.

        Args:
            motions: (4, 4) rigid by prim path, of the world to the world, metres, since the scene
                was opened; prims that are not named stay where they are.

        Raises:
            InputError: There is no such prim, or a motion is not rigid.
        """
        stage = self._context.stage
        for path in motions if isinstance(motions, Mapping) else ("motions",):
            if not (str(path).startswith("/") and stage.GetPrimAtPath(str(path))):
                raise InputError(
                    "there is no such prim",
                    place=path,
                    remedy="give motions by prim paths, such as /World/Furniture/chair_0",
                )
        self._context.move({path: rigid_of(motion, path) for path, motion in motions.items()})

    @property
    def _context(self) -> "RenderContext":
        if self._opened is None:
            raise InputError(
                "this renderer is closed", remedy="open it again: ou.open_renderer(scene)"
            )
        return self._opened

    def _with(
        self, channels: str | Iterable[str] | None, fields: Mapping[str, Any]
    ) -> "RenderContext":
        """The opened scene with what one picture is asked for."""
        asked = {**fields, "channels": channels} if channels is not None else fields
        if not asked:
            return self._context
        return self._context.with_settings(settings_of(self._context.settings, asked, PICTURE))

    def _shot(self, context: "RenderContext", camera: "str | Camera | SceneCamera") -> Any:
        """What renders a camera: a function of what it calls with its progress."""
        if isinstance(camera, Camera):
            size = camera.resolution
            pinhole = context.prepared(camera.pinhole(), size[0], camera.name)
            return partial(context.shoot, pinhole, camera.name, size=size)
        from openrooms_usd.rendering.plan import choose_cameras

        named = camera if isinstance(camera, str) else getattr(camera, "path", None)
        if named is None:
            raise InputError(
                "this is not a camera",
                place="camera",
                remedy="give a name, a prim path, one of scene.cameras, or ou.Camera(...)",
            )
        if named in context.views:
            return partial(context.view, named)
        path = next(iter(choose_cameras([named], context.cameras).values()))
        return partial(context.shoot, context.camera(path), path)


def _named(
    cameras: "str | Camera | Iterable[str | Camera] | Mapping[str, Camera]",
) -> "Mapping[str, str | Camera]":
    """Cameras by the names of their views."""
    if isinstance(cameras, Mapping):
        return cameras
    every = [cameras] if isinstance(cameras, str | Camera) else cameras
    return {one.name if isinstance(one, Camera) else one: one for one in every}


@takes_settings(*ALL)
def open_renderer(
    scene: AnyPath,
    *,
    cameras: str | Iterable[str] = (),
    settings: "RenderSettings | None" = None,
    **fields: Any,
) -> OpenRenderer:
    """Open a scene once, for many pictures as arrays.

    Args:
        scene: A composed room or any USD file.
        cameras: Names or prim paths of the scene's own that are meant; all by default.
        settings: What is asked for, in one record.
        **fields: The same, by name:

    Returns:
        ``.render(camera, channels)`` gives arrays, ``.write(out)`` files. Use it by ``with``.

    Raises:
        InputError: The scene is unreadable, a name is unknown, or a number is outside its limits.
        MissingPackageError: The renderer or the denoiser needs a package that is not installed.
        RenderError: The renderer's backend is not available.
    """
    from openrooms_usd.rendering.opening import open_for_rendering
    from openrooms_usd.usd.files.diagnostics import quiet

    file, wanted = usd_file(scene), settings_of(settings, fields)
    with ExitStack() as held:
        held.enter_context(quiet())
        context = open_for_rendering(
            file, wanted, cameras=[cameras] if isinstance(cameras, str) else list(cameras)
        )
        return OpenRenderer(context, held.pop_all())
