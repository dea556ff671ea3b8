"""UsdPreviewSurface by its specification, against the formulas written down once more in NumPy."""

from typing import Any

import numpy as np
import pytest

from openrooms_usd.rendering.scene.surfaces import Surface
from openrooms_usd.usd.shading.surfaces import Texture
from orusd_mitsuba import MitsubaExporter
from tests import small
from tests.mitsuba.rendering import session_of, shown
from tests.pictures import save_picture

Array = np.ndarray[Any, Any]
WHITE = (1.0, 1.0, 1.0)
TINT = (0.9, 0.3, 0.1)
# Of the look: base colour, roughness, metalness, index of refraction, specular colour, coat.
LOOKS: list[dict[str, Any]] = [
    {"base_color": WHITE, "roughness": 0.5},
    {"base_color": WHITE, "roughness": 0.15, "ior": 2.0},
    {"base_color": WHITE, "roughness": 1.0},
    {"base_color": TINT, "roughness": 0.3, "metallic": 1.0},
    {"base_color": TINT, "roughness": 0.6, "metallic": 0.4},
    {"base_color": (0.2, 0.2, 0.2), "roughness": 0.4, "specular": TINT},
    {"base_color": (0.2, 0.4, 0.6), "roughness": 0.7, "clearcoat": 0.8, "clearcoat_roughness": 0.2},
]


def lobe(wi: Array, wo: Array, roughness: float) -> tuple[Array, Array]:
    """D G / (4 n.l n.v), and v.h."""
    h = wi + wo
    h /= np.linalg.norm(h, axis=-1, keepdims=True)
    alpha = roughness**2
    D = alpha**2 / (np.pi * (h[..., 2] ** 2 * (alpha**2 - 1.0) + 1.0) ** 2)
    k = alpha / 2.0
    n_v, n_l = wi[..., 2], wo[..., 2]
    G = n_v / (n_v * (1.0 - k) + k) * n_l / (n_l * (1.0 - k) + k)
    return D * G / (4.0 * n_v * n_l), (wi * h).sum(axis=-1)


def model(wi: Array, wo: Array, look: dict[str, Any]) -> Array:
    """(..., 3) f of previewSurface.glslfx without its epsilons."""
    base, m = np.array(look["base_color"]), look.get("metallic", 0.0)
    r = ((1.0 - look.get("ior", 1.5)) / (1.0 + look.get("ior", 1.5))) ** 2
    if "specular" in look:
        f0, f90, m = np.array(look["specular"]), np.ones(3), 0.0
    else:
        f90 = (1.0 - m) + m * base
        f0 = (1.0 - m) * r * f90 + m * f90
    shape, v_h = lobe(wi, wo, look["roughness"])
    schlick = (1.0 - v_h[..., None]) ** 5
    F = f0 + (f90 - f0) * schlick
    found = (1.0 - m) * base / np.pi * (1.0 - F) + F * shape[..., None]
    shape, _ = lobe(wi, wo, max(look.get("clearcoat_roughness", 0.01), 0.01))
    return found + look.get("clearcoat", 0.0) * (r + (1.0 - r) * schlick) * shape[..., None]


def view(cosine: float) -> Array:
    return np.array([np.sqrt(1.0 - cosine**2), 0.0, cosine])


def albedo(look: dict[str, Any], cosine: float, steps: int = 1200) -> Array:
    """(3,) what it reflects of even light, by the midpoint rule over polar angles."""
    half = (np.arange(steps) + 0.5) / steps
    theta, phi = np.meshgrid(0.5 * np.pi * half, np.pi * half)
    side, z = np.sin(theta), np.cos(theta)
    wo = np.stack([side * np.cos(phi), side * np.sin(phi), z], axis=-1)
    value = model(np.broadcast_to(view(cosine), wo.shape), wo, look) * (z * side)[..., None]
    return np.asarray(np.pi**2 * value.mean(axis=(0, 1)))


def plugin(mi: Any, look: dict[str, Any], by_formula: bool = True) -> Any:
    from orusd_mitsuba.plugins import preview_bsdf
    from orusd_mitsuba.plugins.descriptions import describe_bsdf

    preview_bsdf.register(str(mi.variant()))
    return mi.load_dict(describe_bsdf(Surface(**look), by_formula=by_formula))


def seen(mi: Any, cosine: float) -> Any:
    import drjit as dr

    si = dr.zeros(mi.SurfaceInteraction3f)
    si.n = mi.Normal3f(0, 0, 1)
    si.sh_frame = mi.Frame3f(si.n)
    si.wi = mi.Vector3f(*view(cosine).tolist())
    return si


