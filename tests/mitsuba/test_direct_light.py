"""Direct light of each lamp and opening: identities, closed forms and the path tracer."""

from typing import Any

import numpy as np
import pytest
from numpy.typing import ArrayLike, NDArray
from pxr import UsdLux

from openrooms_usd.usd.lights import Portal, connect_portals, define_mesh_light, define_portal

Array = NDArray[np.float64]
WHITE = (1.0, 1.0, 1.0)


def room(build: Any, size: float = 4.0) -> Any:
    """An empty white room about the origin, seen from its middle: wall, floor and corner."""
    made = build()
    made.box("/Room", size, inside=True, material=made.material("/White", base_color=WHITE))
    made.camera((0.2, -0.3, 0.3), (1.0, 1.0, -0.6), fov=80, aspect=1.0)
    return made


def panel(made: Any, path: str, center: ArrayLike, half: float, nits: float) -> None:
    """A square lamp that shines down."""
    x, y, z = np.asarray(center, dtype=float)
    corners = [(x - half, y - half, z), (x - half, y + half, z), (x + half, y + half, z),
               (x + half, y - half, z)]  # fmt: skip
    mesh = made.quad(path, corners, material="/White")
    define_mesh_light(mesh.GetPrim(), nits=nits)


def ball(
    made: Any, path: str, center: tuple[float, float, float], radius: float, nits: float
) -> None:
    light = UsdLux.SphereLight.Define(made.stage, path)
    light.CreateRadiusAttr(radius)
    light.CreateIntensityAttr(nits)
    light.AddTranslateOp().Set(center)


def z_score(a: Array, b: Array) -> float:
    """Of the difference of the means of two sets of independent estimates."""
    spread = a.var(ddof=1) / len(a) + b.var(ddof=1) / len(b)
    return float((a.mean() - b.mean()) / np.sqrt(spread))


def test_alone_in_a_convex_room_every_lamp_is_seen_whole(build: Any, lit: Any) -> None:
    made = room(build)
    panel(made, "/Panel", (0.5, 0.4, 1.9), 0.3, 100.0)
    ball(made, "/Ball", (-0.5, 0.9, 0.2), 0.2, 50.0)
    found = lit(made.stage).lights(8)
    for number in range(2):
        seen = found["visibility_i"][number]
        assert (seen[found["unoccluded_i"][number] > 0.0] == 1.0).mean() > 0.9
        assert seen.max() == 1.0
    panel_only = room(build)
    panel(panel_only, "/Panel", (0.5, 0.4, 1.9), 0.3, 100.0)
    found = lit(panel_only.stage).lights(8)
    assert (found["visibility_i"][0] == np.where(found["unoccluded_i"][0] > 0.0, 1.0, 0.0)).all()
    np.testing.assert_array_equal(found["direct_i"][0], found["unoccluded_i"][0])


def test_closed_form_is_what_is_sampled(build: Any, lit: Any) -> None:
    made = room(build)
    panel(made, "/Panel", (0.9, 1.2, 0.6), 0.4, 100.0)
    scene = lit(made.stage)
    planes = np.stack([scene.direct(16, seed) for seed in range(8)]).astype(np.float64)
    lights = len(scene.sources)
    sampled, closed = (planes[:, n * lights].mean(axis=(1, 2, 3)) for n in (1, 2))
    assert closed.mean() > 1.0
    assert abs(z_score(sampled, closed)) < 4.0
    assert sampled.std(ddof=1) / sampled.mean() < 0.01


def test_a_sphere_gives_pi_l_r_squared_over_d_squared(build: Any, lit: Any) -> None:
    made = build()
    made.quad("/Patch", [(-0.01, -0.01, 0), (0.01, -0.01, 0), (0.01, 0.01, 0), (-0.01, 0.01, 0)],
              material=made.material("/White", base_color=WHITE))  # fmt: skip
    made.camera((0.0, -0.5, 0.3), (0, 0, 0), fov=0.5, aspect=1.0)
    ball(made, "/Ball", (0.6, 0.0, 0.8), 0.25, 40.0)
    found = lit(made.stage).lights(64)["unoccluded_i"][0]
    expected = np.pi * 40.0 * 0.25**2 * 0.8
    spread = found[:, 1].std() / np.sqrt(len(found))
    # The facets have the area of the sphere, not its outline.
    assert abs(found[:, 1].mean() - expected) < 4.0 * spread + 2e-3 * expected


