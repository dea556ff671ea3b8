"""Radiance beside that of Cycles, raw and denoised by the same denoiser, on the same cores.

Both render the same stage, each is judged by a reference of its own. A single view is one in a room
that has not been rendered before; the twentieth is one more of a room that stays loaded.
"""

import json
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np

from benchmarks.light.bias import Pair, mse_of, robust_of
from benchmarks.light.pictures import denoised, truth_of
from benchmarks.light.processes import run
from benchmarks.light.references import Images
from benchmarks.light.rooms import REFERENCE_SEED, Room
from benchmarks.light.section import Section, Setting, section
from benchmarks.light.sessions import Cost, OpenedRoom, methods_of
from benchmarks.light.targets import Target
from benchmarks.report import table
from benchmarks.scenes import demo_stage
from openrooms_usd.usd.layers import open_stage

_PYTHON: Final = "ORUSD_BLENDER_PYTHON"
_INSTALLED: Final = Path(__file__).parents[2] / ".venv-blender/bin/python"
_FIGURES: Final = ("relative MSE", "robust error")
_MOMENTS: Final = ("single view", "twentieth view")
_LIMITS: Final = (10.0, 30.0)


def cycles(setting: Setting) -> Section:
    """Seconds and errors of both, and how many times the product of ours is theirs."""
    python = Path(os.environ.get(_PYTHON, _INSTALLED))
    if not python.is_file():
        return Section([], f"Not measured: no Blender here (.ci/install-blender, or {_PYTHON}).")
    size, counts, many = ((320, 240), (16, 64), (128, 256))
    if setting.quick:
        size, counts, many = ((32, 24), (2,), (4, 4))
    room = Room(open_stage(demo_stage(setting.folder)), *size)
    blender = _Blender(python, setting.folder, room)
    theirs = setting.references.pair(
        room.scene,
        {"cycles": many[0], "seen": room.seen},
        lambda half: blender.reference(many[0], half),
    )
    rows = _theirs(blender, counts, (theirs[0]["radiance"], theirs[1]["radiance"]))
    truth = truth_of(setting, room, ("radiance",), many[1])["radiance"]
    for method in methods_of(room):
        rows += _ours(room, method, (1,) if setting.quick else (1, 4, 16), truth)
    ratios = _ratios(rows)
    found = section(rows)
    titles = tuple(ratios[0])
    compared = table(titles, [list(row.values()) for row in ratios])
    targets = [
        Target(f"error x s of Cycles over ours, {moment}, denoised: {ratios[-1]['denoised']}",
               limit, ratios[-1][f"{moment}, by relative MSE"], at_least=True)
        for moment, limit in zip(_MOMENTS, _LIMITS, strict=True)
    ]  # fmt: skip
    data = {"rows": rows, "ratios": ratios}
    return Section(data, f"{found.markdown}\n\n{compared}", tuple(targets))


def _row(
    title: str, clean: bool, samples: int, cost: Cost, pictures: Sequence[Any], truth: Pair
) -> dict[str, Any]:
    return {
        "renderer": title, "denoised": "yes" if clean else "no", "samples": samples,
        "s, single view": cost.views(1), "s, twentieth view": cost.view,
        "relative MSE": float(np.mean([mse_of(x, truth) for x in pictures])),
        "robust error": float(np.mean([robust_of(x, truth) for x in pictures])),
    }  # fmt: skip


def _ours(room: Room, method: str, counts: Sequence[int], truth: Pair) -> list[dict[str, Any]]:
    opened, rows = OpenedRoom(room, method), []
    for samples in counts:
        cost = opened.cost(("radiance",), samples)
        shots = [opened.shot(("radiance",), samples, seed=seed, guides=True) for seed in (11, 12)]
        taken: list[float] = []
        clean = [denoised(shot, taken) for shot in shots]
        # With what the guides cost: they are rendered for the denoiser alone.
        guided = opened.cost(("radiance",), samples, guides=True)
        raw = [shot.pixels["radiance"] for shot in shots]
        rows.append(_row(method, False, samples, cost, raw, truth))
        full = Cost(guided.room, guided.view + taken[-1])
        rows.append(_row(method, True, samples, full, clean, truth))
    return rows


def _theirs(blender: "_Blender", counts: Sequence[int], truth: Pair) -> list[dict[str, Any]]:
    asked = [(samples, clean) for samples in counts for clean in (False, True)]
    # The first picture loads the room too; what it takes longer than the same again is the room's.
    shots = [{"samples": samples, "seed": 11, "denoise": clean} for samples, clean in asked]
    pictures, seconds = blender.render([shots[0], *shots])
    room = max(0.0, seconds[0] - seconds[1])
    return [
        _row("Cycles", clean, samples, Cost(room, taken), [picture], truth)
        for (samples, clean), picture, taken in zip(asked, pictures[1:], seconds[1:], strict=True)
    ]


def _ratios(rows: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """Error times seconds, theirs over ours, each with the number of samples that suits it best."""

    def best(renderer: str, denoised: str, figure: str, moment: str) -> float:
        return min(
            row[figure] * row[f"s, {moment}"]
            for row in rows
            if row["renderer"] == renderer and row["denoised"] == denoised
        )

    methods = dict.fromkeys(row["renderer"] for row in rows if row["renderer"] != "Cycles")
    return [
        {"Cycles to": method, "denoised": clean}
        | {
            f"{moment}, by {figure}": best("Cycles", clean, figure, moment)
            / best(method, clean, figure, moment)
            for moment in _MOMENTS
            for figure in _FIGURES
        }
        for method in methods
        for clean in ("no", "yes")
    ]


class _Blender:
    """Cycles in a process of its own.

    Args:
        python: Of an environment that has bpy.
        folder: For the pictures.
        room: What it renders, from its file.
    """

    def __init__(self, python: Path, folder: Path, room: Room) -> None:
        self._python, self._folder, self._room = python, folder, room

    def reference(self, samples: int, half: int) -> Images:
        """A picture of many samples."""
        (picture,), _ = self.render([{"samples": samples, "seed": REFERENCE_SEED + half}])
        return {"radiance": picture}

    def render(self, shots: Sequence[dict[str, Any]]) -> tuple[list[Any], list[float]]:
        """Pictures, and the seconds of each."""
        import OpenImageIO

        files = [str(self._folder / f"cycles_{number}.exr") for number in range(len(shots))]
        job, report = self._folder / "cycles.json", self._folder / "cycles_report.json"
        told = {
            "scene": self._room.stage.GetRootLayer().realPath,
            "camera": self._room.path.rpartition("/")[2],
            "size": self._room.size,
            "report": str(report),
            "shots": [shot | {"picture": file} for shot, file in zip(shots, files, strict=True)],
        }
        job.write_text(json.dumps(told))
        run(self._python, "-P", Path(__file__).with_name("in_blender.py"), job, PYTHONPATH="")
        buffers = [OpenImageIO.ImageBuf(file) for file in files]
        pictures = [np.asarray(buffer.get_pixels(OpenImageIO.FLOAT))[..., :3] for buffer in buffers]
        return pictures, json.loads(report.read_text())
