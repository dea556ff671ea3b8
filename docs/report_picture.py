"""The page about the example's dataset, as a browser shows it: ``docs/report.png``."""

import shutil
import subprocess
from pathlib import Path

from benchmarks.scenes import orusd

DATASET = Path("examples/dataset.yaml")
SIZE = (1180, 800)
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
    orusd("dataset", "run", DATASET, "-o", folder, "--workers", 2)
    orusd("dataset", "report", folder, "--price", 0.04)
    photograph(chromium, folder / "report.html", target)


def photograph(chromium: str, page: Path, target: Path) -> None:
    """Take a picture of the beginning of a page."""
    command = [
        chromium,
        "--headless",
        "--no-sandbox",
        "--hide-scrollbars",
        "--disable-gpu",
        f"--window-size={SIZE[0]},{SIZE[1]}",
        f"--force-device-scale-factor={SCALE}",
        f"--screenshot={target.absolute()}",
        page.absolute().as_uri(),
    ]
    subprocess.run(command, check=True, capture_output=True)
