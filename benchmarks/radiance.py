"""Seconds of radiance against its relative mean squared error, on each backend present.

The error is the mean over pixels of (x - ref)^2 / (ref^2 + 0.01 M^2) for each colour, M the mean of
the reference in that colour, and the mean of the three; the robust error is the same with every
pixel's part capped at 1. Beside them stands what the renderer itself estimates. The reference has
another seed and many more samples; its own error, which the measured ones include, stands in its
row. Every backend runs in a process of its own, whose peak memory is the last column. The share is
what translation and output take beside 64 samples with all channels.

With --denoise each picture is denoised too: its error then stands beside the raw one, and the
seconds that it took. Its bias is what denoising does to the reference itself: the distance of the
denoised reference from a second one of another seed, beside that of the raw one, and the mean of
the signed difference over the mean. Two references that are good enough leave only the bias.
"""

import json
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

import click
import numpy as np

from benchmarks.report import publish, table
from benchmarks.scenes import demo_stage
from openrooms_usd.arrays import Floats
from openrooms_usd.description.rendering import RenderSettings
from openrooms_usd.errors import RenderError
from openrooms_usd.rendering import RenderRequest, View, render_stage
from openrooms_usd.rendering.denoise import load_denoiser
from openrooms_usd.rendering.estimates import relative_mse, robust_error
from openrooms_usd.rendering.opening import open_for_rendering

VARIANTS: Final = ("cuda", "llvm", "scalar")
SAMPLES: Final = (4, 16, 64, 256, 1024)
# Of the second reference.
OTHER_SEED: Final = 77_777
DENOISED: Final = ("denoised, relative MSE", "seconds with it")


@click.command(help=__doc__)
@click.option("--stage", type=click.Path(path_type=Path), help="By default the bundled example.")
@click.option("--camera", help="Its path; by default the stage's first.")
@click.option("--variant", "variants", multiple=True, type=click.Choice(VARIANTS))
@click.option("--samples", type=int, multiple=True, default=SAMPLES, show_default=True)
@click.option("--reference", type=int, default=4096, show_default=True, help="Its samples.")
@click.option("--half", is_flag=True, help="320x240 in place of 640x480.")
@click.option("--denoise", is_flag=True, help="Also denoised (needs the extra 'denoise').")
@click.option("--quick", is_flag=True, help="64x48, few samples, the scalar backend only.")
@click.option("--json", "target", type=click.Path(path_type=Path), help="Where to write numbers.")
def main(
    stage: Path | None,
    camera: str | None,
    variants: tuple[str, ...],
    samples: tuple[int, ...],
    reference: int,
    half: bool,
    denoise: bool,
    quick: bool,
    target: Path | None,
) -> None:
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        scene = stage or demo_stage(place)
        chosen = ("scalar",) if quick else variants or usable(scene)
        counts, many = ((2, 8), 64) if quick else (samples, reference)
        job = {
            "stage": str(scene),
            "camera": camera,
            "resolution": [64, 48] if quick else [320, 240] if half else [640, 480],
            "folder": folder,
            "denoise": denoise,
        }
        # The first backend is the fastest: it alone renders the reference.
        backends = [
            in_process(
                {
                    **job,
                    "variant": variant,
                    "samples": [*counts, *([many] * first)],
                    "second": many * first * denoise,
                }
            )
            for variant, first in zip(chosen, [1] + [0] * len(chosen), strict=False)
        ]
        rows = compared(backends, place, many)
        bias = denoiser_bias(place, backends[0]["variant"], many) if denoise else None
    measured = ("relative MSE", "robust error", "estimated", *(DENOISED * denoise))
    titles = ("backend", "samples", "seconds", *measured)
    summary = [[b["variant"], b["share"], b["memory_MB"]] for b in backends]
    markdown = "\n\n".join(
        [
            table(titles, [list(row.values()) for row in rows]),
            table(("backend", "translation + output / tracing", "peak MB"), summary),
            *([table(tuple(bias), [list(bias.values())])] if bias else []),
        ]
    )
    data = {"rows": rows, "backends": backends} | ({"denoiser": bias} if bias else {})
    publish("radiance", data, markdown, target)


def usable(stage: Path) -> tuple[str, ...]:
    """The backends that can open the stage here, the fastest first."""
    return tuple(variant for variant in VARIANTS if _opens(stage, variant))


def _opens(stage: Path, variant: str) -> bool:
    try:
        open_for_rendering(stage, RenderSettings(options={"variant": variant}))
    except RenderError:
        return False
    return True