@pytest.mark.slow
def test_the_lights_add_up_to_the_path_tracer(build: Any, lit: Any) -> None:
    from orusd_mitsuba.transport.path_integrator import PathIntegrator

    made = room(build)
    made.box("/Table", 0.5, material="/White")
    panel(made, "/Panel", (0.5, 0.4, 1.9), 0.3, 100.0)
    ball(made, "/Ball", (0.9, 1.4, 0.1), 0.15, 300.0)
    scene = lit(made.stage)
    ours = np.stack([scene.direct(16, seed) for seed in range(6)]).astype(np.float64)
    lights = len(scene.sources)
    integrator = PathIntegrator(scene.built, scene.index, scene.camera(16, 16), 16, 16,
                          scene.scene.origin, 2, by_light=False, first=scene.first)  # fmt: skip
    theirs = (
        np.stack([integrator(64, 100 + seed)[1] for seed in range(6)]).astype(np.float64) * np.pi
    )
    total = ours[:, :lights].sum(axis=1).mean(axis=(1, 2, 3))
    assert total.mean() > 1.0
    assert abs(z_score(total, theirs.mean(axis=(1, 2, 3)))) < 4.0


@pytest.mark.parametrize("samples", [1, 5])
def test_visibility_is_a_share_and_zero_where_nothing_could_come(
    build: Any, lit: Any, samples: int
) -> None:
    made = room(build)
    made.box("/Table", 0.5, material="/White")
    panel(made, "/Panel", (0.5, 0.4, 1.9), 0.3, 1e9)
    ball(made, "/Ball", (0.9, 1.4, 0.1), 0.1, 1e-3)
    found = lit(made.stage).lights(samples)
    seen, whole = found["visibility_i"], found["unoccluded_i"]
    assert seen.min() == 0.0 and seen.max() <= 1.0
    assert (seen[whole == 0.0] == 0.0).all()
    assert (found["direct_i"] <= whole).all()


def test_a_lamp_and_a_patch_are_reciprocal(build: Any, lit: Any) -> None:
    # A1 E12 / (pi L) = A1 F12 = A2 F21: what one receives of the other, with a blocker between.
    first = np.array([(-0.4, -0.3, -1.0), (0.4, -0.3, -1.0), (0.4, 0.3, -1.0), (-0.4, 0.3, -1.0)])
    second = np.array([(0.1, 0.2, 0.8), (0.1, 0.8, 0.8), (0.5, 0.8, 0.8), (0.5, 0.2, 0.8)])
    block = [(-0.2, 0.0, 0.0), (0.3, 0.0, 0.0), (0.3, 0.5, 0.0), (-0.2, 0.5, 0.0)]
    passed = []
    for patch, lamp in ((first, second), (second, first)):
        made = build()
        made.quad("/Patch", patch, material=made.material("/White", base_color=WHITE))
        define_mesh_light(made.quad("/Lamp", lamp, material="/White").GetPrim(), nits=10.0)
        made.quad("/Block", block, material="/White")
        normal = np.cross(patch[1] - patch[0], patch[2] - patch[0])
        normal /= np.linalg.norm(normal)
        middle, area = patch.mean(axis=0), np.ptp(patch[:, 0]) * np.ptp(patch[:, 1])
        # Near enough that only the patch is seen, from between it and the blocker.
        made.camera(middle + 0.02 * normal, middle, up=(0, 1, 0), fov=170, aspect=1.0)
        scene = lit(made.stage)
        passed.append(area * _mean_over(scene, middle, normal, patch))
    assert passed[0] == pytest.approx(passed[1], rel=0.02)


