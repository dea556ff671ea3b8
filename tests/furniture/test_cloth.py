"""Soft things: pillows, covers and curtains against what they are asked for."""

import numpy as np
import pytest

from openrooms_usd.furniture.joinery.cloth import cover, folded, pillow, ripples
from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.geometry.topology import is_closed


def _rng(seed: int = 0) -> np.random.Generator:
    return np.random.default_rng(seed)


def _section(mesh: Mesh, z: float) -> np.ndarray:
    """(N, 2) where the edges of a mesh of quads cross a level, by ascending x."""
    quads = mesh.indices.reshape(-1, 4)
    ends = np.stack([quads, np.roll(quads, -1, axis=1)], axis=-1).reshape(-1, 2)
    a, b = mesh.points[ends[:, 0]], mesh.points[ends[:, 1]]
    crossing = (a[:, 2] < z) != (b[:, 2] < z)
    a, b = a[crossing], b[crossing]
    t = ((z - a[:, 2]) / (b[:, 2] - a[:, 2]))[:, None]
    found = (a + t * (b - a))[:, :2]
    return found[np.argsort(found[:, 0])]


@pytest.mark.parametrize("seed", range(4))
def test_a_pillow_is_a_closed_lens_of_its_size(seed: int) -> None:
    mesh = pillow(0.6, 0.4, 0.15, _rng(seed))
    assert is_closed(mesh)
    np.testing.assert_allclose(mesh.extent[1] - mesh.extent[0], [0.6, 0.4, 0.15], atol=1e-9)
    # Between a cone and a box over its outline, and its seam is level.
    assert 0.4 * 0.6 * 0.4 * 0.15 < mesh.volume() < 0.9 * 0.6 * 0.4 * 0.15
    rim = mesh.points[np.abs(mesh.points[:, 0]) > 0.5 * 0.6 * 0.999]
    assert np.abs(rim[:, 2]).max() == 0
    # The seam is drawn in between the corners.
    assert np.abs(mesh.points[np.abs(mesh.points[:, 1]) < 0.01][:, 0]).max() < 0.29


@pytest.mark.parametrize("pitch", [0.07, 0.1, 0.15])
def test_a_curtain_has_its_folds(pitch: float) -> None:
    mesh = folded((-0.5, 0.5), (0.1, 2.1), 0.3, 0.1, pitch, 0.003, _rng(2))
    assert is_closed(mesh)
    assert mesh.volume() > 0
    low, high = mesh.extent
    assert (low[2], high[2]) == pytest.approx((0.1, 2.1), abs=1e-3)
    assert low[1] >= 0.3 - 0.05
    assert high[1] <= 0.3 + 0.05
    # It crosses its middle plane twice a fold, in any section.
    for level in (0.3, 1.0, 1.9):
        ahead = _section(mesh, level)[:, 1] - 0.3
        crests = ahead[np.abs(ahead) > 0.012] > 0
        turns = int((crests[1:] != crests[:-1]).sum())
        assert turns == pytest.approx(2 * round(1.0 / pitch), abs=2)


def test_cloth_in_folds_is_longer_than_the_curtain_is_wide() -> None:
    """Fullness: what hangs is 1.3 to 3 times as long as its rail."""
    thick = 0.002
    mesh = folded((0.0, 2.0), (0.0, 2.0), 0.0, 0.1, 0.1, thick, _rng(1))
    fullness = mesh.volume() / (thick * 2.0 * 2.0)
    assert 1.3 < fullness < 3.0


def test_wide_curtains_stay_light() -> None:
    mesh = folded((-4.0, 4.0), (0.0, 2.5), 0.0, 0.1, 0.09, 0.002, _rng())
    assert (mesh.counts - 2).sum() < 5000


@pytest.mark.parametrize("drop", [(0.25, 0.2), (0.0, 0.0), (0.2, 0.0)])
def test_a_cover_lies_on_its_bed_and_hangs_down(drop: tuple[float, float]) -> None:
    mesh = cover(0.7, (-0.9, 0.4), 0.5, drop, 0.02, _rng(3), puff=0.0)
    assert is_closed(mesh)
    assert mesh.volume() > 0
    low, high = mesh.extent
    assert high[2] == pytest.approx(0.5)
    assert high[1] == pytest.approx(0.4)
    # Over the edge it hangs outside the bed, within a hand's breadth.
    beside = mesh.points[np.abs(mesh.points[:, 0]) > 0.7 + 0.02]
    assert (len(beside) > 0) == (drop[0] > 0)
    assert max(-low[0], high[0]) < 0.7 + 0.08
    assert low[2] == pytest.approx(0.5 - max(np.hypot(*drop), 0.02), abs=0.05)


def test_nothing_of_a_hanging_cover_is_inside_the_bed() -> None:
    mesh = cover(0.7, (-0.9, 0.4), 0.5, (0.3, 0.25), 0.02, _rng(5), puff=0.0)
    x, y, z = mesh.points.T
    below = z < 0.5 - 0.06
    assert not (below & (np.abs(x) < 0.7 - 1e-6) & (y > -0.9 + 1e-6)).any()


def test_ripples_are_bounded_and_follow_from_their_seed() -> None:
    x, y = np.meshgrid(np.linspace(0, 3, 40), np.linspace(0, 3, 40))
    values = ripples(x, y, 0.4, _rng(7))
    np.testing.assert_array_equal(values, ripples(x, y, 0.4, _rng(7)))
    assert np.abs(values).max() <= 5 / 3
    assert values.std() > 0.2
