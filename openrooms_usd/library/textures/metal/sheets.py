"""Metal by the shape that a press, a roll or a loom gave it."""

from typing import Final

import numpy as np

from openrooms_usd.library.textures.base import vocabulary as tx
from openrooms_usd.library.textures.metal.metals import (
    ALUMINIUM,
    BRASS,
    BRONZE,
    STEEL,
    ZINC,
    bare,
    drawn_metal,
)

# What one sees through a hole: nothing that reflects.
_VOID: Final = 0.02


def _places(order: tx.TextureParams) -> tuple[tx.Field, tx.Field]:
    """Places of the texels along s, and up along t as a column, in shares of the side."""
    place = (np.arange(order.resolution) + 0.5) / order.resolution
    return place, 1.0 - place[:, None]


def tread_plate(order: tx.TextureParams) -> tx.Maps:
    """Floor plate: lozenges of 26 x 6 mm, 1.5 mm high, that lie crosswise by turns."""
    metal, matt = drawn_metal(order, STEEL, ALUMINIUM), tx.drawn_roughness(order, 0.3, 0.45)
    count = tx.whole(order.size, 0.028, 2)
    pitch = order.size / count
    s, t = (place * count for place in _places(order))
    column, row = np.floor(s), np.floor(t)
    across, up = (s - column - 0.5) * pitch, (t - row - 0.5) * pitch
    turned = np.where((column + row) % 2 == 0, 1.0, -1.0)
    along, beside = (across + turned * up) / np.sqrt(2.0), (up - turned * across) / np.sqrt(2.0)
    # Two arcs of a circle meet at the ends of a lozenge 26 mm long and 6 mm wide.
    half_long, half_wide = 0.46 * pitch, 0.105 * pitch
    radius = (half_long**2 + half_wide**2) / (2.0 * half_wide)
    inside = radius - np.hypot(along, np.abs(beside) + radius - half_wide)
    raised = tx.smoothstep(-0.0006, 0.0016, inside)
    wear = raised * tx.smoothstep(-1.0, 1.0, tx.fractal(order, 0.04, 0.4))
    roll, fine = tx.noise(order, 0.002, 0.03), tx.fractal(order, 0.004, 0.2)
    shade = 1.0 + 0.02 * fine + 0.02 * roll - 0.10 * (1.0 - raised) + 0.04 * wear
    height = 0.0015 * raised + 4e-6 * fine + 3e-6 * roll
    return bare(order, metal, shade, height, matt + 0.02 * fine - 0.10 * wear)


def perforated_sheet(order: tx.TextureParams) -> tx.Maps:
    """Round holes of 5 mm, 8 mm apart in rows shifted by half."""
    metal, matt = drawn_metal(order, STEEL, ALUMINIUM, BRASS), tx.drawn_roughness(order, 0.25, 0.4)
    holes = tx.hexagons(order, 0.008)
    outside = holes.radius - 0.0025
    solid = tx.covered(order, outside)
    bevel = tx.smoothstep(0.0, 0.0005, outside)
    grain = tx.noise(order, 0.0008, 0.05)
    shade = (1.0 + 0.02 * grain)[..., None] * metal
    albedo = tx.mixed(solid, shade, np.full((1, 1, 3), _VOID))
    height = solid * (0.0013 + 0.0002 * bevel + 1.5e-6 * grain)
    rough = solid * (matt + 0.02 * grain) + (1.0 - solid) * 0.95
    return tx.finished(order, albedo, height, rough, solid)


def corrugated_sheet(order: tx.TextureParams) -> tx.Maps:
    """Wavy sheet of 76 mm pitch and 18 mm depth, waves along t, faintly streaked."""
    metal, matt = drawn_metal(order, ZINC, ALUMINIUM, STEEL), tx.drawn_roughness(order, 0.3, 0.5)
    waves = tx.whole(order.size, 0.076)
    s, _ = _places(order)
    wave = np.cos(2.0 * np.pi * waves * s)
    streak, cloud = tx.noise(order, 0.01, 0.5), tx.fractal(order, 0.1, 0.3)
    shade = 0.97 + 0.02 * streak + 0.025 * cloud + 0.02 * wave
    height = 0.009 * wave + 0.0002 * tx.noise(order, 0.2) + 4e-6 * cloud
    return bare(order, metal, shade, height, matt + 0.03 * cloud + 0.02 * streak)


def knurled_metal(order: tx.TextureParams) -> tx.Maps:
    """Diamonds pressed by a knurling tool, 1.6 mm apart, tips a little flat."""
    metal, matt = drawn_metal(order, STEEL, BRASS, ALUMINIUM), tx.drawn_roughness(order, 0.2, 0.32)
    columns = tx.whole(order.size, 0.0016 * 2.0 * np.sin(np.radians(30.0)) * 1.2)
    rows = tx.whole(order.size, 0.0016 * 2.0 * np.cos(np.radians(30.0)) * 1.2)
    s, t = _places(order)
    left, right = columns * s + rows * t, columns * s - rows * t
    ridge = np.minimum(_tooth(left), _tooth(right))
    tip, root = tx.smoothstep(0.6, 0.9, ridge), 1.0 - tx.smoothstep(0.0, 0.3, ridge)
    fine = tx.fractal(order, 0.002, 0.2)
    shade = 1.0 + 0.02 * fine - 0.2 * root
    height = 0.00035 * np.minimum(ridge, 0.8) + 1.5e-6 * fine
    return bare(order, metal, shade, height, matt + 0.12 * root - 0.04 * tip + 0.01 * fine)


