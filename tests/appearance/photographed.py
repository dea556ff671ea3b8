"""A small room of known colours and lamps, and photographs of it by the path tracer."""

import json
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

import openrooms_usd as ou
from openrooms_usd.imagefile import write_png
from tests import small

Array = NDArray[np.float64]

SIZE: Final = (96, 72)
K: Final = np.array([[60.0, 0.0, 48.0], [0.0, 60.0, 36.0], [0.0, 0.0, 1.0]])
# Corners of the room, base colours, and nits of lamps by primary.
LOW, HIGH = np.array([0.0, 0.0, 0.0]), np.array([3.6, 3.0, 2.5])
COLORS: Final = {
    "Floor": (0.35, 0.22, 0.14),
    "Ceiling": (0.8, 0.8, 0.78),
    "North": (0.7, 0.65, 0.55),
    "South": (0.25, 0.4, 0.6),
    "East": (0.6, 0.25, 0.2),
    "West": (0.5, 0.55, 0.3),
    "Crate": (0.15, 0.3, 0.12),
    "Chest": (0.65, 0.5, 0.12),
}
ROUGHNESS: Final = 0.6
LAMPS: Final = {"Warm": (900.0, 620.0, 370.0), "Cool": (500.0, 520.0, 540.0)}
EXPOSURES: Final = (0.006, 0.0085, 0.005, 0.007, 0.0045, 0.0095)
BALANCE: Final = np.array([0.8, 1.0, 1.3])
_EYES: Final = (
    ((0.4, 0.4, 1.5), (3.0, 2.4, 0.6)),
    ((3.2, 0.4, 1.6), (0.5, 2.6, 0.5)),
    ((3.2, 2.6, 1.3), (0.4, 0.5, 1.0)),
    ((0.4, 2.6, 1.4), (3.1, 0.6, 0.7)),
    ((1.8, 0.3, 0.9), (1.9, 2.8, 1.9)),
    ((1.7, 2.7, 1.0), (1.6, 0.4, 1.9)),
)


@dataclass(frozen=True)
class Photographed:
    """A stage and the list of frames of its photographs."""

    stage: Path
    frames: Path


def room(path: Path, *, true: bool) -> Path:
    """A stage of six sides, two boxes and two lamps, with its true looks or with none."""
    made = small.Stage()
    made.stage.DefinePrim("/World", "Xform")
    made.stage.SetDefaultPrim(made.stage.GetPrimAtPath("/World"))
    looks: dict[str, str | None] = dict.fromkeys(COLORS)
    if true:
        for name, color in COLORS.items():
            look = made.material(f"/Looks/{name}", base_color=color, roughness=ROUGHNESS, ior=1.5)
            looks[name] = look
    (x, y, z), middle = HIGH, 0.5 * HIGH
    sides = {
        "Floor": ((middle[0], middle[1], 0.0), (x / 2, y / 2), "+Z"),
        "Ceiling": ((middle[0], middle[1], z), (x / 2, y / 2), "-Z"),
        "North": ((middle[0], y, middle[2]), (z / 2, x / 2), "-Y"),
        "South": ((middle[0], 0.0, middle[2]), (z / 2, x / 2), "+Y"),
        "East": ((x, middle[1], middle[2]), (y / 2, z / 2), "-X"),
        "West": ((0.0, middle[1], middle[2]), (y / 2, z / 2), "+X"),
    }
    for name, (center, half, facing) in sides.items():
        made.quad(f"/World/{name}", small.square(center, half, facing), material=looks[name])
    made.box("/World/Crate", 0.7, at=(2.5, 2.0, 0.35), material=looks["Crate"])
    made.box("/World/Chest", 0.5, at=(1.0, 1.6, 0.25), material=looks["Chest"])
    made.quad("/World/Warm", small.square((1.0, 1.0, z - 0.02), 0.15, "-Z"), nits=1000.0)
    made.quad("/World/Cool", small.square((2.9, 2.2, z - 0.02), 0.2, "-Z"), nits=1000.0)
    for name, nits in LAMPS.items() if true else ():
        lamp = made.stage.GetPrimAtPath(f"/World/{name}")
        lamp.GetAttribute("inputs:color").Set(tuple(1e-3 * np.array(nits)))
    return made.save(path)


def pose(eye: tuple[float, ...], target: tuple[float, ...]) -> Array:
    """(4, 4) of a level camera: x right, y down, z forward."""
    found = np.eye(4)
    ahead = np.subtract(target, eye) / np.linalg.norm(np.subtract(target, eye))
    right = np.cross(ahead, (0.0, 0.0, 1.0))
    right /= np.linalg.norm(right)
    found[:3, :3] = np.stack([right, np.cross(ahead, right), ahead], axis=1)
    found[:3, 3] = eye
    return found


POSES: Final = [pose(*one) for one in _EYES]


def frame(index: int, pose: Array) -> dict[str, Any]:
    """A row of a list of frames."""
    return {
        "id": str(index),
        "picture": f"{index}.png",
        "resolution": SIZE,
        "K": K.tolist(),
        "world_from_camera": pose.tolist(),
    }


def write_frames(path: Path, poses: list[Array]) -> Path:
    path.write_text(json.dumps([frame(i, one) for i, one in enumerate(poses)]))
    return path


@cache
def radiances() -> list[Array]:
    """(H, W, 3) nits of each camera, by full paths."""
    from tempfile import TemporaryDirectory

    with TemporaryDirectory() as folder:
        stage = room(Path(folder) / "room.usda", true=True)
        with ou.open_renderer(
            stage, channels=["radiance"], samples=32, method="reference"
        ) as renderer:
            cameras = [ou.Camera(K, one, SIZE) for one in POSES]
            return [np.asarray(p["radiance"], float) for p in renderer.render_batch(cameras)]


def developed(radiance: Array, exposure: float) -> NDArray[np.uint8]:
    """What a camera makes of it: white balance, exposure, the sRGB curve, 8 bits."""
    x = np.clip(radiance * BALANCE * exposure, 0.0, 1.0)
    v = np.where(x <= 0.0031308, 12.92 * x, 1.055 * np.maximum(x, 1e-9) ** (1 / 2.4) - 0.055)
    return np.rint(255.0 * v).astype(np.uint8)


def photographed(folder: Path) -> Photographed:
    """The room without looks, and photographs of the true one, as files."""
    stage = room(folder / "room.usda", true=False)
    for index, (radiance, exposure) in enumerate(zip(radiances(), EXPOSURES, strict=True)):
        write_png(folder / f"{index}.png", developed(radiance, exposure))
    return Photographed(stage, write_frames(folder / "frames.json", POSES))


def one_grey(folder: Path) -> Photographed:
    """The room and one picture, which is grey everywhere."""
    write_png(folder / "0.png", np.full((*SIZE[::-1], 3), 120, np.uint8))
    stage = room(folder / "room.usda", true=False)
    return Photographed(stage, write_frames(folder / "frames.json", POSES[:1]))
