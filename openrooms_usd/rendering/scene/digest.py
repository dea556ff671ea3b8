"""A digest of what determines a scene's light: equal where equal light would be computed."""

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import fields, is_dataclass
from typing import Any, Final

import numpy as np

from openrooms_usd.rendering.scene.arrays import Scene
from openrooms_usd.rendering.scene.sources import sources_of

# Fields that are for people.
_SAYS_NOTHING: Final = frozenset({"losses", "primvar"})


def light_digest(scene: Scene, *settings: Any) -> str:
    """A digest of surfaces, textures, lights and their numbers, and of whatever else counts.

    Labels and reports do not count, but for those that number the lights.

    Args:
        scene: The translated stage.
        settings: Plain data: numbers, texts, sequences, mappings, arrays, dataclasses.

    Returns:
        64 hexadecimal digits, the same in every process.

    Raises:
        TypeError: A setting is not plain data.
    """
    lit = (
        scene.patches,
        scene.panes,
        scene.environment,
        scene.suns,
        scene.portals,
        sources_of(scene),
    )
    return _digest((lit, settings), {}).hex()


def _digest(value: Any, known: dict[int, bytes]) -> bytes:
    """The digest of a value, by those of its parts.

    Args:
        value: What is asked for.
        known: Digests of objects that live as long as this lasts, by their identity: patches
            share surfaces, and those share pictures.
    """
    if id(value) in known:
        return known[id(value)]
    found = hashlib.blake2b(digest_size=32)
    if isinstance(value, np.ndarray):
        found.update(f"array {value.dtype.str} {value.shape}".encode())
        found.update(np.ascontiguousarray(value).data)
    elif is_dataclass(value) and not isinstance(value, type):
        found.update(type(value).__name__.encode())
        for field in fields(value):
            if field.name not in _SAYS_NOTHING:
                found.update(f" {field.name} ".encode())
                found.update(_digest(getattr(value, field.name), known))
    elif isinstance(value, Mapping):
        found.update(b"mapping")
        for name in sorted(value):
            found.update(_digest(name, known) + _digest(value[name], known))
    elif isinstance(value, Sequence) and not isinstance(value, str | bytes):
        found.update(b"sequence")
        for part in value:
            found.update(_digest(part, known))
    elif value is None or isinstance(value, bool | int | float | str | np.generic):
        plain = value.item() if isinstance(value, np.generic) else value
        found.update(f"{type(plain).__name__} {plain!r}".encode())
    else:
        raise TypeError(f"{type(value).__name__} is not plain data")
    if isinstance(value, np.ndarray) or is_dataclass(value):
        known[id(value)] = found.digest()
    return found.digest()
