"""Families of plastic in sheets: laminates, floors of vinyl and linoleum, foils."""

from dataclasses import replace
from typing import Final

import numpy as np

from openrooms_usd.library.textures.base import vocabulary as tx
from openrooms_usd.library.textures.wood.boards import planks, staves
from openrooms_usd.library.textures.wood.species import ASH, OAK
from openrooms_usd.library.textures.wood.timber import face
from openrooms_usd.tables import read_table

_PALETTES: Final = read_table(__file__, "palettes.toml")

FLOORS: Final[tuple[tx.Color, ...]] = _PALETTES["sheets_floors"]


def _wood_laminate(order: tx.TextureParams) -> tx.Maps:
    """Laminate with a printed ash: the press plate's ticks lie where they like."""
    wood = face(order, staves(order, (0.3, 0.4), mirrored=True), replace(ASH, pores=0.2))
    tick = tx.smoothstep(1.3, 2.0, tx.noise(order, 0.0007, 0.014))
    albedo = wood.colored(order, ASH)
    roughness = tx.drawn_roughness(order, 0.4, 0.55) + 0.1 * tick
    return tx.finished(order, albedo, -45e-6 * tick, roughness)


def _vinyl_planks(order: tx.TextureParams) -> tx.Maps:
    """Planks of vinyl with a printed oak, embossed in register, bevelled and painted edges."""
    boards = planks(order, (0.18, 0.18), (1.2, 1.2))
    wood = face(
        order, boards, replace(OAK, late=0.2, cut="flat", knots=2.0, knot=(0.012, 0.02)), 0.07
    )
    groove = boards.bevel(3e-3)
    albedo = wood.colored(order, OAK) * (1.0 - 0.35 * groove)[..., None]
    height = 4.0 * wood.height - 0.5e-3 * groove
    return tx.finished(
        order, albedo, height, tx.drawn_roughness(order, 0.45, 0.6) + 2.0 * wood.gloss
    )


def _marbled(order: tx.TextureParams) -> tx.Maps:
    """Linoleum: granules of several colours rolled out along t into flames."""
    flow = 0.012 * tx.noise(order, 0.05, 0.15), 0.02 * tx.noise(order, 0.05, 0.15)
    flame = tx.displaced(
        tx.noise(order, 0.006, 0.05) + 0.5 * tx.noise(order, 0.002, 0.012), order, *flow
    )
    dark = tx.smoothstep(0.4, 1.6, flame)
    light = tx.smoothstep(0.5, 1.7, -flame)
    accent = tx.smoothstep(1.4, 2.1, tx.displaced(tx.noise(order, 0.004, 0.02), order, *flow))
    color = tx.drawn_color(order, FLOORS)
    even = np.broadcast_to(color, (*flame.shape, 3))
    albedo = tx.mixed(dark, 0.62 * color, tx.mixed(light, 1.3 * color, even))
    albedo = tx.mixed(0.6 * accent, color * np.array((1.5, 1.3, 1.0)), albedo)
    height = 2e-6 * tx.noise(order, 0.0015) + 20e-6 * tx.noise(order, 0.04)
    return tx.finished(order, albedo, height, tx.drawn_roughness(order, 0.4, 0.55) + 0.02 * dark)


def _composition_tiles(order: tx.TextureParams) -> tx.Maps:
    """Vinyl composition tiles: a foot square, streaks turned from tile to tile."""
    tiles = tx.bond(order, (0.305, 0.305))
    streak = tx.smoothstep(
        0.7,
        1.9,
        tx.shifted_per_piece(order, tx.noise(order, 0.003, 0.03), tiles.index, tiles.count),
    )
    crossed = tx.smoothstep(
        0.7,
        1.9,
        tx.shifted_per_piece(order, tx.noise(order, 0.03, 0.003), tiles.index, tiles.count),
    )
    turned = order.rng.permutation(tiles.count)[tiles.index] % 2 == 0
    mottle = np.where(turned, streak, crossed)
    dot = tx.smoothstep(1.6, 1.9, tx.noise(order, 0.004))
    tone = order.rng.uniform(-0.03, 0.03, tiles.count)[tiles.index]
    seam = tx.smoothstep(0.0006, -0.0002, tiles.inside(0.0004))
    color = tx.drawn_color(order, FLOORS[:5])
    shade = (1.0 + tone - 0.25 * mottle) * (1.0 - 0.4 * seam)
    albedo = tx.mixed(dot, 1.5 * color, color * shade[..., None])
    scuff = tx.fractal(order, 0.4, 0.4)
    height = -40e-6 * seam + 8e-6 * tx.noise(order, 0.03)
    return tx.finished(order, albedo, height, tx.drawn_roughness(order, 0.3, 0.45) + 0.03 * scuff)


