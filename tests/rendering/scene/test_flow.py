"""Optical flow: closed forms, and a reprojection that is written again here."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from pxr import Gf, Usd

from openrooms_usd.geometry.pinhole import intrinsics, look_at
from openrooms_usd.geometry.rotations import pose
from openrooms_usd.rendering import RenderRequest
from openrooms_usd.rendering.context import RenderContext as OpenedStage
from openrooms_usd.rendering.exact import flow_images
from openrooms_usd.usd.cameras import PinholeCamera
from tests import small
from tests.small import square

WIDTH, HEIGHT = 40, 30
SIZE = np.array([WIDTH, HEIGHT])
K = intrinsics(60.0, WIDTH, HEIGHT)
REQUEST = RenderRequest("/Camera", ("depth", "position", "valid"), WIDTH, HEIGHT, samples=1)
AT = look_at((0.0, -3.0, 1.0), (0.0, 0.0, 1.0))
COLUMN, ROW = np.meshgrid(np.arange(WIDTH) + 0.5, np.arange(HEIGHT) + 0.5)


@pytest.fixture
def wall(open_stage: Callable[[Usd.Stage], OpenedStage]) -> OpenedStage:
    """A wall at y = 0."""
    made = small.Stage()
    made.quad("/Wall", square((0, 0, 0), 9, "-Y"))
    return open_stage(made.stage)


def flow(
    stage: OpenedStage, first: np.ndarray, second: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    cameras = PinholeCamera(K, first), PinholeCamera(K, second)
    images = flow_images(stage.scene, stage.tracer, *cameras, (REQUEST.width, REQUEST.height))
    return images["flow"].pixels, images["flow_visible"].pixels[..., 0] > 0.5


def moved(metres: tuple[float, float, float], turned: np.ndarray | None = None) -> np.ndarray:
    """`AT`, moved and turned in its own frame."""
    inner = pose(np.eye(3) if turned is None else turned, np.array(metres))
    return AT @ inner


def test_beside_a_wall_all_moves_alike(wall: OpenedStage) -> None:
    found, seen = flow(wall, AT, moved((0.3, -0.1, 0.0)))
    # u' - u = -f t / Z.
    np.testing.assert_allclose(found[..., 0], -K[0, 0] * 0.3 / 3.0, atol=1e-4)
    np.testing.assert_allclose(found[..., 1], K[1, 1] * 0.1 / 3.0, atol=1e-4)
    inside = (COLUMN + found[..., 0] >= 0.0) & (ROW + found[..., 1] <= HEIGHT)
    np.testing.assert_array_equal(seen, inside)


def test_towards_a_wall_all_moves_from_the_middle(wall: OpenedStage) -> None:
    found, _ = flow(wall, AT, moved((0.0, 0.0, 1.0)))
    np.testing.assert_allclose(found[..., 0], (COLUMN - K[0, 2]) * 0.5, atol=1e-4)
    np.testing.assert_allclose(found[..., 1], (ROW - K[1, 2]) * 0.5, atol=1e-4)


@pytest.mark.parametrize("degrees", [4.0, 170.0])
def test_a_turn_moves_all_by_its_homography(wall: OpenedStage, degrees: float) -> None:
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    turn = np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])
    found, seen = flow(wall, AT, moved((0.0, 0.0, 0.0), turn))
    H = K @ turn.T @ np.linalg.inv(K)
    wanted = np.stack([COLUMN, ROW, np.ones_like(ROW)], axis=-1) @ H.T
    if degrees > 90.0:
        # All of it is behind the camera then.
        assert not found.any() and not seen.any()
        return
    np.testing.assert_allclose(
        found, wanted[..., :2] / wanted[..., 2:] - np.dstack([COLUMN, ROW]), atol=1e-4
    )
    # No depth tells of the surroundings: they move as the wall does.
    assert 0.5 < seen.mean() < 1.0


def test_the_surroundings_turn_and_do_not_move(
    open_stage: Callable[[Usd.Stage], OpenedStage],
) -> None:
    made = small.Stage()
    made.quad("/Wall", square((-4.5, 0, 0), (9, 4.5), "-Y"))
    found, seen = flow(open_stage(made.stage), AT, moved((0.4, 0.0, 0.0)))
    sky = COLUMN > WIDTH / 2
    assert np.abs(found[sky]).max() < 1e-9
    # The wall comes to hide nothing of them: it moves away to the left.
    assert seen[sky].all() and (found[~sky][:, 0] < -1.0).all()
    _, back = flow(open_stage(made.stage), AT, moved((-0.4, 0.0, 0.0)))
    edge = WIDTH / 2 + K[0, 0] * 0.4 / 3.0
    np.testing.assert_array_equal(back[:, WIDTH // 2 :], COLUMN[:, WIDTH // 2 :] > edge)


def test_what_comes_to_be_hidden_is_as_the_next_depth_says(
    open_stage: Callable[[Usd.Stage], OpenedStage],
) -> None:
    made = small.Stage()
    made.quad("/Wall", square((0, 2, 0), 9, "-Y"))
    made.quad("/Floor", square((0, 0, 0), (9, 4)))
    box = made.box("/Box", 0.8)
    box.AddTransformOp().Set(Gf.Matrix4d().SetTranslate(Gf.Vec3d(0.1, -0.4, 0.9)))
    stage = open_stage(made.stage)
    after = look_at((0.5, -2.8, 1.2), (0.1, 0.0, 1.0))
    now = stage.picture(PinholeCamera(K, AT), REQUEST).images
    found, seen = flow(stage, AT, after)
    # A point into the next camera, and what lies there of a picture ten times as fine.
    fine = 10
    big = replace(REQUEST, width=fine * WIDTH, height=fine * HEIGHT)
    K_fine = np.diag([fine, fine, 1.0]) @ K
    depth = stage.picture(PinholeCamera(K_fine, after), big).images["depth"].pixels[..., 0]
    local = (now["position"].pixels - after[:3, 3]) @ after[:3, :3]
    place = np.dstack([COLUMN, ROW]) + found
    np.testing.assert_allclose(
        local[..., :2] / local[..., 2:] * K[0, 0] + K[:2, 2], place, atol=1e-3
    )
    inside = ((place > 0.0) & (place < SIZE)).all(axis=-1)
    assert not seen[~inside].any() and 0.6 < inside.mean() < 1.0
    column, row = np.clip((place * fine).astype(int), 0, fine * SIZE - 1)[inside].T
    before = local[..., 2][inside] - depth[row, column]
    hidden = before > 0.05
    agreement = (hidden == ~seen[inside]).mean()
    assert 0.03 < hidden.mean() < 0.4 and agreement > 0.99