def _tooth(phase: tx.Field) -> tx.Field:
    """0 in each furrow, 1 on each ridge, straight between."""
    return np.asarray(2.0 * np.abs(phase - np.rint(phase)))


def wire_mesh(order: tx.TextureParams) -> tx.Maps:
    """Plain woven wire of 0.9 mm, 3 mm apart; dark behind."""
    metal, matt = drawn_metal(order, STEEL, BRASS, BRONZE), tx.drawn_roughness(order, 0.2, 0.35)
    wires = tx.whole(order.size, 0.003, 2)
    pitch, radius = order.size / wires, 0.00045
    s, t = (place * wires for place in _places(order))
    number_s, number_t = np.floor(s), np.floor(t)
    beside_s, beside_t = (s - number_s - 0.5) * pitch, (t - number_t - 0.5) * pitch
    # A wire rises over one crossing and dips under the next.
    warp = _wire(beside_s, radius) + radius * np.cos(np.pi * (t - 0.5 + number_s))
    weft = _wire(beside_t, radius) - radius * np.cos(np.pi * (s - 0.5 + number_t))
    inside = radius - np.minimum(np.abs(beside_s), np.abs(beside_t))
    solid = tx.covered(order, inside)
    top = np.fmax(warp, weft)
    drawn = np.where(
        np.nan_to_num(warp, nan=-1.0) > np.nan_to_num(weft, nan=-1.0),
        tx.noise(order, 0.0004, 0.03),
        tx.noise(order, 0.03, 0.0004),
    )
    low = np.clip(0.5 - 0.5 * np.nan_to_num(top) / radius, 0.0, 1.0)
    shade = np.minimum(1.0 + 0.03 * drawn - 0.15 * low, 1.05)[..., None] * metal
    height = np.where(np.isnan(top), -2.0 * radius, np.nan_to_num(top))
    rough = solid * (matt + 0.02 * drawn) + (1.0 - solid) * 0.95
    return tx.finished(
        order, tx.mixed(solid, shade, np.full((1, 1, 3), _VOID)), height, rough, solid
    )


def _wire(beside: tx.Field, radius: float) -> tx.Field:
    """Height of a round wire over its axis; nan beside it."""
    with np.errstate(invalid="ignore"):
        return np.asarray(np.sqrt(radius**2 - beside**2))


def pressed_tin(order: tx.TextureParams) -> tx.Maps:
    """Tin panels of 0.3 m with a pressed frame, a rosette and beads: ceilings of around 1900."""
    metal, matt = drawn_metal(order, ZINC, STEEL, BRONZE), tx.drawn_roughness(order, 0.3, 0.45)
    count = tx.whole(order.size, 0.305)
    pitch = order.size / count
    s, t = (place * count for place in _places(order))
    across, up = s - np.floor(s) - 0.5, t - np.floor(t) - 0.5
    edge = 0.5 - np.maximum(np.abs(across), np.abs(up))
    radius, angle = np.hypot(across, up), np.arctan2(up, across)
    frame = _bead(edge, 0.03, 0.018) + 0.7 * _bead(edge, 0.085, 0.012)
    petal = 0.20 + 0.07 * np.cos(8.0 * angle)
    flower = tx.smoothstep(0.0, 0.05, petal - radius) * (0.6 + 0.4 * np.cos(8.0 * angle))
    flower = flower + 0.8 * tx.smoothstep(0.055, 0.02, radius) + 0.7 * _bead(radius, 0.33, 0.014)
    corner = np.hypot(0.5 - np.abs(across) - 0.14, 0.5 - np.abs(up) - 0.14)
    relief = frame + flower + 0.8 * tx.smoothstep(0.045, 0.01, corner)
    fine, cloud = tx.fractal(order, 0.006, 0.2), tx.fractal(order, 0.2, 0.4)
    hollow = 1.0 - np.clip(relief, 0.0, 1.0)
    shade = 1.0 - 0.14 * hollow + 0.02 * fine + 0.02 * cloud
    height = 0.016 * pitch * relief + 5e-6 * fine + 0.0002 * tx.noise(order, 0.3)
    return bare(order, metal, shade, height, matt + 0.08 * hollow + 0.02 * cloud)


def _bead(distance: tx.Field, at: float, width: float) -> tx.Field:
    """A round bead along a line of constant distance."""
    return np.asarray(np.sqrt(np.clip(1.0 - ((distance - at) / width) ** 2, 0.0, 1.0)))


FAMILIES: Final[dict[str, tx.Family]] = {
    "tread_plate": tx.Family(tread_plate, 0.56, frozenset({"floor", "object"}), metallic=1.0),
    "perforated_sheet": tx.Family(
        perforated_sheet, 0.16, frozenset({"furniture", "object"}), metallic=None
    ),
    "corrugated_sheet": tx.Family(
        corrugated_sheet, 0.76, frozenset({"wall", "ceiling"}), grain=True, metallic=1.0
    ),
    "knurled_metal": tx.Family(knurled_metal, 0.04, frozenset({"object"}), metallic=1.0),
    "wire_mesh": tx.Family(wire_mesh, 0.06, frozenset({"furniture", "object"}), metallic=None),
    "pressed_tin": tx.Family(pressed_tin, 0.915, frozenset({"ceiling", "wall"}), metallic=1.0),
}
