"""Small pictures of materials: a ball that wears one repeat, lit from the upper left.

They are computed from the maps alone, without a renderer: a Lambertian term and Blinn's highlight,
as wide as the roughness says. The same material gives the same bytes.
"""

import hashlib
import json
from contextlib import suppress
from dataclasses import asdict
from typing import Final

import numpy as np

from openrooms_usd import atomic
from openrooms_usd.arrays import Array, Bytes
from openrooms_usd.codedigest import code_digest
from openrooms_usd.colorimetry import linear_from_srgb, srgb_from_linear
from openrooms_usd.errors import OutputError
from openrooms_usd.imagefile import is_whole, write_png
from openrooms_usd.library.textures import Color, Material, TextureSet, make
from openrooms_usd.scratch import scratch_folder
from openrooms_usd.usercache import cache_folder

SIZE: Final = 72
"""Pixels along each side."""

_FOLDER: Final = "thumbnails"
_TEXELS: Final = 128
# Towards the light, and halfway between it and the eye, in the picture's axes (y up, z to the eye).
_LIGHT: Final = np.array([-0.48, 0.62, 0.62])
_AMBIENT: Final = 0.32
_F0: Final = 0.04


def thumbnail(
    family: str, number: int = 0, color: Color | None = None, roughness: float | None = None
) -> bytes:
    """The picture of a material, as a PNG with an alpha channel.

    Args:
        family: Its family.
        number: Which of its family.
        color: Its mean base colour, scene-linear Rec.709; None: its own.
        roughness: Its mean perceptual roughness; None: its own.

    Raises:
        InputError: There is no such family.
    """
    material = Material(family, number, color, roughness, _TEXELS)
    said = json.dumps([code_digest(__name__), material.entry, SIZE])
    folder = cache_folder(_FOLDER)
    entry = folder / f"{hashlib.sha256(said.encode()).hexdigest()}.png" if folder else None
    if entry and entry.is_file() and is_whole(entry):
        return entry.read_bytes()
    pixels = ball(make(**asdict(material)))
    with scratch_folder() as scratch:
        file = scratch / "ball.png"
        write_png(file, pixels)
        data = file.read_bytes()
    if entry:
        with suppress(OSError, OutputError):
            atomic.write_bytes(entry, data)
    return data


def ball(maps: TextureSet) -> Bytes:
    """(SIZE, SIZE, 4) a ball that wears a material, encoded as sRGB.

    Args:
        maps: The material.
    """
    axis = (np.arange(SIZE) + 0.5) / SIZE * 2.04 - 1.02
    x, y = np.meshgrid(axis, -axis)
    inside = x**2 + y**2 < 1.0
    z = np.sqrt(np.clip(1.0 - x**2 - y**2, 0.0, 1.0))
    normal, color, rough, metal = _sample_maps(maps, np.stack([x, y, z], axis=-1))
    light = _LIGHT / np.linalg.norm(_LIGHT)
    half = light + np.array([0.0, 0.0, 1.0])
    lit = np.clip(normal @ light, 0.0, 1.0)
    power = 2.0 / np.clip(rough, 0.08, 1.0) ** 4 - 1.0
    gloss = np.clip(normal @ (half / np.linalg.norm(half)), 0.0, 1.0) ** power
    gloss = gloss * np.minimum((power + 8.0) / 40.0, 4.0)
    f0 = _F0 + (color - _F0) * metal[..., None]
    body = color * (1.0 - 0.6 * metal)[..., None] * (_AMBIENT + lit)[..., None]
    shown = srgb_from_linear(np.clip(body + f0 * (gloss * (lit > 0.0))[..., None], 0.0, 1.0))
    alpha = np.where(inside, 255.0, 0.0)[..., None]
    pixels = np.rint(np.concatenate([shown * 255.0, alpha], axis=-1))
    return np.asarray(pixels, np.uint8)


def _sample_maps(maps: TextureSet, place: Array) -> tuple[Array, Array, Array, Array]:
    """Normal, linear base colour, roughness and metalness at points of a unit ball (..., 3)."""
    side = maps.albedo.shape[0]
    # Half a turn shows one repeat; latitude and longitude stretch it a little at the rim.
    s = np.arctan2(place[..., 0], np.maximum(place[..., 2], 1e-6)) / np.pi + 0.5
    t = np.arcsin(np.clip(place[..., 1], -1.0, 1.0)) / np.pi + 0.5
    column = np.clip((s * side).astype(int), 0, side - 1)
    row = np.clip(((1.0 - t) * side).astype(int), 0, side - 1)
    # The tangents of these coordinates on the ball.
    along = np.stack([place[..., 2], np.zeros_like(s), -place[..., 0]], axis=-1)
    along /= np.maximum(np.linalg.norm(along, axis=-1, keepdims=True), 1e-6)
    up = np.cross(place, along)
    bent = maps.normal[row, column].astype(np.float64) / 127.5 - 1.0
    normal = bent[..., :1] * along + bent[..., 1:2] * up + np.maximum(bent[..., 2:], 0.1) * place
    normal /= np.maximum(np.linalg.norm(normal, axis=-1, keepdims=True), 1e-6)
    color = linear_from_srgb(maps.albedo[row, column].astype(np.float64) / 255.0)
    rough = maps.roughness[row, column].astype(np.float64) / 255.0
    return normal, color, rough, maps.metallic[row, column].astype(np.float64) / 255.0
