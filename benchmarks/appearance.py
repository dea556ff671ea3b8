"""Materials and lights found in photographs, against their truth: python -m benchmarks.appearance.

Each room of a kit is composed from its description and photographed by another renderer. The kit's
``score.py`` compares the found room, and the room as it was guessed, with the truth.
"""

import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any, Final

import click

from benchmarks.report import publish, table
from benchmarks.scenes import ORUSD, orusd

_FRAMES: Final = {"exact": "frames.json", "noisy": "frames_noisy.json"}
# Titles of columns, by the scorer's names.
_NUMBERS: Final = {
    "base_abs_scaled": "base colour",
    "within_0.05": "within 0.05",
    "rough_abs": "roughness",
    "metal_right": "metal",
    "light_ratio_stops": "lights, stops",
    "light_deg": "lights, degrees",
    "on_off": "on or off",
    "psnr": "PSNR",
    "relit_psnr": "relit PSNR",
}


@click.command(help=__doc__.splitlines()[0])
@click.argument("kit", type=click.Path(path_type=Path, exists=True))
@click.option("--room", "rooms", multiple=True, help="Names of rooms; all by default.")
@click.option("--poses", type=click.Choice([*_FRAMES]), default="exact", show_default=True)
@click.option("--spp", type=int, default=32, show_default=True, help="Samples of the scorer.")
@click.option("--json", "target", type=click.Path(path_type=Path), help="Where numbers go.")
def main(kit: Path, rooms: tuple[str, ...], poses: str, spp: int, target: Path | None) -> None:
    found = sorted(path.parent for path in kit.rglob("heldout_views.json"))
    chosen = [path for path in found if not rooms or path.name in rooms]
    if not chosen:
        raise SystemExit(f"no room is here: {', '.join(path.name for path in found) or kit}")
    results = [_measured(kit / "score.py", room, _FRAMES[poses], spp) for room in chosen]
    rows = [
        [one["room"], looks, *(one[looks][name] for name in _NUMBERS), one["seconds"][looks]]
        for one in results
        for looks in ("guessed", "found")
    ]
    titles = ["room", "looks", *_NUMBERS.values(), "seconds"]
    publish("appearance", {"poses": poses, "rooms": results}, table(titles, rows), target)


def _measured(scorer: Path, room: Path, frames: str, spp: int) -> dict[str, Any]:
    """Scores of a room as it is guessed and as it is found, and the seconds to find it."""
    with tempfile.TemporaryDirectory() as folder:
        guessed, found = Path(folder) / "guessed", Path(folder) / "found"
        orusd("compose", room / "room.yaml", "-o", guessed)
        stage, looks = guessed / "scene.usda", found / "looks.usda"
        began = time.perf_counter()
        orusd("appearance", stage, "--photographs", room / frames, "-o", looks)
        seconds = time.perf_counter() - began
        (found / "scene.usda").write_text(_over(stage, looks))
        tool = _tool(Path(folder) / "orusd")
        scores = {one.name: _score(scorer, room, one, tool, spp) for one in (guessed, found)}
    return {"room": room.name, "seconds": {"guessed": None, "found": round(seconds, 1)}, **scores}


def _over(stage: Path, looks: Path) -> str:
    """A root layer of opinions above a stage."""
    head = (
        'defaultPrim = "World"\n    metersPerUnit = 1\n    kilogramsPerUnit = 1\n    upAxis = "Z"'
    )
    return f"#usda 1.0\n(\n    {head}\n    subLayers = [@{looks}@, @{stage}@]\n)\n"


def _tool(path: Path) -> Path:
    """The command line as a program, which the scorer calls."""
    python, *rest = ORUSD
    path.write_text(f"#!{python}\n{rest[1]}\n")
    path.chmod(0o755)
    return path


def _score(scorer: Path, room: Path, out: Path, tool: Path, spp: int) -> dict[str, Any]:
    """The scorer's last line."""
    words = [sys.executable, scorer, room, out, "--tool", tool, "--spp", spp]
    done = subprocess.run([*map(str, words)], capture_output=True, text=True, check=False)
    if done.returncode:
        raise SystemExit(f"{scorer} failed:\n{done.stdout}{done.stderr}")
    lines = [line for line in done.stdout.splitlines() if line.startswith("SCORE ")]
    return dict(json.loads(lines[-1].removeprefix("SCORE ")))


if __name__ == "__main__":
    main()
