"""Whether a render has the same bytes whatever computes it: threads, processes, order of views."""

import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, Final

from benchmarks.light.processes import run
from benchmarks.light.rooms import ROOMS, Room
from benchmarks.light.section import Section, Setting, section
from benchmarks.light.sessions import OpenedRoom, methods_of
from benchmarks.light.targets import Target
from openrooms_usd.usercache import VARIABLE

_THREADS: Final = (1, 2, 4)
_AT_ONCE: Final = 4
_ROOM: Final = "three windows"


def repeatable(setting: Setting) -> Section:
    """Digests of all channels of light of a view, which must be one."""
    rows: list[dict[str, Any]] = []
    for method in methods_of(Room(ROOMS["plain"].build(setting.folder), 4, 3)):
        # Nobody finds here what another has kept on disk.
        alone = {f"{n} threads": _digest(setting.folder, method, n) for n in _THREADS}
        alone["after another view"] = _digest(setting.folder, method, 2, 1)
        # Whoever is first keeps it for the others.
        shared = str(setting.folder / f"kept_{method}")
        with ThreadPoolExecutor(_AT_ONCE) as pool:
            jobs = [
                pool.submit(_digest, setting.folder, method, 1, 0, shared) for _ in range(_AT_ONCE)
            ]
        together = {f"process {n + 1} of {_AT_ONCE}": job.result() for n, job in enumerate(jobs)}
        afterwards = {"from what they kept": _digest(setting.folder, method, 1, 0, shared)}
        digests = alone | together | afterwards
        known = next(iter(digests.values()))
        rows += [{"method": method, "computed by": how, "digest": digest[:12],
                  "same bytes": "yes" if digest == known else "NO"}
                 for how, digest in digests.items()]  # fmt: skip
    differing = sum(row["same bytes"] != "yes" for row in rows)
    return section(rows, [Target("renders with bytes of their own", 0.0, float(differing))])


def _digest(folder: Path, method: str, threads: int, before: int = 0, kept: str = "off") -> str:
    arguments = f"{str(folder)!r}, {method!r}, {threads}, {before}"
    script = f"from benchmarks.light.repeatable import digest; digest({arguments})"
    return run(sys.executable, "-P", "-c", script, **{VARIABLE: kept}).said.split()[-1]


def digest(folder: str, method: str, threads: int, before: int) -> None:
    """Print the digest of a view that so many threads render, after so many others."""
    import hashlib

    import drjit as dr

    from benchmarks.light.channels import LIT

    room = Room(ROOMS[_ROOM].build(Path(folder)), 48, 36)
    dr.set_thread_count(threads)
    opened = OpenedRoom(room, method)
    for view in range(before):
        opened.shot(LIT, 4, view=view + 1, grid=(4, 3))
    found = hashlib.blake2b(digest_size=16)
    for name, pixels in sorted(opened.shot(LIT, 4, grid=(4, 3)).pixels.items()):
        found.update(name.encode())
        found.update(pixels.tobytes())
    print(found.hexdigest())
