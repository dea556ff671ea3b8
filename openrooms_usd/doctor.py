"""What this machine can do for the toolkit, and what it lacks."""

import os
import platform
import re
import sys
from dataclasses import asdict, dataclass
from importlib import import_module, metadata
from typing import Any, Final

from openrooms_usd import adapters
from openrooms_usd.errors import OrusdError
from openrooms_usd.usercache import cache_folder
from openrooms_usd.version import __version__

_DISTRIBUTION: Final = "openrooms-usd"
INSTALLED: Final = "installed"
"""The state of a renderer that says nothing of itself."""

# Ray casters from the fastest to the slowest: what to import, what it is, what to do about it.
_RAY_CASTERS: Final = (
    ("embreex.rtcore_scene", "Embree", ""),
    ("rtree", "trimesh with rtree, many times slower than Embree", "pip install embreex"),
)

_KINDS: Final = (
    adapters.IMPORTERS,
    adapters.RENDERERS,
    adapters.EXPORTERS,
    adapters.ENGINES,
    adapters.SEGMENTERS,
    adapters.DATASETS,
    adapters.EXECUTORS,
)


@dataclass(frozen=True)
class Diagnosis:
    """What was found.

    Attributes:
        system: Versions of this package and of Python, the platform, the processor's cores, where
            caches lie.
        packages: Version of each required package; None where it is not installed.
        extras: What the package of each extra is: its version, or how to install it.
        ray_caster: What casts the core's rays; None where nothing can.
        adapters: Names of the installed adapters by kind, such as importers.
        renderers: By renderer: what each of its backends says about this machine.
        remedies: What to do, in words; empty when nothing is missing.
    """

    system: dict[str, str]
    packages: dict[str, str | None]
    extras: dict[str, str]
    ray_caster: str | None
    adapters: dict[str, list[str]]
    renderers: dict[str, dict[str, str]]
    remedies: list[str]

    @property
    def healthy(self) -> bool:
        """Whether everything that the toolkit needs is there."""
        unusable = any("state" in s and s["state"] != INSTALLED for s in self.renderers.values())
        return None not in (*self.packages.values(), self.ray_caster) and not unusable

    def as_dict(self) -> dict[str, Any]:
        """Everything as plain data."""
        return {**asdict(self), "healthy": self.healthy}


def diagnose() -> Diagnosis:
    """Look at this machine; nothing is changed, and no renderer stays loaded."""
    remedies: list[str] = []
    return Diagnosis(
        system=_system(),
        packages=_packages(remedies),
        extras=_extras(),
        ray_caster=_ray_caster(remedies),
        adapters={kind.rpartition(".")[2]: list(adapters.available(kind)) for kind in _KINDS},
        renderers=_renderers(remedies),
        remedies=remedies,
    )


def _system() -> dict[str, str]:
    textures = cache_folder("textures")
    return {
        "openrooms_usd": __version__,
        "python": platform.python_version(),
        "platform": platform.platform(terse=True),
        "machine": platform.machine(),
        "cores": str(os.cpu_count() or 1),
        "caches": str(textures.parent) if textures else "switched off",
    }


def _version(package: str) -> str | None:
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return None


def _requirements() -> list[str]:
    """What the distribution requires, as its metadata say it."""
    try:
        return metadata.requires(_DISTRIBUTION) or []
    except metadata.PackageNotFoundError:
        return []


def _name(requirement: str) -> str:
    return re.split(r"[^A-Za-z0-9._-]", requirement, maxsplit=1)[0]


def _extras() -> dict[str, str]:
    """The packages that only an extra brings; nothing is missing without them."""
    found = {}
    for line in _requirements():
        older = re.search(r"python_version < ['\"]3\.(\d+)['\"]", line)
        if older and sys.version_info >= (3, int(older[1])):
            continue  # it has no wheel for this Python
        if extra := re.search(r"extra == ['\"]([\w-]+)['\"]", line):
            name = _name(line)
            missing = f"not installed: pip install {_DISTRIBUTION}[{extra[1]}]"
            found[f"{extra[1]} ({name})"] = _version(name) or missing
    return found


def _packages(remedies: list[str]) -> dict[str, str | None]:
    """Versions of what the distribution requires everywhere."""
    required = _requirements()
    if not required:
        remedies.append("install the package itself: pip install -e . in its folder")
    names = sorted({_name(line) for line in required if ";" not in line}, key=str.lower)
    versions = {name: _version(name) for name in names}
    remedies += [f"pip install {name}" for name, version in versions.items() if version is None]
    return versions


def _ray_caster(remedies: list[str]) -> str | None:
    for module, words, remedy in _RAY_CASTERS:
        try:
            import_module(module)
        except ImportError:
            continue
        if remedy:
            remedies.append(remedy)
        return f"{words} ({module.partition('.')[0]} {_version(module.partition('.')[0])})"
    remedies.append("pip install embreex, or where it has no wheel: pip install rtree")
    return None


def _renderers(remedies: list[str]) -> dict[str, dict[str, str]]:
    """What each renderer says; one that cannot be loaded says why."""
    said: dict[str, dict[str, str]] = {}
    for name in adapters.available(adapters.RENDERERS):
        try:
            examine = getattr(adapters.load(adapters.RENDERERS, name), "diagnose", None)
            said[name] = dict(examine()) if examine else {"state": INSTALLED}
        except OrusdError as error:
            said[name] = {"state": f"not usable: {error.message}"}
            if error.remedy:
                remedies.append(error.remedy)
    return said
