"""The light of a panorama is that of pinholes which look the same ways."""

import numpy as np
import pytest

from openrooms_usd.errors import RenderError
from openrooms_usd.geometry.pinhole import intrinsics, look_at, panorama_intrinsics
from openrooms_usd.rendering import RenderRequest
from openrooms_usd.rendering.context import RenderContext as OpenedStage
from openrooms_usd.usd.cameras import EQUIRECTANGULAR, PinholeCamera
from tests import small
from tests.mitsuba.rendering import session_of
from tests.small import square

EYE = (0.3, -0.2, 0.1)
WIDTH, HEIGHT = 48, 24


@pytest.fixture(params=["llvm", "scalar"])
def stage(request: pytest.FixtureRequest) -> OpenedStage:
    """Under an even sky, a wall of one colour before the camera and a floor of another."""

    if request.param == "llvm":
        request.getfixturevalue("vectorized")
    made = small.Stage()
    red = made.material("/Red", base_color=(0.8, 0.1, 0.1))
    blue = made.material("/Blue", base_color=(0.1, 0.2, 0.7))
    made.bind(made.quad("/Wall", square((2, 0, 0.5), (3, 1.5), "+X")).GetPrim(), red)
    floor = made.quad("/Floor", square((0, 0, -1), 3))
    made.bind(floor.GetPrim(), blue)
    made.dome()
    return session_of(made.stage, variant=request.param)


def panorama(stage: OpenedStage, method: str = "reference") -> np.ndarray:
    camera = PinholeCamera(
        panorama_intrinsics(WIDTH, HEIGHT),
        look_at(EYE, (1.3, -0.2, 0.1)),
        projection=EQUIRECTANGULAR,
    )
    request = RenderRequest("/a", ("radiance",), WIDTH, HEIGHT, samples=256, bounces=3)
    return stage.picture(camera, request).images["radiance"].pixels.astype(np.float64)


def test_panoramas_have_the_light_of_pinholes(stage: OpenedStage) -> None:
    if stage.session.backend.find("scalar") >= 0:
        with pytest.raises(RenderError, match="cannot render panoramas"):
            panorama(stage)
        return
    found = panorama(stage)
    assert np.isfinite(found).all()
    K = intrinsics(40.0, 8, 8)
    # Ahead, to the right, back, and down: where a map has them.
    for target, longitude, latitude in (
        ((1.3, -0.2, 0.1), 0.0, 0.0),
        ((0.3, -1.2, 0.1), 90.0, 0.0),
        ((-0.7, -0.2, 0.1), 180.0, 0.0),
        ((1.3, -0.2, -0.9), 0.0, -45.0),
    ):
        request = RenderRequest("/b", ("radiance",), 8, 8, samples=256, bounces=3)
        seen = stage.picture(PinholeCamera(K, look_at(EYE, target)), request)
        pixels = seen.images["radiance"].pixels[3:5, 3:5].astype(np.float64).mean(axis=(0, 1))
        column = int((longitude / 360.0 + 0.5) * WIDTH)
        row = int((0.5 - latitude / 180.0) * HEIGHT)
        near = found[row - 1 : row + 1, [column - 1, column % WIDTH]].mean(axis=(0, 1))
        np.testing.assert_allclose(near, pixels, rtol=0.08, atol=0.01)


def test_edges_of_light_lie_where_directions_are(stage: OpenedStage) -> None:
    """What is bounded by meridians and parallels is bounded by columns and rows, exactly."""
    if stage.session.backend.find("scalar") >= 0:
        pytest.skip("the scalar backend renders cannot render panoramas")

    made = small.Stage()
    black = made.material("/Black", base_color=(0, 0, 0))
    # Seen from the origin: from 30 to 60 degrees to the right of x, over all but the poles.
    a, b = (np.array([np.cos(t), -np.sin(t)]) * 2.0 for t in np.radians([30.0, 60.0]))
    made.quad("/Strip", [(*a, -20), (*b, -20), (*b, 20), (*a, 20)], material=black)
    # And a disc from 45 degrees below the horizon down.
    turn = np.radians(np.arange(360.0))
    disc = np.column_stack([np.cos(turn), np.sin(turn), np.full(360, -1.0)])
    made.mesh("/Disc", disc, [np.arange(360)], material=black)
    made.dome(radiance=3.0)
    camera = PinholeCamera(
        panorama_intrinsics(WIDTH, HEIGHT),
        look_at((0.0, 0.0, 0.0), (1.0, 0.0, 0.0)),
        projection=EQUIRECTANGULAR,
    )
    request = RenderRequest("/a", ("radiance",), WIDTH, HEIGHT, samples=64, bounces=1)
    opened = session_of(made.stage, variant="llvm")
    found = opened.picture(camera, request).images["radiance"].pixels[..., 1]
    # 7.5 degrees a pixel: 4 to 8 columns to the right of the middle, 6 rows below it.
    wanted = np.full((HEIGHT, WIDTH), 3.0)
    wanted[2:-2, 28:32] = 0.0
    wanted[18:] = 0.0
    # Two of 64 samples may pass beside the corners of the disc.
    np.testing.assert_allclose(found[2:], wanted[2:], atol=0.1)
