"""The BSDF in a scene: sides, relief, hard inputs, backends, and when it is used."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from openrooms_usd.usd.shading.surfaces import NORMAL_BIAS, NORMAL_SCALE, Texture
from orusd_mitsuba import MitsubaExporter
from tests import small
from tests.mitsuba.rendering import session_of, shown
from tests.pictures import save_picture
from tests.small import square

Prepare = Callable[[str], Any]


def unit(*vector: float) -> np.ndarray:
    return np.array(vector) / np.linalg.norm(vector)


def facing(mi: Any, wi: Any, *, smooth: Any = (0, 0, 1)) -> Any:
    """An interaction with the true normal +z of local coordinates turned to ``smooth``."""
    import drjit as dr

    si = dr.zeros(mi.SurfaceInteraction3f)
    si.n = mi.Normal3f(0, 0, 1)
    si.sh_frame = mi.Frame3f(mi.Normal3f(*map(float, smooth)))
    si.wi = si.to_local(mi.Vector3f(*map(float, wi)))
    return si


def tilted(mi: Any, normal: np.ndarray, **inputs: Any) -> Any:
    stored = {"type": "rgb", "value": ((normal + 1) / 2).tolist()}
    return mi.load_dict({"type": "openrooms", "normal": stored, "roughness": 0.4} | inputs)


def numbers(value: Any) -> np.ndarray:
    return np.array(value, dtype=np.float64).ravel()


def test_relief_is_the_flat_model_in_a_turned_frame(prepare: Prepare) -> None:
    mi = prepare("llvm")
    normal, context = unit(0.3, -0.2, 1.0), mi.BSDFContext()
    bsdf, flat = tilted(mi, normal), mi.load_dict({"type": "openrooms", "roughness": 0.4})
    wi, wo = unit(0.5, 0.3, 0.8), unit(-0.6, 0.2, 0.5)
    frame = mi.Frame3f(mi.Vector3f(*normal.tolist()))
    found = bsdf.eval_pdf(context, facing(mi, wi), mi.Vector3f(*wo.tolist()))
    turned = numbers(frame.to_local(mi.Vector3f(*wi.tolist())))
    expected = flat.eval_pdf(context, facing(mi, turned), frame.to_local(mi.Vector3f(*wo.tolist())))
    for a, b in zip(found, expected, strict=True):
        np.testing.assert_allclose(numbers(a), numbers(b), rtol=1e-4)


def test_the_back_is_the_mirror_image_of_the_front(prepare: Prepare) -> None:
    """A relief is seen from behind with its heights turned round."""
    mi = prepare("llvm")
    bsdf, context = tilted(mi, unit(0.3, -0.2, 1.0)), mi.BSDFContext()
    mirror = np.array([1, 1, -1])
    wi, wo = unit(0.5, 0.3, 0.8), unit(-0.6, 0.2, 0.5)
    front, back = (
        bsdf.eval_pdf(context, facing(mi, wi * side), mi.Vector3f(*(wo * side).tolist()))
        for side in (np.ones(3), mirror)
    )
    for a, b in zip(front, back, strict=True):
        np.testing.assert_allclose(numbers(a), numbers(b), rtol=1e-5)
    across = bsdf.eval(context, facing(mi, wi), mi.Vector3f(*(wo * mirror).tolist()))
    assert not numbers(across).any()


@pytest.mark.parametrize("normal", [unit(0.9, 0, 0.2), unit(-1, 0, 0.01), unit(0, 0, -1)])
def test_a_normal_that_turns_away_is_bent_to_the_horizon(
    prepare: Prepare, normal: np.ndarray
) -> None:
    """Neither black nor infinite, and no light comes through the true surface."""
    mi = prepare("llvm")
    wi, context = unit(-0.8, 0.1, 0.3), mi.BSDFContext()
    bsdf = tilted(mi, normal)
    si = facing(mi, wi)
    random = np.random.default_rng(1).random((3, 2000)).astype(np.float32)
    bs, weight = bsdf.sample(context, si, mi.Float(random[0]), mi.Point2f(random[1:]))
    weights, heights = np.array(weight), np.array(bs.wo)[2]
    assert np.isfinite(weights).all() and weights.any() and weights.max() < 4.0
    assert (heights[weights[0] > 0] >= 0.0).all()


def test_a_smooth_normal_that_turns_away_keeps_the_side(prepare: Prepare) -> None:
    """At the silhouette of a smooth mesh light still comes from outside."""
    mi = prepare("llvm")
    bsdf = mi.load_dict({"type": "openrooms", "roughness": 0.5})
    wi, smooth = unit(-0.9, 0.0, 0.1), unit(0.4, 0.0, 1.0)
    assert wi @ smooth < 0
    si = facing(mi, wi, smooth=smooth)
    out, inside = (si.to_local(mi.Vector3f(0, 0, z)) for z in (1.0, -1.0))
    assert (numbers(bsdf.eval(mi.BSDFContext(), si, out)) > 0.05).all()
    assert not numbers(bsdf.eval(mi.BSDFContext(), si, inside)).any()


HARD = [(r, b, m) for r in (0.0, 1e-4, 0.01, 1.0) for b in (0.0, 1.0) for m in (0.0, 1.0)]


@pytest.mark.one_in(4)
@pytest.mark.parametrize("name", ["llvm", "scalar"])
@pytest.mark.parametrize("roughness, base, metallic", HARD)
def test_hard_inputs_give_finite_numbers(
    prepare: Prepare, name: str, roughness: float, base: float, metallic: float
) -> None:
    mi = prepare(name)
    color = {"type": "rgb", "value": [base] * 3}
    inputs = {"base_color": color, "roughness": roughness, "metallic": metallic}
    bsdf, context = mi.load_dict({"type": "openrooms"} | inputs), mi.BSDFContext()
    views = [unit(0.3, 0.2, 1), unit(1, 0, 1e-4), unit(1, 0, 0), unit(1, 0, -1e-4), unit(0, 0, -1)]
    for wi in views:
        si = facing(mi, wi)
        for wo in (*views, -wi, wi * [-1, -1, 1]):
            value, density = bsdf.eval_pdf(context, si, mi.Vector3f(*wo.tolist()))
            assert np.isfinite([*numbers(value), *numbers(density)]).all()
            assert (numbers(value) >= 0).all() and (numbers(density) >= 0).all()
        for u in (0.0, 0.02, 0.5, 1 - 2**-24):
            for v in (0.0, 0.5, 1 - 2**-24):
                bs, weight = bsdf.sample(context, si, u, mi.Point2f(u, v))
                assert np.isfinite([*numbers(weight), *numbers(bs.wo), *numbers(bs.pdf)]).all()
                assert (numbers(weight) >= 0).all() and (numbers(weight) < 8.0).all()
    if roughness < 0.01:
        sharpest = mi.load_dict({"type": "openrooms"} | inputs | {"roughness": 0.01})
        wi, wo = unit(0.3, 0.2, 1), unit(-0.3, -0.2, 1)
        a, b = (
            numbers(x.pdf(context, facing(mi, wi), mi.Vector3f(*wo.tolist())))
            for x in (bsdf, sharpest)
        )
        np.testing.assert_allclose(a, b)


def test_backends_agree(prepare: Prepare) -> None:
    rng = np.random.default_rng(3)
    cases = [
        (unit(*rng.normal(size=3)), unit(*rng.normal(size=3)), rng.random(7).tolist())
        for _ in range(30)
    ]
    found = {}
    for name in ("llvm", "scalar"):
        mi = prepare(name)
        rows = []
        for wi, wo, (x, y, metallic, passed, u, v, w) in cases:
            bsdf = tilted(mi, unit(x - 0.5, y - 0.5, 1.0), metallic=metallic, transmission=passed)
            si, context = facing(mi, wi), mi.BSDFContext()
            value, density = bsdf.eval_pdf(context, si, mi.Vector3f(*wo.tolist()))
            bs, weight = bsdf.sample(context, si, u, mi.Point2f(v, w))
            parts = (value, density, bs.wo, bs.pdf, bs.sampled_type, weight)
            rows.append(np.concatenate([numbers(part) for part in parts]))
        found[name] = np.array(rows)
    np.testing.assert_allclose(found["llvm"], found["scalar"], rtol=2e-4, atol=1e-6)


def test_only_the_parts_that_are_asked_for(prepare: Prepare) -> None:
    mi = prepare("llvm")
    bsdf = mi.load_dict({"type": "openrooms", "transmission": 0.5})
    si = facing(mi, unit(0.2, 0.1, 1))
    directions = [mi.Vector3f(*unit(-0.3, 0.4, z).tolist()) for z in (0.8, -0.8)]
    total = [numbers(bsdf.eval(mi.BSDFContext(), si, wo)) for wo in directions]
    parts = np.zeros((2, 3))
    for number in range(3):
        context = mi.BSDFContext()
        context.component = number
        parts += [numbers(bsdf.eval(context, si, wo)) for wo in directions]
    np.testing.assert_allclose(parts, total, rtol=1e-5)


def plate(**inputs: Any) -> Any:
    made = small.Stage()
    material = made.material("/Paint", **inputs)
    made.quad("/Plate", square((0, 0, 0), 9), material=material)
    made.camera((-4, 0, 2.0), (0, 0, 0), fov=4.0)
    return made


def test_a_surface_of_ours_is_rendered_by_our_model(prepare: Prepare) -> None:
    """Under parallel light the radiance is the formula; --bsdf chooses."""
    mi = prepare("llvm")
    made = plate(base_color=(0.5, 0.3, 0.1), roughness=0.4, f0=0.05)
    made.light("Distant", "/Sun", 100.0, turn=(0, 50.0, 0), angle=0.0)
    color = {"type": "rgb", "value": [0.5, 0.3, 0.1]}
    bsdf = mi.load_dict({"type": "openrooms", "base_color": color, "roughness": 0.4, "f0": 0.05})
    angle = np.radians(50.0)
    towards = mi.Vector3f(float(np.sin(angle)), 0.0, float(np.cos(angle)))
    expected = 100.0 * numbers(bsdf.eval(mi.BSDFContext(), facing(mi, unit(-4, 0, 2.0)), towards))
    seen = {}
    for bsdf_name in ("auto", "openrooms", "preview"):
        session = session_of(made.stage, variant="llvm", bsdf=bsdf_name)
        images = shown(
            session, "radiance", "roughness", width=8, height=6, samples=16, bounces=1
        ).images
        assert (images["roughness"].pixels == np.float32(0.4)).all()
        seen[bsdf_name] = images["radiance"].pixels[3, 4]
        losses = [reason for path, _, reason in session.report.losses() if path == "/Paint"]
        assert bool(losses) == (bsdf_name == "preview") and session.session.settings == {
            "bsdf": bsdf_name
        }
    np.testing.assert_allclose(seen["auto"], expected, rtol=0.02)
    np.testing.assert_array_equal(seen["auto"], seen["openrooms"])
    assert (np.abs(seen["preview"] / expected - 1) > 0.03).any()


def test_a_scalar_backend_shows_previews_unless_told_otherwise() -> None:
    made = plate(f0=0.05)
    opened = {b: session_of(made.stage, variant="scalar", bsdf=b) for b in ("auto", "openrooms")}
    assert {b: one.session.settings["bsdf"] for b, one in opened.items()} == {
        "auto": "preview",
        "openrooms": "openrooms",
    }


def test_cloth_of_ours_keeps_all_light(prepare: Prepare) -> None:
    """In a white furnace a sheet without a lobe's part shows what is reflected and passed."""
    mi = prepare("llvm")
    context, si = mi.BSDFContext(), facing(mi, unit(0.3, 0, 1))
    sheet = mi.load_dict(
        {
            "type": "openrooms",
            "transmission": 1.5,
            "f0": 0.0,
            "base_color": {"type": "rgb", "value": [0.4] * 3},
        }
    )
    u = np.random.default_rng(2).random((3, 50_000)).astype(np.float32)
    context.type_mask = mi.BSDFFlags.Diffuse
    weight = np.array(sheet.sample(context, si, mi.Float(u[0]), mi.Point2f(u[1:]))[1])
    np.testing.assert_allclose(weight, 1.0, rtol=1e-5)


def test_exported_files_need_nothing_of_ours(tmp_path: Any, prepare: Prepare) -> None:
    mi = prepare("llvm")
    relief = save_picture(tmp_path / "n.png", np.full((2, 2, 3), 128, dtype=np.uint8))
    made = plate(f0=0.05, normal=Texture(relief, scale=NORMAL_SCALE, bias=NORMAL_BIAS))
    report = MitsubaExporter().convert(made.stage, tmp_path / "scene.xml", {})
    assert any(path == "/Paint" and "1.576" in why for path, _, why in report.losses())
    text = (tmp_path / "scene.xml").read_text()
    assert "openrooms" not in text and 'name="eta" value="1.57' in text
    mi.load_file(str(tmp_path / "scene.xml"))
