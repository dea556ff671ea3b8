"""How much memory renders take: with many lights, and over many views."""

import sys
from pathlib import Path
from typing import Any, Final

from benchmarks.light.hard import many
from benchmarks.light.processes import run
from benchmarks.light.rooms import ROOMS, Room
from benchmarks.light.section import Section, Setting, section
from benchmarks.light.sessions import OpenedRoom, methods_of
from benchmarks.light.targets import Target
from benchmarks.scenes import ORUSD
from openrooms_usd.channels import RENDERED

_LIGHTS: Final = 50
_VIEWS: Final = 200
# Views until all that is kept from view to view is there.
_SETTLED_VIEWS: Final = 20


def memory(setting: Setting) -> Section:
    """The peak of a render with many lights by the command line, and growth over many views."""
    resolution, grid = ("32x24", "4x3") if setting.quick else ("640x480", "160x120")
    stage = setting.folder / "many.usda"
    many(_LIGHTS).Export(str(stage))
    rows: list[dict[str, Any]] = []
    methods = methods_of(Room(ROOMS["plain"].build(setting.folder), 4, 3))
    for method in methods:
        target = setting.folder / f"many_{method}"
        ran = run(
            *ORUSD, "render", stage, "-o", target, "--channels", "all", "--resolution", resolution,
            "--grid", grid, "--spp", 16, "--method", method,
        )  # fmt: skip
        rows.append({"what": f"{_LIGHTS} lights, {resolution}, all channels", "method": method,
                     "s": ran.seconds, "peak GiB": ran.peak_gib, "growth, MiB": None})  # fmt: skip
    views = (4, 8) if setting.quick else (_SETTLED_VIEWS, _VIEWS)
    for method in methods:
        script = f"from benchmarks.light.memory import walk; walk({method!r}, {views})"
        ran = run(sys.executable, "-P", "-c", script)
        rows.append({"what": f"{views[1]} views, all channels", "method": method,
                     "s": ran.seconds, "peak GiB": ran.peak_gib,
                     "growth, MiB": float(ran.said.split()[-1])})  # fmt: skip
    last = len(methods) - 1
    return section(rows, [
        Target(f"{rows[last]['what']}, GiB", 4.0, rows[last]["peak GiB"]),
        Target(f"{rows[-1]['what']}, growth, MiB", 16.0, rows[-1]["growth, MiB"]),
    ])  # fmt: skip


def walk(method: str, views: tuple[int, int]) -> None:
    """Render views and print by how many MiB memory has grown from the first number to the last."""
    opened = OpenedRoom(Room(ROOMS["plain"].build(Path()), 64, 48), method)
    held = 0.0
    for view in range(views[1]):
        opened.shot(RENDERED, 2, view=view, grid=(4, 3))
        if view + 1 == views[0]:
            held = resident_mib()
    print(resident_mib() - held)


def resident_mib() -> float:
    """What this process holds now."""
    import gc
    import resource

    gc.collect()
    try:
        return int(Path("/proc/self/statm").read_text().split()[1]) * resource.getpagesize() / 2**20
    except OSError:
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**10
