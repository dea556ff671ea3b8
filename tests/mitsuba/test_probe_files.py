"""Files of probes, read as a real-time engine reads them: by what stands in the file alone."""

import json
from pathlib import Path

import numpy as np
import pytest

from openrooms_usd.description.rendering import RenderSettings
from openrooms_usd.rendering.exr import read_picture
from openrooms_usd.rendering.probes import harmonics, irradiance, probe_stage
from tests import small
from tests.small import square

WAYS = {
    "+X": (1, 0, 0),
    "-X": (-1, 0, 0),
    "+Y": (0, 1, 0),
    "-Y": (0, -1, 0),
    "+Z": (0, 0, 1),
    "-Z": (0, 0, -1),
}
# The clamped cosine less its part up to the second degree is 3/32 at most, at right angles.
CUT = 3 / 32


def functions(d: np.ndarray) -> np.ndarray:
    """(..., 9) as the file says them: with its digits and in its order."""
    x, y, z = np.moveaxis(d, -1, 0)
    return np.stack(
        [
            np.full_like(x, 0.282095),
            0.488603 * y,
            0.488603 * z,
            0.488603 * x,
            1.092548 * x * y,
            1.092548 * y * z,
            0.315392 * (3 * z * z - 1),
            1.092548 * x * z,
            0.546274 * (x * x - y * y),
        ],
        axis=-1,
    )


def pixels_of(height: int, finer: int = 1) -> tuple[np.ndarray, np.ndarray]:
    """Directions and solid angles of a panorama's pixels, each in parts: poles, -Y in the middle.

    A quarter from the left is +X.
    """
    rows, columns = height * finer, 2 * height * finer
    polar = (np.arange(rows) + 0.5) / rows * np.pi
    turn = ((np.arange(columns) + 0.5) / columns - 0.5) * 2 * np.pi
    t, p = np.meshgrid(polar, turn, indexing="ij")
    d = np.stack([-np.sin(t) * np.sin(p), -np.sin(t) * np.cos(p), np.cos(t)], axis=-1)
    edges = np.cos(np.linspace(0.0, np.pi, rows + 1))
    return d, np.broadcast_to(-np.diff(edges)[:, None] * 2 * np.pi / columns, t.shape)


@pytest.fixture(scope="module")
def made(vectorized: str, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A probe off the middle of a red room with a lamp."""
    room, folder = small.Stage(), tmp_path_factory.mktemp("probe")
    red = room.material("/Red", base_color=(0.8, 0.3, 0.2))
    room.box("/Room", 2.0, inside=True, material=red)
    lamp = square((0.45, 0.35, 0.98), (0.25, 0.25), "-Z")
    room.quad("/Lamp", lamp, material=red, nits=1000.0)
    room.stage.GetRootLayer().Export(str(folder / "scene.usda"))
    probe_stage(
        folder / "scene.usda",
        folder / "out",
        RenderSettings(resolution=(32, 16), samples=8),
        at=[(0.3, -0.2, 0.1)],
    )
    return folder / "out"


def test_the_file_says_its_basis_and_its_order(made: Path) -> None:
    found = json.loads((made / "probes.json").read_text("utf-8"))
    said = found["conventions"]["harmonics"]
    words = [
        "0.282095",
        "0.488603 y",
        "0.488603 z",
        "0.488603 x",
        "1.092548 x y",
        "1.092548 y z",
        "0.315392 (3 z^2 - 1)",
        "1.092548 x z",
        "0.546274 (x^2 - y^2)",
    ]
    places = [said.index(word) for word in words]
    assert places == sorted(places)
    (probe,) = found["probes"]
    assert (found["order"], len(probe["radiance"]), len(probe["irradiance"])) == (2, 9, 9)
    assert probe["position"] == [0.3, -0.2, 0.1]
    assert "metres" in found["conventions"]["position"]


def test_coefficients_are_integrals_of_the_panorama(made: Path) -> None:
    (probe,) = json.loads((made / "probes.json").read_text("utf-8"))["probes"]
    light = read_picture(made / probe["panorama"]).repeat(8, axis=0).repeat(8, axis=1)
    d, sizes = pixels_of(16, finer=8)
    integrals = np.einsum("rc,rck,rcx->kx", sizes, functions(d), light)
    scale = integrals[0].max()
    # Least squares over cells, and integrals over them: apart by how coarse 16 rows are.
    np.testing.assert_allclose(probe["radiance"], integrals, atol=0.01 * scale)
    degrees = np.array([0, 1, 1, 1, 2, 2, 2, 2, 2])
    factors = np.array([np.pi, 2 * np.pi / 3, np.pi / 4])[degrees]
    np.testing.assert_allclose(probe["irradiance"], factors[:, None] * probe["radiance"])


def test_irradiance_is_that_of_the_panorama_but_for_what_is_cut_off(made: Path) -> None:
    (probe,) = json.loads((made / "probes.json").read_text("utf-8"))["probes"]
    light = read_picture(made / probe["panorama"]).repeat(8, axis=0).repeat(8, axis=1)
    d, sizes = pixels_of(16, finer=8)
    whole = np.einsum("rc,rcx->x", sizes, light)
    for name, normal in WAYS.items():
        exact = np.einsum("rc,rcx->x", sizes * np.maximum(d @ normal, 0.0), light)
        assert probe["axes"][name] == pytest.approx(exact, abs=2e-3 * whole[0])
        smooth = functions(np.array(normal, float)) @ probe["irradiance"]
        assert (np.abs(smooth - exact) < CUT * whole).all()
    # A room is dim below and bright above: which way is up is no matter of taste.
    assert probe["axes"]["+Z"][0] > 1.2 * probe["axes"]["-Z"][0]
    assert probe["axes"]["+X"][0] > probe["axes"]["-X"][0]


def test_light_up_to_the_second_degree_loses_nothing() -> None:
    d, _ = pixels_of(64)
    rng = np.random.default_rng(3)
    coefficients = rng.normal(size=(9, 3)) * 0.1
    coefficients[0] = 5.0
    panorama = (functions(d) @ coefficients).astype(np.float32)
    np.testing.assert_allclose(harmonics(panorama), coefficients, atol=5e-3)
    factors = np.repeat([np.pi, 2 * np.pi / 3, np.pi / 4], [1, 3, 5])[:, None]
    for normal in rng.normal(size=(5, 3)):
        n = normal / np.linalg.norm(normal)
        wanted = functions(n) @ (factors * coefficients)
        np.testing.assert_allclose(irradiance(panorama, n), wanted, rtol=2e-3)
