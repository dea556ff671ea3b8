"""Which of Mitsuba's backends works on this machine.

Dr.Jit loads the LLVM library while it is imported, takes the first one that it finds, and aborts
the whole process in the middle of a render when that one is too old. So each candidate is tried in
a process of its own, and the one that works is named in ``DRJIT_LIBLLVM_PATH`` before Mitsuba is
imported here.
"""

import ctypes.util
import os
import re
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Final

from openrooms_usd.errors import MissingPackageError, RenderError

LIBRARY: Final = "DRJIT_LIBLLVM_PATH"
NAMES: Final = {"cuda": "cuda_ad_rgb", "llvm": "llvm_ad_rgb", "scalar": "scalar_rgb"}
REMEDY: Final = (
    "install LLVM 17 or newer (Debian, Ubuntu: apt-get install libllvm19; macOS: brew install "
    f"llvm), or name its library in the environment variable {LIBRARY}"
)
_PROBE_SECONDS: Final = 30.0  # seconds; a probe takes about half of one

_FOLDERS: Final = (
    "/usr/lib/x86_64-linux-gnu",
    "/usr/lib/aarch64-linux-gnu",
    "/usr/lib64",
    "/usr/lib",
    "/usr/lib/llvm-*/lib",
    "/usr/lib64/llvm*/lib64",
    "/usr/local/lib",
    "/opt/homebrew/opt/llvm*/lib",
    "/usr/local/opt/llvm*/lib",
    "C:/Program Files/LLVM/bin",
)
_LIBRARIES: Final = ("libLLVM*.so*", "libLLVM*.dylib", "LLVM-C.dll")

# The literal makes the kernel a new one, so that Dr.Jit's cache on disk cannot stand in for the
# compiler; minimum and maximum are what old LLVMs cannot select.
_PROBE: Final = """
import random, sys
try:
    import resource
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
except ImportError:
    pass
import drjit as dr, mitsuba as mi
mi.set_variant(sys.argv[1])
x = dr.linspace(mi.Float, 0, 1, 64)
y = dr.minimum(x, random.random()) + dr.maximum(dr.sqrt(x), random.random())
assert bool(dr.all(dr.isfinite(y)))
scene = mi.load_dict({
    "type": "scene", "light": {"type": "constant"},
    "ball": {"type": "sphere", "bsdf": {"type": "twosided", "nested": {"type": "principled"}}},
    "sensor": {"type": "perspective", "film": {"type": "hdrfilm", "width": 4, "height": 4},
               "to_world": mi.ScalarTransform4f().look_at([0, 0, 4], [0, 0, 0], [0, 1, 0])},
})
image = mi.render(scene, spp=2, integrator=mi.load_dict({"type": "path", "max_depth": 3}))
assert bool(dr.all(dr.isfinite(image.array)))
version = dr.detail.llvm_version() if sys.argv[1].startswith("llvm") else ()
print("works", ".".join(map(str, version)))
"""


@dataclass(frozen=True)
class Backend:
    """A variant of Mitsuba that works here.

    Attributes:
        variant: Mitsuba's name of it.
        library: The LLVM library to load; None where Dr.Jit finds the right one, or needs none.
        version: The version of LLVM, for the record.
        advice: What would make it faster; empty when nothing would.
    """

    variant: str
    library: Path | None = None
    version: str = ""
    advice: str = ""

    @property
    def is_llvm(self) -> bool:
        """Whether processors compute, in vectors."""
        return self.variant.startswith("llvm")


@dataclass(frozen=True)
class Probe:
    """The outcome of trying one backend with one library."""

    works: bool
    detail: str


def choose(name: str = "auto") -> Backend:
    """Find a backend that works, and prepare this process for it.

    Args:
        name: ``cuda``, ``llvm``, ``scalar``, or ``auto``: the first of them that works.

    Returns:
        The backend; Mitsuba can now be imported and set to its variant.

    Raises:
        RenderError: There is no such backend, or it does not work here.
        MissingPackageError: Mitsuba is not installed.
    """
    _check_installed()
    if name != "auto" and name not in NAMES:
        known = ", ".join(("auto", *NAMES))
        raise RenderError(f"Mitsuba has no backend {name!r} here", remedy=f"one of: {known}")
    backend = _fastest() if name == "auto" else _find(name)
    if backend is None:
        raise RenderError(
            f"Mitsuba's {name} backend does not work on this machine: {diagnose()[name]}",
            remedy=(REMEDY if name == "llvm" else "install NVIDIA's driver")
            + "; or choose --variant auto",
        )
    if backend.library is not None:
        os.environ[LIBRARY] = str(backend.library)
    return backend


