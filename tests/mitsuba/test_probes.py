"""Light probes: what they hold against closed forms, and their files."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from openrooms_usd.description.rendering import RenderSettings
from openrooms_usd.errors import InputError, RenderError
from openrooms_usd.geometry import spherical_harmonics as sh
from openrooms_usd.library.surroundings import environments
from openrooms_usd.rendering.exr import read_picture
from openrooms_usd.rendering.probes import irradiance, probe_stage
from openrooms_usd.usd.light.lights import Portal, define_portal
from tests import small
from tests.small import square

NITS = 1000.0
SIZE = (32, 16)


def saved(stage: Any, folder: Path) -> Path:
    path = folder / "scene.usda"
    stage.GetRootLayer().Export(str(path))
    return path


@pytest.mark.usefixtures("vectorized")
def test_a_probe_under_an_even_sky(tmp_path: Path) -> None:
    room = small.Stage()
    room.quad("/Far", square((0.05, 0.05, -99), 0.05))
    room.dome(radiance=NITS)
    found = probe_stage(
        saved(room.stage, tmp_path),
        tmp_path / "out",
        RenderSettings(resolution=SIZE, samples=16),
        at=[(1, 2, 3)],
    )
    (probe,) = found["probes"]
    radiance, lux = np.array(probe["radiance"]), np.array(probe["irradiance"])
    assert radiance[0, 1] == pytest.approx(NITS * np.sqrt(4 * np.pi), rel=0.01)
    assert (np.abs(radiance[1:]) < 0.03 * radiance[0]).all()
    for normal in np.eye(3):
        assert (sh.basis(normal, 2) @ lux)[0] == pytest.approx(np.pi * NITS, rel=0.03)
    for value in probe["axes"].values():
        assert value[2] == pytest.approx(np.pi * NITS, rel=0.03)
    assert json.loads((tmp_path / "out/probes.json").read_text()) == json.loads(json.dumps(found))
    assert read_picture(tmp_path / "out/probe_0.exr").mean() == pytest.approx(NITS, rel=0.02)


@pytest.mark.usefixtures("vectorized")
def test_a_lamp_is_where_the_panorama_says(tmp_path: Path) -> None:
    """On the +X side, a little to +Y and below: a picture that is turned or mirrored fails."""
    room = small.Stage()
    black = room.material("/Black", base_color=(0.0, 0.0, 0.0))
    x, y, z, half = 2.0, 0.7, -0.4, 0.1
    corners = [
        (x, y - half, z - half),
        (x, y - half, z + half),
        (x, y + half, z + half),
        (x, y + half, z - half),
    ]
    room.quad("/Lamp", corners, material=black, nits=NITS)
    probe_stage(
        saved(room.stage, tmp_path),
        tmp_path / "out",
        RenderSettings(resolution=SIZE, samples=8),
        at=[(0, 0, 0)],
    )
    pixels = read_picture(tmp_path / "out/probe_0.exr")
    way = np.array([x, y, z]) / np.linalg.norm([x, y, z])
    d = environments.directions(16)
    middle = (pixels[..., :1] * d * np.cos(np.arcsin(d[..., 2:]))).sum(axis=(0, 1))
    assert middle / np.linalg.norm(middle) @ way > 0.998
    # Lambert's contour sum would say the same as this: small and far.
    facing = NITS * (2 * half) ** 2 * way[0] * way[0] / (x * x + y * y + z * z)
    assert irradiance(pixels, [1, 0, 0])[0] == pytest.approx(facing, rel=0.05)
    assert irradiance(pixels, [-1, 0, 0])[0] == 0.0


@pytest.mark.usefixtures("vectorized")
def test_openings_have_probes_that_look_both_ways(tmp_path: Path) -> None:
    room = small.Stage()
    black = room.material("/Black", base_color=(0.0, 0.0, 0.0))
    # A black wall close behind the opening: from inside nothing comes, from outside half the sky.
    room.quad("/Wall", square((0, -0.1, 0), 50, "-Y"), material=black)
    room.dome(radiance=NITS)
    world = np.eye(4)
    world[:3, :3] = np.array([[-1, 0, 0], [0, 0, 1], [0, 1, 0]]).T
    define_portal(room.stage, Portal("/window_3", world, 1.0, 1.0))
    found = probe_stage(
        saved(room.stage, tmp_path),
        tmp_path / "out",
        RenderSettings(resolution=SIZE, samples=16),
        at_openings=True,
    )
    (probe,) = found["probes"]
    assert probe["name"] == "window_3"
    assert probe["opening"]["outwards"] == pytest.approx([0, 1, 0])
    assert probe["opening"]["from_outside"][0] == pytest.approx(np.pi * NITS, rel=0.03)
    assert probe["opening"]["from_inside"][0] < 0.02 * np.pi * NITS


@pytest.mark.usefixtures("vectorized")
def test_equal_seeds_give_equal_files(tmp_path: Path) -> None:
    room = small.Stage()
    room.box("/Box", 2.0, inside=True)
    room.dome()
    path = saved(room.stage, tmp_path)
    for name in ("a", "b"):
        probe_stage(
            path, tmp_path / name, RenderSettings(resolution=SIZE, samples=2), at=[(0, 0, 2)]
        )
    for file in ("probes.json", "probe_0.exr", "probe_0.png"):
        assert (tmp_path / "a" / file).read_bytes() == (tmp_path / "b" / file).read_bytes()


def test_what_makes_no_probe_is_refused(tmp_path: Path) -> None:
    room = small.Stage()
    room.box("/Box", 2.0)
    path, out = saved(room.stage, tmp_path), tmp_path / "out"
    with pytest.raises(InputError, match="no opening"):
        probe_stage(path, out, at_openings=True)
    with pytest.raises(InputError, match="no place"):
        probe_stage(path, out)
    with pytest.raises(InputError, match="not a position"):
        probe_stage(path, out, at=[(0, float("nan"), 0)])
    with pytest.raises(InputError, match="not the size"):
        probe_stage(path, out, RenderSettings(resolution=(2, 1)), at=[(0, 0, 0)])
    with pytest.raises(RenderError, match="scalar"):
        probe_stage(path, out, RenderSettings(options={"variant": "scalar"}), at=[(0, 0, 0)])
    assert not out.exists()
