"""Rooms that light is measured in, opened for our integrators and for Mitsuba's `path`."""

import re
import time
from collections.abc import Callable, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from pxr import Usd

from benchmarks.light.hard import CAMERA, CASES
from benchmarks.scenes import orusd
from openrooms_usd.arrays import Array
from openrooms_usd.usd.cameras import PinholeCamera, list_cameras, read_camera
from openrooms_usd.usd.files.layers import open_stage

Pictures = Array
# Noon in March: the sun shines in by a window that looks south.
_SKY: Final = (
    "{from: sky, latitude: 48.0, longitude: 11.0, date: 2024-03-21, time: '13:00', north: 20}"
)
BOUNCES: Final = 7
# References begin at this seed; far from the seeds that are compared with them.
REFERENCE_SEED: Final = 1_000_000


def generated(kind: str, seed: int, folder: Path) -> Usd.Stage:
    """A furnished room with sun and sky through its windows, and its lamps on."""
    found = folder / f"{kind}_{seed}" / "out" / "scene.usda"
    if not found.is_file():
        orusd("generate", "--type", kind, "--seed", seed, "-o", found.parents[1])
        text = found.parents[1] / "room.yaml"
        text.write_text(re.sub(r"environment: \{.*\}", f"environment: {_SKY}", text.read_text()))
        orusd("compose", text, "-o", found.parent)
    return open_stage(found)


def lit_plain(folder: Path) -> Usd.Stage:
    """Walls, a box and a lamp."""
    return CASES["plain"].build(folder)


def of_case(name: str) -> Callable[[Path], Usd.Stage]:
    """A room that is hard to light."""
    return CASES[name].build


@dataclass(frozen=True)
class Shown:
    """A room of the comparison."""

    condition: str
    build: Callable[[Path], Usd.Stage]


ROOMS: Final = {
    "plain": Shown("a box, a lamp", lit_plain),
    "bedroom": Shown("furnished; sun, sky, lamps", lambda f: generated("bedroom", 1, f)),
    "office": Shown("furnished; sun, sky, lamps", lambda f: generated("office", 1, f)),
    "kitchen": Shown("furnished; sun, sky, lamps", lambda f: generated("kitchen", 1, f)),
    "living room": Shown(
        "furnished; sun, sky, lamps; sheers drawn", lambda f: generated("living_room", 1, f)
    ),
    "three windows": Shown("hard; sun, sky", of_case("three windows")),
    "slit": Shown("hard; sky by a gap of 1 cm", of_case("slit")),
    "mirror": Shown("hard; a patch of sun on it", of_case("mirror")),
    "door ajar": Shown("hard; sky by a gap of 5 cm", of_case("door ajar")),
}


class Room:
    """A stage with all that integrators need, for the fastest backend here.

    Args:
        stage: The stage.
        width: Pixels.
        height: Pixels.
        bounces: At most this many scatterings.
    """

    def __init__(self, stage: Usd.Stage, width: int, height: int, bounces: int = BOUNCES) -> None:
        from orusd_mitsuba import variants

        chosen = variants.choose().variant  # before Mitsuba is imported
        import mitsuba as mi

        mi.set_variant(chosen)
        mi.set_log_level(mi.LogLevel.Error)
        from openrooms_usd.rendering.scene.sources import sources_of
        from openrooms_usd.rendering.scene.translate import translate
        from orusd_mitsuba.plugins.build import Builder
        from orusd_mitsuba.transport.light_index import LightIndex

        self.stage, self.size, self.bounces = stage, (width, height), bounces
        self.scene = translate(stage)
        self.built = Builder(self.scene.origin).scene(self.scene)
        self.index = LightIndex(sources_of(self.scene), self.built, self.scene.origin)
        prims = {str(prim.GetPath()): prim for prim in list_cameras(stage)}
        self.path = f"/World{CAMERA}" if f"/World{CAMERA}" in prims else min(prims)
        self.camera = self.seen_at(width, height)

    @property
    def seen(self) -> tuple[Any, ...]:
        """What tells its picture from others of the same scene."""
        pose = self.camera.world_from_camera.round(6)
        return self.size, self.bounces, self.camera.K.round(6).tolist(), pose.tolist()

    def seen_at(self, width: int, height: int) -> PinholeCamera:
        """Its camera, for a picture of any size."""
        return read_camera(self.stage.GetPrimAtPath(self.path), width, height)


@contextmanager
def stopwatch(into: list[float]) -> Any:
    """Adds the seconds of all cores that its body takes to a list."""
    began = time.process_time()
    yield
    into.append(time.process_time() - began)


def first(values: Sequence[Any], quick: bool, count: int = 1) -> Sequence[Any]:
    """All values, or the first ones where it shall be quick."""
    return values[:count] if quick else values
