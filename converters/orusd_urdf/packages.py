"""Optional packages, asked for by name and missed in words."""

from importlib import import_module
from typing import Any, Final

from openrooms_usd.errors import MissingPackageError

_OTHERWISE: Final = {"pybullet": "; for Python 3.12 and newer use the engine mujoco"}


def needed(name: str) -> Any:
    """Import an engine's package.

    Raises:
        MissingPackageError: It is not installed.
    """
    try:
        return import_module(name)
    except ImportError as error:
        raise MissingPackageError(
            f"the package {name!r} cannot be imported ({error})",
            remedy='pip install "openrooms-usd[physics]"' + _OTHERWISE.get(name, ""),
        ) from error
