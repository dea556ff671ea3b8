"""Draws the pictures of the documentation: ``make pictures``.

Every room goes the whole way on the command line: generate, compose, validate --strict, render.
``python -m docs.pictures --all`` does so for every room type and leaves all files in the folder;
the rooms of the documentation are drawn by `docs.gallery`.
"""

import argparse
import json
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any, get_args

import numpy as np
import OpenImageIO

from benchmarks.scenes import orusd
from docs import plan_film, plan_picture, report_picture, view_picture
from docs.scan_picture import scanned
from openrooms_usd import removal
from openrooms_usd.channels import CHANNELS, numbered
from openrooms_usd.description.room import RoomType
from openrooms_usd.imagefile import write_png
from openrooms_usd.rendering.sheet import write_sheet

# Lights of the example whose channels are shown.
LIGHTS = ("pendant", "window_east")
COLUMNS = 3
# The room that is scanned.
SCANNED = ("bedroom", 2)
# Substances of the library in the documentation.
SUBSTANCES = ("wood", "fabric", "specular_stone")


def room(kind: str, seed: int, folder: Path, size: str, *quality: str) -> Path:
    """Make a room and render its best view; the folder of that view."""
    home = folder / f"{kind}_{seed}"
    if not (home / "render" / "manifest.json").is_file():
        orusd("generate", "--type", kind, "--seed", seed, "-o", home)
        orusd("compose", home / "room.yaml", "-o", home / "out")
        orusd("validate", home / "out" / "scene.usda", "--strict")
        orusd(
            "render",
            home / "out" / "scene.usda",
            "-o",
            home / "render",
            "--resolution",
            size,
            *quality,
        )
    return min(path.parent for path in (home / "render").glob("*/radiance.exr"))


def tiled(
    pictures: Sequence["np.ndarray[Any, np.dtype[np.uint8]]"],
) -> "np.ndarray[Any, np.dtype[np.uint8]]":
    """Pictures of one size side by side, with a little white between them."""
    tiles = [*pictures, *[np.full_like(pictures[0], 255)] * (-len(pictures) % COLUMNS)]
    framed = [np.pad(tile, ((3, 3), (3, 3), (0, 0)), constant_values=255) for tile in tiles]
    rows = [framed[i : i + COLUMNS] for i in range(0, len(framed), COLUMNS)]
    return np.concatenate([np.concatenate(row, axis=1) for row in rows], axis=0)


def _read(path: Path) -> "np.ndarray[Any, np.dtype[np.uint8]]":
    return np.asarray(OpenImageIO.ImageBuf(str(path)).get_pixels(OpenImageIO.UINT8))[..., :3]


def materials(folder: Path, *quality: str) -> "np.ndarray[Any, np.dtype[np.uint8]]":
    """Sheets of some substances, one below the other."""
    chosen = [word for substance in SUBSTANCES for word in ("--substance", substance)]
    orusd("materials", "sheet", "-o", folder, "--size", 112, *chosen, *quality)
    sheets = [_read(folder / f"{substance}.png") for substance in SUBSTANCES]
    width = max(sheet.shape[1] for sheet in sheets)
    return np.concatenate(
        [np.pad(s, ((0, 0), (0, width - s.shape[1]), (0, 0)), mode="edge") for s in sheets]
    )


def light(folder: Path, samples: str) -> None:
    """Every channel of one view of the example, of two of its lights: ``docs/light.png``."""
    home = folder / "light"
    orusd("compose", "openrooms_usd/demo/room.yaml", "-o", home / "out")
    orusd(
        "render",
        home / "out" / "scene.usda",
        "-o",
        home / "render",
        "--camera",
        "dining",
        "--resolution",
        "160x120",
        "--grid",
        "40x30",
        "--spp",
        samples,
        "--channels",
        "all",
        "--denoise",
        "--method",
        "cache",
    )
    manifest = json.loads((home / "render/manifest.json").read_text("utf-8"))
    (view,) = manifest["views"].values()
    named = {light["name"]: light["number"] for light in manifest["lights"]}
    tiles = []
    for name, row in CHANNELS.items():
        of_light = [(shown, numbered(name, named[shown])) for shown in LIGHTS]
        singles = of_light if row.scope == "light" else [(" ", name)]
        for below, single in singles:
            picture = _read(home / "render" / view["channels"][single]["preview"])
            tiles.append((f"{name}\n{below}", _fitted(picture)))
    write_sheet(Path("docs/light.png"), [tiles[i : i + 10] for i in range(0, len(tiles), 10)])


def robot(folder: Path) -> None:
    """What a robot sees on its way through the example: ``docs/robot.png``."""
    subprocess.run([sys.executable, "examples/05_navigate.py", folder / "robot"], check=True)
    removal.copy_file(folder / "robot/strip.png", Path("docs/robot.png"))


def _fitted(
    picture: "np.ndarray[Any, np.dtype[np.uint8]]",
) -> "np.ndarray[Any, np.dtype[np.uint8]]":
    """In 160x120 pixels: cut, or on black."""
    whole = np.zeros((120, 160, 3), np.uint8)
    part = picture[:120, :160]
    whole[: len(part), : part.shape[1]] = part
    return whole


def main() -> None:
    """Draw what the options ask for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--all", action="store_true", help="every room type, into the folder")
    parser.add_argument("--folder", type=Path, default=Path("out/pictures"))
    parser.add_argument("--resolution", default="480x360")
    parser.add_argument("--spp", default="64")
    options = parser.parse_args()
    quality = ("--spp", options.spp, "--denoise")
    if options.all:
        views = []
        for kind in get_args(RoomType):
            print(kind, flush=True)
            views.append(room(kind, 1, options.folder, options.resolution, *quality))
        pictures = [_read(view / "denoised.png") for view in views]
        write_png(options.folder / "rooms.png", tiled(pictures))
    else:
        quality += ("--camera", "view_0")
        # So wide, the tracked file stays below 2 MB.
        orusd("library", "sheet", "-o", "docs/catalogue.png", "--denoise", "--max-width", "1300")
        light(options.folder, options.spp)
        robot(options.folder)
        report_picture.draw(options.folder / "report", Path("docs/report.png"))
        view_picture.draw(options.folder, Path("docs"))
        plan_picture.draw(options.folder, *SCANNED, Path("docs/plan.png"))
        plan_film.draw(options.folder, *SCANNED, Path("docs/plan.webm"))
        tiles = scanned(options.folder, *SCANNED, (480, 360), quality[:3])
        write_sheet(Path("docs/scan.png"), [tiles[:2], tiles[2:]])
        write_png(Path("docs/materials.png"), materials(options.folder / "materials", *quality[:3]))


if __name__ == "__main__":
    main()
