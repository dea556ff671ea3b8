"""The page about a small dataset, as a browser shows it: ``docs/report.png``."""

import shutil
import subprocess
from pathlib import Path

from benchmarks.scenes import orusd

TYPES = (
    "bathroom", "hallway", "bedroom", "kitchen", "office", "living_room", "dining_room",
)  # fmt: skip
DATASET = """\
name: small_homes
seed: 7
rooms:
  - files: [{files}]
views: {{count: 2, resolution: [160, 120], replace: 3}}
variants: [main, mainDiffMat, mainDiffLight]
channels: [usual, direct, indirect, irradiance]
budget: {{samples: 16}}
rendering: {{denoise: true, method: cache}}
splits: {{train: 0.6, val: 0.2, test: 0.2}}
"""
SIZE = (1180, 1180)
# Of pixels in a picture to those of the page.
SCALE = 0.62


def draw(folder: Path, target: Path) -> None:
    """Make the dataset, write its page, and take a picture of the page's beginning.

    Args:
        folder: Where the dataset is made, or was.
        target: The picture.
    """
    chromium = shutil.which("chromium")
    if chromium is None:
        raise SystemExit("docs/report.png is taken by Chromium, which is not installed")
    for kind in TYPES:
        home = folder / "source" / kind
        orusd("generate", "--type", kind, "--seed", 3, "--clutter", 1, "-o", home)
        text = (home / "room.yaml").read_text(encoding="utf-8")
        # Views are small.
        small = text.replace("\nmaterials:\n", "\nmaterials:\n  resolution: 64\n", 1)
        (home / "room.yaml").write_text(small, encoding="utf-8")
    files = ", ".join(f"{kind}/room.yaml" for kind in TYPES)
    file = folder / "source/dataset.yaml"
    file.write_text(DATASET.format(files=files), encoding="utf-8")
    orusd("dataset", "run", file, "-o", folder / "made")
    orusd("dataset", "report", folder / "made", "--price", 0.04)
    photograph(chromium, folder / "made/report.html", target)


def photograph(chromium: str, page: Path, target: Path) -> None:
    """Take a picture of the beginning of a page."""
    command = [
        chromium, "--headless", "--no-sandbox", "--hide-scrollbars", "--disable-gpu",
        f"--window-size={SIZE[0]},{SIZE[1]}", f"--force-device-scale-factor={SCALE}",
        f"--screenshot={target.absolute()}", page.absolute().as_uri(),
    ]  # fmt: skip
    subprocess.run(command, check=True, capture_output=True)
