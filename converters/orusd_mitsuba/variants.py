"""Which of Mitsuba's backends works on this machine.

An LLVM library that does not fit aborts the whole process in the middle of a render. So each one
that `orusd_mitsuba.llvm` finds is tried in a process of its own, and the first one that works is
prepared before Mitsuba is imported here.
"""

import ctypes.util
import os
import re
import subprocess
import sys
from dataclasses import dataclass
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Final

from openrooms_usd.errors import MissingPackageError, RenderError
from orusd_mitsuba.llvm import LEAST_VERSION, VARIABLE, Library, libraries, remedy

NAMES: Final = {"cuda": "cuda_ad_rgb", "llvm": "llvm_ad_rgb", "scalar": "scalar_rgb"}
_PROBE_SECONDS: Final = 30.0  # seconds; a probe takes about half of one

# The literal makes the kernel a new one, so that Dr.Jit's cache on disk cannot stand in for the
# compiler; minimum and maximum are what old LLVMs cannot select.
_PROBE: Final = """
import ctypes, random, sys
for needed in sys.argv[2:]:
    ctypes.CDLL(needed)
try:
    import resource
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
except ImportError:
    pass
import drjit as dr, mitsuba as mi
mi.set_variant(sys.argv[1])
if sys.argv[1].startswith("scalar"):
    sys.exit(print("works"))
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
        library: The LLVM library to load; None where none is needed.
        version: The version of LLVM, for the record.
        advice: What would make it faster; empty when nothing would.
    """

    variant: str
    library: Library | None = None
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
        RenderError: There is no such backend, or it does not work here, or Mitsuba does not at all.
        MissingPackageError: Mitsuba is not installed.
    """
    _check_installed()
    if name != "auto" and name not in NAMES:
        known = ", ".join(("auto", *NAMES))
        raise RenderError(f"Mitsuba has no backend {name!r} here", remedy=f"one of: {known}")
    backend = _fastest() if name == "auto" else _find(name)
    _check_usable()
    if backend is None:
        raise RenderError(
            f"Mitsuba's {name} backend is {diagnose()[name]}",
            remedy=(remedy() if name == "llvm" else "install NVIDIA's driver")
            + "; or choose --variant auto",
        )
    # Also for scalar: Dr.Jit loads one library, whichever backend imports it first.
    llvm = None if backend.variant == NAMES["cuda"] else _find("llvm")
    if llvm is not None and llvm.library is not None:
        llvm.library.prepare()
    else:
        _import_in_silence()
    return backend


def diagnose() -> dict[str, str]:
    """What works on this machine, in words, by backend.

    Raises:
        MissingPackageError: Mitsuba is not installed.
        RenderError: Mitsuba cannot be imported.
    """
    _check_installed()
    _check_usable()
    found, fastest = {name: _find(name) for name in NAMES}, _fastest()
    return {
        "cuda": "works" if found["cuda"] else f"not usable: {_cuda().detail}",
        "llvm": _llvm_in_words(found["llvm"]),
        "scalar": "works",
        "auto": "; ".join(filter(None, (f"chooses {fastest.variant}", fastest.advice))),
    }


def _check_installed() -> None:
    for package in ("mitsuba", "drjit"):
        if find_spec(package) is None:
            raise MissingPackageError(
                f"the renderer needs the package {package!r}, which is not installed",
                remedy=f"pip install {package}",
            )


def _check_usable() -> None:
    """Refuse a machine on which Mitsuba cannot even be imported."""
    probe = _scalar()
    if probe.works:
        return
    remedy = "try python -c 'import mitsuba'; pip install --force-reinstall mitsuba drjit"
    if "libatomic" in probe.detail:
        # Dr.Jit's wheels take it from the system; minimal ones lack it.
        remedy = "Debian, Ubuntu: apt-get install libatomic1; Fedora, RHEL: dnf install libatomic"
    raise RenderError(f"Mitsuba cannot be used on this machine: {probe.detail}", remedy=remedy)


def _import_in_silence() -> None:
    """Import Dr.Jit without what its library prints where it finds no LLVM: we say it in words."""
    if "drjit" in sys.modules:
        return
    sys.stderr.flush()
    kept = os.dup(2)
    try:
        with Path(os.devnull).open("wb") as nowhere:
            os.dup2(nowhere.fileno(), 2)
            import drjit  # noqa: F401
    finally:
        os.dup2(kept, 2)
        os.close(kept)


def _llvm_in_words(backend: Backend | None) -> str:
    if backend is not None:
        return f"works, LLVM {backend.version} ({backend.library})"
    return "not usable: " + "; ".join(f"{one}: {_llvm(one).detail}" for one in _candidates())


def vectorized_remedy() -> str:
    """How to have what the scalar backend lacks."""
    return "use --variant llvm (or cuda)" if _find("llvm") else remedy()


def _scalar_advice() -> str:
    """What a user misses without LLVM, why, and how to get it."""
    named = [one for one in _candidates() if one.origin.startswith("named")]
    why = f" ({named[0]}: {_llvm(named[0]).detail})" if named else ""
    return (
        f"without LLVM{why} rendering takes several times as long, and the only channel of light "
        "is radiance: no light by source, irradiance or environment maps, no probes, no "
        "lightmaps, no "
        f"light cache; to get them, {remedy()}"
    )


@cache
def _fastest() -> Backend:
    backend = _find("cuda") or _find("llvm")
    return backend or Backend(NAMES["scalar"], advice=_scalar_advice())


@cache
def _find(name: str) -> Backend | None:
    if name == "scalar":
        return Backend(NAMES["scalar"])
    if name == "cuda":
        return Backend(NAMES["cuda"]) if _cuda().works else None
    for library in _candidates():
        probe = _llvm(library)
        if probe.works:
            return Backend(NAMES["llvm"], library, probe.detail)
    return None


@cache
def _candidates() -> tuple[Library, ...]:
    """What there was before Dr.Jit was imported here, and a library named."""
    return tuple(libraries())


@cache
def _scalar() -> Probe:
    """Whether Mitsuba can be imported; where another backend works, it can."""
    if _find("cuda") or _find("llvm"):
        return Probe(True, "")
    return _probe(NAMES["scalar"], None)


@cache
def _cuda() -> Probe:
    if not any(ctypes.util.find_library(name) for name in ("cuda", "nvcuda")):
        return Probe(False, "no NVIDIA driver is installed")
    return _probe(NAMES["cuda"], None)


@cache
def _llvm(library: Library) -> Probe:
    if library.too_old:
        old = f"LLVM {library.version[0]} is too old, {LEAST_VERSION} or newer is needed"
        return Probe(False, old)
    if library.path and library.path.is_absolute() and not library.path.is_file():
        return Probe(False, "there is no such file")
    return _probe(NAMES["llvm"], library)


def _probe(variant: str, library: Library | None) -> Probe:
    environment, needed = dict(os.environ), list[str]()
    if library is not None:
        needed = [str(path) for path in library.dependencies]
        if library.path is not None:
            environment[VARIABLE] = str(library.path)
    try:
        done = subprocess.run(
            [sys.executable, "-P", "-c", _PROBE, variant, *needed],
            env=environment,
            capture_output=True,
            encoding="utf-8",
            errors="replace",
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
    if missing := re.search(r"(\S+\.so[.\d]*): cannot open shared object file", output):
        return f"it needs {missing[1]}, which this machine lacks"
    lines = [line.strip() for line in output.splitlines() if line.strip()]
    return f"{lines[-1][:200]} (exit code {code})" if lines else f"exit code {code}"
