"""Rooms as anybody opens them, for one method of light: what a view gives, and what it costs."""

import os
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Final
from unittest.mock import patch

import numpy as np

from benchmarks.light.rooms import Room
from benchmarks.report import table
from openrooms_usd import adapters
from openrooms_usd.arrays import Floats
from openrooms_usd.description.rendering import REFERENCE, RenderSettings
from openrooms_usd.rendering import Image, RenderRequest
from openrooms_usd.rendering.channel_plan import ChannelPlan
from openrooms_usd.rendering.context import RenderContext
from openrooms_usd.rendering.scene.arrays import Scene
from openrooms_usd.rendering.scene.digest import light_digest
from openrooms_usd.usd.cameras import PinholeCamera
from openrooms_usd.usercache import VARIABLE

# What is true of a room's light: pictures of many samples, kept on disk and so made once.
#
# Each is a pair of independent halves, so that their own noise is known and can be taken out of
# what is measured against them.

Images = dict[str, Floats]
"""By the name of the channel."""
_KEY_DIGITS: Final = 24


@dataclass(frozen=True)
class References:
    """References of rooms in a folder.

    Attributes:
        folder: Where they are kept.
    """

    folder: Path

    def pair(
        self, scene: Scene, what: Mapping[str, Any], make: Callable[[int], Mapping[str, Any]]
    ) -> tuple[Images, Images]:
        """Two independent halves of a reference.

        Args:
            scene: What is seen; a reference of a scene that has changed is made anew.
            what: What is asked for, by name.
            make: Given 0 or 1, gives the pictures of that half by channel.
        """
        return self._half(scene, what, make, 0), self._half(scene, what, make, 1)

    def _half(
        self,
        scene: Scene,
        what: Mapping[str, Any],
        make: Callable[[int], Mapping[str, Any]],
        half: int,
    ) -> Images:
        path = self.folder / f"{light_digest(scene, {**what, 'half': half})[:_KEY_DIGITS]}.npz"
        if not path.is_file():
            self.folder.mkdir(parents=True, exist_ok=True)
            np.savez(path, **make(half))
        with np.load(path, allow_pickle=False) as found:
            return {name: found[name] for name in found.files}


# Degrees from one view of a room to the next.
_TURN_DEG: Final = 18.0


@dataclass(frozen=True)
class Shot:
    """A rendered view.

    Attributes:
        images: By channel.
        seconds: Of all cores.
        guides: What a denoiser is guided by, where it was asked for.
    """

    images: Mapping[str, Image]
    seconds: float
    guides: Images

    @property
    def pixels(self) -> Images:
        """By channel."""
        return {name: image.pixels for name, image in self.images.items()}


@dataclass(frozen=True)
class Cost:
    """Seconds of all cores.

    Attributes:
        room: Once for a room, whatever its views.
        view: For each view.
    """

    room: float
    view: float

    def views(self, count: int) -> float:
        """So many views of a room, in the mean."""
        return self.room / count + self.view


class OpenedRoom:
    """A room that is opened for a method.

    Args:
        room: The room.
        method: ``reference``, or another that `methods_of` names.
    """

    def __init__(self, room: Room, method: str = REFERENCE) -> None:
        renderer = adapters.load(adapters.RENDERERS, "mitsuba")
        plan = ChannelPlan.of(RenderSettings(), renderer)
        self.opened = RenderContext(Path("room"), room.stage, room.scene, renderer, plan)
        self._room, self.method = room, method

    @property
    def methods(self) -> tuple[str, ...]:
        """What the renderer has of them."""
        return tuple(getattr(self.opened.session, "methods", (REFERENCE,)))

    def shot(
        self, channels: tuple[str, ...], samples: int, *, seed: int = 0, view: int = 0, **how: Any
    ) -> Shot:
        """Render a view.

        Args:
            channels: Which.
            samples: Of a pixel.
            seed: Of the random numbers.
            view: Its number; from one to the next the camera turns.
            how: What else is asked of a `RenderRequest`.
        """
        asked: dict[str, Any] = {
            "camera": self._room.path,
            "channels": channels,
            "samples": samples,
            "seed": seed,
            "width": self._room.size[0],
            "height": self._room.size[1],
            "bounces": self._room.bounces,
            "method": self.method,
            "measure_bias": False,
        }
        request = RenderRequest(**{**asked, **how})
        camera = turned(self._room.seen_at(request.width, request.height), view * _TURN_DEG)
        began = time.process_time()
        found = self.opened.picture(camera, request)
        return Shot(found.images, time.process_time() - began, found.guides)

    def cost(self, channels: tuple[str, ...], samples: int, views: int = 2, **how: Any) -> Cost:
        """What views cost when all is compiled; arguments as of `shot`."""
        self.shot(channels, samples, seed=1, **how)
        seconds = [self.shot(channels, samples, view=n, **how).seconds for n in range(views)]
        return Cost(self._room_seconds, float(np.mean(seconds)))

    @cached_property
    def _room_seconds(self) -> float:
        """What the first view takes, in a room that nobody has rendered, more than it does again.

        Where there is nothing to be prepared, this would be chance.
        """
        if self.method == REFERENCE:
            return 0.0
        # What another session has kept on disk is not looked for.
        with patch.dict(os.environ, {VARIABLE: "off"}):
            fresh = OpenedRoom(self._room, self.method)
            first, again = (fresh.shot(("radiance",), 4).seconds for _ in range(2))
        return max(0.0, first - again)


def methods_of(room: Room) -> tuple[str, ...]:
    """The methods that the renderer has for a room, the reference first."""
    return tuple(sorted(OpenedRoom(room).methods, key=lambda name: name != REFERENCE))


def turned(camera: PinholeCamera, degrees: float) -> PinholeCamera:
    """The same camera, turned about the vertical through its eye."""
    angle = np.radians(degrees)
    turn = np.array(
        [[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]]
    )
    pose = camera.world_from_camera.copy()
    pose[:3, :3] = turn @ pose[:3, :3]
    return replace(camera, world_from_camera=pose)


# What light shall reach, beside what it has reached.


@dataclass(frozen=True)
class Target:
    """A number that shall be reached.

    Attributes:
        what: It is, with its unit.
        limit: The number.
        found: What it is; None where nothing that was measured reaches what it is asked of.
        at_least: Whether it shall be at least the limit; else at most, whatever its sign.
    """

    what: str
    limit: float
    found: float | None
    at_least: bool = False

    @property
    def met(self) -> bool:
        """Whether it is reached."""
        if self.found is None:
            return False
        return self.found >= self.limit if self.at_least else abs(self.found) <= self.limit


def listed(targets: Sequence[Target]) -> str:
    """Targets as a table."""
    return table(
        ("target", "limit", "found", "met"),
        [
            (
                target.what,
                f"{'>=' if target.at_least else '<='} {target.limit:g}",
                target.found,
                "yes" if target.met else "no",
            )
            for target in targets
        ],
    )
