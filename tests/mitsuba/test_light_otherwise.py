"""The same light otherwise: roles swapped, what hides it gone, and lamps that see themselves."""

from typing import Any

import numpy as np
import pytest
from numpy.typing import ArrayLike, NDArray
from pxr import UsdGeom

from openrooms_usd.render import RenderRequest
from openrooms_usd.usd.lights import define_mesh_light
from orusd_mitsuba import MitsubaRenderer

Array = NDArray[np.float64]
NITS = 40.0
SIZE = (24, 18)
SEEDS = 8


def view_of(stage: Any, *names: str, seeds: int = SEEDS, **how: Any) -> dict[str, Array]:
    """(seeds, height, width, C) by name; what is seen is the same for all."""
    session = MitsubaRenderer().open(stage)
    how = {"camera": "/Camera", "width": SIZE[0], "height": SIZE[1], "samples": 16} | how
    views = [
        session.render(RenderRequest(channels=names, seed=seed, **how)) for seed in range(seeds)
    ]
    return {
        name: np.stack([view.images[name].pixels for view in views]).astype(np.float64)
        for name in views[0].images
    }


def down(half: float, z: float, x: float = 0.0, y: float = 0.0) -> Array:
    """A square that looks down."""
    return np.array([(x - half, y - half, z), (x - half, y + half, z),
                     (x + half, y + half, z), (x + half, y - half, z)])  # fmt: skip


def lamp(made: Any, corners: ArrayLike, path: str = "/Lamp", nits: float = NITS) -> UsdGeom.Mesh:
    mesh = made.quad(path, corners, material="/Grey")
    define_mesh_light(mesh.GetPrim(), nits=nits)
    return mesh


def z_of(a: Array, b: Array) -> Array:
    spread = a.var(axis=0, ddof=1) / len(a) + b.var(axis=0, ddof=1) / len(b)
    return np.asarray((a.mean(axis=0) - b.mean(axis=0)) / np.sqrt(np.maximum(spread, 1e-18)))


def blocks(pictures: Array) -> Array:
    """(seeds, 12) means of blocks of 6 by 6 pixels."""
    count = len(pictures)
    return pictures.mean(axis=-1).reshape(count, 3, 6, 4, 6).mean(axis=(2, 4)).reshape(count, -1)


def closed_room(build: Any, **material: Any) -> Any:
    """Two metres about the origin, seen from a corner."""
    made = build()
    grey = made.material("/Grey", **({"base_color": (0.5, 0.5, 0.5)} | material))
    made.box("/Room", 2.0, inside=True, material=grey)
    made.camera((-0.8, -0.9, 0.2), (0.3, 0.9, -0.3), fov=95)
    return made


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