def _chip_vinyl(order: tx.TextureParams) -> tx.Maps:
    """Vinyl with chips rolled flat, as terrazzo looks but without its polish and relief."""
    large = tx.chips(order, 0.55, (0.003, 0.011))
    palette = np.array(
        [(0.62, 0.6, 0.55), (0.2, 0.19, 0.18), (0.42, 0.33, 0.24), (0.75, 0.74, 0.72)]
    )
    chosen = palette[order.rng.integers(len(palette), size=large.count)]
    chip = tx.smoothstep(-0.0001, 0.0003, large.inside)
    sand = tx.smoothstep(0.9, 1.3, tx.noise(order, 0.0012))
    color = tx.drawn_color(order, FLOORS)
    ground = color * (1.0 + 0.35 * sand)[..., None]
    albedo = tx.mixed(chip, chosen[large.index], ground)
    height = 12e-6 * tx.noise(order, 0.0018)
    return tx.finished(order, albedo, height, tx.drawn_roughness(order, 0.38, 0.5))


def _anti_slip(order: tx.TextureParams) -> tx.Maps:
    """Raised lozenges, each turned against its neighbours, on a matt ground."""
    count = tx.whole(order.size, 0.018, 2)
    place = (np.arange(order.resolution) + 0.5) / order.resolution * count
    s, t = place[None, :], place[:, None]
    side = np.where((np.floor(s) + np.floor(t)) % 2 == 0, 1.0, -1.0)
    x, y = s % 1.0 - 0.5, 0.5 - t % 1.0
    along, across = (x + side * y) / np.sqrt(2.0), (y - side * x) / np.sqrt(2.0)
    inside = 1.0 - np.abs(along) / 0.46 - np.abs(across) / 0.13
    bar = tx.smoothstep(0.0, 0.35, inside)
    fine = tx.noise(order, 0.0007)
    color = tx.drawn_color(order, ((0.11, 0.11, 0.115), (0.045, 0.045, 0.047), (0.24, 0.25, 0.26)))
    shade = 1.0 + 0.05 * fine + 0.10 * bar
    height = 0.9e-3 * bar + 8e-6 * fine
    return tx.finished(
        order, color * shade[..., None], height, tx.drawn_roughness(order, 0.5, 0.65) - 0.1 * bar
    )


def _studded(order: tx.TextureParams) -> tx.Maps:
    """Round flat studs in rows, as of the floors of stations."""
    count = tx.whole(order.size, 0.033)
    place = (np.arange(order.resolution) + 0.5) / order.resolution * count % 1.0 - 0.5
    far = np.hypot(place[None, :], place[:, None]) * (order.size / count)
    stud = tx.smoothstep(0.0130, 0.0118, far)
    scuff = tx.fractal(order, 0.15, 0.4)
    fine = tx.noise(order, 0.001)
    color = tx.drawn_color(order, FLOORS)
    shade = 1.0 + 0.025 * scuff + 0.02 * fine
    roughness = tx.drawn_roughness(order, 0.45, 0.6) + 0.03 * scuff - 0.08 * stud
    return tx.finished(order, color * shade[..., None], 0.6e-3 * stud + 6e-6 * fine, roughness)


