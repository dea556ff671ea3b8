"""How the texture lies on the parts of furniture: along the grain, and elsewhere on each part."""

import hashlib
from collections.abc import Mapping
from typing import Final

import numpy as np

from openrooms_usd.geometry.grain import LONG_RATIO, along_grain, shifted
from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.library.styles.assignment.kinds import kind_of
from openrooms_usd.tables import read_table

_TABLES: Final = read_table(__file__, "timber.toml")
_SOFT: Final = frozenset(_TABLES["soft"])
_BOARDS: Final = frozenset(_TABLES["boards"])
# The grain of these is upright, however wide they are.
_UPRIGHT: Final = frozenset({"door"})
# Of one sheet, sawn where the gaps are: their texture goes on from one to the next.
_SHEET: Final = frozenset({"door", "drawer_front"})
# Tiles begin where they are laid.
_LAID: Final = frozenset({"panel"})
# Parts take their texture from anywhere within so many metres.
_REACH_M: Final = 2.0


def grained(parts: Mapping[str, Mesh]) -> dict[str, Mesh]:
    """Parts whose textures follow the grain of wood, no two of them cut from the same place.

    Args:
        parts: Meshes by name, in the object frame.
    """
    return {name: _laid(name, mesh) for name, mesh in parts.items()}


def follow_grain(name: str, mesh: Mesh) -> Mesh:
    """A part whose texture runs along its grain; cloth stays as it was laid."""
    kind = kind_of(name)
    if kind in _SOFT:
        return mesh
    return along_grain(mesh, upright=kind in _UPRIGHT, ends=kind in _BOARDS)


def _place_on_sheet(mesh: Mesh, *, upright: bool) -> tuple[float, float]:
    """Where a front has been sawn from its sheet, (s, t) metres: where it hangs."""
    low, high = mesh.extent
    x, _, z = (0.5 * (low + high)).tolist()
    lying = not upright and high[0] - low[0] > LONG_RATIO * (high[2] - low[2])
    return (-z, x) if lying else (x, z)


def _laid(name: str, mesh: Mesh) -> Mesh:
    kind = kind_of(name)
    if kind in _LAID:
        return mesh
    mesh = follow_grain(name, mesh)
    if kind in _SHEET:
        return shifted(mesh, _place_on_sheet(mesh, upright=kind in _UPRIGHT))
    words = np.frombuffer(hashlib.sha256(name.encode()).digest()[:8], dtype="<u4")
    return shifted(mesh, _REACH_M * words / 2.0**32)
