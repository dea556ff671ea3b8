"""Light of generated rooms, taken apart and added up again from the files."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from openrooms_usd.arrays import Array
from openrooms_usd.description.rendering import RenderSettings
from openrooms_usd.rendering import render_stage
from openrooms_usd.rendering.reading import RenderedView, read_render

SIZE = (24, 18)
CHANNELS = (
    "radiance emission direct indirect irradiance irradiance_direct irradiance_indirect "
    "diffuse specular residual base_color metallic valid radiance_i direct_i unoccluded_i "
    "visibility_i irradiance_i irradiance_unoccluded_i"
).split()


def of_lights(view: RenderedView, name: str) -> Array:
    """(L, height, width, 3)."""
    found = view.lights[name]
    return np.stack([found[number] for number in sorted(found)]).astype(np.float64)


def assert_adds_up(view: RenderedView) -> None:
    """All that holds for every pixel by itself."""
    one = {name: pixels.astype(np.float64) for name, pixels in view.pixels.items()}
    lights = {name: of_lights(view, name) for name in view.lights}
    straight, free = lights["direct"], lights["unoccluded"]
    for whole, parts in (
        (one["radiance"], one["emission"] + one["direct"] + one["indirect"]),
        (one["radiance"], lights["radiance"].sum(axis=0)),
        (one["irradiance"], one["irradiance_direct"] + one["irradiance_indirect"]),
        (one["irradiance"], lights["irradiance"].sum(axis=0)),
        (one["irradiance_direct"], straight.sum(axis=0)),
        (one["direct"] + one["indirect"], one["diffuse"] + one["specular"]),
        (one["radiance"], one["diffuse"] + one["residual"]),
        (lights["irradiance_unoccluded"], lights["irradiance"] - straight + free),
    ):
        np.testing.assert_allclose(parts, whole, rtol=1e-4, atol=1e-5 * (1.0 + whole.mean()))
    assert lights["visibility"].min() >= 0.0 and lights["visibility"].max() <= 1.0
    assert not lights["visibility"][free == 0.0].any()
    assert (straight <= free * (1.0 + 1e-5)).all()
    assert one["specular"].min() >= 0.0 and one["diffuse"].min() >= 0.0


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "seed"), [("bedroom", 12), ("kitchen", 16), ("office", 19)])
@pytest.mark.one_in(3, rest="long")
def test_light_that_was_taken_apart_adds_up(
    vectorized: str,
    kind: str,
    seed: int,
    generated: Callable[[str, int], Path],
    tmp_path: Path,
    fastest: str,
) -> None:
    render_stage(
        generated(kind, seed),
        tmp_path,
        RenderSettings(
            resolution=SIZE, options={"variant": fastest}, channels=CHANNELS, samples=16
        ),
        cameras=["view_0"],
    )
    assert_adds_up(read_render(tmp_path).views["view_0"])
