"""The same light otherwise: roles swapped, what hides it gone, and lamps that see themselves."""

from typing import Any

import numpy as np
import pytest

from openrooms_usd.usd.lights import define_mesh_light
from tests.mitsuba.lamps import NITS, Array, blocks, closed_room, down, lamp, view_of, z_of


@pytest.mark.parametrize("turned", [0.0, 37.0])
def test_a_convex_lamp_does_not_shine_on_itself(build: Any, lit: Any, turned: float) -> None:
    made = closed_room(build)
    mesh = made.box("/Lamp", 0.3, material="/Grey")
    mesh.AddTranslateOp().Set((0.3, 0.3, 0.1))
    mesh.AddRotateXYZOp().Set((turned, turned / 2, turned / 3))
    define_mesh_light(mesh.GetPrim(), nits=NITS)
    made.camera((-0.4, -0.4, 0.4), (0.3, 0.3, 0.1), fov=12)
    channels = ("unoccluded_i", "direct_i", "visibility_i", "irradiance_direct")
    found = view_of(made.stage, *channels, "mask_i", seeds=1)
    assert (found.pop("mask_0") == 1.0).all()
    for name in ("unoccluded_0", "direct_0", "visibility_0", "irradiance_direct"):
        assert found[name].max() < 1e-9 * NITS, name


@pytest.mark.slow
def test_what_stands_between_is_left_out_of_unoccluded_light(build: Any, lit: Any) -> None:
    """unoccluded_i is what path tracing finds once the board is gone."""
    pictures = []
    for board in (True, False):
        made = build()
        made.material("/Grey", base_color=(0.5,) * 3)
        made.quad("/Floor", down(3.0, 0.0)[::-1], material="/Grey")
        lamp(made, down(0.4, 1.5, 0.2))
        glowing_cube_at(made)
        if board:
            made.quad("/Board", down(0.3, 0.7, 0.1, 0.1), material="/Grey")
        made.camera((0, -0.6, 0.6), (0, 0.1, 0), fov=60)
        names = ("unoccluded_i", "direct_i") if board else ("irradiance_i",)
        pictures.append(view_of(made.stage, *names, bounces=1))
    hidden, free = pictures
    for number in range(2):
        theirs = blocks(free[f"irradiance_{number}"])
        z = z_of(blocks(hidden[f"unoccluded_{number}"]), theirs)
        assert np.abs(z).max() < 6.0 and np.mean(z**2) < 2.5
        assert hidden[f"direct_{number}"].mean() < 0.95 * theirs.mean()


def glowing_cube_at(made: Any) -> None:
    mesh = made.box("/Cube", 0.2, material="/Grey")
    mesh.AddTranslateOp().Set((-0.5, 0.3, 1.1))
    define_mesh_light(mesh.GetPrim(), nits=5 * NITS)


def framed(made: Any, center: Array, size: tuple[float, float], outwards: float) -> None:
    """A camera above or below whose picture is exactly a rectangle along x and y."""
    far = 0.3
    fov = 2.0 * np.degrees(np.arctan(size[0] / 2 / far))
    eye = center + np.array([0, 0, outwards * far])
    made.camera(eye, center, up=(0, 1, 0), fov=float(fov), aspect=size[0] / size[1])


@pytest.mark.slow
def test_a_lamp_and_a_patch_are_reciprocal(build: Any, lit: Any) -> None:
    """The flux from one to the other is the same both ways, past what stands between."""
    ends = [(np.array([0.0, 0.0, -1.0]), (0.8, 0.6)), (np.array([0.3, 0.5, 0.8]), (0.4, 0.3))]
    flux: dict[str, list[Array]] = {"direct_0": [], "irradiance_direct": [], "unoccluded_0": []}
    for (patch, size), (other, wide), outwards in ((*ends, 1.0), (*ends[::-1], -1.0)):
        made = build()
        made.material("/Grey", base_color=(0.5,) * 3)
        half, reach = (np.array([*s, 0.0]) / 2 for s in (size, wide))
        turn = [(-1, -1), (1, -1), (1, 1), (-1, 1)]
        turn = turn if outwards > 0 else turn[::-1]
        made.quad("/Patch", [patch + half * (*t, 0) for t in turn], material="/Grey")
        lamp(made, [other + reach * (*t, 0) for t in turn[::-1]])
        made.quad("/Board", [(-0.2, 0, 0), (0.3, 0, 0), (0.3, 0.5, 0), (-0.2, 0.5, 0)])
        framed(made, patch, size, outwards)
        found = view_of(made.stage, "direct_i", "unoccluded_i", "irradiance_direct", samples=64)
        for name, fluxes in flux.items():
            fluxes.append(size[0] * size[1] * found[name].mean(axis=(1, 2))[:, 1])
    for name, (there, back) in flux.items():
        assert abs(z_of(there, back)) < 5.0, (name, there.mean(), back.mean())
        assert there.mean() == pytest.approx(back.mean(), rel=0.01), name
    assert flux["direct_0"][0].mean() < 0.9 * flux["unoccluded_0"][0].mean()
    assert flux["direct_0"][0].mean() == pytest.approx(
        flux["irradiance_direct"][1].mean(), rel=0.01
    )
