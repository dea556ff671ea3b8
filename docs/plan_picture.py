"""The page of a plan over a simulated scan, as a browser shows it: ``docs/plan.png``."""

from pathlib import Path

import numpy as np

from benchmarks.scan.rooms import generated
from benchmarks.scan.scanner import Scanner, simulate
from openrooms_usd.importing import ROOM, import_capture
from openrooms_usd.view.plan.session import Session
from openrooms_usd.view.server import serving
from tests.chromium import Page, opened

SIZE = (1180, 800)


def draw(folder: Path, kind: str, seed: int, target: Path) -> None:
    """Scan a generated room, open its plan, select its widest window, and take a picture.

    Args:
        folder: For what is made on the way.
        kind: The type of the room.
        seed: Of the room.
        target: The picture.
    """
    session = Session(scanned_room(folder, kind, seed, "picture"))
    with serving(session.app()) as server, opened(server.address, size=SIZE) as page:
        page.wait("document.getElementById('points')?.dataset.loaded")
        _select(page, session)
        page.screenshot(target)


def scanned_room(folder: Path, kind: str, seed: int, name: str) -> Path:
    """The ``room.yaml`` of a simulated scan of a generated room, as it is imported.

    Args:
        folder: For what is made on the way.
        kind: The type of the room.
        seed: Of the room.
        name: Of the folder that it is imported to.
    """
    home = folder / f"{kind}_{seed}_plan"
    if not (home / "scan.npz").is_file():
        cloud = simulate(generated(kind, seed, folder), seed, Scanner()).cloud
        assert cloud.label is not None and cloud.instance is not None, "the simulator says both"
        shades = np.random.default_rng(7).integers(90, 230, (4096, 3), np.uint8)
        home.mkdir(parents=True, exist_ok=True)
        colors = shades[(cloud.label * 97 + cloud.instance) % len(shades)]
        np.savez(
            home / "scan.npz",
            points=cloud.points,
            colors=colors,
            sensor_origins=cloud.sensor_origins,
        )
    if (home / name / ROOM).is_file():
        return home / name / ROOM
    return import_capture("scan", home / "scan.npz", home / name).file


def _select(page: Page, session: Session) -> None:
    """The widest window, on its wall."""
    openings = list(enumerate(session.history.now.openings))
    number, window = max(openings, key=lambda row: (row[1].kind == "window", row[1].width or 0.0))
    page.click_on(f"[data-wall='{window.wall}']")
    page.wait(f"document.querySelector('[data-hole=\"{number}\"]') !== null")
    page.click_on(f"[data-hole='{number}']")
    page.wait("document.getElementById('selected').textContent.includes('sill')")
