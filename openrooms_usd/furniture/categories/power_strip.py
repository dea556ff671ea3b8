"""Strips of sockets with their switch and cable."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import ANY, filled, row
from openrooms_usd.furniture.joinery.boards import board
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style, numbered
from openrooms_usd.furniture.placements import on
from openrooms_usd.furniture.record import STANDARD, BuiltCategory
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.lofts import rounded_rectangle
from openrooms_usd.geometry.mesh import Mesh, joined
from openrooms_usd.geometry.solids import cylinder
from openrooms_usd.geometry.sweeps import extrude, tube
from openrooms_usd.geometry.vectors import points_at

_POWERED: Final = (
    "living_room bedroom office apartment game_room computer_cluster classroom garage hotel "
    "conference_room"
)


def _strip(size: Size, long: float, count: int, plugs: int) -> Parts:
    """Sockets in a row along X over a part of the width; the cable takes the rest."""
    width, depth, height = size
    tall = height if not plugs else height - 0.026
    left = -0.5 * width
    outline = rounded_rectangle(long, depth, 0.4 * depth)
    body = extrude(outline, tall, bevel=0.004).moved((left + 0.5 * long, 0.0, 0.0))
    pitch = (long - 0.09) / count
    radius = min(0.019, 0.42 * pitch)
    wells: list[Mesh] = []
    lids: list[Mesh] = []
    for k in range(count):
        x = left + 0.035 + (k + 0.5) * pitch
        wells.append(cylinder(radius, 0.0012, segments=18, base=(x, 0.0, tall - 0.0006)))
        if k < plugs:
            lids.append(cylinder(0.018, 0.026, bevel=0.004, segments=16, base=(x, 0.0, tall)))
    end = left + long
    switch = board((end - 0.042, -0.009, tall - 0.002), (end - 0.018, 0.009, tall + 0.0008), 0.0008)
    t = np.linspace(0.0, 1.0, 11)
    far = 0.5 * width - 0.004
    path = points_at(
        end - 0.004 + (far - end + 0.004) * t,
        (0.5 * depth - 0.004) * np.sin(3.0 * np.pi * t) * t,
        0.0045,
    )
    parts = {
        "body": body,
        "well": joined(wells),
        "switch": switch,
        "cable": tube(path, 0.004, segments=8),
    }
    return {**parts, **numbered("plug", lids)}


def plain(size: Size, rng: np.random.Generator) -> Parts:
    """A strip with nothing in it."""
    return _strip(size, 0.68 * size[0], 5, 0)


def used(size: Size, rng: np.random.Generator) -> Parts:
    """A strip with two or three plugs."""
    return _strip(size, 0.68 * size[0], 5, int(rng.integers(2, 4)))


CATEGORY: Final = BuiltCategory(
    description="a strip of sockets",
    size=(0.46, 0.056, 0.042),
    min_size=(0.15, 0.03, 0.02),
    max_size=(1.2, 0.15, 0.12),
    styles={"plain": Style(plain), "used": Style(used, size=(0.46, 0.056, 0.068))},
    size_variation=STANDARD,
    alternative_supports=("surface",),
    mass_range=(0.2, 1.2),
    words="socket_strip multi_socket extension_lead surge_protector",
    schemes=(
        scheme("plastic", grey="well", toy_plastic="switch", black_plastic="plug", weight=2.0),
        scheme("black_plastic", cavity="well", toy_plastic="switch"),
    ),
    construction=(row(ANY, filled(700), "common"),),
    placements=(
        on("floor_under_desk", weight=0.9, styles="used", max_groups=1),
        on("floor_by_media", styles="used", max_groups=1),
        on("floor_by_wall", _POWERED, weight=0.25, clutter=2, max_groups=1),
    ),
)
