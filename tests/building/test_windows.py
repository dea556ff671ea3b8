"""Sashes and wide doors: what moves is free, what is shut lets nothing through."""

import typing
from itertools import product

import numpy as np
import pytest

from openrooms_usd.building import leaves, windows
from openrooms_usd.building.doors import TWO_LEAVES_M, door, free_angle
from openrooms_usd.building.windows import Sash, window
from openrooms_usd.description.layout import DoorStyle, WindowStyle
from openrooms_usd.geometry.mesh import Mesh, joined
from openrooms_usd.geometry.raycast import RayCaster


def _caster(mesh: Mesh) -> RayCaster:
    corners, _ = mesh.triangles()
    return RayCaster(mesh.points, mesh.indices[corners])


def _free(meshes: list[Mesh], width: float, height: float) -> float:
    """The share of an opening that rays straight through it pass."""
    rng = np.random.default_rng(0)
    targets = rng.uniform(-0.5, 0.5, (4000, 3)) * [width, 0.0, height] - [0.0, 2.0, 0.0]
    hits = _caster(joined(meshes)).first_hit(targets, np.tile([0.0, 1.0, 0.0], (4000, 1)))
    return float(np.isinf(hits.distance).mean())


def _turned(mesh: Mesh, degrees: float, hinge: np.ndarray) -> Mesh:
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    pose = np.array([[c, -s, 0, hinge[0]], [s, c, 0, hinge[1]], [0, 0, 1, 0], [0, 0, 0, 1]])
    return mesh.transformed(pose)


def _moved(sash: Sash, share: float) -> Mesh:
    value = share * sash.upper
    if sash.kind == "rail":
        return sash.mesh.moved(np.array(sash.origin) + value * np.array(sash.axis))
    return _turned(sash.mesh, sash.axis[2] * value, np.zeros(2)).moved(sash.origin)


def test_the_description_knows_the_same_styles() -> None:
    assert typing.get_args(DoorStyle) == tuple(leaves.STYLES)
    assert typing.get_args(WindowStyle) == tuple(windows.STYLES)


@pytest.mark.parametrize("style", windows.STYLES)
def test_sashes_open_into_the_room_or_slide_in_their_frame(style: str) -> None:
    made = window(1.5, 1.3, 0.2, board=True, style=style)
    assert bool(made.sashes) == (style != "fixed")
    for sash in made.sashes:
        shut, wide = _moved(sash, 0.0).extent, _moved(sash, 1.0).extent
        if sash.kind == "hinge":
            assert wide[0, 1] < shut[0, 1] - 0.3
            assert abs(sash.axis[2]) == 1
        else:
            assert wide[:, :2] == pytest.approx(shut[:, :2])
            clear = np.abs(wide[:, 2]).max()
            assert clear < 0.65
            assert abs(wide[0, 2] - shut[0, 2]) > 0.4


@pytest.mark.parametrize("style", ["casement", "grid"])
def test_an_open_window_is_freer_than_a_shut_one(style: str) -> None:
    made = window(1.5, 1.3, 0.2, board=True, style=style)
    shut = _free([made.closed()], 1.5, 1.3)
    opened = _free([made.frame, *(_moved(sash, 1.0) for sash in made.sashes)], 1.5, 1.3)
    assert opened > shut + 0.08
    assert _free([window(1.5, 1.3, 0.2, board=True, style="fixed").frame], 1.5, 1.3) > shut


def test_a_grid_has_bars_between_its_panes() -> None:
    plain, grid = (window(1.5, 1.3, 0.2, board=False, style=s) for s in ("casement", "grid"))
    assert _free([grid.closed()], 1.5, 1.3) < _free([plain.closed()], 1.5, 1.3) - 0.04


