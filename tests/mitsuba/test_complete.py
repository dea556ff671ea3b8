"""What the pass of all channels has of its own: sheets, diffuse and glossy parts, few strands."""

from typing import Any

import numpy as np
import pytest

from tests.mitsuba.rendering import SIZE, pictures, session_of
from tests.mitsuba.rooms import closed_room, furnished
from tests.mitsuba.statistics import assert_alike, z_of
from tests.mitsuba.test_light_identities import OTHERS, SEEDS, SENT
from tests.small import square


def cloth(**looks: Any) -> Any:
    """A closed room with a lamp behind a sheet, in the light of another."""
    made = closed_room()
    made.quad("/Lamp", square((0, 0.8, 0), 0.3, "-Y"), material="/Grey", nits=40.0)
    made.quad("/Other", square((0, -0.7, 0.6), 0.2, "-Z"), material="/Grey", nits=40.0)
    sheet = made.material("/Cloth", **({"base_color": (0.5, 0.4, 0.3), "ior": 1.5} | looks))
    made.quad("/Sheet", square((0, 0.5, 0), 0.9, "-Y"), material=sheet)
    return made.stage


@pytest.mark.slow
@pytest.mark.parametrize("looks", [{"transmission": 0.4}, {"opacity": 0.5}], ids=["cloth", "clear"])
@pytest.mark.parametrize("bsdf", ["openrooms", "preview"])
def test_what_passes_a_sheet_is_that_of_paths(
    vectorized: str, looks: dict[str, float], bsdf: str
) -> None:
    made = session_of(cloth(**looks), bsdf=bsdf)
    ours = pictures(made, ("irradiance", *SENT), SEEDS)
    for name, paths in pictures(made, SENT, OTHERS).items():
        if "opacity" in looks:
            # Paths find a lamp behind a clear sheet by luck: pixels say nothing.
            assert np.abs(z_of(*(f.mean(axis=(1, 2)) for f in (ours[name], paths)))).max() < 5
        else:
            assert_alike(ours[name], paths, name)


@pytest.mark.parametrize("metallic", [0.0, 0.75, 1.0])
def test_of_one_colour_diffuse_is_albedo_over_pi_times_irradiance(
    vectorized: str, metallic: float
) -> None:
    color = (0.5, 0.4, 0.3)
    made = closed_room(base_color=color, metallic=metallic, roughness=0.4, ior=1.5)
    made.quad("/Lamp", square((0, 0, 0.9), 0.3, "-Z"), material="/Grey", nits=40.0)
    opened = session_of(made.stage, bsdf="openrooms")
    found = pictures(opened, ("diffuse", "specular", "irradiance"), range(1), samples=4)
    expected = np.array(color) * (1.0 - metallic) / np.pi * found["irradiance"]
    assert found["irradiance"].mean() > 1.0
    np.testing.assert_allclose(found["diffuse"], expected, rtol=1e-5, atol=1e-6)
    assert found["specular"].min() >= 0.0 and found["specular"].mean() > 0.0


@pytest.mark.slow
def test_sums_take_no_more_room_for_more_samples(lit: Any, monkeypatch: Any) -> None:
    """Equal seeds give equal bits, and a pixel has few strands for any number of samples."""
    from orusd_mitsuba.complete import integrator as complete
    from orusd_mitsuba.complete.meeting import CompleteScene
    from orusd_mitsuba.transport.paths import TracedPaths
    from orusd_mitsuba.transport.scattered import ScatteredLight

    room = lit(furnished().stage)
    scene = CompleteScene(room.scene, room.built, room.builder, room.sources, room.index)
    traced = ScatteredLight(TracedPaths(room.built, room.index, 8), is_cheap=False)
    made = complete.CompleteIntegrator(scene, traced, room.camera(*SIZE), *SIZE, 8)
    sizes: list[int] = []
    real = complete.WholeAccumulator

    class Counted(real):  # type: ignore[valid-type,misc]
        def __init__(self, strands: int, lights: int | None, *, guided: bool) -> None:
            super().__init__(strands, lights, guided=guided)
            sizes.append(strands)

    monkeypatch.setattr(complete, "WholeAccumulator", Counted)
    monkeypatch.setattr(complete, "_THREADS", 4 * SIZE[0] * SIZE[1])
    first = made(64, 3)
    np.testing.assert_array_equal(first, made(64, 3))
    made(256, 3)
    assert sizes == [4 * SIZE[0] * SIZE[1]] * 3
    assert not np.array_equal(first, made(64, 4))