def _mean_over(scene: Any, middle: Array, normal: Array, patch: Array) -> float:
    """Mean irradiance of a rectangle along x and y, from its own small grid of cameras' rays."""
    import drjit as dr
    import mitsuba as mi

    from orusd_mitsuba.direct.accumulator import DirectAccumulator
    from orusd_mitsuba.direct.integrator import DirectIntegrator

    count = 1 << 17
    rng = np.random.default_rng(1)
    at = patch[0] + rng.random((count, 1)) * (patch[1] - patch[0])
    at = at + rng.random((count, 1)) * (patch[3] - patch[0]) + 0.01 * normal - scene.scene.origin
    ray = mi.Ray3f(mi.Point3f(at.T.astype(np.float32)), mi.Vector3f(*(-normal).tolist()))
    integrator = DirectIntegrator(scene.scene, scene.built, scene.sources, scene.index, scene.first,
                      scene.camera(8, 8), 8, 8)  # fmt: skip
    sampler = mi.load_dict({"type": "independent"})
    sampler.seed(3, count)
    accumulator = DirectAccumulator(count, len(scene.sources), 1)
    integrator._gather(ray, sampler, accumulator)
    sums = dr.block_sum(accumulator.entries, count).numpy()
    return float(sums[0]) / count


def window(center: ArrayLike = (0.1, 2.0, 0.2), path: str = "/Portal") -> Portal:
    """1.2 by 0.8 m in a wall y = constant."""
    world = np.eye(4)
    world[:3, :3] = np.array([[-1, 0, 0], [0, 0, 1], [0, 1, 0]]).T
    world[:3, 3] = center
    return Portal(path, world, 1.2, 0.8)


def window_room(build: Any, *, sky: bool) -> Any:
    """A room without its wall y = 2: the sky or a lamp is where the rectangle is."""
    made = build()
    made.material("/White", base_color=WHITE)
    floor = [(-8, -8, -2), (8, -8, -2), (8, 8, -2), (-8, 8, -2)]
    made.quad("/Floor", floor, material="/White")
    made.box("/Table", 0.9, material="/White")
    made.camera((0.2, -1.5, 1.5), (0.0, 0.6, -2.0), fov=60, aspect=1.0)
    if sky:
        dome = made.dome(radiance=70.0)
        connect_portals(dome.GetPrim(), [define_portal(made.stage, window()).GetPrim()])
        return made
    x, y, z = window().world_from_portal[:3, 3]
    pane = [
        (x - 0.6, y, z - 0.4),
        (x + 0.6, y, z - 0.4),
        (x + 0.6, y, z + 0.4),
        (x - 0.6, y, z + 0.4),
    ]
    define_mesh_light(made.quad("/Pane", pane, material="/White").GetPrim(), nits=70.0)
    return made


@pytest.mark.slow
def test_sky_through_a_rectangle_is_a_lamp_in_its_place(build: Any, lit: Any) -> None:
    by_lamp = lit(window_room(build, sky=False).stage)
    by_sky = lit(window_room(build, sky=True).stage)
    assert by_sky.sources[0].kind == "opening" and by_lamp.sources[0].kind == "lamp"
    for name in ("direct_i", "unoccluded_i"):
        a, b = (
            np.array([scene.lights(32, seed)[name][0].mean() for seed in range(6)])
            for scene in (by_sky, by_lamp)
        )
        assert a.mean() > 1.0
        assert abs(z_score(a, b)) < 4.0


def test_what_comes_past_all_openings_is_elsewhere(build: Any, lit: Any) -> None:
    found = lit(window_room(build, sky=True).stage).lights(64)
    # An open field under an even sky receives pi L in all; the table takes its part away.
    whole, arriving = (found[n].sum(axis=0)[:, 1] for n in ("unoccluded_i", "direct_i"))
    assert whole[whole > 0.0].mean() == pytest.approx(70.0 * np.pi, rel=0.02)
    assert 0.5 * whole.mean() < arriving.mean() < whole.mean()


def test_equal_seeds_give_equal_bits(build: Any, lit: Any) -> None:
    made = window_room(build, sky=True)
    panel(made, "/Panel", (0.5, 0.4, 1.9), 0.3, 100.0)
    scene = lit(made.stage)
    first, again, other = (scene.direct(3, seed) for seed in (5, 5, 6))
    np.testing.assert_array_equal(first, again)
    assert (first != other).any()