def _carbon_look(order: tx.TextureParams) -> tx.Maps:
    """Tows of fibre, two over two, under a clear coat that hides their relief."""
    count = tx.whole(order.size, 0.0022, 4)
    place = (np.arange(order.resolution) + 0.5) / order.resolution * count
    s, t = place[None, :], place[:, None]
    warp = (np.floor(s) + np.floor(t)) % 4 < 2
    across = np.where(warp, s % 1.0, t % 1.0) - 0.5
    fibre = np.where(warp, tx.noise(order, 0.00022, 0.01), tx.noise(order, 0.01, 0.00022))
    # The tow leans where it goes under: that is what glints.
    lean = np.where(warp, (t - s) % 4.0, (s - t) % 4.0)
    shade = (1.0 + 0.16 * fibre) * np.where(warp, 1.45, 0.62) * (1.0 - 0.8 * np.abs(across) ** 2)
    shade = shade * (0.9 + 0.2 * np.abs(np.sin(0.25 * np.pi * lean)))
    color = tx.drawn_color(order, ((0.045, 0.046, 0.048), (0.06, 0.06, 0.062)), 0.08)
    albedo = np.maximum(color * shade[..., None], 0.02)
    height = 2e-6 * tx.noise(order, 0.01)
    return tx.finished(order, albedo, height, tx.drawn_roughness(order, 0.08, 0.16))


def _corrugated(order: tx.TextureParams) -> tx.Maps:
    """Twin-wall sheet: broad flutes along t with a web between each two."""
    count = tx.whole(order.size, 0.012)
    place = (np.arange(order.resolution) + 0.5) / order.resolution * count % 1.0 - 0.5
    sag = np.cos(2.0 * np.pi * place)[None, :]
    web = tx.smoothstep(0.42, 0.48, np.abs(place))[None, :]
    wave = tx.noise(order, 0.03, 0.2)
    color = tx.drawn_color(order, ((0.62, 0.66, 0.67), (0.7, 0.72, 0.72), (0.3, 0.45, 0.5)))
    shade = 1.0 + 0.04 * sag - 0.2 * web + 0.008 * wave
    height = 60e-6 * sag - 50e-6 * web + 25e-6 * wave
    return tx.shaded(order, color, shade, height, (0.15, 0.28))


def _tarpaulin(order: tx.TextureParams) -> tx.Maps:
    """Coated fabric: a square net of threads shows through the foil."""
    count = tx.whole(order.size, 0.0022)
    place = (np.arange(order.resolution) + 0.5) / order.resolution * count % 1.0 - 0.5
    s, t = 0.5 - np.abs(place)[None, :], 0.5 - np.abs(place)[:, None]
    net = np.maximum(tx.smoothstep(0.22, 0.45, s), tx.smoothstep(0.22, 0.45, t))
    fold = tx.noise(order, 0.05)
    color = tx.drawn_color(
        order, ((0.6, 0.6, 0.58), (0.07, 0.13, 0.25), (0.1, 0.2, 0.13), (0.5, 0.38, 0.08))
    )
    shade = 1.0 + 0.05 * net + 0.01 * fold
    height = 45e-6 * net + 120e-6 * fold + 2e-6 * tx.noise(order, 0.0006)
    return tx.shaded(order, color, shade, height, (0.3, 0.45))


_FLOOR: Final[frozenset[tx.Use]] = frozenset({"floor"})
_OBJECTS: Final[frozenset[tx.Use]] = frozenset({"object"})

FAMILIES: Final[dict[str, tx.Family]] = {
    "anti_slip_sheet": tx.Family(_anti_slip, 0.25, _FLOOR),
    "carbon_look": tx.Family(_carbon_look, 0.08, _OBJECTS),
    "chip_vinyl": tx.Family(_chip_vinyl, 0.6, _FLOOR),
    "coated_fabric": tx.Family(_tarpaulin, 0.12, frozenset({"textile", "object"})),
    "linoleum": tx.Family(_marbled, 0.8, _FLOOR, grain=True),
    "studded_vinyl": tx.Family(_studded, 0.5, _FLOOR),
    "twin_wall_sheet": tx.Family(_corrugated, 0.3, frozenset({"object", "wall"}), grain=True),
    "vinyl_composition_tiles": tx.Family(_composition_tiles, 1.22, _FLOOR),
    "vinyl_planks": tx.Family(_vinyl_planks, 2.4, _FLOOR, grain=True),
    "wood_laminate": tx.Family(
        _wood_laminate, 0.8, frozenset({"furniture", "worktop", "wall"}), grain=True
    ),
}
