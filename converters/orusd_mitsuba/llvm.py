"""Which LLVM library Dr.Jit is given, of those that this machine has.

Dr.Jit loads LLVM while it is imported. By itself it takes the first library in the system's
folders, however old. We name one before that, in this order:

1. what the user names in ``DRJIT_LIBLLVM_PATH``, and then no other;
2. the library of an installed package (`PACKAGES`): pip brings it, and machines with the same
   packages compute the same bytes;
3. the libraries in the system's folders, the newest first;
4. what Dr.Jit finds by itself.

The first one that works is used.
"""

import ctypes
import os
import platform
import re
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from importlib import metadata
from pathlib import Path
from typing import Final

VARIABLE: Final = "DRJIT_LIBLLVM_PATH"
# Older ones abort the whole process: they cannot select instructions that Dr.Jit emits.
LEAST_VERSION: Final = 17

# Packages that carry the library: its name in their lists of files, and what it needs that the
# system's loader may not find beside it, in the order of loading.
PACKAGES: Final[dict[str, tuple[tuple[str, ...], tuple[str, ...]]]] = {
    "llvm-nanobind": (
        ("llvm_nanobind.libs/libLLVM*", "llvm_nanobind.dylibs/*.dylib", "llvm/LLVM.dll"),
        (),
    ),
    "karellen-llvm-core": (
        ("libLLVM.so.*",),
        ("libunwind.so.1.0", "libc++abi.so.1.0", "libc++.so.1.0"),
    ),
}

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


@dataclass(frozen=True)
class Library:
    """An LLVM library to try.

    Attributes:
        path: The file; None for the one that Dr.Jit finds by itself.
        origin: Who brought it, in words.
        dependencies: Libraries to load before it.
        version: As far as its name says; empty where it does not.
    """

    path: Path | None
    origin: str
    dependencies: tuple[Path, ...] = ()
    version: tuple[int, ...] = ()

    @property
    def too_old(self) -> bool:
        """Whether its name says that Mitsuba cannot use it."""
        return bool(self.version) and self.version[0] < LEAST_VERSION

    def __str__(self) -> str:
        """Where it is and who brought it."""
        return f"{self.path}, {self.origin}" if self.path else self.origin

    def prepare(self) -> None:
        """Make Dr.Jit take this library, here and in processes that start from here.

        Raises:
            OSError: A library that it depends on cannot be loaded.
        """
        for path in self.dependencies:
            ctypes.CDLL(str(path))
        if self.path is not None:
            os.environ[VARIABLE] = str(self.path)


def libraries() -> Iterator[Library]:
    """The libraries to try, in order."""
    named = os.environ.get(VARIABLE)
    packaged = _packaged()
    if named:
        known = {str(library.path): library for library in packaged}
        path = Path(named)
        version = _version(path.resolve())
        yield known.get(named) or Library(path, f"named in {VARIABLE}", version=version)
    elif "drjit" in sys.modules:
        yield Library(None, "found by Dr.Jit, which was imported before the first render")
    else:
        yield from packaged
        yield from _installed()
        yield Library(None, "found by Dr.Jit")


def remedy() -> str:
    """How to get a library that works on this machine."""
    package = _package_for_this_machine()
    missing = f"pip install {package}" if package and package not in _versions() else ""
    if os.environ.get(VARIABLE):
        first = f"unset the environment variable {VARIABLE}, or name a library in it that works"
        return f"{first}; then {missing}" if missing else first
    system = (
        f"install LLVM {LEAST_VERSION} or newer (Debian, Ubuntu: apt-get install libllvm19; macOS: "
        f"brew install llvm), or name its library in the environment variable {VARIABLE}"
    )
    return f"{missing}; or {system}" if missing else system


def _package_for_this_machine() -> str | None:
    """The package of `PACKAGES` that has a wheel for this Python and system."""
    machine = f"{sys.platform} {platform.machine().lower()}"
    if machine == "linux x86_64" and sys.version_info < (3, 12):
        return "karellen-llvm-core"
    wheels = ("linux x86_64", "linux aarch64", "darwin arm64", "darwin x86_64", "win32 amd64")
    return "llvm-nanobind" if machine in wheels and sys.version_info >= (3, 12) else None


@cache
def _versions() -> dict[str, str]:
    """Versions of the packages that are installed."""
    found = {}
    for name in PACKAGES:
        try:
            found[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            continue
    return found


@cache
def _packaged() -> tuple[Library, ...]:
    """The libraries that packages of this Python have brought."""
    found = []
    for name, version in _versions().items():
        patterns, needed = PACKAGES[name]
        files = metadata.files(name) or ()
        main = [file for file in files if any(file.match(pattern) for pattern in patterns)]
        before = [file for end in needed for file in files if file.name == end]
        if main:
            path, *first = (Path(str(file.locate())).resolve() for file in (main[0], *before))
            found.append(Library(path, f"package {name} {version}", tuple(first)))
    return tuple(found)


@cache
def _installed() -> tuple[Library, ...]:
    """The libraries in the system's folders, the newest first."""
    found: dict[Path, tuple[int, ...]] = {}
    for folder in _FOLDERS:
        root = Path(Path(folder).anchor)
        for place in root.glob(folder.removeprefix(str(root.as_posix()))):
            for pattern in _LIBRARIES:
                for path in place.glob(pattern):
                    found[path.resolve()] = _version(path.resolve())
    ordered = sorted(found, key=lambda path: (found[path], path.as_posix()), reverse=True)
    return tuple(Library(path, "of the system", version=found[path]) for path in ordered)


def _version(path: Path) -> tuple[int, ...]:
    """The version in a library's name, ``libLLVM.so.19.1``, or folder, ``llvm-18/lib/...``."""
    numbers = re.findall(r"\d+", path.name) or re.findall(r"\d+", path.parent.parent.name)
    return tuple(map(int, numbers))