def compared(backends: Sequence[dict[str, Any]], folder: Path, many: int) -> list[dict[str, Any]]:
    """A row for every picture, with its distance from the reference, which comes last."""
    reference = np.load(picture_file(folder, backends[0]["variant"], many))
    rows = []
    for backend in backends:
        for picture in backend.pop("pictures"):
            itself = picture["samples"] == many
            pixels = np.load(picture_file(folder, backend["variant"], picture["samples"]))
            row = {
                "backend": backend["variant"] + " (reference)" * itself,
                "samples": picture["samples"],
                "seconds": picture["seconds"],
                "relative_mse": None if itself else relative_mse(pixels, reference),
                "robust_error": None if itself else robust_error(pixels, reference),
                "estimated": picture["estimated"],
            }
            if "denoising" in picture:
                cleaned = np.load(picture_file(folder, backend["variant"], picture["samples"], "d"))
                row["denoised_mse"] = None if itself else relative_mse(cleaned, reference)
                row["seconds_with_denoising"] = picture["seconds"] + picture["denoising"]
            rows.append(row)
    return sorted(rows, key=lambda row: row["relative_mse"] is None)


def denoiser_bias(folder: Path, variant: str, many: int) -> dict[str, float]:
    """What denoising does to the reference, measured against a second, independent one."""
    second = np.load(picture_file(folder, variant, many, "second"))
    raw, cleaned = (np.load(picture_file(folder, variant, many, kind)) for kind in ("", "d"))
    difference = cleaned.astype(np.float64) - second
    return {
        "raw reference, relative MSE": relative_mse(raw, second),
        "denoised reference, relative MSE": relative_mse(cleaned, second),
        "raw, mean signed difference": float((raw.astype(np.float64) - second).mean())
        / float(second.mean()),
        "denoised, mean signed difference": float(difference.mean()) / float(second.mean()),
    }


def in_process(job: dict[str, Any]) -> dict[str, Any]:
    """Run `measure` in a process of its own, so that its memory is its own."""
    script = (
        "import json, sys; from benchmarks.radiance import measure; "
        "print(json.dumps(measure(json.loads(sys.argv[1]))))"
    )
    command = [sys.executable, "-c", script, json.dumps(job)]
    done = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=False)
    if done.returncode:
        raise SystemExit(f"the backend {job['variant']} failed")
    result: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    return result


def measure(job: dict[str, Any]) -> dict[str, Any]:
    """Render every number of samples on one backend, and once the whole way through the driver."""
    stage, folder = Path(job["stage"]), Path(job["folder"])
    width, height = job["resolution"]
    settings = RenderSettings(
        resolution=(width, height), samples=64, options={"variant": job["variant"]}
    )
    session = open_for_rendering(stage, settings)
    camera = job["camera"] or next(iter(session.cameras), None)
    pictures = []
    cleaned = _Cleaner(session, camera, width, height) if job["denoise"] else None
    if job["second"]:
        request = RenderRequest(
            camera, ("radiance",), width, height, samples=job["second"], seed=OTHER_SEED
        )
        pixels = session.render(request).images["radiance"].pixels
        np.save(picture_file(folder, job["variant"], job["second"], "second"), pixels)
    for samples in (1, *job["samples"]):  # the first compiles the kernels
        # Another seed for every picture: a shared one would make their errors alike.
        request = RenderRequest(camera, ("radiance",), width, height, samples=samples, seed=samples)
        began = time.perf_counter()
        image = session.render(request).images["radiance"]
        seconds = time.perf_counter() - began
        np.save(picture_file(folder, job["variant"], samples), image.pixels)
        pictures.append({"samples": samples, "seconds": seconds, "estimated": image.error})
        if cleaned:
            began = time.perf_counter()
            pixels = cleaned(image.pixels)
            pictures[-1]["denoising"] = time.perf_counter() - began
            np.save(picture_file(folder, job["variant"], samples, "d"), pixels)
    out, cameras = folder / f"{job['variant']}_all", [camera] if camera else []
    timing = render_stage(stage, out, settings, cameras=cameras).timing
    (view,) = timing["views"].values()
    return {
        "variant": job["variant"],
        "backend": session.session.backend,
        "pictures": pictures[1:],
        "share": (timing["translation"] + view["output"]) / view["render"],
        "translation_s": timing["translation"],
        "output_s": view["output"],
        "tracing_s": view["render"],
        "memory_MB": peak_memory() / 1e6,
    }


class _Cleaner:
    """Denoises pictures of one camera, whose guides are rendered once."""

    def __init__(self, session: Any, camera: str | None, width: int, height: int) -> None:
        self._denoiser = load_denoiser()
        request = RenderRequest(camera, (), width, height, samples=1, guides=True)
        view: View = session.render(request)
        self._guides = view.guides

    def __call__(self, radiance: Floats) -> Floats:
        return self._denoiser.denoise(radiance, self._guides)


def picture_file(folder: Path, variant: str, samples: int, kind: str = "") -> Path:
    """Where a picture is kept for the comparison: raw, ``d`` denoised, ``second`` reference."""
    return folder / f"{variant}_{samples}{kind and '_' + kind}.npy"


def peak_memory() -> int:
    """The most bytes that this process ever had in memory."""
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak if sys.platform == "darwin" else 1024 * peak


if __name__ == "__main__":
    main()