def sampled(mi: Any, bsdf: Any, cosine: float, count: int = 1 << 18) -> Array:
    """(3,) the directional albedo by the BSDF's own directions."""
    rng = np.random.default_rng(7)
    which = mi.Float(rng.random(count, dtype=np.float32))
    where = mi.Point2f(rng.random((2, count), dtype=np.float32))
    weights = np.array(bsdf.sample(mi.BSDFContext(), seen(mi, cosine), which, where)[1])
    assert np.isfinite(weights).all() and (weights >= 0.0).all()
    return np.asarray(weights.mean(axis=1, dtype=np.float64))


@pytest.mark.parametrize("look", LOOKS)
def test_values_and_densities_are_those_of_the_formula(mi: Any, look: dict[str, Any]) -> None:
    bsdf = plugin(mi, look)
    rng = np.random.default_rng(3)
    wo = rng.normal(size=(200, 3))
    wo[:, 2] = np.abs(wo[:, 2]) + 0.05
    wo /= np.linalg.norm(wo, axis=1, keepdims=True)
    for cosine in (0.95, 0.3):
        si = seen(mi, cosine)
        value, density = bsdf.eval_pdf(mi.BSDFContext(), si, mi.Vector3f(wo.T.astype(np.float32)))
        expected = model(np.broadcast_to(view(cosine), wo.shape), wo, look) * wo[:, 2:]
        np.testing.assert_allclose(np.array(value).T, expected, rtol=2e-3, atol=1e-5)
        assert (np.array(density) > 0.0).all()


@pytest.mark.parametrize("look", LOOKS)
@pytest.mark.parametrize("cosine", [1.0, 0.5, 0.2])
def test_it_is_sampled_as_it_is(mi: Any, look: dict[str, Any], cosine: float) -> None:
    expected = albedo(look, cosine, 600)
    found = sampled(mi, plugin(mi, look), cosine)
    np.testing.assert_allclose(found, expected, rtol=0.01, atol=2e-3)


@pytest.mark.parametrize("cosine", [1.0, 0.4, 0.1])
def test_a_rough_white_surface_reflects_no_more_than_it_gets(mi: Any, cosine: float) -> None:
    """Disney's diffuse part gave 1.05 to 1.42."""
    found = sampled(mi, plugin(mi, {"base_color": WHITE, "roughness": 1.0}), cosine)
    np.testing.assert_allclose(found, 0.974, atol=3e-3)


def furnace(looks: list[dict[str, Any]]) -> small.Stage:
    """Quads that look up beside each other in a white sky; each fills its part of a picture."""
    made = small.Stage()
    for number, look in enumerate(looks):
        material = made.material(f"/M{number}", **({"ior": 1.5} | look))
        made.quad(f"/Q{number}", small.square((2.0 * number, 0, 0), 1), material=material)
    made.dome()
    middle, many = len(looks) - 1.0, len(looks)
    fov = float(np.degrees(2.0 * np.arctan(many / 100.0)))
    made.camera((middle, 0, 100), (middle, 0, 0), up=(0, 1, 0), fov=fov, aspect=float(many))
    return made


@pytest.mark.slow
def test_a_picture_in_a_white_furnace(vectorized: str, tmp_path: Any) -> None:
    """Radiance is the albedo: of rows of the table, of pictures, behind a mask, coloured."""
    grey = save_picture(tmp_path / "grey.png", np.full((4, 4, 3), 204, np.uint8))
    looks: list[dict[str, Any]] = [
        {"base_color": WHITE, "roughness": 1.0},
        {"base_color": Texture(grey), "roughness": 0.5},
        {"base_color": (0.2, 0.2, 0.2), "roughness": 0.4, "specular": TINT},
        {"base_color": (0.2, 0.2, 0.2), "roughness": 0.4, "specular": TINT, "opacity": 0.5},
        {"base_color": TINT, "roughness": 0.5, "clearcoat": 1.0, "clearcoat_roughness": 0.3},
    ]
    session = session_of(furnace(looks).stage, variant="llvm")
    image = shown(session, "radiance", width=40, height=8, samples=64).images["radiance"].pixels
    means = image.reshape(8, 5, 8, 3)[1:-1, :, 1:-1].mean(axis=(0, 2))
    expected = [
        albedo(look | {"base_color": c}, 1.0)
        for look, c in zip(looks, (WHITE, (0.8,) * 3, (0.2,) * 3, (0.2,) * 3, TINT), strict=True)
    ]
    expected[3] = 0.5 * expected[3] + 0.5
    np.testing.assert_allclose(means, expected, atol=0.03)


def test_exported_xml_has_no_plugin_of_ours(tmp_path: Any) -> None:
    made = furnace([{"base_color": WHITE, "specular": TINT}])
    report = MitsubaExporter().convert(made.stage, tmp_path / "scene.xml", {})
    text = (tmp_path / "scene.xml").read_text()
    assert "principled" in text and "usd_preview" not in text
    assert any("principled" in why for path, _, why in report.losses() if path == "/M0")