@pytest.mark.parametrize("style", windows.STYLES)
def test_glass_fills_what_is_free_of_a_shut_window(style: str) -> None:
    made = window(1.5, 1.3, 0.2, board=True, style=style)
    glass = [*made.panes, *(sash.pane.moved(sash.origin) for sash in made.sashes)]
    assert _free([made.closed()], 1.5, 1.3) > 0.4
    # Sliding sashes overlap, and keep a gap between their tracks.
    assert _free([made.closed(), *glass], 1.5, 1.3) == 0.0
    for pane in glass:
        assert np.ptp(pane.points, axis=0).min() == pytest.approx(0.004)


@pytest.mark.parametrize("style", leaves.STYLES)
def test_glass_fills_glazed_doors(style: str) -> None:
    made = door(1.6, 2.05, 0.2, style=style, hinge="right", swing="out")
    shut = [made.frame]
    for leaf in made.leaves:
        assert (leaf.pane is not None) == (style == "glazed")
        parts = [leaf.panel, *([leaf.pane] if leaf.pane else [])]
        shut += [_turned(part, 0.0, leaf.hinge) for part in parts]
    assert _free(shut, 1.6 - 0.06, 2.05 - 0.08) == 0.0


@pytest.mark.parametrize("style", leaves.STYLES)
def test_only_glazed_doors_let_light_through_while_shut(style: str) -> None:
    made = door(0.9, 2.05, 0.2, style=style)
    shut = [made.frame, *(_turned(leaf.panel, 0.0, leaf.hinge) for leaf in made.leaves)]
    free = _free(shut, 0.9 - 0.06, 2.05 - 0.08)
    assert (free > 0.4) if style == "glazed" else (free == 0.0)


@pytest.mark.parametrize(("hinge", "swing"), list(product(("left", "right"), ("in", "out"))))
def test_wide_doors_have_two_leaves_that_meet(hinge: str, swing: str) -> None:
    width, height = 1.8, 2.05
    made = door(width, height, 0.2, hinge=hinge, swing=swing)  # type: ignore[arg-type]
    first, second = made.leaves
    assert (first.hinge[0] < 0) == (hinge == "left")
    assert first.hinge[0] == pytest.approx(-second.hinge[0])
    assert first.sense == -second.sense
    shut = [made.frame, *(_turned(leaf.panel, 0.0, leaf.hinge) for leaf in made.leaves)]
    assert _free(shut, width - 0.06, height - 0.08) == 0.0
    wide = [_turned(leaf.panel, leaf.sense * 90.0, leaf.hinge) for leaf in made.leaves]
    assert _free([made.frame, *wide], width, height) > 0.75
    for leaf in wide:
        assert (leaf.points[:, 1].mean() < 0) == (swing == "in")


def test_two_leaves_open_together_without_touching() -> None:
    made = door(1.8, 2.05, 0.2)
    first, second = made.leaves
    for angle in (0.5, 2.0, 5.0, 20.0, 60.0):
        a = _turned(joined([first.panel, first.handle]), first.sense * angle, first.hinge)
        b = _turned(joined([second.panel, second.handle]), second.sense * angle, second.hinge)
        inside = _caster(b).first_hit(a.points, np.tile([0.0, 0.0, 1.0], (len(a.points), 1)))
        corners = inside.hit & (a.points[:, 2] > b.extent[0, 2] + 0.01)
        corners &= a.points[:, 2] < b.extent[1, 2] - 0.01
        assert not corners.any()


def test_each_leaf_of_a_wide_door_stops_at_what_is_in_its_way() -> None:
    made = door(1.8, 2.05, 0.2)
    beside = np.array([[-1.2, -2.0], [-1.0, -2.0], [-1.0, 0.0], [-1.2, 0.0]])
    angles = [free_angle(leaf, 160.0, [beside]) for leaf in made.leaves]
    assert 85 < angles[0] < 120
    assert angles[1] == 160


def test_doors_up_to_the_limit_have_one_leaf() -> None:
    assert len(door(TWO_LEAVES_M, 2.05, 0.2).leaves) == 1
    assert len(door(TWO_LEAVES_M + 0.01, 2.05, 0.2).leaves) == 2
