"""The wheel in an empty environment, with each extra: its size, and the seconds to a picture.

Every environment starts with an empty home: no caches, no compiled kernels. What is tried in each:
the example as `orusd demo` makes it, then one view with light that only a vectorized backend has,
then the same without any LLVM, where the example must work and the light must be refused.
"""

import os
import shutil
import subprocess
import sys
import tempfile
import time
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

import click
import numpy as np

from benchmarks.report import publish, table
from openrooms_usd.rendering.reading import read_render
from orusd_mitsuba.llvm import PACKAGES, VARIABLE

ROOT: Final = Path(__file__).parents[1]
BASE: Final = "(none)"
DEMO_SAMPLES: Final = 4
LIGHT: Final = ("irradiance", "radiance_i")
TITLES: Final = (
    "extra",
    "MB installed",
    "install s",
    "demo s",
    "view with light s",
    "demo without LLVM s",
)


@click.command(help=__doc__)
@click.option("--extra", "extras", multiple=True, help="By default none, and each one alone.")
@click.option("--python", default=sys.executable, help="Which Python; by default this one.")
@click.option("--wheel", type=click.Path(path_type=Path), help="By default it is built.")
@click.option("--json", "target", type=click.Path(path_type=Path), help="Where to write numbers.")
def main(extras: tuple[str, ...], python: str, wheel: Path | None, target: Path | None) -> None:
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        made = wheel.resolve() if wheel else build(place / "wheel")
        rows = []
        for extra in extras or (BASE, *declared()):
            rows.append(measure(place / "one", python, made, extra))
            shutil.rmtree(place / "one")
            click.echo(f"{extra}: {rows[-1]}", err=True)
    markdown = table(TITLES, [list(row.values()) for row in rows])
    publish("install", {"rows": rows}, markdown, target)


def declared() -> list[str]:
    """The extras of the project, but for PyTorch: how large it is depends on where pip finds it."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    return [extra for extra in project["optional-dependencies"] if extra != "torch"]


def build(folder: Path) -> Path:
    """Build the wheel."""
    run([sys.executable, "-m", "build", "--wheel", "--no-isolation", "--outdir", folder, ROOT])
    (path,) = folder.glob("*.whl")
    return path


def measure(folder: Path, python: str, wheel: Path, extra: str) -> dict[str, Any]:
    """One environment with one extra: its row."""
    home = folder / "home"
    home.mkdir(parents=True)
    kept = {name: value for name, value in os.environ.items() if name not in ("HOME", VARIABLE)}
    fresh = {**kept, "HOME": str(home), "ORUSD_CACHE": str(home / "cache")}
    run([python, "-m", "venv", folder / "venv"])
    bin_ = folder / "venv" / ("Scripts" if os.name == "nt" else "bin")
    wanted = f"{wheel}" if extra == BASE else f"{wheel}[{extra}]"
    installed = run([bin_ / "python", "-m", "pip", "install", "--quiet", wanted], fresh)
    size = sum(file.lstat().st_size for file in (folder / "venv").rglob("*") if file.is_file())

    def orusd(*words: object, environment: Mapping[str, str] = fresh) -> float:
        return run([bin_ / "orusd", *words], environment, folder)

    demo = orusd("demo", "-o", "demo", "--spp", DEMO_SAMPLES)
    stage = "demo/scene.usda"
    how = ("--camera", "dining", "--resolution", "160x120", "--spp", 16)
    asked = ("--channels", ",".join(("radiance", *LIGHT)))
    light = orusd("render", stage, "-o", "light", *how, *asked)
    (view,) = read_render(folder / "light").each()
    found = (view.pixels["irradiance"], *view.lights["radiance"].values())
    if not all(np.isfinite(light).all() for light in found) or not found[0].mean() > 0.0:
        raise SystemExit(f"{extra}: there is no light in {folder / 'light'}")

    # A machine without LLVM: neither of the packages, and none that the system has.
    run([bin_ / "python", "-m", "pip", "uninstall", "--quiet", "--yes", *PACKAGES], fresh)
    without = {**fresh, VARIABLE: str(folder / "no-such-library")}
    plain = orusd("demo", "-o", "plain", "--spp", DEMO_SAMPLES, environment=without)
    refused = subprocess.run(
        [bin_ / "orusd", "render", stage, "-o", "none", *map(str, (*how, *asked))],
        env=without,
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
    )
    said = refused.stderr
    if refused.returncode == 0 or "Traceback" in said or "irradiance" not in said:
        raise SystemExit(f"{extra}: light without LLVM is not refused:\n{said}")
    return {
        "extra": extra,
        "megabytes": size / 1e6,
        "install_s": installed,
        "demo_s": demo,
        "light_s": light,
        "without_llvm_s": plain,
    }


def run(
    command: list[Any], environment: Mapping[str, str] | None = None, folder: Path | None = None
) -> float:
    """Run a command and give its seconds.

    Raises:
        SystemExit: It failed; with what it said.
    """
    began = time.perf_counter()
    done = subprocess.run(
        list(map(str, command)),
        env=environment,
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode:
        said = f"{done.stdout}\n{done.stderr}".strip()
        raise SystemExit(f"{' '.join(map(str, command))} failed:\n{said}")
    return time.perf_counter() - began


if __name__ == "__main__":
    main()