def diagnose() -> dict[str, str]:
    """What works on this machine, in words, by backend.

    Raises:
        MissingPackageError: Mitsuba is not installed.
    """
    _check_installed()
    found, fastest = {name: _find(name) for name in NAMES}, _fastest()
    return {
        "cuda": "works" if found["cuda"] else f"not usable: {_cuda().detail}",
        "llvm": _llvm_in_words(found["llvm"]),
        "scalar": "works",
        "auto": f"chooses {fastest.variant}" + (f"; {fastest.advice}" if fastest.advice else ""),
    }


def _check_installed() -> None:
    for package in ("mitsuba", "drjit"):
        if find_spec(package) is None:
            raise MissingPackageError(
                f"the renderer needs the package {package!r}, which is not installed",
                remedy=f"pip install {package}",
            )


def _llvm_in_words(backend: Backend | None) -> str:
    if backend is not None:
        where = f" ({backend.library})" if backend.library else ""
        return f"works, LLVM {backend.version}{where}"
    tried = "; ".join(f"{path or 'found by Dr.Jit'}: {_llvm(path).detail}" for path in _libraries())
    return f"not usable: {tried}"


@cache
def _fastest() -> Backend:
    backend = _find("cuda") or _find("llvm")
    return backend or Backend(NAMES["scalar"], advice=f"for three times the speed, {REMEDY}")


@cache
def _find(name: str) -> Backend | None:
    if name == "scalar":
        return Backend(NAMES["scalar"])
    if name == "cuda":
        return Backend(NAMES["cuda"]) if _cuda().works else None
    for library in _libraries():
        probe = _llvm(library)
        if probe.works:
            return Backend(NAMES["llvm"], library, probe.detail)
    return None


def _libraries() -> Iterator[Path | None]:
    """LLVM libraries to try: first what Dr.Jit takes by itself, then the newest of the others."""
    yield None
    # What the user names is meant, and what is loaded already cannot be changed any more.
    if not os.environ.get(LIBRARY) and "drjit" not in sys.modules:
        yield from _installed()


@cache
def _installed() -> tuple[Path, ...]:
    found: dict[Path, tuple[int, ...]] = {}
    for folder in _FOLDERS:
        root = Path(Path(folder).anchor)
        for place in root.glob(folder.removeprefix(str(root.as_posix()))):
            for pattern in _LIBRARIES:
                for path in place.glob(pattern):
                    found[path.resolve()] = _version(path.resolve())
    return tuple(sorted(found, key=lambda path: (found[path], path.as_posix()), reverse=True))


def _version(path: Path) -> tuple[int, ...]:
    """The version in a library's name, ``libLLVM.so.19.1``, or folder, ``llvm-18/lib/...``."""
    numbers = re.findall(r"\d+", path.name) or re.findall(r"\d+", path.parent.parent.name)
    return tuple(map(int, numbers))


@cache
def _cuda() -> Probe:
    if not any(ctypes.util.find_library(name) for name in ("cuda", "nvcuda")):
        return Probe(False, "no NVIDIA driver is installed")
    return _probe(NAMES["cuda"], None)


@cache
def _llvm(library: Path | None) -> Probe:
    return _probe(NAMES["llvm"], library)


def _probe(variant: str, library: Path | None) -> Probe:
    environment = dict(os.environ)
    if library is not None:
        environment[LIBRARY] = str(library)
    try:
        done = subprocess.run(
            [sys.executable, "-P", "-c", _PROBE, variant],
            env=environment,
            capture_output=True,
            text=True,
            timeout=_PROBE_SECONDS,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return Probe(False, f"no answer in {_PROBE_SECONDS:.0f} s")
    if done.returncode == 0 and "works" in done.stdout:
        return Probe(True, done.stdout.rpartition("works")[2].strip())
    return Probe(False, _reason(done.stdout + "\n" + done.stderr, done.returncode))


def _reason(output: str, code: int) -> str:
    if "Cannot select" in output:
        return "this LLVM is too old, it cannot compile Mitsuba's code"
    if "could not be found" in output or "LLVM backend is inactive" in output:
        return "no usable library"
    lines = [line.strip() for line in output.splitlines() if line.strip()]
    return f"{lines[-1][:200]} (exit code {code})" if lines else f"exit code {code}"
