"""Draws the rooms of docs/gallery.md and docs/rooms.png: ``python -m docs.gallery``.

Six types of rooms in two styles each go the whole way on the command line: generate, compose,
validate --strict, render at 960x720. What is finished in the folder is not made again.
"""

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import Final, NamedTuple

import numpy as np
import OpenImageIO
from numpy.typing import NDArray

from benchmarks.scenes import orusd
from docs.pictures import tiled
from openrooms_usd.imagefile import write, write_png


class Shown(NamedTuple):
    """A room of the gallery."""

    kind: str
    style: str
    seed: int

    @property
    def name(self) -> str:
        """Of its picture."""
        return f"{self.kind}_{self.style}"


ROOMS: Final = (
    Shown("living_room", "scandinavian", 1),
    Shown("living_room", "traditional", 2),
    Shown("bedroom", "rustic", 1),
    Shown("bedroom", "mid_century", 2),
    Shown("kitchen", "scandinavian", 1),
    Shown("kitchen", "industrial", 2),
    Shown("bathroom", "traditional", 1),
    Shown("bathroom", "scandinavian", 2),
    Shown("dining_room", "mid_century", 1),
    Shown("dining_room", "rustic", 2),
    Shown("office", "industrial", 1),
    Shown("office", "mid_century", 2),
)
CHANNELS: Final = "radiance,depth,normal_geometric,instance,semantic_nyu40"
WIDTH, HEIGHT = 960, 720
# Those of the sheet that the README shows, and their width there.
SHEET: Final = (
    "living_room_scandinavian",
    "kitchen_industrial",
    "bedroom_mid_century",
    "dining_room_mid_century",
    "office_industrial",
    "bathroom_scandinavian",
)
_SHEET_WIDTH: Final = 480
# JPEG's: no blocks can be seen from here on.
_QUALITY: Final = "jpeg:90"


def room(shown: Shown, folder: Path, samples: int, size: str) -> Path:
    """Make a room and render its first view; the denoised picture of it."""
    home = folder / shown.name
    if not (home / "render" / "manifest.json").is_file():
        orusd(
            "generate",
            "--type",
            shown.kind,
            "--seed",
            shown.seed,
            "--style",
            shown.style,
            "-o",
            home,
        )
        orusd("compose", home / "room.yaml", "-o", home / "out")
        orusd("validate", home / "out" / "scene.usda", "--strict")
        orusd(
            "render",
            home / "out" / "scene.usda",
            "-o",
            home / "render",
            "--camera",
            "view_0",
            "--resolution",
            size,
            "--spp",
            samples,
            "--denoise",
            "--channels",
            CHANNELS,
        )
    return next((home / "render").glob("*/denoised.png"))


def read(path: Path, width: int) -> NDArray[np.uint8]:
    """(H, W, 3) a picture in sRGB, made smaller to a width where it is larger."""
    picture = OpenImageIO.ImageBuf(str(path))
    if picture.spec().width > width:
        height = round(picture.spec().height * width / picture.spec().width)
        # By areas, as a sensor of larger pixels sees it: other filters sharpen.
        picture = OpenImageIO.ImageBufAlgo.resize(
            picture, "box", 0.0, OpenImageIO.ROI(0, width, 0, height, 0, 1, 0, 3)
        )
    return np.asarray(picture.get_pixels(OpenImageIO.UINT8)[..., :3], np.uint8)


def publish(picture: Path, target: Path) -> None:
    """A picture as JPEG, which pages load faster."""
    pixels = read(picture, WIDTH)
    write(target, pixels, "uint8", {"compression": _QUALITY, "oiio:ColorSpace": "sRGB"})


def main(words: Sequence[str] | None = None) -> None:
    """Draw the rooms that the options ask for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--folder", type=Path, default=Path("out/gallery"))
    parser.add_argument("--target", type=Path, default=Path("docs/gallery"))
    parser.add_argument("--resolution", default=f"{WIDTH}x{HEIGHT}")
    parser.add_argument("--spp", type=int, default=64)
    parser.add_argument("--only", nargs="*", help="names such as kitchen_industrial")
    options = parser.parse_args(words)
    options.target.mkdir(parents=True, exist_ok=True)
    for shown in ROOMS:
        if not options.only or shown.name in options.only:
            print(shown.name, flush=True)
            picture = room(shown, options.folder, options.spp, options.resolution)
            publish(picture, options.target / f"{shown.name}.jpg")
    if not options.only:
        found = [next((options.folder / name / "render").glob("*/denoised.png")) for name in SHEET]
        write_png(Path("docs/rooms.png"), tiled([read(path, _SHEET_WIDTH) for path in found]))


if __name__ == "__main__":
    main()
