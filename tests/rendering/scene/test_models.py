"""All surfaces of one reflectance model: which values change, and what the report says of it."""

import pytest
from pxr import Gf, Usd, UsdGeom, UsdShade

from openrooms_usd.rendering.scene.arrays import Scene
from openrooms_usd.rendering.scene.models import MODELS, Model, with_model
from openrooms_usd.rendering.scene.surfaces import SurfaceReader
from openrooms_usd.rendering.scene.translate import translate
from openrooms_usd.usd.shading.materials import define_preview_surface
from openrooms_usd.usd.shading.surfaces import PreviewSurface, ior_of

LOOKS = {
    "Ours": PreviewSurface(f0=0.05, ior=ior_of(0.05)),
    "Glass": PreviewSurface(ior=1.5, clearcoat=0.5),
    "Chalk": PreviewSurface(ior=1.0),
}


def scene(**more: PreviewSurface) -> Scene:
    """A triangle of each look, and one without any."""
    stage, looks = Usd.Stage.CreateInMemory(), LOOKS | more
    for name in (*LOOKS, "Bare", *more):
        mesh = UsdGeom.Mesh.Define(stage, f"/{name}Mesh")
        mesh.CreatePointsAttr([Gf.Vec3f(0, 0, 0), Gf.Vec3f(1, 0, 0), Gf.Vec3f(0, 1, 0)])
        mesh.CreateFaceVertexCountsAttr([3])
        mesh.CreateFaceVertexIndicesAttr([0, 1, 2])
        if name in looks:
            define_preview_surface(stage, f"/{name}", looks[name])
            look = UsdShade.Material.Get(stage, f"/{name}")
            UsdShade.MaterialBindingAPI.Apply(mesh.GetPrim()).Bind(look)
    return translate(stage)


def row(found: Scene, path: str) -> tuple[str, str]:
    return [(outcome, why) for prim, outcome, why in found.report.rows if prim == path][-1]


@pytest.mark.parametrize(
    ("model", "expected"),
    [
        ("auto", [0.05, None, None, None]),
        ("openrooms", [0.05, 0.04, None, 0.04]),
        ("preview", [None, None, None, None]),
    ],
)
def test_which_model_each_surface_is_of(model: Model, expected: list[float | None]) -> None:
    found = [patch.surface.f0 for patch in with_model(scene(), model).patches]
    assert found == [None if f0 is None else pytest.approx(f0) for f0 in expected]


def test_what_is_lost_stands_in_the_row_of_what_gave_the_surface() -> None:
    assert row(with_model(scene(), "preview"), "/Ours") == (
        "approximated",
        "OpenRooms' model is shown by UsdPreviewSurface with ior 1.576",
    )
    found = with_model(scene(), "openrooms")
    assert row(found, "/Ours") == row(found, "/Chalk") == ("translated", "")
    assert "F0 0.04; its clearcoat is left out" in row(found, "/Glass")[1]
    outcome, reason = row(found, "/BareMesh")
    assert outcome == "approximated"
    assert sum("F0" in why for prim, _, why in found.report.rows if prim == "/BareMesh") == 1
    assert "it has no material" in reason and reason.endswith("with F0 0.04")


@pytest.mark.parametrize("model", MODELS)
def test_nothing_else_changes(model: Model) -> None:
    before, after = scene(), with_model(scene(), model)
    assert [path for path, _, _ in before.report.rows] == [p for p, _, _ in after.report.rows]
    for one, other in zip(before.patches, after.patches, strict=True):
        kept = ("base_color", "roughness", "metallic", "ior", "clearcoat", "opacity")
        assert all(getattr(one.surface, n) == getattr(other.surface, n) for n in kept)


def test_openrooms_model_has_no_specular_colour() -> None:
    """Neither of a material of it, which stays a metal, nor of one that is taken as it."""
    ours = PreviewSurface(f0=0.05, metallic=1.0, specular=(0.3, 0.2, 0.1))
    found = SurfaceReader().read(ours)
    assert (found.specular, found.metallic) == (None, 1.0)
    theirs = scene(Theirs=PreviewSurface(specular=(0.3, 0.2, 0.1), metallic=1.0))
    taken = with_model(theirs, "openrooms").patches[-1].surface
    assert (taken.specular, taken.metallic, taken.f0) == (None, 0.0, pytest.approx(0.2))
